//! The check of the law of speed: for each axis and any two times
//!
//! ```text
//!   |v(t) − v(t')| ≤ S + A·|t − t'|
//! ```
//!
//! The law covers acceleration and jump together: corners, ramps, the chords of a curve, and a corner divided
//! into tiny chords. The state of the check is how high and how low the past still allows the speed of each
//! axis to be. This range widens by A each second.

use crate::route::AxisPace;

/// The state of the law of speed, for each axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bucket<const N: usize> {
    /// The largest v(t') − A·(t − t') and the smallest v(t') + A·(t − t') of all past times t', each with the
    /// number of its place.
    high: [(f64, usize); N],
    low: [(f64, usize); N],
}

/// The relative rounding error of the jump.
const ROUNDED: f64 = 1e-9;

impl<const N: usize> Bucket<N> {
    /// The state after a long rest.
    pub const REST: Bucket<N> = Bucket { high: [(0.0, 0); N], low: [(0.0, 0); N] };

    /// The state after only this speed, at this place.
    pub fn only(v: f64, direction: &[f64; N], place: usize) -> Bucket<N> {
        let here = direction.map(|part| (v * part, place));
        Bucket { high: here, low: here }
    }

    /// The same state, with the number 0 for all places so far.
    pub fn begin(mut self) -> Bucket<N> {
        for (_, place) in self.high.iter_mut().chain(&mut self.low) {
            *place = 0;
        }
        self
    }

    /// Lets a time pass, in s, in which no axis exceeds its acceleration.
    pub fn wait(&mut self, time: f64, axes: &[AxisPace; N]) {
        for (n, axis) in axes.iter().enumerate() {
            self.high[n].0 -= axis.accel * time;
            self.low[n].0 += axis.accel * time;
        }
    }

    /// Adds the speed `v` along `direction` at the place with this number. If the law does not allow the speed,
    /// returns the number of the place whose speed differs too much from it; of several, the lowest.
    pub fn meet(
        &mut self,
        v: f64,
        direction: &[f64; N],
        place: usize,
        axes: &[AxisPace; N],
    ) -> Option<usize> {
        let mut broken = None;
        for (n, axis) in axes.iter().enumerate() {
            let v = v * direction[n];
            let (high, low) = (&mut self.high[n], &mut self.low[n]);
            if v >= high.0 {
                *high = (v, place);
            }
            if v <= low.0 {
                *low = (v, place);
            }
            let jump = axis.jump * (1.0 + ROUNDED);
            for (off, with) in [(high.0 - v, high.1), (v - low.0, low.1)] {
                if off > jump {
                    broken = Some(broken.map_or(with, |known: usize| known.min(with)));
                }
            }
        }
        broken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_jumps_need_a_time_between() {
        let axes =
            [AxisPace { step: 1.0, speed: 1e3, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY }];
        let met = |time: f64| {
            let mut bucket = Bucket::REST;
            let first = bucket.meet(5.0, &[1.0], 1, &axes);
            bucket.wait(time, &axes);
            (first, bucket.meet(10.0, &[1.0], 2, &axes))
        };
        assert_eq!(met(0.005), (None, None));
        assert_eq!(met(0.0049), (None, Some(0)));
    }
}
