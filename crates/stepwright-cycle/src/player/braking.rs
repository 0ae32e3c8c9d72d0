//! A program while its motor brakes.

use super::{BRAKES, Brake, Faults, PACED, ProgramRunner, Stage, Taken};
use stepwright::run::Run;

impl ProgramRunner<'_> {
    /// Begins to brake, with `left` steps of its run to make; the next of them will be made.
    /// Returns false if the motor stands at once.
    pub(crate) fn brake(&mut self, left: u16) -> bool {
        if BRAKES && (self.rolling.get() || left < self.handed.get()) {
            let interval = self.interval(left);
            self.brake.set(Brake::new(self.beat.hz(), interval, self.motor.decel));
        }
        self.is_braking()
    }

    /// The interval of the program, this many steps before the next one to be handed out, in 2⁻¹⁶
    /// ticks.
    #[cfg_attr(not(feature = "runs"), allow(unused_variables))] // steps of a leg have one interval
    fn interval(&self, back: u16) -> u64 {
        let ticks = match self.stage {
            #[cfg(feature = "runs")]
            Stage::Run => self.fine(back) >> 16,
            _ if PACED && self.reader.has_own_paces() => u64::from(self.own.get()),
            _ => self.beat.ticks(self.delay),
        };
        ticks.min(1 << 31) << 16
    }

    /// The interval before the next step of the program, in 2⁻¹⁶ ticks, while the motor brakes;
    /// `None` if it does not make that step any more.
    pub(super) fn slower(&mut self) -> Option<u64> {
        let interval = self.interval(0);
        let mut brake = self.brake.get()?;
        // Where the program turns, the motor stands.
        let next = if self.forward == self.facing { brake.next(interval) } else { None };
        self.brake.set(Some(brake));
        next
    }

    /// The next step by deadlines while the motor brakes.
    pub(super) fn brake_on(&mut self) -> Taken {
        let Some(interval) = self.slower() else {
            self.end();
            return Taken::End;
        };
        self.heading = Some(self.forward);
        if self.room(1) == 0 {
            return self.trip(Faults::soft(self.forward), self.strategies.soft_end);
        }
        let before = match self.stage {
            Stage::Pace => self.before.get(),
            _ => 0,
        };
        if self.stage == Stage::Pace {
            self.stage = Stage::Leg;
        }
        self.plan(1);
        Taken::Run(Run::new(interval.saturating_sub(u64::from(before) << 16), 0, 1))
    }
}
