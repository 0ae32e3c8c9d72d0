//! The two clocks of a cycle, and µs in ticks of the step timer.
//!
//! A delay of d µs is d·f/10⁶ ticks. It is stored in 2⁻¹⁶ ticks, and the rounding of a run is
//! carried in 10⁻⁶ of these: no step is further than 1/16 tick from its time, and no error
//! accumulates.

use stepwright::run::Run;
use stepwright::units::{Rate, Ticks};

use super::brake::BRAKES;
use super::kept::Kept;
use super::wide::product;

/// The clock that places the edges of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clock {
    /// Every step at its own deadline: any delay, to a tick of the timer.
    #[default]
    Deadlines,
    /// stepper_h's fixed tick: steps are rounded down to ticks of `period` µs since the start, and
    /// the rest is carried; a step takes three passes.
    ///
    /// ```text
    ///   tick     n−2      n−1       n
    ///   bounds    ╳
    ///   STEP      ________▔▔▔▔▔▔▔▔▔▔________
    ///                              step counted
    /// ```
    Tick {
        /// µs, 1 and more.
        period: u32,
    },
    /// The fixed tick for a chip that has no time for ticks without a step: a step takes one pass.
    /// STEP rises where that of [`Tick`](Clock::Tick) does, falls after the board's own pulse
    /// length, and the step counts as STEP rises.
    ///
    /// ```text
    ///   tick     n−2      n−1       n
    ///   bounds    ╳
    ///   STEP      ________▔▔__________
    ///                     step counted
    /// ```
    Grid {
        /// µs, 1 and more.
        period: u32,
    },
}

/// One million.
const MILLION: u64 = 1_000_000;

/// Whether there is a fixed tick with three passes per step, and one with one pass: without it,
/// none of its code is compiled.
pub(crate) const TICKS: bool = cfg!(feature = "tick");
pub(crate) const GRID: bool = cfg!(feature = "grid");
/// 1 if there is one of them.
pub(crate) const ANY_TICK: usize = (TICKS || GRID) as usize;
/// Whether the timer may have any rate. If not, nothing is ever divided by it in 64 bits.
const ANY_RATE: bool = cfg!(feature = "any-rate");

/// A clock's times in ticks of the timer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beat {
    hz: Kept<u32, { (ANY_RATE || BRAKES) as usize }>,
    /// Ticks per µs, if they are whole; 0 if not. If whole, nothing is ever divided or lost: a
    /// 64-bit division takes a small chip longer than a step.
    whole: u16,
    /// The fixed tick in µs; 0: none.
    period: Kept<u32, ANY_TICK>,
    /// Whether it takes three passes per step.
    passes: Kept<bool, ANY_TICK>,
    /// Waits are handed out in pieces of at most this many µs, below 2³¹ ticks.
    pub piece: u32,
    /// See [`longest`](Beat::longest).
    longest: Kept<u16, { ANY_RATE as usize }>,
    /// The rounding so far, in 10⁻⁶ of 2⁻¹⁶ ticks.
    lost: Kept<u64, { ANY_RATE as usize }>,
}

impl Beat {
    pub(crate) const fn new(clock: Clock, rate: Rate) -> Beat {
        let hz = rate.hz();
        Beat {
            hz: Kept::new(hz),
            // At most 4,294.
            whole: if ANY_RATE && !hz.is_multiple_of(1_000_000) {
                0
            } else {
                (hz / 1_000_000) as u16
            },
            period: Kept::new(match clock {
                Clock::Deadlines => 0,
                Clock::Tick { period: 0 } | Clock::Grid { period: 0 } => 1,
                Clock::Tick { period } | Clock::Grid { period } => period,
            }),
            passes: Kept::new(matches!(clock, Clock::Tick { .. })),
            piece: (1 << 31) / (hz / 1_000_000 + 1),
            longest: Kept::new(match hz % 1_000_000 {
                0 => u16::MAX,
                _ => 1 << 12,
            }),
            lost: Kept::new(0),
        }
    }

    /// The fixed tick in µs; 0: none.
    #[inline(always)]
    pub(crate) fn period(&self) -> u32 {
        self.period.get()
    }

    /// Begins a new cycle, without rounding so far.
    pub(crate) fn reset(&mut self) {
        self.lost.set(0);
    }

    /// The interval of `us` ≤ [`piece`](Beat::piece), in 2⁻¹⁶ ticks, for `count` ≥ 1 steps one
    /// after another.
    fn interval(&mut self, us: u32, count: u16) -> u64 {
        if self.is_whole() {
            // Below 2³¹: `piece` ensures it.
            return u64::from(us.wrapping_mul(self.whole())) << 16;
        }
        let fine = u64::from(us) * u64::from(self.hz());
        let (ticks, rest) = (fine / MILLION, (fine % MILLION) << 16);
        let count = u64::from(count.max(1));
        // 20 + 16 bits, and as many again for the carried rounding.
        let lost = self.lost.get().wrapping_add((rest % MILLION).wrapping_mul(count));
        let share = MILLION.wrapping_mul(count);
        self.lost.set(lost % share);
        (ticks << 16) + rest / MILLION + lost / share
    }

    /// `count` steps, one every `us` ≤ [`piece`](Beat::piece).
    pub(crate) fn steps(&mut self, us: u32, count: u16) -> Run {
        Run::new(self.interval(us, count), 0, count)
    }

