//! The law of speed, kept while a speed is planned: for every axis and every two times
//!
//! ```text
//!   |v(t) − v(t')| ≤ S + A·|t − t'|
//! ```
//!
//! Acceleration and jump in one: a corner, a ramp, the chords of a curve and a corner that has
//! been divided into tiny chords are all judged by it. All that has to be remembered of the past
//! is how high and how low it still allows the speed to be, which widens by A in each second.

use crate::route::AxisPace;

/// What the speeds so far leave to each axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bucket<const N: usize> {
    /// The largest of all v(t') − A·(t − t'), and the least of all v(t') + A·(t − t'), with the
    /// number of the place where it was met.
    high: [(f64, usize); N],
    low: [(f64, usize); N],
}

/// Rounding, of the jump.
const ROUNDED: f64 = 1e-9;

impl<const N: usize> Bucket<N> {
    /// After a long rest.
    pub const REST: Bucket<N> = Bucket { high: [(0.0, 0); N], low: [(0.0, 0); N] };

    /// After nothing but this speed at this place.
    pub fn only(v: f64, direction: &[f64; N], place: usize) -> Bucket<N> {
        let here = direction.map(|part| (v * part, place));
        Bucket { high: here, low: here }
    }

    /// The same with all places so far as number 0.
    pub fn begin(mut self) -> Bucket<N> {
        for (_, place) in self.high.iter_mut().chain(&mut self.low) {
            *place = 0;
        }
        self
    }

    /// Later by this time, within which no axis exceeds its acceleration.
    pub fn wait(&mut self, time: f64, axes: &[AxisPace; N]) {
        for (n, axis) in axes.iter().enumerate() {
            self.high[n].0 -= axis.accel * time;
            self.low[n].0 += axis.accel * time;
        }
    }

    /// The speed `v` along `direction` at a place with this number. `Some` if the law does not
    /// allow it, with the number of the place whose speed is too far away.
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
