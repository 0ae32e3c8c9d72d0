//! An entry: "pins, then wait", many times over.
//!
//! What the engine and the step interrupts of a chip play. An entry is a number
//! of *groups*, a group a number of *events* with the same pins and the same
//! wait; the wait grows from group to group:
//!
//! ```text
//!   pins      pins      then      then      then      then
//!    │interval │interval │ +growth │ +growth │+2·growth│ …
//!   ─┴─────────┴─────────┴─────────┴─────────┴─────────┴───► ticks
//!    └───── group 1 ─────┘└────── group 2 ───┘└─ …
//! ```
//!
//! A step, a turn, a hold and a long interval are one kind: a step sets its pin
//! and waits, a turn toggles DIR and waits, a hold sets nothing, and a long
//! interval is a step followed by waits without a pin. What plays them looks at
//! nothing but the next deadline.
//!
//! A [`Run`](crate::run::Run) is "wait, then step", so its last step belongs to the entry that
//! follows it: [`Writer`] keeps what is due and makes entries of runs.
//!
//! # Error
//!
//! An entry has 11 bytes on an AVR, as its step interrupts add three of them to a
//! deadline. Waits have 8 bits behind the point then, half as many as a run's
//! intervals, and so has what is made for such interrupts on the virtual board. Every
//! entry rounds to the nearest, and what is left is added to the next: deadlines
//! at the ends of runs stay within 1/512 tick a step of that run, and of the few
//! that are joined with it, and do not drift. Steps that are joined share what
//! their intervals are in all. Between the ends, the growth of a run is played in
//! groups that deviate by one tick at most, and rounded to 1/256 tick a group: less
//! than eight ticks for all that the planner makes of ramps.
//!
//! For a [prompt](Wiring::prompt) player an entry is its run: to the last bit, step by
//! step.

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

/// Waits of this many ticks or more are several events: half a turn of a counter
/// of 16 bits, less what a deadline may have passed by.
pub const NEAR: Ticks = 0x7F00;

/// No event comes sooner after a turn or a hold on an AVR, in ticks: the interrupts of three
/// axes that begin together take over their next groups meanwhile.
pub const LEAST: Ticks = 1200;

/// Behind the last step of a travel, in ticks: late is what comes later than half of it. Three axes
/// may step at once, with pulses of 20 µs that are held.
const LAST: Ticks = 2 * LEAST;

/// The most entries that one run becomes, with those of a run that was kept.
pub const MOST: u8 = 3;

/// Events of a group, 1 … 65536, as an 8-bit chip counts them down: `high` · 256
/// + `low`, where a `low` of 0 means 256.
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

    /// How many they are.
    pub const fn count(self) -> u32 {
        let low = if self.low == 0 { 256 } else { self.low as u32 };
        (self.high as u32) * 256 + low
    }
}

/// Pins, then a wait: see the [module](self).
///
/// The layout is the one that step interrupts in assembly know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Entry {
    /// The wait after each event of the first group.
    interval: [u8; BYTES],
    /// What the wait grows by from group to group.
    growth: [u8; BYTES],
    /// Events of a group.
    events: Events,
    /// Groups.
    groups: Groups,
    /// Pins of the second group and of all that follow.
    then: u8,
    /// Pins of the first group.
    pins: u8,
}

/// What an [`Entry`] is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryParts {
    /// Pins of the first group.
    pub pins: u8,
    /// Pins of the groups after it.
    pub then: u8,
    /// Events of a group, 1 … 65536.
    pub events: u32,
    /// Groups, at least 1.
    pub groups: u32,
    /// The wait after each event of the first group, in 2⁻¹⁶ ticks.
    pub interval: u32,
    /// By how much the wait grows from group to group, in 2⁻¹⁶ ticks.
    pub growth: i32,
}

impl EntryParts {
    /// The entry that is made of them. Of an 8-bit chip's waits 8 bits are behind the point, and it
    /// has at most 256 groups: what is beyond falls off.
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

/// A wait in 2⁻¹⁶ ticks as an entry has it.
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

/// The wait in 2⁻¹⁶ ticks that an entry has so.
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
    /// Where an entry has what step interrupts in assembly read.
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

    /// All zeros, so that queues need no room in flash.
    pub(crate) const EMPTY: Entry = Entry {
        interval: [0; BYTES],
        growth: [0; BYTES],
        events: Events { low: 0, high: 0 },
        groups: 0,
        then: 0,
        pins: 0,
    };

    /// How many groups it has.
    const fn count(self) -> u32 {
        format::count(self.groups)
    }

    /// What it is made of, for a player that takes whole groups.
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

    /// Its groups: their pins, events, and the wait after each in 2⁻¹⁶ ticks.
    pub fn groups(self) -> impl Iterator<Item = (u8, u32, u32)> {
        let (first, growth) = (wait(self.interval), wait(self.growth));
        (0..self.count()).map(move |n| {
            let pins = if n == 0 { self.pins } else { self.then };
            (pins, self.events.count(), first.wrapping_add(growth.wrapping_mul(n)))
        })
    }

    /// One event after another, as the step interrupts play them.
    pub fn play(self) -> Play {
        Play::of(self)
    }
}

#[cfg(test)]
mod tests;
