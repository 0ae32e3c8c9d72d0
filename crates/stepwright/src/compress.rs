//! Makes runs of any profile, within an error bound.
//!
//! For laws without a closed form: lists, callbacks, iterators of other crates. The method is
//! greedy: a run doubles its length while a parabola through its end keeps **every** step within
//! the bound, then grows by ever smaller pieces. The parabola takes its growth from the mean
//! intervals of both halves of the run, and ends at the exact time of its last step, so that errors
//! never accumulate.

use crate::run::Run;
use crate::units::Ticks;

/// Compresses the delays of a profile into [runs](Run), with every step within `error` ticks of its
/// time.
///
/// Looks ahead at most `WINDOW` steps (2 … 16384), which is the greatest length of a run; each
/// takes four bytes of memory. A delay of a billion ticks becomes a run of its own.
///
/// ```
/// use stepwright::{compress::Compress, Rate, Speed, Accel, profile::Trapezoid, run::Steps};
/// let law = Trapezoid::new(
///     Rate::MHZ,
///     Speed::ZERO,
///     Speed::from_steps(4000)?,
///     Accel::from_steps(10_000)?,
/// );
/// let runs: Vec<_> = Compress::<_, 64>::new(law.delays(4000)?, 2).collect();
/// assert!(runs.len() < 400);
/// assert_eq!(Steps::new(runs).count(), 4000);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Compress<I, const WINDOW: usize> {
    delays: I,
    /// Delays that are not in a run yet: the first `filled`.
    window: [Ticks; WINDOW],
    filled: usize,
    /// The largest error of a step, in 2⁻¹⁶ ticks.
    error: i64,
    /// The shortest interval of a run of several steps, in 2⁻¹⁶ ticks.
    least: i64,
    /// How far the runs made so far are behind the profile, in 2⁻¹⁶ ticks.
    lag: i64,
}

/// Half a tick: deadlines are rounded down to whole ticks.
const HALF: i64 = 1 << 15;

impl<I: Iterator<Item = Ticks>, const WINDOW: usize> Compress<I, WINDOW> {
    const WINDOW_FITS: () = assert!(WINDOW >= 2 && WINDOW <= 16_384);

    /// Compresses `delays`; every step comes within `error` ticks of its time.
    pub fn new(delays: impl IntoIterator<IntoIter = I>, error: Ticks) -> Self {
        let () = Self::WINDOW_FITS;
        Compress {
            delays: delays.into_iter(),
            window: [0; WINDOW],
            filled: 0,
            // Rounding to a tick takes half a tick of the bound.
            error: ((i64::from(error) << 16) - HALF).max(0),
            least: 0,
            lag: HALF,
        }
    }

    /// No interval is shorter than this many ticks, unless a delay of the profile is.
    pub fn with_least(mut self, ticks: Ticks) -> Self {
        self.least = i64::from(ticks) << 16;
        self
    }

    fn fill(&mut self) {
        for slot in self.window.iter_mut().skip(self.filled) {
            let Some(delay) = self.delays.next() else { return };
            *slot = delay;
            self.filled += 1;
        }
    }

    /// A run of the first `n` ≥ 1 delays that keeps the bound, and the lag after it.
    fn fit(&self, n: usize) -> Option<(Run, i64)> {
        let delays = self.window.get(..n)?;
        let count = i64::try_from(n).ok()?;
        let total: i64 = delays.iter().map(|&d| i64::from(d)).sum::<i64>() << 16;
        let half = n / 2;
        let mut add = 0i64;
        if n > 1 && n <= 4096 {
            let sum = |part: &[Ticks]| part.iter().map(|&d| i64::from(d)).sum::<i64>() << 16;
            let (first, last) = (delays.get(..half)?, delays.get(n - half..)?);
            let half = i64::try_from(half).ok()?;
            // The middles of the two halves are n − half steps apart.
            add = (sum(last) - sum(first)) / (half * (count - half));
        }
        let add = i32::try_from(add).ok()?;
        let triangle = i64::from(add) * (count * (count - 1) / 2);
        let interval = (total + self.lag - triangle).div_euclid(count);
        if interval < 0 || interval >> 48 != 0 {
            return None;
        }
        let run = Run::new(interval as u64, add, count as u16);
        // Checks every step as it will be played.
        let (mut at, mut step, mut want) = (0i64, interval, self.lag);
        for &delay in delays {
            at += step;
            let short = step < self.least;
            step += i64::from(add);
            want += i64::from(delay) << 16;
            // `want` is half a tick late, so that floor(at) rounds to nearest. A single step always
            // comes exactly at its time.
            if n > 1 && (short || step < 0 || (at - want).abs() > self.error) {
                return None;
            }
        }
        Some((run, total + self.lag - run.duration() as i64))
    }
}

