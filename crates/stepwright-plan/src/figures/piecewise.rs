//! Figure 5: the ramp approaches its top speed in stages.
//!
//! The breaks are at delays (c)_j = ((c)_(j−1) + c_min) / 2, from 3·c_min on. Where the ramp passes a
//! break, n becomes 1.375·(n + 1), so that the acceleration falls to 1/1.375.

use std::f64::consts::PI;

use super::Drawing;
use super::smooth::approach;
use super::trace::Trace;
use crate::equations::{Begin, MOTOR, next};
use crate::sheet::{Cell, Sheet};

/// 120 rpm in one second as in Figure 2, in rad/s and rad/s².
const TOP: f64 = 4.0 * PI;
/// The number of breaks.
const BREAKS: usize = 7;

/// A break, and the step at which the ramp passes it.
#[derive(Clone, Copy, Debug)]
struct Break {
    /// The delay of the break.
    delay: f64,
    /// The first step after it.
    step: usize,
    /// n at this step, before and after the change.
    n: (f64, f64),
}

fn breaks(least: f64) -> Vec<f64> {
    let mut delay = 3.0 * least;
    let next = |_| {
        delay = f64::midpoint(delay, least);
        delay
    };
    (0..BREAKS).map(next).collect()
}

/// The delays down to the delay of the top speed, and the breaks passed on the way.
fn ramp() -> (Vec<f64>, Vec<Break>) {
    let least = MOTOR.delay(TOP);
    let mut left = breaks(least).into_iter().peekable();
    let (mut delays, mut passed) = (MOTOR.begin(TOP, Begin::Short), Vec::new());
    let (mut c, mut n) = (delays[0], 0.0);
    loop {
        let plain = n + 1.0;
        n = plain;
        if let Some(delay) = left.next_if(|&delay| c <= delay) {
            n = 1.375 * plain;
            passed.push(Break { delay, step: delays.len(), n: (plain, n) });
        }
        c = next(c, n);
        if c <= least {
            delays.push(least);
            return (delays, passed);
        }
        delays.push(c);
    }
}

/// The figure.
pub fn draw() -> Drawing {
    let (delays, passed) = ramp();
    let trace = Trace { name: "piecewise, 7 breaks".into(), motor: MOTOR, delays };
    let times = trace.times();
    let title = "Figure 5: piecewise linear, top speed 4π rad/s, ω′ = 4π rad/s²";
    let mut sheet = Sheet {
        columns: vec![
            ("break", "break j"),
            ("delay", "(c)_j"),
            ("delay_c_min", "of c_min"),
            ("speed", "ω, rad/s"),
            ("step", "passed at step"),
            ("time_s", "time, s"),
            ("n", "n there"),
            ("n_new", "becomes"),
            ("accel", "ω′ (3) behind it"),
        ],
        notes: vec![
            "The rule is printed, from 3 c_min on with 1.375 (n + 1); its results are not.".into(),
            format!(
                "The top speed is reached at step {}, after {:.3} s; without breaks it would be \
                 step 200, after 1 s.",
                trace.delays.len() - 1,
                times[trace.delays.len() - 1],
            ),
        ],
        ..Sheet::new(title)
    };
    for (&Break { delay, step, n: (before, n) }, j) in passed.iter().zip(1u32..) {
        let accel = MOTOR.accel(trace.delays[step - 1], trace.delays[step]);
        sheet.rows.push(vec![
            j.into(),
            Cell::fixed(delay, 3),
            Cell::fixed(delay / MOTOR.delay(TOP), 6),
            Cell::fixed(MOTOR.speed(delay), 3),
            (step as i64).into(),
            Cell::fixed(times[step], 4),
            Cell::fixed(before, 3),
            Cell::fixed(n, 3),
            Cell::fixed(accel, 3),
        ]);
    }
    let note = "Seven breaks, at each the acceleration falls to 1/1.375";
    approach(sheet, title, note, vec![trace], TOP, TOP)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (c)_j = c_min (1 + 2^(1−j)): the printed rule without its recursion.
    #[test]
    fn the_breaks_halve_the_rest() {
        for (delay, j) in breaks(1.0).into_iter().zip(1..) {
            assert_eq!(delay, 1.0 + 2f64.powi(1 - j));
        }
    }

    /// Each break divides the acceleration by 1.375, all seven divide it by 9.3.
    #[test]
    fn the_acceleration_falls_in_stages() {
        let (delays, passed) = ramp();
        assert_eq!(passed.len(), BREAKS);
        let accel = |i: usize| MOTOR.accel(delays[i - 1], delays[i]);
        for (j, window) in passed.windows(2).enumerate() {
            let want = TOP / 1.375f64.powi(j as i32 + 1);
            // In the middle between two breaks. The half step that Eq 18 adds and the rule leaves out makes
            // some percent at the first break.
            let middle = window[0].step.midpoint(window[1].step);
            assert!((accel(middle) / want - 1.0).abs() < 0.03, "{j}: {}", accel(middle));
        }
        assert_eq!(delays[delays.len() - 1], MOTOR.delay(TOP));
        assert!(delays.windows(2).all(|pair| pair[1] < pair[0]));
    }
}
