//! A program on stepper_h's fixed tick: bounds are checked two ticks before a step, STEP rises one
//! tick before, and the step counts where STEP falls. The part of a delay that is less than a tick
//! is added to the next delay.

use super::{Faults, ProgramRunner, Stage, Taken};
use crate::wide::remainder;
use stepwright::units::Ticks;

impl ProgramRunner<'_> {
    /// µs before the next step of the leg, more while the motor brakes; `None` if it stands then.
    pub(super) fn braked(&mut self) -> Option<u32> {
        if !self.is_braking() {
            return Some(self.delay);
        }
        let ticks = Ticks::try_from(self.slower()? >> 16).unwrap_or(Ticks::MAX);
        Some(self.delay.max(self.beat.micros(ticks)))
    }

    /// The time from the last step to one `us` µs later in whole ticks, in µs; the rest is carried.
    pub(super) fn ticked(&mut self, us: u64) -> u64 {
        let period = self.beat.period().max(1);
        let us = us.saturating_add(self.over.get().into());
        // Bit by bit takes a small chip three times as long.
        let over = match u32::try_from(us) {
            Ok(us) => us % period,
            Err(_) => remainder(us, period),
        };
        self.over.set(over);
        us.wrapping_sub(over.into())
    }

    /// The next run on the fixed tick.
    pub(super) fn by_tick(&mut self) -> Taken {
        let period = self.beat.period();
        loop {
            match self.stage {
                Stage::Leg => match self.read() {
                    None => return Taken::End,
                    Some(Stage::Over) => {
                        self.end();
                        self.stage = Stage::Linger;
                    }
                    Some(Stage::Wait) => {
                        self.pending = self.ticked(self.pending);
                        self.stage = Stage::Wait;
                    }
                    Some(stage) => self.stage = stage,
                },
                Stage::Wait if self.pending > 0 => return self.pass_piece(),
                Stage::Wait => self.stage = Stage::Leg,
                Stage::Steps if self.left == 0 => self.stage = Stage::Leg,
                Stage::Steps => {
                    let Some(delay) = self.braked() else {
                        self.end();
                        self.stage = Stage::Linger;
                        continue;
                    };
                    if let Some(turn) = self.turn(0) {
                        return turn;
                    }
                    let way = self.ticked(delay.into());
                    self.pending = way.saturating_sub(2 * u64::from(period));
                    self.stage = Stage::Approach;
                }
                Stage::Approach if self.pending > 0 => {
                    self.heading = Some(self.forward);
                    return self.pass_piece();
                }
                Stage::Approach => {
                    if self.room(1) == 0 {
                        return self.trip(Faults::soft(self.forward), self.strategies.soft_end);
                    }
                    self.heading = Some(self.forward);
                    self.stage = Stage::Drop;
                    self.plan(1);
                    return Taken::Run(self.beat.steps(period, 1));
                }
                Stage::Drop => {
                    self.stage = Stage::Steps;
                    return self.pass(period);
                }
                Stage::Linger => {
                    self.stage = Stage::Over;
                    return self.pass(period);
                }
                _ => return Taken::End,
            }
        }
    }
}
