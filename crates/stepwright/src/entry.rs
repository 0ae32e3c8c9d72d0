//! An entry: "pins, then wait", repeated many times.
//!
//! The engine and the step interrupts of a chip play entries. An entry consists of *groups*, and a
//! group of *events* with the same pins and the same wait; the wait grows from group to group:
//!
//! ```text
//!   pins      pins      then      then      then      then
//!    │interval │interval │ +growth │ +growth │+2·growth│ …
//!   ─┴─────────┴─────────┴─────────┴─────────┴─────────┴───► ticks
//!    └───── group 1 ─────┘└────── group 2 ───┘└─ …
//! ```
//!
//! A step, a turn, a hold and a long interval are all of this kind: a step sets its pin and waits,
//! a turn toggles DIR and waits, a hold sets nothing, and a long interval is a step followed by
//! waits without a pin. A player looks only at the next deadline.
//!
//! A [`Run`](crate::run::Run) is "wait, then step", so its last step belongs to the entry that
//! follows it: [`Writer`] keeps the step that is due and makes entries of runs.
//!
//! # Error
//!
//! On an AVR an entry has 11 bytes, because its step interrupts add three bytes to a deadline.
//! Waits then have 8 fractional bits, half as many as a run's intervals; so do entries for such
//! interrupts on the virtual board. Every entry is rounded to nearest, and the remainder is added
//! to the next: deadlines at the ends of runs stay within 1/512 tick a step of that run, and of the
//! few steps that are joined with it, and do not drift. Joined steps share the sum of their
//! intervals. Between the ends, the growth of a run is played in groups that deviate by one tick at
//! most, and rounded to 1/256 tick a group: less than eight ticks for all ramps that the planner
//! makes.
//!
//! For a [prompt](Wiring::prompt) player an entry equals its run: to the last bit, step by step.

mod exact;
mod play;
mod wiring;
mod writer;

use core::mem::offset_of;

use crate::format::{self, BYTES, Groups};
use crate::units::Ticks;
pub use play::Play;
pub use wiring::Wiring;
pub use writer::{Sink, Writer};

/// Waits of this many ticks or more are split into several events: half the range of a 16-bit
/// counter, less what a deadline may have passed by.
pub const NEAR: Ticks = 0x7F00;

/// The shortest time to the next event after a turn or a hold on an AVR, in ticks: the interrupts
/// of three axes that begin together prepare their next groups meanwhile.
pub const LEAST: Ticks = 1200;

/// The wait after the last step of a travel, in ticks: the step is late after half of it. Three
/// axes may step at once, with held pulses of 20 µs.
const LAST: Ticks = 2 * LEAST;

/// The most entries that one run becomes, including those of a run that was kept.
pub const MOST: u8 = 3;

/// Events of a group, 1 … 65536, as an 8-bit chip counts them down: `high` · 256 + `low`, where a
/// `low` of 0 means 256.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Events {
    low: u8,
    high: u8,
}

impl Events {
    /// One event.
    pub const ONE: Events = Events { low: 1, high: 0 };

    /// `count` events; 0 stands for 65536.
    pub const fn new(count: u16) -> Events {
        let [low, high] = count.to_le_bytes();
        Events { low, high: if low == 0 { high.wrapping_sub(1) } else { high } }
    }

    /// The number of events.
    pub const fn count(self) -> u32 {
        let low = if self.low == 0 { 256 } else { self.low as u32 };
        (self.high as u32) * 256 + low
    }
}

/// Pins, then a wait: see the [module](self).
///
/// Step interrupts in assembly depend on the layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Entry {
    /// The wait after each event of the first group.
    interval: [u8; BYTES],
    /// The growth of the wait from group to group.
    growth: [u8; BYTES],
    /// Events in a group.
    events: Events,
    /// Number of groups.
    groups: Groups,
    /// Pins of the second group and of all later ones.
    then: u8,
    /// Pins of the first group.
    pins: u8,
}

/// The values of an [`Entry`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryParts {
    /// Pins of the first group.
    pub pins: u8,
    /// Pins of the later groups.
    pub then: u8,
    /// Events in a group, 1 … 65536.
    pub events: u32,
    /// Number of groups, at least 1.
    pub groups: u32,
    /// The wait after each event of the first group, in 2⁻¹⁶ ticks.
    pub interval: u32,
    /// The growth of the wait from group to group, in 2⁻¹⁶ ticks.
    pub growth: i32,
}

