//! Plays entries, one event after another.

use super::{Entry, wait};
use crate::format::{Alike, Left};

/// The events of an [`Entry`]: the pins, and the wait after them in 2⁻¹⁶ ticks.
///
/// Defines how an entry is played. Interrupts in assembly do the same.
#[derive(Clone, Debug)]
pub struct Play {
    /// The wait of the present group.
    wait: u32,
    pins: u8,
    /// Events in a group, and those left of the present group; 0 stands for 65536.
    events: u16,
    left: u16,
    /// Groups left, including the present one; 0 at the end.
    groups: Left,
    growth: u32,
    then: u8,
}

impl Play {
    /// An entry that has been played to its end.
    pub(crate) const NONE: Play =
        Play { wait: 0, pins: 0, events: 0, left: 0, groups: 0, growth: 0, then: 0 };

    pub(super) fn of(entry: Entry) -> Play {
        let events = entry.events.count() as u16;
        Play {
            wait: wait(entry.interval),
            pins: entry.pins,
            events,
            left: events,
            groups: entry.count() as Left,
            growth: wait(entry.growth),
            then: entry.then,
        }
    }

    /// Sets one group of 1 … 65535 events, whose waits are in 2⁻¹⁶ ticks.
    #[inline(always)]
    pub(crate) fn set(&mut self, pins: u8, wait: u32, events: u16) {
        (self.pins, self.wait) = (pins, wait);
        (self.events, self.left, self.groups) = (events, events, 1);
    }

    /// Sets 1 … 65535 events whose waits grow by `growth` from one to the next: the first has
    /// `pins`, the others `then`.
    #[inline(always)]
    pub(crate) fn grow(&mut self, pins: u8, then: u8, wait: u32, growth: i32, count: u16) {
        (self.pins, self.then, self.wait, self.growth) = (pins, then, wait, growth as u32);
        (self.events, self.left, self.groups) = (1, 1, count.into());
    }

    /// Skips the next event if it is the same as the last one and not the last of its group.
    #[inline(always)]
    pub(crate) fn again(&mut self) -> bool {
        // A group that is over has no events left, as before its first event.
        let again = self.left > 1 && self.left != self.events;
        if again {
            self.left = self.left.wrapping_sub(1);
        }
        again
    }

    /// Whether the next event is in the last group, or there is none.
    #[inline(always)]
    pub(crate) fn is_last(&self) -> bool {
        self.groups <= 1
    }

    /// Takes out the events that are like the step of `pins` before them: steps at one speed, or of
    /// one parabola. The last event of a group of several stays, and so do the last two groups of
    /// one event. Returns their number, and by how much the wait of each is longer than the
    /// previous one, in 2⁻¹⁶ ticks.
    #[cfg(not(feature = "compact"))]
    #[inline(always)]
    pub(crate) fn take_alike(&mut self, pins: u8) -> (u32, u32) {
        if self.left > 1 && self.left != self.events {
            let count = self.left.wrapping_sub(1);
            self.left = 1;
            return (count.into(), 0);
        }
        let other = self.events ^ 1 | u16::from((self.pins ^ pins) | (self.then ^ pins));
        if other != 0 || self.groups <= 2 {
            return (0, 0);
        }
        let count = self.groups.wrapping_sub(2);
        self.groups = 2;
        self.wait = self.wait.wrapping_add(self.growth.wrapping_mul(count));
        (count, self.growth)
    }

    /// Takes out events that are waits of the same length as the one before them, and that take no
    /// more than `hop` together with it. Returns how long they all take.
    #[cfg(not(feature = "compact"))]
    pub(crate) fn join(&mut self, wait: u32, hop: u64) -> u64 {
        let one = u64::from(wait);
        if self.groups == 0 || self.pins != 0 {
            return one;
        }
        let count = |events: u16| u32::from(events.wrapping_sub(1)) + 1;
        let more = self.groups.wrapping_sub(1);
        if self.then == 0 && self.growth == 0 {
            // 64-bit products take a 32-bit chip long.
            let all = if self.events == 1 {
                one * u64::from(more.saturating_add(2))
            } else {
                let more = u64::from(more) * u64::from(count(self.events));
                one.saturating_mul(more + u64::from(count(self.left)) + 1)
            };
            if all <= hop {
                self.groups = 0;
                return all;
            }
        }
        // Events of this group, except its last.
        let rest = count(self.left) - 1;
        if rest == 0 {
            // Mostly the case: avoids a division, which takes a thousand instructions.
            return one;
        }
        let some = u64::from(rest).min((hop / one.max(1)).saturating_sub(1));
        self.left = self.left.wrapping_sub(some as u16);
        one * (some + 1)
    }

    /// How long the events that are left take, in ticks, including those in `taken`. All count with
    /// the wait of the next event, which is within a quarter of the waits they grow to; at most
    /// 65535 are counted.
    pub(crate) fn waits(&self, taken: Alike) -> u32 {
        if self.groups == 0 {
            return 0;
        }
        let count = |events: u16| u32::from(events.wrapping_sub(1)) + 1;
        let more = u32::from(self.groups.wrapping_sub(1) as u16).saturating_mul(count(self.events));
        let all = count(self.left).saturating_add(more).saturating_add(taken.count());
        // The wait in 16 bits.
        all.min(0xFFFF).wrapping_mul(taken.before(self.wait) >> 16)
    }

    /// Events left of the present group, or groups of one event.
    pub(crate) fn left(&self) -> u16 {
        match (self.groups, self.events) {
            (0, _) => 0,
            (groups, 1) => groups as u16,
            _ => self.left,
        }
    }
}

impl Iterator for Play {
    type Item = (u8, u32);

    #[inline]
    fn next(&mut self) -> Option<(u8, u32)> {
        if self.groups == 0 {
            return None;
        }
        let event = (self.pins, self.wait);
        self.left = self.left.wrapping_sub(1);
        if self.left == 0 {
            self.groups -= 1;
            if self.groups != 0 {
                self.wait = self.wait.wrapping_add(self.growth);
                (self.pins, self.left) = (self.then, self.events);
            }
        }
        Some(event)
    }
}
