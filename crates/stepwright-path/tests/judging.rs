//! The judges of a motion, tested with violations made by hand.

use crate::judge::jerk::jerk_broken;
use crate::judge::{self, Axis, jump_needed};

const STEP: f64 = 0.0125;

/// The steps of a motion whose place is known at each time, by search.
fn steps(place: impl Fn(f64) -> f64, end: f64) -> Axis {
    let (mut steps, mut at) = (Vec::new(), 0i64);
    let grain = 1e-5;
    for n in 0..(end / grain).round() as i64 {
        let (from, to) = (n as f64 * grain, (n + 1) as f64 * grain);
        loop {
            let middle = |up: bool| (at as f64 + if up { 0.5 } else { -0.5 }) * STEP;
            let up = place(to) > middle(true);
            if !up && place(to) >= middle(false) {
                break;
            }
            let (mut low, mut high) = (from, to);
            for _ in 0..60 {
                let t = (low + high) / 2.0;
                if (place(t) > middle(up)) == up { high = t } else { low = t }
            }
            steps.push((high, up));
            at += if up { 1 } else { -1 };
        }
    }
    steps
}

#[test]
fn a_ramp_within_its_acceleration_needs_no_jump() {
    // 1000 mm/s² for 0.1 s, 100 mm/s for 0.1 s, and the same ramp down.
    let place = |t: f64| match t {
        t if t < 0.1 => 500.0 * t * t,
        t if t < 0.2 => 5.0 + 100.0 * (t - 0.1),
        t => 20.0 - 500.0 * (0.3 - t) * (0.3 - t),
    };
    let steps = steps(place, 0.3);
    assert_eq!(steps.len(), 1_600);
    assert!(jump_needed(&steps, STEP, 1_000.0, 0.3).0 < 0.01);
    // An acceleration 1 % too high over 0.1 s: 1 mm/s.
    let (jump, t) = jump_needed(&steps, STEP, 990.0, 0.3);
    assert!((jump - 1.0).abs() < 0.05, "{jump} at {t}");
}

#[test]
fn a_jump_is_seen_whole_and_in_parts() {
    // 20 mm/s, and at once 27 mm/s.
    let place = |t: f64| if t < 0.1 { 20.0 * t } else { 2.0 + 27.0 * (t - 0.1) };
    let axis = steps(place, 0.2);
    let middle: Axis = axis[10..axis.len() - 10].to_vec();
    let seen = |steps: &Axis, accel: f64| {
        // Without rest at both ends.
        let inner = judge::speeds(steps, STEP, 0.2);
        let inner = &inner[1..inner.len() - 1];
        let mut most = 0.0f64;
        for (t, v) in inner {
            for (u, w) in inner {
                most = most.max((v - w).abs() - accel * (t - u).abs());
            }
        }
        most
    };
    // 7 mm/s less 100 mm/s² over the interval of the jump and half of its neighbours, some 1 ms.
    let jump = seen(&middle, 100.0);
    assert!((jump - 6.9).abs() < 0.05, "{jump}");
    // The judge in one pass gives the same as all pairs, rest at both ends included.
    let (jump, _) = jump_needed(&axis, STEP, 100.0, 0.2);
    assert!((jump - 27.0).abs() < 0.05, "{jump}");
    // The same jump in seven parts within 1 ms counts as much.
    let parts = |t: f64| {
        let n = ((t - 0.1) * 7_000.0).ceil().clamp(0.0, 7.0) as i32;
        20.0 * t + (0..n).map(|k| t - 0.1 - f64::from(k) / 7_000.0).sum::<f64>()
    };
    let axis = steps(parts, 0.2);
    let jump = seen(&axis, 100.0);
    assert!((jump - 6.8).abs() < 0.1, "{jump}");
}

#[test]
fn a_turn_is_no_speed() {
    // There and back at 2 mm/s: a jump of 4.
    let place = |t: f64| if t < 0.5 { 2.0 * t } else { 1.0 - 2.0 * (t - 0.5) };
    let steps = steps(place, 1.0);
    let inner = judge::speeds(&steps, STEP, 1.0);
    let (high, low) = inner.iter().fold((0.0f64, 0.0f64), |m, s| (m.0.max(s.1), m.1.min(s.1)));
    assert!((high - 2.0).abs() < 1e-6 && (low + 2.0).abs() < 1e-6);
    let (jump, _) = jump_needed(&steps, STEP, 1e-3, 1.0);
    assert!((jump - 4.0).abs() < 0.01, "{jump}");
}

