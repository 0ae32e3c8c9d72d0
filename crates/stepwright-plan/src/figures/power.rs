//! Figure 6: a power term in the denominator, for p = 2, 3, 4 and 5.

use std::f64::consts::PI;

use super::Drawing;
use super::smooth::approach;
use super::trace::Trace;
use crate::equations::{Begin, MOTOR, next_power};
use crate::sheet::{Cell, Sheet};

/// 120 rpm in one second as in Figure 2, in rad/s and rad/s².
const TOP: f64 = 4.0 * PI;
/// The powers.
const POWERS: [i32; 4] = [2, 3, 4, 5];
/// The time of a ramp that is shown, in seconds.
const LONG: f64 = 3.0;

/// The ramp of one power over the time that is shown.
fn ramp(p: i32) -> Trace {
    let k = MOTOR.power(TOP, TOP, p);
    let mut delays = MOTOR.begin(TOP, Begin::Short);
    let (mut c, mut seconds) = (delays[0], 0.0);
    while seconds < LONG {
        c = next_power(c, delays.len() as f64, k, p);
        delays.push(c);
        seconds += c / MOTOR.hz;
    }
    Trace { name: format!("p = {p}"), motor: MOTOR, delays }
}

/// The figure.
pub fn draw() -> Drawing {
    let title = "Figure 6: power term, p = 2, 3, 4, 5, top speed 4π rad/s, ω′ = 4π rad/s²";
    let traces: Vec<Trace> = POWERS.into_iter().map(ramp).collect();
    let mut sheet = Sheet {
        columns: vec![
            ("p", "p"),
            ("k", "k (21)"),
            ("knee", "4n = k·n^p at step"),
            ("speed_1_s", "ω after 1 s"),
            ("speed_2_s", "after 2 s"),
            ("speed_3_s", "after 3 s"),
            ("part", "% of the top speed"),
        ],
        notes: vec!["For p = 2 the curve falls short, for higher powers k is good.".into()],
        ..Sheet::new(title)
    };
    for (p, trace) in POWERS.into_iter().zip(&traces) {
        let k = MOTOR.power(TOP, TOP, p);
        let at = |seconds| Cell::fixed(trace.speed_at(seconds), 4);
        sheet.rows.push(vec![
            p.into(),
            Cell::digits(k, 4),
            Cell::fixed((4.0 / k).powf(1.0 / f64::from(p - 1)), 1),
            at(1.0),
            at(2.0),
            at(LONG),
            Cell::fixed(trace.speed_at(LONG) / TOP * 100.0, 2),
        ]);
    }
    let note = "A higher power makes a sharper knee; p = 2 falls short of the top speed";
    approach(sheet, title, note, traces, TOP, TOP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn k_by_equation_21() {
        for (p, k) in POWERS.into_iter().zip([0.02, 1e-4, 5e-7, 2.5e-9]) {
            assert!((MOTOR.power(TOP, TOP, p) / k - 1.0).abs() < 1e-12, "{p}");
        }
    }

    /// "The curve falls short of ωmax for p=2 but k is good for higher powers."
    #[test]
    fn only_the_second_power_falls_short() {
        let part = |p| ramp(p).speed_at(LONG) / TOP;
        assert!(part(2) < 0.9, "{}", part(2));
        assert!(POWERS[1..].iter().all(|&p| (0.98..1.0).contains(&part(p))));
    }

    /// "At low speed the power term is negligible, so acceleration is constant."
    #[test]
    fn a_sharper_knee_begins_later() {
        let full = |p| {
            let Trace { delays, .. } = ramp(p);
            let accel = |c: &[f64]| MOTOR.accel(c[0], c[1]) / TOP;
            delays.windows(2).skip(2).take_while(|c| accel(c) > 0.9).count()
        };
        let steps = POWERS.map(full);
        assert!(steps.is_sorted() && steps[3] > 3 * steps[0], "{steps:?}");
    }
}
