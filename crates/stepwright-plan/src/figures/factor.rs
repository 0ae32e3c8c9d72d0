//! Figure 7: the changes of c are scaled by a factor that falls from 1 at step n1 to 0 at step n2.

use std::f64::consts::PI;

use super::Drawing;
use super::smooth::approach;
use super::trace::Trace;
use crate::equations::{Begin, Counter, MOTOR, next_scaled};
use crate::sheet::{Cell, Sheet};

/// 120 rpm in one second as in Figure 2, in rad/s and rad/s².
const TOP: f64 = 4.0 * PI;
/// Where the transitions begin, as parts of the top speed.
const BEGINS: [f64; 4] = [0.0, 0.3, 0.5, 0.7];

/// Eq 22's factor at step n.
pub fn factor(n: f64, n1: f64, n2: f64) -> f64 {
    ((n2 - n) / (n2 - n1)).clamp(0.0, 1.0)
}

/// c0 … c_n2.
pub fn ramp(motor: Counter, accel: f64, n1: f64, n2: f64) -> Vec<f64> {
    let mut delays = motor.begin(accel, Begin::Short);
    for n in (1..).map(f64::from).take_while(|&n| n <= n2) {
        delays.push(next_scaled(delays[delays.len() - 1], n, factor(n, n1, n2)));
    }
    delays
}

/// n1 and n2 of a transition that begins at a part of the top speed.
fn steps(part: f64) -> (f64, f64) {
    let n1 = MOTOR.step_of(part * TOP, TOP).round();
    // Eq 23 has a solution for every part below 1.
    let n2 = MOTOR.transition(TOP, n1, TOP).unwrap_or(n1 + 1.0);
    (n1, n2.floor())
}

/// The figure.
pub fn draw() -> Drawing {
    let title = "Figure 7: linear factor from 0, 30, 50 and 70 % of the top speed of 4π rad/s";
    let mut sheet = Sheet {
        columns: vec![
            ("begin", "begins at, %"),
            ("n1", "n1 (16)"),
            ("n2", "n2 (23)"),
            ("time_s", "time to n2, s"),
            ("speed", "ω there, rad/s"),
            ("part", "% of the top speed"),
        ],
        notes: vec![
            "Without a transition the top speed is reached at step 200, after 1 s.".into(),
            "n2 is rounded down, as (24) has it.".into(),
        ],
        ..Sheet::new(title)
    };
    let mut traces = Vec::new();
    for begin in BEGINS {
        let (n1, n2) = steps(begin);
        let percent = begin * 100.0;
        let name = format!("from {percent:.0} %");
        let trace = Trace { name, motor: MOTOR, delays: ramp(MOTOR, TOP, n1, n2) };
        sheet.rows.push(vec![
            Cell::fixed(percent, 0),
            Cell::fixed(n1, 0),
            Cell::fixed(n2, 0),
            Cell::fixed(trace.times()[n2 as usize], 4),
            Cell::fixed(trace.peak(), 4),
            Cell::fixed(trace.peak() / TOP * 100.0, 2),
        ]);
        traces.push(trace);
    }
    let note = "ω′ = 4π rad/s²; the acceleration falls nearly linearly over the transition";
    approach(sheet, title, note, traces, TOP, TOP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transitions_end_at_the_top_speed() {
        let all = [(0.0, 543.0), (18.0, 478.0), (50.0, 404.0), (98.0, 323.0)];
        for (begin, want) in BEGINS.into_iter().zip(all) {
            let (n1, n2) = steps(begin);
            assert_eq!((n1, n2), want);
            let delays = ramp(MOTOR, TOP, n1, n2);
            assert_eq!(delays.len() as f64, n2 + 1.0);
            let part = MOTOR.speed(delays[delays.len() - 1]) / TOP;
            assert!((part - 1.0).abs() < 2e-3, "{begin}: {part}");
        }
    }

    /// "ωmax is reached in about twice the time taken with no transition."
    #[test]
    fn from_rest_it_takes_twice_as_long() {
        let delays = ramp(MOTOR, TOP, 0.0, 543.0);
        let seconds: f64 = delays[..543].iter().sum::<f64>() / MOTOR.hz;
        assert!((1.9..2.1).contains(&seconds), "{seconds}");
    }
}