impl<I: Iterator<Item = Ticks>, const WINDOW: usize> Iterator for Compress<I, WINDOW> {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        self.fill();
        if self.filled == 0 {
            return None;
        }
        // Doubles, then halves the stride: about 2·log₂ n fits.
        let (mut n, mut best) = (1, self.fit(1)?);
        let mut stride = 1;
        let mut growing = true;
        while stride > 0 {
            match self.fit(n + stride).filter(|_| n + stride <= self.filled) {
                Some(fit) => {
                    n += stride;
                    best = fit;
                    stride = if growing { stride * 2 } else { stride / 2 };
                }
                None => {
                    growing = false;
                    stride /= 2;
                }
            }
        }
        self.lag = best.1;
        self.window.copy_within(n..self.filled, 0);
        self.filled -= n;
        Some(best.0)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::run::Steps;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn held(delays: &[Ticks], error: Ticks) -> usize {
        let runs: Vec<Run> = Compress::<_, 64>::new(delays.iter().copied(), error).collect();
        let played: Vec<Ticks> = Steps::new(runs.iter().copied()).collect();
        assert_eq!(played.len(), delays.len());
        let (mut t, mut want) = (0i64, 0i64);
        for (n, (got, delay)) in played.iter().zip(delays).enumerate() {
            t += i64::from(*got);
            want += i64::from(*delay);
            assert!((t - want).unsigned_abs() <= error.into(), "step {n}: {t}, not {want}");
        }
        runs.len()
    }

    #[test]
    fn no_interval_is_shorter_than_the_least() {
        // Down to 200 and up again: a parabola would be below that.
        let delays: Vec<Ticks> = (0..400i32).map(|n| 200 + n.abs_diff(200) / 2).collect();
        let runs = |least| Compress::<_, 512>::new(delays.iter().copied(), 32).with_least(least);
        let least = |run: Run| run.interval().min(run.last_interval()) >> 16;
        assert!(runs(0).any(|run| least(run) < 200));
        let runs: Vec<_> = runs(200).collect();
        assert!(runs.iter().all(|run| least(*run) >= 200));
        assert_eq!(Steps::new(runs).count(), delays.len());
    }

    #[test]
    fn a_constant_speed_is_a_run_a_window() {
        assert_eq!(held(&[1_000; 640], 1), 10);
        assert_eq!(held(&[], 1), 0);
        assert_eq!(held(&[u32::MAX; 5], 1), 1);
    }

    proptest! {
        #[test]
        fn every_step_keeps_the_bound(
            delays in prop::collection::vec(prop_oneof![0u32..50, 900u32..1_100, any::<u32>()], 0..300),
            error in 1u32..200,
        ) {
            held(&delays, error);
        }

        #[test]
        fn ramps_become_few_runs(first in 2_000u32..60_000, error in 1u32..50) {
            // c(n) = c0·(√(n+1) − √n): Austin, Eq 8.
            let c0 = f64::from(first);
            let delays: Vec<Ticks> =
                (0..2_000).map(|n| { let n = f64::from(n); (c0 * ((n + 1.0).sqrt() - n.sqrt())) as u32 }).collect();
            prop_assert!(held(&delays, error) < 600);
        }
    }
}
