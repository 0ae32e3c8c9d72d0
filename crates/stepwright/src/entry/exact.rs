//! Entries that equal their runs to the last bit, for a [prompt](super::Wiring::prompt) player.

use super::writer::{Due, Sink, Writer};
use super::{Entry, Events, NEAR, bytes};
use crate::format;
use crate::run::Run;
use crate::units::Ticks;

impl Writer {
    pub(super) fn exact_turn(&mut self, wait: Ticks, changes: bool, to: &mut impl Sink) {
        self.exact_wait(u64::from(wait) << 16, to);
        self.due = if changes { Due::Turn } else { Due::Nothing };
    }

    pub(super) fn exact_run(&mut self, run: &Run, to: &mut impl Sink) {
        let mut rest = *run;
        if self.due != Due::Step || run.count == 1 {
            self.exact_wait(run.interval(), to);
            self.due = Due::Step;
            rest = Run::new(
                run.interval().wrapping_add_signed(run.add.into()),
                run.add,
                run.count.saturating_sub(1),
            );
        }
        let first = rest.interval() as u32;
        let step = self.wiring.step;
        match rest.count {
            0 => {}
            count if rest.add == 0 => to.put(exact(first, 0, Events::new(count), 1, step, step)),
            count => to.put(exact(first, rest.add, Events::ONE, count.into(), step, step)),
        }
    }

    pub(super) fn exact_end(&mut self, to: &mut impl Sink) {
        if self.due == Due::Step {
            // Nothing follows.
            to.put(exact(0, 0, Events::ONE, 1, 0, self.pins()));
        }
        self.forget();
    }

    /// Writes the pins that are due and a wait in 2⁻¹⁶ ticks, as 2^k events. The remainder is added
    /// to the next wait.
    fn exact_wait(&mut self, wait: u64, to: &mut impl Sink) {
        let mut part = wait.wrapping_add_signed(self.owed.into());
        let mut k = 0u32;
        while part >> 16 >= u64::from(NEAR) {
            part >>= 1;
            k += 1;
        }
        let all = part << k;
        self.owed = wait.wrapping_add_signed(self.owed.into()).wrapping_sub(all) as i32;
        to.put(exact(part as u32, 0, Events::ONE, 1 << k, 0, self.pins()));
    }
}

/// An entry with an interval and a growth in 2⁻¹⁶ ticks.
fn exact(wait: u32, growth: i32, events: Events, groups: u32, then: u8, pins: u8) -> Entry {
    let (interval, growth) = (bytes(wait), bytes(growth as u32));
    Entry { interval, growth, events, groups: format::groups(groups), then, pins }
}
