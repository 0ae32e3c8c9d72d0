//! What Figures 5 to 7 have in common: ways to approach a top speed.

use super::trace::{Trace, target};
use super::{Drawing, given};
use crate::sheet::Sheet;
use stepwright_plot::{Figure, Panel, View};

/// Speed and acceleration over time, beside the ramp without a transition to the same speed.
pub fn approach(
    mut sheet: Sheet,
    title: &str,
    note: &str,
    traces: Vec<Trace>,
    accel: f64,
    top: f64,
) -> Drawing {
    given(&mut sheet, accel, None, top);
    // Long enough to show all of them at the top speed.
    let longest = traces.iter().map(Trace::seconds).fold(0.0, f64::max);
    let end = (longest.min(3.0) * 10.0).ceil() / 10.0;
    let (full, plain) = (top / accel, "no transition");
    let at_top = target(plain, vec![(0.0, 0.0), (full, top), (end, top)]);
    let fall = target(plain, vec![(0.0, accel), (full, accel), (full, 0.0), (end, 0.0)]);
    let panel = |name: &str, unit: &str, curves, high| Panel {
        y: (name.into(), unit.into()),
        x: ("time".into(), "s".into()),
        curves,
        view: View { x: Some((0.0, end)), y: Some((0.0, high)) },
        ..Panel::default()
    };
    let with = |line, curve: &dyn Fn(&Trace, usize) -> stepwright_plot::Curve| {
        let curves = traces.iter().zip(0..).map(|(trace, i)| curve(trace, i));
        std::iter::once(line).chain(curves).collect()
    };
    // Every curve continues at its last speed.
    let speed = with(at_top, &|trace, i| {
        let mut curve = trace.line(i);
        let last = trace.speed_at(f64::INFINITY);
        curve.points.push((end.max(trace.seconds()), last));
        curve
    });
    let accels = with(fall, &|trace, i| trace.accels(i));
    let figure = Figure {
        title: title.into(),
        notes: vec![note.into()],
        rows: vec![
            (400.0, vec![panel("Speed ω", "rad/s", speed, 1.08 * top)]),
            (300.0, vec![panel("Acceleration ω′", "rad/s²", accels, 1.12 * accel)]),
        ],
    };
    Drawing { sheet, figure: Some(figure), traces, printed: Vec::new() }
}
