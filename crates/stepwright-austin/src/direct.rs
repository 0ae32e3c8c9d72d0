//! [`Carried`] as a feed: computes a law in the step interrupt.
//!
//! The engine asks for one step at a time. Each interval is computed after the pulse before it, and
//! loaded one step later. The cost is one division per step.
//!
//! ```text
//!   STEP    ┌───┐             ┌───┐
//!        ───┘   └─────────────┘   └──────
//!           │ load c(n)       │ load c(n+1)
//!           └── compute c(n+1)└── compute c(n+2)
//! ```

use super::carried::{BITS, Carried, LONGEST};
use stepwright::queue::{Feed, Taken};
use stepwright::run::Run;
use stepwright::units::Ticks;

/// The travel of one axis, with its next interval computed one step ahead.
#[derive(Clone, Debug)]
pub struct Direct {
    /// The interval after the next pulse, in 2⁻⁸ ticks; `None` once the travel is over.
    ready: Option<u32>,
    ramp: Carried,
    /// Ticks from the beginning to the change of direction.
    hold: Ticks,
    /// Ticks from there to the first pulse.
    lead: Ticks,
    stage: Stage,
    forward: bool,
}

/// How far the beginning of a travel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Turn,
    Lead,
    Steps,
}

impl Direct {
    /// Nothing to do.
    pub const IDLE: Direct = Direct {
        ready: None,
        ramp: Carried::NONE,
        hold: 0,
        lead: 0,
        stage: Stage::Steps,
        forward: true,
    };

    /// Begins a travel: its direction is set `hold` ticks after the start, and its first pulse
    /// comes `lead` ticks later.
    pub fn begin(&mut self, forward: bool, hold: Ticks, lead: Ticks, ramp: Carried) {
        let lead = lead.min(LONGEST);
        *self = Direct { ready: None, ramp, hold, lead, stage: Stage::Turn, forward };
        // The first interval is computed here, because the interrupt would be late.
        self.prepare();
    }

    /// Computes the interval after the one that is ready: 530 cycles on an AVR, at most 1,600.
    fn prepare(&mut self) {
        self.ready = self.ramp.step();
    }

    /// Brakes from here: the interval that is ready and the one after it are still those of the
    /// ramp up.
    pub fn stop(&mut self) {
        self.ramp.stop();
    }
}

impl Feed for Direct {
    fn take(&mut self) -> Taken {
        match self.stage {
            Stage::Turn => {
                self.stage = Stage::Lead;
                return Taken::Run(Run::turn(self.hold, self.forward));
            }
            Stage::Lead => {
                self.stage = Stage::Steps;
                return Taken::Run(Run::steady(self.lead, 1));
            }
            Stage::Steps => {}
        }
        let Some(fine) = self.ready else { return Taken::End };
        self.prepare();
        Taken::Run(Run::new(u64::from(fine) << (16 - BITS), 0, 1))
    }

    fn clear(&mut self) {
        (self.ready, self.stage) = (None, Stage::Steps);
        self.ramp = Carried::NONE;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn taken(feed: &mut Direct) -> Vec<Run> {
        let mut runs = Vec::new();
        while let Taken::Run(run) = feed.take() {
            runs.push(run);
        }
        runs
    }

    #[test]
    fn a_travel_is_a_turn_a_lead_and_the_ramp() {
        let mut feed = Direct::IDLE;
        assert_eq!(feed.take(), Taken::End);
        feed.begin(false, 20, 1_000, Carried::new(3, 50_000, 2_500));
        let steady = |ticks| Run::steady(ticks, 1);
        let want = [Run::turn(20, false), steady(1_000), steady(50_000), steady(30_000)];
        assert_eq!(taken(&mut feed), want);
        assert_eq!(feed.take(), Taken::End);
    }

    /// On hosts and chips an interval keeps its 2⁻⁸ ticks: the top speed is exact.
    #[test]
    fn fractions_reach_the_deadlines() {
        let mut feed = Direct::IDLE;
        feed.begin(true, 0, 100, Carried::new(10, 50_000, 2_500));
        let runs = taken(&mut feed);
        assert_eq!(runs[4].interval(), (30_000u64 * 7 / 9) << 16 | 0x5600); // 23,333.34
    }

    #[test]
    fn forgotten_is_over() {
        let mut feed = Direct::IDLE;
        feed.begin(true, 0, 100, Carried::new(10, 50_000, 2_500));
        feed.take();
        feed.clear();
        assert_eq!(feed.take(), Taken::End);
    }
}
