//! A program on the fixed tick for a chip that is not called at each tick: the ticks with steps are
//! computed, and only they are played.
//!
//! STEP rises a tick before a step's own tick, as with three passes. So the first step, and one
//! after a wait or a turn, comes a tick earlier than its delay says; the time after a step counts
//! from that earlier tick.

use super::{ProgramRunner, Stage, Taken};
use stepwright::run::Run;

impl ProgramRunner<'_> {
    /// The next run, or `None` if the present stage is the same as by deadlines.
    pub(super) fn on_grid(&mut self) -> Option<Taken> {
        let period = self.beat.period();
        loop {
            match self.stage {
                Stage::Leg => match self.read() {
                    None => return Some(Taken::End),
                    Some(Stage::Over) => self.stage = Stage::Linger,
                    Some(Stage::Wait) => {
                        let wait = self.ticked(self.pending);
                        self.pending = wait.saturating_add(self.own_tick().into());
                        self.stage = Stage::Wait;
                    }
                    Some(stage) => self.stage = stage,
                },
                Stage::Wait if self.pending == 0 => self.stage = Stage::Leg,
                Stage::Steps if self.left == 0 => self.stage = Stage::Leg,
                Stage::Steps => {
                    let Some(delay) = self.braked() else {
                        self.stage = Stage::Linger;
                        continue;
                    };
                    if self.turn(0).is_some() {
                        let tick = self.own_tick();
                        let wait = self.beat.wait(tick).saturating_add(self.hold);
                        return Some(Taken::Run(Run::turn(wait, self.facing)));
                    }
                    self.heading = Some(self.forward);
                    let over = self.over.get();
                    let way = self.ticked(delay.into());
                    // Whole ticks: steps of one interval are one run.
                    if self.risen.get()
                        && self.over.get() == over
                        && delay <= self.beat.piece
                        && !self.is_braking()
                    {
                        let count = self.room(self.left.min(self.beat.longest().into())) as u16;
                        if count > 0 {
                            self.plan(count);
                            return Some(Taken::Run(self.beat.steps(delay, count)));
                        }
                    }
                    let early = if self.risen.get() { 0 } else { period };
                    self.pending = way.saturating_sub(early.into());
                    self.risen.set(true);
                    self.stage = Stage::Far;
                }
                Stage::Linger if self.risen.get() => {
                    let tick = self.own_tick();
                    return Some(self.pass(tick));
                }
                Stage::Linger => {
                    self.end();
                    return Some(self.pass(period));
                }
                _ => return None,
            }
        }
    }

    /// µs from here to the tick of the last step.
    fn own_tick(&mut self) -> u32 {
        if self.risen.take() { self.beat.period() } else { 0 }
    }
}
