//! Runs that were planned elsewhere: lines and arcs on a board without 64-bit floats.
//!
//! A run is handed out whole, for the engine to play by itself. A soft end cuts it, and after a
//! turn its first step is handed out alone, because half of its interval has passed then. The start
//! checks that its intervals are not too small, because the products for that take a small chip as
//! long as all the rest.

use super::super::program::after;
use super::{ProgramRunner, Stage, Taken};
use stepwright::run::Run;
use stepwright::units::Ticks;

impl ProgramRunner<'_> {
    /// Begins a run.
    #[inline(always)]
    pub(super) fn read_run(&mut self, run: Run, forward: bool) -> Stage {
        if run.count() == 0 {
            // A motor that waits stands: nothing is left to brake.
            if self.is_braking() {
                return Stage::Over;
            }
            self.pace.set(((run.interval() >> 16) as Ticks).max(1));
            self.fresh = false;
            self.rolling.set(false);
            return Stage::Look;
        }
        if self.forward != forward {
            (self.forward, self.free) = (forward, 0);
        }
        (self.left, self.run) = (run.count().into(), run);
        Stage::Run
    }

    /// The run after one that is made, if nothing prevents it: no turn, no wait, no end and no
    /// brake.
    #[inline(always)]
    pub(super) fn by_next_run(&mut self) -> Option<Run> {
        if self.stage != Stage::Run || self.left != 0 || self.is_braking() {
            return None;
        }
        let (run, forward) = self.reader.next_run()?;
        let count = run.count();
        if count == 0 || forward != self.facing || self.free < count.into() {
            return None;
        }
        self.reader.skip();
        (self.left, self.run, self.heading) = (count.into(), run, Some(forward));
        self.plan(count);
        Some(run)
    }

    /// The rest of the run, as far as a soft end allows.
    #[inline(always)]
    pub(super) fn by_run(&mut self) -> Taken {
        let mut first = self.fine(0);
        if let Some(turn) = self.turn(first >> 16) {
            return turn;
        }
        self.heading = Some(self.forward);
        let mut count = self.left.min(u16::MAX.into());
        if self.gone != 0 {
            first = first.saturating_sub(u64::from(core::mem::take(&mut self.gone)) << 16);
            count = 1;
        }
        if self.free < count {
            // Further than this run, so that it is not computed for each run.
            count = self.room(u16::MAX.into()).min(count);
        }
        let count = count as u16;
        if count == 0 {
            self.stage = Stage::Out;
            return Taken::Run(Run::turn((first >> 16) as Ticks, self.facing));
        }
        self.plan(count);
        Taken::Run(Run::new(first, self.run.add(), count))
    }

    /// The interval before the next step of the run, or `back` steps before that, in 2⁻¹⁶ ticks.
    #[inline(always)] // out of line, a Mega's compiler would pass its fields on the stack
    pub(super) fn fine(&self, back: u16) -> u64 {
        let made = self.run.count().wrapping_sub(self.left as u16).saturating_sub(back);
        if made == 0 { self.run.interval() } else { after(self.run, made) }
    }
}
