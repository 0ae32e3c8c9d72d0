//! The joint of two pieces of a route: how fast it may be passed.
//!
//! Two limits of each axis bound the speed, with Δt the change of the direction of the axis and h the length of
//! the shorter piece:
//!
//! ```text
//!   the jump       v·|Δt|     ≤ S        what a motor can take at once
//!   the curvature  v²·|Δt|/h  ≤ A        of chords of a curve: it turns by Δt in every h
//! ```
//!
//! A corner by itself uses none of the acceleration for speeding up. A joint is one if it turns by 20° or more,
//! or if it joins pieces so long that it turns slowly (v²·|Δt|/h ≤ A/8).
//!
//! Chords of a curve are limited as the curve: v stays within S/2 of a speed u that turns evenly from the
//! middle of one chord to the middle of the next. Half of a chord on each side therefore has less of the axis's
//! acceleration for speeding up ([`Joint::zones`]). If one chord is much shorter, or places are rounded, more
//! of the curve is considered ([`chords`](crate::chords)).
//!
//! On request, junction deviation, as in grbl and Marlin, takes the place of the jump: the corner is passed as
//! fast as an arc that misses it by d,
//!
//! ```text
//!   v² = A·d·c / (1 − c)         c = cos(half of the angle by which it turns)
//! ```
//!
//! with a jump that is not checked.

use crate::cell::Bend;
use crate::route::AxisPace;

/// The limits of a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint<const N: usize> {
    /// The largest w = v²; and the largest w as a corner by itself.
    pub cap: f64,
    pub alone: f64,
    /// The lengths before and behind the joint in which it turns; how the direction of each axis turns along
    /// the route, with its sign; and the most that it turns in the zones.
    pub zones: [f64; 2],
    pub turn: [f64; N],
    pub bend: Bend<N>,
    /// Whether it turns by 20° or more, or is passed at rest: no curve leads over it.
    pub corner: bool,
    /// The w of twice the ordered speed, if more of the curve is to be considered; otherwise 0.
    pub top: f64,
}

/// A joint is a corner by itself if turning uses at most this part of the acceleration,
const ALONE: f64 = 0.125;

/// or if it turns by an angle whose cosine is less than this.
const SHARP: f64 = 0.94;

impl<const N: usize> Joint<N> {
    /// A joint that is passed at rest.
    pub const REST: Joint<N> = Joint {
        cap: 0.0,
        alone: 0.0,
        zones: [0.0; 2],
        turn: [0.0; N],
        bend: Bend { bend: [0.0; N], tilt: [0.0; N], lean: [0.0; N] },
        corner: true,
        top: 0.0,
    };

    /// The joint between two directions of pieces of these lengths, both of which can be passed at the speed
    /// `top`.
    pub fn new(
        [before, after]: [&[f64; N]; 2],
        lengths: [f64; 2],
        top: f64,
        axes: &[AxisPace; N],
        deviation: Option<f64>,
    ) -> Joint<N> {
        let length = lengths[0].min(lengths[1]);
        let turn: [f64; N] = std::array::from_fn(|n| after[n] - before[n]);
        let over = |limit: fn(&AxisPace) -> f64| {
            let each = axes.iter().zip(&turn).map(move |(axis, turn)| limit(axis) / turn.abs());
            each.fold(f64::INFINITY, f64::min)
        };
        let jump = over(|axis| axis.jump);
        let v = jump.min(top);
        let mut alone = jump * jump;
        let cos: f64 = before.iter().zip(after).map(|(a, b)| a * b).sum();
        if let Some(deviation) = deviation {
            let half = ((1.0 + cos) / 2.0).clamp(0.0, 1.0).sqrt();
            let accel = axes.iter().map(|axis| axis.accel).fold(f64::INFINITY, f64::min);
            alone =
                if half < 1.0 { accel * deviation * half / (1.0 - half) } else { f64::INFINITY };
        }
        let corner = cos < SHARP;
        let part = if corner { 1.0 } else { ALONE };
        let most = over(|axis| axis.accel) * length;
        let slow = v * v <= part * most;
        let cap = if slow { alone } else { alone.min(most) };
        // By the law of jerk, a curve that the joint does not slow down may be rough.
        let smooth = axes.iter().any(|axis| axis.jerk < f64::INFINITY);
        let seen = !corner && (smooth || cap < top * top);
        let top = if seen { top * top } else { 0.0 };
        let joint = Joint { cap, alone, corner, top, ..Joint::REST };
        if slow || corner && deviation.is_none() {
            // As a chord, a corner would be no faster, and up to the middle of the next chord no acceleration
            // would be left for speeding up.
            return joint;
        }
        let bound = turn.map(|turn| turn / length);
        let turn = turn.map(|turn| 2.0 * turn / (lengths[0] + lengths[1]));
        Joint { turn, ..joint.turning(bound, [before, after], [length / 2.0; 2]) }
    }

    /// Whether the joint is one of a curve, and turns.
    pub fn turns(&self) -> bool {
        self.zones[1] > 0.0
    }

    /// The joint with this turning, between these directions, in these zones.
    pub fn turning(
        self,
        turn: [f64; N],
        [before, after]: [&[f64; N]; 2],
        zones: [f64; 2],
    ) -> Joint<N> {
        let bend = Bend {
            bend: turn.map(f64::abs),
            tilt: std::array::from_fn(|n| (after[n] + before[n]).abs() / 2.0),
            lean: std::array::from_fn(|n| {
                let same = after[n] * before[n] > 0.0;
                if same { turn[n] * after[n] } else { 0.0 }
            }),
        };
        Joint { zones, turn, bend, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: AxisPace =
        AxisPace { step: 0.01, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

    fn cap(turn: f64, length: f64, deviation: Option<f64>) -> f64 {
        let after = [turn.cos(), turn.sin()];
        Joint::new([&[1.0, 0.0], &after], [length; 2], 300.0, &[AXIS; 2], deviation).cap.sqrt()
    }

    #[test]
    fn a_corner_has_its_jump() {
        assert!((cap(std::f64::consts::FRAC_PI_2, 10.0, None) - 5.0).abs() < 1e-12);
        assert!((cap(std::f64::consts::PI, 10.0, None) - 2.5).abs() < 1e-12);
        assert_eq!(cap(0.0, 1e-9, None), f64::INFINITY);
    }

    #[test]
    fn a_chord_has_its_curve() {
        // A circle of 20: √(1000·20) = 141, whatever the chord.
        for chord in [0.1, 0.2, 0.4] {
            assert!((cap(chord / 20.0, chord, None) - 141.4).abs() < 1.0, "{chord}");
        }
    }

    #[test]
    fn junction_deviation_by_hand() {
        // 90°: c = 0.7071, so v² = 1000·0.01·2.414.
        let v = cap(std::f64::consts::FRAC_PI_2, 10.0, Some(0.01));
        assert!((v * v - 24.142).abs() < 1e-3);
    }
}
