//! A [`Ramp`] as a feed: the engine asks it for one step at a time.

use super::ramp::{BITS, LONGEST, Ramp};
use crate::queue::{Feed, Taken};
use crate::run::Run;
use crate::units::Ticks;

/// No interval is ready: the travel is over. So is anything above: the assembly
/// sets the highest byte.
const NOTHING: u32 = 0xFF00_0000;

/// The travel of one axis, its next interval computed one step ahead.
// The layout up to the ramp's end is the one that `short.rs` knows.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Direct {
    /// The interval after the next pulse, in 2⁻⁸ ticks.
    pub(crate) ready: u32,
    pub(crate) ramp: Ramp,
    /// From the beginning to the change of direction.
    hold: Ticks,
    /// From there to the first pulse.
    lead: Ticks,
    stage: Stage,
    forward: bool,
}

/// How far a travel's beginning is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Stage {
    Turn,
    Lead,
    Steps,
}

impl Direct {
    /// Nothing to do.
    pub const IDLE: Direct = Direct {
        ready: NOTHING,
        ramp: Ramp::NONE,
        hold: 0,
        lead: 0,
        stage: Stage::Steps,
        forward: true,
    };

    /// A travel: `hold` ticks after the start its direction is set, its first
    /// pulse comes `lead` ticks later.
    pub fn begin(&mut self, forward: bool, hold: Ticks, lead: Ticks, ramp: Ramp) {
        let lead = lead.min(LONGEST);
        *self = Direct { ready: NOTHING, ramp, hold, lead, stage: Stage::Turn, forward };
        // The first interval is computed here: the interrupt would be late.
        self.prepare();
    }

    /// Computes the interval after the one that is ready: 300 to 900 cycles on
    /// an AVR.
    #[cfg(not(target_arch = "avr"))]
    fn prepare(&mut self) {
        self.ready = self.ramp.step().unwrap_or(NOTHING);
    }

    #[cfg(target_arch = "avr")]
    fn prepare(&mut self) {
        unsafe extern "C" {
            fn stepwright_direct_step(travel: *mut Direct);
        }
        // SAFETY: `direct_way!` has it. It touches what lies there and nothing
        // else; its layout is asserted in `short.rs`.
        unsafe { stepwright_direct_step(self) };
    }

    /// Brakes from where it is: the interval that is ready and the one after it
    /// are still of the ramp up.
    pub fn brake(&mut self) {
        self.ramp.brake();
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
        let fine = self.ready;
        if fine >= NOTHING {
            return Taken::End;
        }
        self.prepare();
        Taken::Run(Run::new(u64::from(fine) << (16 - BITS), 0, 1))
    }

    fn clear(&mut self) {
        (self.ready, self.stage) = (NOTHING, Stage::Steps);
        self.ramp = Ramp::NONE;
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
        feed.begin(false, 20, 1_000, Ramp::new(3, 50_000, 2_500));
        let steady = |ticks| Run::steady(ticks, 1);
        let want = [Run::turn(20, false), steady(1_000), steady(50_000), steady(30_000)];
        assert_eq!(taken(&mut feed), want);
        assert_eq!(feed.take(), Taken::End);
    }

    /// On hosts and chips an interval keeps its 2⁻⁸ ticks: the top speed is exact.
    #[test]
    fn fractions_reach_the_deadlines() {
        let mut feed = Direct::IDLE;
        feed.begin(true, 0, 100, Ramp::new(10, 50_000, 2_500));
        let runs = taken(&mut feed);
        assert_eq!(runs[4].interval(), (30_000u64 * 7 / 9) << 16 | 0x5600); // 23,333.34
    }

    #[test]
    fn forgotten_is_over() {
        let mut feed = Direct::IDLE;
        feed.begin(true, 0, 100, Ramp::new(10, 50_000, 2_500));
        feed.take();
        feed.clear();
        assert_eq!(feed.take(), Taken::End);
    }
}
