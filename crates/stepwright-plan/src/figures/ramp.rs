//! Figures 2 to 4: the linear ramp, exact and approximated, from 0 to 120 rpm in 1 s.

use std::f64::consts::PI;

use super::printed::Printed;
use super::trace::{Trace, target};
use super::{Drawing, given};
use crate::equations::{Begin, MOTOR, next, next_simple};
use crate::sheet::{Cell, Sheet};
use stepwright_plot::{Figure, Panel, View};

/// 120 rpm in rad/s. The acceleration is the same number: the ramp takes a second.
const TOP: f64 = 4.0 * PI;
/// Steps of the ramp, by Eq 16.
const STEPS: u32 = 200;
/// rpm of one rad/s.
const RPM: f64 = 30.0 / PI;

/// The ramp made in four ways.
struct Ramps {
    exact: Trace,
    special: Trace,
    short: Trace,
    simple: Trace,
}

impl Ramps {
    fn new() -> Ramps {
        let steps = 1..STEPS;
        let trace = |name: &str, delays| Trace { name: name.into(), motor: MOTOR, delays };
        let go_on = |mut delays: Vec<f64>, law: fn(f64, f64) -> f64| {
            for n in delays.len() as u32..STEPS {
                delays.push(law(delays[delays.len() - 1], n.into()));
            }
            delays
        };
        let exact: Vec<f64> = (0..1).chain(steps).map(|n| MOTOR.exact(TOP, n.into())).collect();
        // The c0 with which c/2n ends at the speed of the exact ramp.
        let simple = vec![PI.sqrt() / 2.0 * exact[0]];
        Ramps {
            special: trace("c1 = 0.4056 c0", go_on(MOTOR.begin(TOP, Begin::Special), next)),
            short: trace("c0 by (15)", go_on(MOTOR.begin(TOP, Begin::Short), next)),
            simple: trace("c/2n", go_on(simple, next_simple)),
            exact: trace("exact (8)", exact),
        }
    }

    fn all(&self) -> [&Trace; 4] {
        [&self.exact, &self.special, &self.short, &self.simple]
    }

    fn drawing(self, mut sheet: Sheet, title: &str, note: &str, view: View) -> Drawing {
        given(&mut sheet, TOP, None, TOP);
        let mut curves = vec![target("target", vec![(0.0, 0.0), (1.0, 120.0)])];
        let shown = [&self.exact, &self.special, &self.short];
        curves.extend(shown.into_iter().zip(0..).map(|(trace, i)| trace.stairs(i, RPM)));
        let panel = Panel {
            y: ("Speed".into(), "rpm".into()),
            x: ("time".into(), "s".into()),
            curves,
            view,
            ..Panel::default()
        };
        let figure = Figure {
            title: title.into(),
            notes: vec![note.into()],
            rows: vec![(480.0, vec![panel])],
        };
        let Ramps { exact, special, short, simple } = self;
        let traces = vec![exact, special, short, simple];
        Drawing { sheet, figure: Some(figure), traces, printed: Vec::new() }
    }
}

/// The whole ramp.
pub fn whole() -> Drawing {
    let ramps = Ramps::new();
    let c0 = MOTOR.c0(TOP);
    let last = |trace: &Trace| trace.delays[trace.delays.len() - 1];
    // The c0 with which a ramp ends at the speed of the exact ramp, in % of the exact c0.
    let part = |law: &Trace| last(&ramps.exact) / (last(law) / law.delays[0]) / c0 * 100.0;
    let rows = [
        ("delay of 300 rpm (2)", Printed::right("1000", MOTOR.delay(10.0 * PI))),
        ("delay of 120 rpm (2)", Printed::none(MOTOR.delay(TOP), 3)),
        ("steps to 120 rpm (16)", Printed::none(MOTOR.step_of(TOP, TOP), 3)),
        ("1 rad in degrees", Printed::right("57.3", 180.0 / PI)),
        ("1 rad/s in rpm", Printed::right("9.55", RPM)),
        ("c0 of (13), % of the exact", Printed::right("67.6", part(&ramps.short))),
        ("c0 of c/2n, % of the exact", Printed::right("88.6", part(&ramps.simple))),
        ("c1 / c0 of (13) and (15), times 0.676", Printed::right("0.4056", 0.6 * 0.676)),
    ];
    let mut printed = Vec::new();
    let mut row = |what: &str, ramp: Cell, value: Printed| {
        let row = vec![what.into(), ramp, value.published(), value.computed()];
        printed.push(value);
        row
    };
    let text = rows.into_iter().map(|(what, value)| row(what, Cell::Empty, value));
    let mut cells: Vec<Vec<Cell>> = text.collect();
    for trace in ramps.all() {
        let name = || trace.name.as_str().into();
        cells.push(row("c0", name(), Printed::none(trace.delays[0], 2)));
        cells.push(row("c199", name(), Printed::none(last(trace), 3)));
        let sum = trace.delays.iter().sum();
        cells.push(row("c0 + … + c199", name(), Printed::none(sum, 1)));
    }
    let title = "Figure 2: stepper-motor speed ramp, 0 to 120 rpm in 1 s";
    let sheet = Sheet {
        columns: vec![
            ("what", "what"),
            ("ramp", "ramp"),
            ("published", "published"),
            ("computed", "computed"),
        ],
        rows: cells,
        notes: vec!["(15) ends 0.024 s early: its first steps are that much faster.".into()],
        ..Sheet::new(title)
    };
    let note = "The speed of each step by (2): a true profile lies close to the line";
    let mut drawing = ramps.drawing(sheet, title, note, View::default());
    drawing.printed = printed;
    drawing
}