/// An S-curve from rest to `v` and back, with this acceleration and jerk: the place over time, and the time of
/// the end.
fn s_curve(v: f64, accel: f64, jerk: f64) -> (impl Fn(f64) -> f64, f64) {
    let bend = accel / jerk;
    let rise = v / accel + bend;
    let up = move |t: f64| match t {
        t if t < bend => jerk * t.powi(3) / 6.0,
        t if t < rise - bend => {
            let u = t - bend;
            jerk * bend.powi(3) / 6.0 + accel * bend / 2.0 * u + accel * u * u / 2.0
        }
        t => v * rise / 2.0 - (v * (rise - t) - jerk * (rise - t).powi(3) / 6.0),
    };
    let place = move |t: f64| {
        if t < rise { up(t) } else { v * rise - up((2.0 * rise - t).max(0.0)) }
    };
    (place, 2.0 * rise)
}

/// An S-curve is within its own limits, but not within a smaller one of any kind.
#[test]
fn an_s_curve_has_its_jerk() {
    let (place, end) = s_curve(150.0, 1_000.0, 10_000.0);
    let steps = steps(place, end);
    let broken = |jump, accel, jerk| jerk_broken(&steps, STEP, [jump, accel, jerk], end);
    assert_eq!(broken(0.05, 1_000.0, 10_000.0), None);
    assert_eq!(broken(0.0501, 1_010.0, 12_000.0), None);
    for (jump, accel, jerk) in
        [(0.05, 980.0, 10_000.0), (0.05, 1_000.0, 9_000.0), (1.0, 1_000.0, 7_000.0)]
    {
        assert!(broken(jump, accel, jerk).is_some(), "{jump} {accel} {jerk}");
    }
}

/// A trapezoid under a jerk. Let u bend from −S/2 on, a time x before a ramp of A begins; there it is at J·x²/2
/// − S/2, at most S/2. On the ramp it is at A·x − A²/2J − S/2 from v. Where the ramp ends, by symmetry, it is
/// at the opposite of that: so at 0. Both together give S = (3 − 2·√2)·A²/J, 17.16 mm/s. The judge's set is
/// never too small, so it must accept more than that. It refuses 13.
#[test]
fn a_trapezoid_has_none() {
    let place = |t: f64| match t {
        t if t < 0.3 => 500.0 * t * t,
        t if t < 0.6 => 45.0 + 300.0 * (t - 0.3),
        t => 180.0 - 500.0 * (0.9 - t) * (0.9 - t),
    };
    let steps = steps(place, 0.9);
    let broken = |jump, jerk| jerk_broken(&steps, STEP, [jump, 1_000.0, jerk], 0.9);
    assert!(jump_needed(&steps, STEP, 1_000.0, 0.9).0 < 0.01);
    assert!(broken(5.0, 10_000.0).is_some());
    assert!(broken(13.0, 10_000.0).is_some());
    assert_eq!(broken(17.4, 10_000.0), None);
    assert_eq!(broken(5.0, 1e6), None);
}

/// A start from rest is a jump, however long the rest was: at the beginning, between two moves, and at the end.
#[test]
fn a_start_from_standing_is_a_jump() {
    for v in [20.0, 50.0, 100.0, 200.0] {
        for stood in [0.05, 0.1, 0.3, 1.0] {
            for before in [0, 100] {
                // At 4 mm/s, which the jump allows; then a rest, and motion at once. In both directions.
                let slow = (0..before).map(|n| STEP / 4.0 * f64::from(n));
                let begin = STEP / 4.0 * f64::from(before) + stood;
                let fast = (0..200).map(|n| begin + STEP / v * f64::from(n));
                let steps: Axis = slow.chain(fast).map(|t| (t, true)).collect();
                let end = steps[steps.len() - 1].0 + stood;
                let back: Axis = steps.iter().rev().map(|(t, _)| (end - t, false)).collect();
                for steps in [steps, back] {
                    let (jump, at) = jump_needed(&steps, STEP, 1_000.0, end);
                    // The jump is known but for 1.25 steps in √(step/accel), and for the acceleration over half
                    // of that time and half of the first interval.
                    let least = v - 1.75 * (STEP * 1_000.0).sqrt() - 500.0 * STEP / v - 0.01;
                    assert!(jump >= least && jump <= v, "{v} after {stood}: {jump} at {at}");
                    let broken = jerk_broken(&steps, STEP, [5.0, 1_000.0, 10_000.0], end);
                    assert!(broken.is_some(), "{v} after {stood}");
                }
            }
        }
    }
}
