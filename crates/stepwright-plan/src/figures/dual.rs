//! Figure 8: linear factors up and down, with and without a section at top speed.

use super::factor::factor;
use super::printed::Printed;
use super::trace::Trace;
use super::{Drawing, given};
use crate::equations::{Begin, MOTOR, next_scaled, turning_point};
use crate::sheet::{Cell, Sheet};
use stepwright_plot::{Curve, Figure, Panel, View};

/// ω_max, ω′1 and −ω′2.
const TOP: f64 = 10.0;
const ACCEL: f64 = 10.0;
const DECEL: f64 = 20.0;

/// A move of m steps: n2 and n3.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Move {
    m: u32,
    n2: u32,
    n3: u32,
}

impl Move {
    /// By Eq 24 up and down; by Eq 19 if the two transitions would overlap.
    fn new(m: u32) -> Move {
        let n2 = MOTOR.transition_from_rest(ACCEL, TOP) as u32;
        let n3 = m.saturating_sub(MOTOR.transition_from_rest(DECEL, TOP) as u32);
        if n2 <= n3 {
            return Move { m, n2, n3 };
        }
        let n = turning_point(m.into(), ACCEL, DECEL).round() as u32;
        Move { m, n2: n, n3: n }
    }

    /// c0 … c_(m−1): up by Eq 22 with n1 = 0, down by Eq 25.
    fn delays(self) -> Vec<f64> {
        let [m, n2, n3] = [self.m, self.n2, self.n3].map(f64::from);
        let mut delays = MOTOR.begin(ACCEL, Begin::Short);
        for i in (1..self.m).map(f64::from) {
            let c = delays[delays.len() - 1];
            delays.push(if i < n3 {
                next_scaled(c, i, factor(i, 0.0, n2))
            } else {
                next_scaled(c, i - m, (i - n3) / (m - n3 - 1.0))
            });
        }
        delays
    }
}

/// The figure.
pub fn draw() -> Drawing {
    let title = "Figure 8: linear factor, dual transitions";
    let mut drawing = Drawing::new(Sheet {
        columns: vec![
            ("m", "m"),
            ("what", "what"),
            ("published", "published"),
            ("computed", "computed"),
        ],
        notes: vec![
            "Transitions begin at rest: n1 = 0.".into(),
            "c_(m−1) is the hold after the last pulse; m pulses have m − 1 intervals.".into(),
        ],
        ..Sheet::new(title)
    });
    given(&mut drawing.sheet, ACCEL, Some(DECEL), TOP);
    for (m, texts) in [(700, ["432", "484"]), (500, ["333", "333"])] {
        let travel = Move::new(m);
        let name = format!("m = {m}");
        let trace = Trace { name, motor: MOTOR, delays: travel.delays() };
        let down = if travel.n2 < travel.n3 { "n3 = m − (24)" } else { "n3 = n2" };
        let up = if travel.n2 < travel.n3 { "n2 (24)" } else { "n2 (19)" };
        let peak = trace.peak();
        let expected = MOTOR.top(ACCEL, 0.0, travel.n2.into());
        let last = trace.delays.len() - 1;
        for (what, value) in [
            (up, Printed::right(texts[0], travel.n2.into())),
            (down, Printed::right(texts[1], travel.n3.into())),
            ("peak speed, rad/s", Printed::none(peak, 4)),
            ("… by (23)", Printed::none(expected, 4)),
            ("c0", Printed::none(trace.delays[0], 2)),
            ("smallest delay", Printed::none(MOTOR.delay(peak), 3)),
            ("c_(m−2), the last interval", Printed::none(trace.delays[last - 1], 2)),
            ("last pulse, s", Printed::none(trace.times()[last], 4)),
        ] {
            let cells = [m.into(), Cell::from(what), value.published(), value.computed()];
            drawing.sheet.rows.push(cells.to_vec());
            drawing.printed.push(value);
        }
        drawing.traces.push(trace);
    }
    drawing.figure = Some(figure(title, &drawing.traces));
    drawing
}

fn figure(title: &str, traces: &[Trace]) -> Figure {
    let panel = |name: &str, unit: &str, curves: Vec<Curve>| Panel {
        y: (name.into(), unit.into()),
        x: ("time".into(), "s".into()),
        curves,
        view: View { x: Some((0.0, 3.2)), y: None },
        ..Panel::default()
    };
    let all = |curve: &dyn Fn(&Trace, usize) -> Curve| {
        traces.iter().zip(0..).map(|(trace, i)| curve(trace, i)).collect()
    };
    // The curves begin at rest.
    let speeds = all(&|trace, i| {
        let mut curve = trace.line(i);
        curve.points.insert(0, (0.0, curve.points[0].1));
        curve
    });
    Figure {
        title: title.into(),
        notes: vec!["With and without a section at 10 rad/s; ω′ = 10 up, −20 rad/s² down".into()],
        rows: vec![
            (400.0, vec![panel("Speed ω", "rad/s", speeds)]),
            (330.0, vec![panel("Acceleration ω′", "rad/s²", all(&Trace::accels))]),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_steps() {
        assert_eq!(Move::new(700), Move { m: 700, n2: 432, n3: 484 });
        assert_eq!(Move::new(500), Move { m: 500, n2: 333, n3: 333 });
    }

    /// "… from acceleration to deceleration with no discontinuity."
    #[test]
    fn the_acceleration_has_no_jump() {
        for m in [700, 500] {
            let delays = Move::new(m).delays();
            assert_eq!(delays.len(), m as usize);
            let accels: Vec<_> = delays.windows(2).map(|c| MOTOR.accel(c[0], c[1])).collect();
            // Except for the first and the last steps, where one step is a large part of a ramp.
            let inner = &accels[2..accels.len() - 3];
            assert!(inner.windows(2).all(|a| (a[1] - a[0]).abs() < 0.3), "m = {m}");
            assert!(inner.iter().all(|a| (-DECEL..=ACCEL).contains(a)), "m = {m}");
        }
    }

    /// The top speed is that of Eq 23, and is kept from n2 to n3.
    #[test]
    fn the_top_speed() {
        let long = Move::new(700).delays();
        assert!((MOTOR.speed(long[432]) / TOP - 1.0).abs() < 3e-3);
        assert!(long[432..=484].iter().all(|&c| c == long[432]));
        let short = Move::new(500).delays();
        assert!((MOTOR.speed(short[333]) / MOTOR.top(ACCEL, 0.0, 333.0) - 1.0).abs() < 3e-3);
    }

    /// Eq 25 is accurate too: the ramp down ends where Eq 15's ramp of ω′2 would begin.
    #[test]
    fn the_down_ramp_ends_as_an_up_ramp_begins() {
        let begin = MOTOR.begin(DECEL, Begin::Short)[0];
        for m in [700, 500] {
            let delays = Move::new(m).delays();
            assert!((delays[m as usize - 1] / begin - 1.0).abs() < 0.025, "m = {m}");
        }
    }
}