    /// A step `us` ≤ [`piece`](Beat::piece) after the last one, of which `gone` ticks have passed.
    pub(crate) fn step(&mut self, us: u32, gone: Ticks) -> Run {
        Run::new(self.interval(us, 1).saturating_sub(u64::from(gone) << 16), 0, 1)
    }

    /// `us` ≤ [`piece`](Beat::piece) in whole ticks; the rest is carried.
    pub(crate) fn wait(&mut self, us: u32) -> Ticks {
        let fine = self.interval(us, 1);
        if self.is_whole() {
            return (fine >> 16) as Ticks;
        }
        self.lost.set(self.lost.get().wrapping_add((fine & 0xFFFF) * MILLION));
        Ticks::try_from(fine >> 16).unwrap_or(Ticks::MAX)
    }

    /// Whether this is the fixed tick of three passes.
    #[inline(always)]
    pub(crate) fn is_fixed(&self) -> bool {
        TICKS && self.passes.get()
    }

    /// Whether steps have deadlines of their own.
    pub(crate) fn is_free(&self) -> bool {
        !self.is_fixed() && !self.is_grid()
    }

    /// Whether this is the fixed tick of one pass.
    #[inline(always)]
    pub(crate) fn is_grid(&self) -> bool {
        GRID && self.period() != 0 && !self.is_fixed()
    }

    /// The ticks of the timer to the next point on the grid of the fixed tick, rounded up; 0
    /// without a fixed tick. They count from `ticks` < 2³² after a place that is `passed` beyond
    /// the grid. `passed` is then set for that later place, in ticks, or in millionths of ticks if
    /// a µs is not whole.
    pub(crate) fn until_grid(&self, passed: &mut u64, ticks: Ticks) -> Ticks {
        if self.period() == 0 {
            return 0;
        }
        // Below 2³¹: `piece` ensures it, and no chip has a longer tick.
        if self.is_whole() && (!ANY_RATE || self.period() <= self.piece) {
            let grid = self.period().wrapping_mul(self.whole()).max(1);
            let beyond = (ticks % grid).wrapping_add(*passed as Ticks) % grid;
            *passed = beyond.into();
            return if beyond == 0 { 0 } else { grid.wrapping_sub(beyond) };
        }
        let grid = u64::from(self.period()) * u64::from(self.hz());
        *passed = passed.wrapping_add(u64::from(ticks) * MILLION) % grid.max(1);
        match *passed {
            0 => 0,
            beyond => grid.wrapping_sub(beyond).div_ceil(MILLION) as Ticks,
        }
    }

    /// The most steps of a run for which it stays exact to 1/16 tick.
    pub(crate) fn longest(&self) -> u16 {
        if ANY_RATE { self.longest.get() } else { u16::MAX }
    }

    /// Ticks of the timer per second.
    pub(crate) fn hz(&self) -> u32 {
        self.hz.get()
    }

    /// Converts µs to ticks of the timer, rounded down.
    pub(crate) fn ticks(&self, us: u32) -> u64 {
        match self.is_whole() {
            false => u64::from(us) * u64::from(self.hz()) / MILLION,
            true => product(us, self.whole()),
        }
    }

    fn whole(&self) -> u32 {
        self.whole.into()
    }

    /// Whether a µs is a whole number of ticks.
    fn is_whole(&self) -> bool {
        !ANY_RATE || self.whole != 0
    }

    /// Converts ticks of the timer to µs, rounded down.
    #[cfg(feature = "runs")]
    pub(crate) fn whole_micros(&self, ticks: Ticks) -> u32 {
        if self.is_whole() {
            return ticks / self.whole().max(1);
        }
        let us = u64::from(ticks) * MILLION / u64::from(self.hz().max(1));
        u32::try_from(us).unwrap_or(u32::MAX)
    }

    /// Converts ticks of the timer to µs, rounded up.
    pub(crate) fn micros(&self, ticks: Ticks) -> u32 {
        if self.is_whole() {
            return ticks.div_ceil(self.whole().max(1));
        }
        let us = (u64::from(ticks) * MILLION).div_ceil(u64::from(self.hz().max(1)));
        u32::try_from(us).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Any mixture of runs, steps and waits ends within 1/16 tick and one
        /// of the sum of its delays.
        #[test]
        fn nothing_gathers(
            hz in 100_000u32..200_000_001,
            parts in prop::collection::vec((0u8..3, 1u32..100_000, 1u16..4_096), 1..60),
        ) {
            let rate = Rate::from_hz(hz).unwrap();
            let mut beat = Beat::new(Clock::Deadlines, rate);
            let (mut us, mut fine) = (0f64, 0f64);
            for (kind, delay, count) in parts {
                let delay = delay.min(beat.piece);
                match kind {
                    0 => {
                        let count = count.min(beat.longest());
                        us += f64::from(delay) * f64::from(count);
                        fine += beat.steps(delay, count).duration() as f64;
                    }
                    1 => {
                        us += f64::from(delay);
                        fine += beat.step(delay, 0).duration() as f64;
                    }
                    _ => {
                        us += f64::from(delay);
                        fine += f64::from(beat.wait(delay)) * 65_536.0;
                    }
                }
                let off = us * f64::from(hz) / 1e6 - fine / 65_536.0;
                prop_assert!((-0.001..1.07).contains(&off), "{off} ticks after {us} µs");
            }
        }
    }

    #[test]
    fn ticks_become_micros_rounded_up() {
        let beat = Beat::new(Clock::Deadlines, Rate::from_hz(16_000_000).unwrap());
        assert_eq!((beat.micros(16), beat.micros(17), beat.micros(0)), (1, 2, 0));
    }
}
