//! A run: many steps in twelve bytes.
//!
//! A run is a parabola in time. Its first step comes `interval` after the step
//! before it; after every step the interval grows by `add`:
//!
//! ```text
//!   step before        1st             2nd            3rd  …  count
//!        │  interval    │ interval+add  │ …+2·add      │
//!   ─────┴──────────────┴───────────────┴──────────────┴────────► ticks
//! ```
//!
//! Both have 16 bits behind the point, so that a ramp at high speed, where the
//! interval changes by a thousandth of a tick a step, stays one run. The step
//! interrupt only adds, compares and counts.

use crate::units::Ticks;

/// `count` steps, the first `interval` ticks after the step before it.
///
/// What planners and programs hand over; [entries](crate::entry) are made of it. Times are
/// multiples of 2⁻¹⁶ ticks.
///
/// ```
/// use stepwright::Run;
/// let run = Run::steady(1_000, 3);
/// assert_eq!(run.duration() >> 16, 3_000);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Whole ticks of the first interval.
    pub(crate) ticks: Ticks,
    /// The first interval's part of a tick, in 2⁻¹⁶.
    pub(crate) part: u16,
    /// Steps; 0 for a turn.
    pub(crate) count: u16,
    /// Growth of the interval per step in 2⁻¹⁶ ticks; a turn's direction.
    pub(crate) add: i32,
}

impl Run {
    /// `count` steps at one interval of whole ticks.
    pub const fn steady(ticks: Ticks, count: u16) -> Run {
        Run { ticks, part: 0, count, add: 0 }
    }

    /// `count` steps; the first `interval` and its growth `add` per step are in
    /// 2⁻¹⁶ ticks. The first and the last are to be below 2⁴⁷: others are played modulo 2⁴⁸.
    pub const fn new(interval: u64, add: i32, count: u16) -> Run {
        Run { ticks: (interval >> 16) as Ticks, part: interval as u16, count, add }
    }

    /// No step, but a change of direction, `wait` ticks after the last step.
    pub const fn turn(wait: Ticks, forward: bool) -> Run {
        Run { ticks: wait, part: 0, count: 0, add: forward as i32 }
    }

    /// The direction that this entry switches to, if it is a turn.
    pub const fn turns(&self) -> Option<bool> {
        if self.count == 0 { Some(self.add != 0) } else { None }
    }

    /// Steps in this run; 0 for a turn.
    pub const fn count(&self) -> u16 {
        self.count
    }

    /// The first interval in 2⁻¹⁶ ticks.
    pub const fn interval(&self) -> u64 {
        (self.ticks as u64) << 16 | self.part as u64
    }

    /// The interval's growth per step in 2⁻¹⁶ ticks; 0 for a turn.
    pub const fn add(&self) -> i32 {
        if self.count == 0 { 0 } else { self.add }
    }

    /// The last interval in 2⁻¹⁶ ticks.
    pub const fn last_interval(&self) -> u64 {
        let n = self.count.saturating_sub(1) as i64;
        self.interval().wrapping_add_signed(self.add() as i64 * n)
    }

    /// From the step before the run to its last step, in 2⁻¹⁶ ticks.
    pub const fn duration(&self) -> u64 {
        if self.count == 0 {
            return self.interval();
        }
        let n = self.count as i64;
        // 32 + 31 bits: the triangle fits.
        (self.interval().wrapping_mul(n as u64))
            .wrapping_add_signed(self.add as i64 * (n * (n - 1) / 2))
    }
}

/// The single steps of a sequence of runs, as delays in whole ticks.
///
/// What the engine's deadlines do, as an iterator: the fraction is carried, so
/// the delays add up to the runs' duration, rounded down.
#[derive(Clone, Debug)]
pub struct Steps<I> {
    runs: I,
    interval: u64,
    add: i64,
    left: u16,
    part: u64,
}

impl<I: Iterator<Item = Run>> Steps<I> {
    /// Plays `runs`; a turn only adds its wait to the next delay.
    pub fn new(runs: impl IntoIterator<IntoIter = I>) -> Steps<I> {
        Steps { runs: runs.into_iter(), interval: 0, add: 0, left: 0, part: 0 }
    }

    /// Where the runs come from, and the steps left in the present one.
    pub(crate) fn remaining(&self) -> (&I, u16) {
        (&self.runs, self.left)
    }

    #[cold]
    fn load(&mut self) -> Option<()> {
        let mut run = self.runs.next()?;
        while run.count == 0 {
            self.part = self.part.wrapping_add(run.interval());
            run = self.runs.next()?;
        }
        (self.interval, self.add, self.left) = (run.interval(), run.add.into(), run.count);
        Some(())
    }
}

impl<I: Iterator<Item = Run>> Iterator for Steps<I> {
    type Item = Ticks;

    #[inline]
    fn next(&mut self) -> Option<Ticks> {
        if self.left == 0 {
            self.load()?;
        }
        let due = self.part.wrapping_add(self.interval);
        self.part = due & 0xFFFF;
        self.interval = self.interval.wrapping_add_signed(self.add);
        self.left -= 1;
        Some(u32::try_from(due >> 16).unwrap_or(Ticks::MAX))
    }

    /// A loop a run, for `sum`, `for_each` and the like.
    #[inline]
    fn fold<B, F: FnMut(B, Ticks) -> B>(mut self, init: B, mut f: F) -> B {
        let mut all = init;
        loop {
            let (mut interval, add, mut part) = (self.interval, self.add, self.part);
            for _ in 0..self.left {
                let due = part.wrapping_add(interval);
                part = due & 0xFFFF;
                interval = interval.wrapping_add_signed(add);
                all = f(all, u32::try_from(due >> 16).unwrap_or(Ticks::MAX));
            }
            self.part = part;
            if self.load().is_none() {
                return all;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_run_is_twelve_bytes() {
        assert_eq!(size_of::<Run>(), 12);
    }

    #[test]
    fn delays_add_up_to_the_duration() {
        let run = Run::new(1000 << 16 | 0x8000, -0x4001, 9);
        let total: u64 = Steps::new([run]).map(u64::from).sum();
        assert_eq!(total, run.duration() >> 16);
        assert_eq!(run.last_interval(), (1000 << 16 | 0x8000) - 8 * 0x4001);
    }

    #[test]
    fn folding_is_stepping() {
        let runs = [Run::new(900 << 16 | 7, -77, 5), Run::turn(9, true), Run::new(70_001, 3, 40)];
        let mut steps = Steps::new(runs);
        let stepped: Vec<Ticks> = core::iter::from_fn(|| steps.next()).collect();
        let mut folded = Vec::new();
        let mut steps = Steps::new(runs);
        folded.extend(steps.next());
        steps.for_each(|delay| folded.push(delay));
        assert_eq!(folded, stepped);
    }

    #[test]
    fn a_turn_delays_the_next_step() {
        let delays: Vec<_> =
            Steps::new([Run::steady(10, 1), Run::turn(3, false), Run::steady(5, 2)]).collect();
        assert_eq!(delays, [10, 8, 5]);
    }
}