/// The first steps.
pub fn start() -> Drawing {
    let ramps = Ramps::new();
    let title = "Figure 3: start of the ramp in detail";
    let note = "Both ways of handling n = 1: as a special case, or with a shorter c0";
    let sheet = detail(&ramps, title, 0..8);
    ramps.drawing(sheet, title, note, View { x: Some((0.0, 0.25)), y: Some((0.0, 32.0)) })
}

/// The last steps.
pub fn end() -> Drawing {
    let ramps = Ramps::new();
    let title = "Figure 4: end of the ramp in detail";
    let note = "The ramp that begins with a fast step ends as much earlier, at the same speed";
    let sheet = detail(&ramps, title, 192..200);
    ramps.drawing(sheet, title, note, View { x: Some((0.95, 1.0)), y: Some((113.0, 120.5)) })
}

/// Some steps of each ramp.
fn detail(ramps: &Ramps, title: &str, steps: std::ops::Range<usize>) -> Sheet {
    let mut sheet = Sheet {
        columns: vec![
            ("n", "n"),
            ("exact", "c_n exact (8)"),
            ("exact_rpm", "rpm"),
            ("exact_s", "from, s"),
            ("special", "c1 = 0.4056 c0"),
            ("special_rpm", "rpm"),
            ("special_s", "from, s"),
            ("short", "c0 by (15)"),
            ("short_rpm", "rpm"),
            ("short_s", "from, s"),
        ],
        ..Sheet::new(title)
    };
    let shown = [&ramps.exact, &ramps.special, &ramps.short];
    for n in steps {
        let mut row: Vec<Cell> = vec![(n as i64).into()];
        for trace in shown {
            let (c, from) = (trace.delays[n], trace.times()[n]);
            let rpm = MOTOR.speed(c) * RPM;
            row.extend([Cell::fixed(c, 3), Cell::fixed(rpm, 3), Cell::fixed(from, 5)]);
        }
        sheet.rows.push(row);
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(value: f64, decimals: usize) -> String {
        format!("{value:.decimals$}")
    }

    /// Corner values and sums of the exact ramp and of Eq 15's.
    #[test]
    fn corners_and_sums() {
        let Ramps { exact, special, short, simple } = Ramps::new();
        assert_eq!(shown(exact.delays[0], 2), "70710.68");
        assert_eq!(shown(short.delays[0], 2), "47800.42");
        assert_eq!(shown(exact.delays[199], 3), "2503.133");
        assert_eq!(shown(short.delays[199], 3), "2503.210");
        assert_eq!(shown(exact.delays.iter().sum(), 1), "1000000.0");
        // 0.4056 = 0.6 · 0.676: from c1 on both ways are equal.
        assert_eq!(exact.delays.len(), 200);
        assert_eq!(special.delays[0], exact.delays[0]);
        for n in 1..200 {
            assert!((special.delays[n] / short.delays[n] - 1.0).abs() < 1e-12, "{n}");
        }
        assert_eq!(shown(simple.delays[0] / exact.delays[0], 3), "0.886");
        assert!((simple.delays[199] / exact.delays[199] - 1.0).abs() < 1e-3);
    }

    /// "The first alternative gives an almost perfect linear ramp."
    #[test]
    fn the_special_case_is_almost_perfect() {
        let Ramps { exact, special, short, .. } = Ramps::new();
        let late = |trace: &Trace| trace.seconds() - exact.seconds();
        assert!(late(&special).abs() < 1e-3, "{}", late(&special));
        assert!((-0.025..-0.022).contains(&late(&short)), "{}", late(&short));
    }
}