impl EntryParts {
    /// The entry with these values. With the feature `compact` its waits have 8 fractional bits and
    /// it has at most 256 groups: bits beyond are dropped.
    ///
    /// ```
    /// use stepwright::entry::EntryParts;
    /// let parts =
    ///     EntryParts { pins: 1, then: 0, events: 1, groups: 4, interval: 9_000 << 16, growth: 0 };
    /// assert_eq!(parts.entry().parts(), parts);
    /// ```
    #[inline(always)]
    pub const fn entry(self) -> Entry {
        Entry {
            interval: bytes(self.interval),
            growth: bytes(self.growth as u32),
            events: Events::new(self.events as u16),
            groups: format::groups(self.groups),
            then: self.then,
            pins: self.pins,
        }
    }
}

/// Encodes a wait in 2⁻¹⁶ ticks.
const fn bytes(wait: u32) -> [u8; BYTES] {
    let mut bytes = [0; BYTES];
    let from = wait.to_le_bytes();
    let mut n = 0;
    while n < BYTES {
        bytes[n] = from[n + 4 - BYTES];
        n += 1;
    }
    bytes
}

/// Decodes a wait, in 2⁻¹⁶ ticks.
const fn wait(bytes: [u8; BYTES]) -> u32 {
    let mut to = [0; 4];
    let mut n = 0;
    while n < BYTES {
        to[n + 4 - BYTES] = bytes[n];
        n += 1;
    }
    u32::from_le_bytes(to)
}

impl Entry {
    /// The offset of a field that step interrupts in assembly read.
    pub const INTERVAL: usize = offset_of!(Entry, interval);
    /// See [`INTERVAL`](Entry::INTERVAL).
    pub const GROWTH: usize = offset_of!(Entry, growth);
    /// See [`INTERVAL`](Entry::INTERVAL).
    pub const EVENTS: usize = offset_of!(Entry, events);
    /// See [`INTERVAL`](Entry::INTERVAL).
    pub const GROUPS: usize = offset_of!(Entry, groups);
    /// See [`INTERVAL`](Entry::INTERVAL).
    pub const THEN: usize = offset_of!(Entry, then);
    /// See [`INTERVAL`](Entry::INTERVAL).
    pub const PINS: usize = offset_of!(Entry, pins);

    /// All zeros, so that queues take no flash.
    pub(crate) const EMPTY: Entry = Entry {
        interval: [0; BYTES],
        growth: [0; BYTES],
        events: Events { low: 0, high: 0 },
        groups: 0,
        then: 0,
        pins: 0,
    };

    /// The number of groups.
    const fn count(self) -> u32 {
        format::count(self.groups)
    }

    /// The values of the entry, for a player that takes whole groups.
    ///
    /// ```
    /// use stepwright::{Run, entry::{Sink, Wiring, Writer}};
    /// # struct Last(Option<stepwright::entry::Entry>);
    /// # impl Sink for Last {
    /// #     fn put(&mut self, entry: stepwright::entry::Entry) { self.0 = Some(entry) }
    /// # }
    /// # let mut sink = Last(None);
    /// let mut writer = Writer::new(Wiring::new(1, 2).prompt());
    /// writer.run(&Run::new(1_000 << 16, 3 << 16, 50), &mut sink);
    /// // The first wait comes before the first step; 49 steps and their waits follow.
    /// let parts = sink.0.unwrap().parts();
    /// assert_eq!((parts.groups, parts.events, parts.interval >> 16), (49, 1, 1_003));
    /// assert_eq!(parts.growth >> 16, 3);
    /// ```
    pub const fn parts(self) -> EntryParts {
        EntryParts {
            pins: self.pins,
            then: self.then,
            events: self.events.count(),
            groups: self.count(),
            interval: wait(self.interval),
            growth: wait(self.growth) as i32,
        }
    }

    /// The groups: their pins, their events, and the wait after each event in 2⁻¹⁶ ticks.
    pub fn groups(self) -> impl Iterator<Item = (u8, u32, u32)> {
        let (first, growth) = (wait(self.interval), wait(self.growth));
        (0..self.count()).map(move |n| {
            let pins = if n == 0 { self.pins } else { self.then };
            (pins, self.events.count(), first.wrapping_add(growth.wrapping_mul(n)))
        })
    }

    /// The events one after another, as the step interrupts play them.
    pub fn play(self) -> Play {
        Play::of(self)
    }
}

#[cfg(test)]
mod tests;
