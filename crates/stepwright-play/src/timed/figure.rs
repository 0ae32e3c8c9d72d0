//! The plot: the speed over time, the steps left in a case beside its published log, and with
//! `--drive` the signals of the pins.

use std::str::FromStr;

use super::output::called;
use super::{SignalLevel, SpeedUpdate, TimedCourse, TimedWiring, WiredSignal};
use stepwright_plot::{Curve, Figure, GAP, PALETTE, Panel, View, number};

/// Signals are shown for this many steps, unless a window is chosen.
const FEW: usize = 16;

/// `0..40`: ms after the call.
#[derive(Clone, Copy, Debug)]
pub struct PlotWindow {
    from: f64,
    to: f64,
}

impl FromStr for PlotWindow {
    type Err = String;

    fn from_str(text: &str) -> Result<PlotWindow, String> {
        let (from, to) = text.split_once("..").ok_or("write FROM..TO in ms, like 0..40")?;
        let number = |text: &str| match text.trim().parse::<f64>() {
            Ok(ms) if (0.0..=1e8).contains(&ms) => Ok(ms),
            _ => Err(format!("{text:?} is no time in ms")),
        };
        let window = PlotWindow { from: number(from)?, to: number(to)? };
        if window.to > window.from { Ok(window) } else { Err("it ends before it begins".into()) }
    }
}

/// The figure of a course.
pub fn draw(course: &TimedCourse, wiring: &TimedWiring, window: Option<PlotWindow>) -> Figure {
    let last = course.steps.last().map_or(1.0, |clock| course.ms(*clock));
    let end = if course.moving { course.ms(course.end) } else { last };
    let across = match window {
        Some(window) => (window.from, window.to),
        None if !wiring.signals.is_empty() && course.steps.len() <= FEW => {
            // The time span of the pins: includes the changes at the call and after the last step.
            let change = course.changes.last().map_or(0.0, |change| course.ms(change.time));
            let end = end.max(change);
            (end * -0.03, end * 1.05)
        }
        None => (0.0, end.max(1e-3) * 1.02),
    };
    // Ten seconds or more are shown in seconds.
    let (unit, scale) = if across.1 >= 10_000.0 { ("s", 1e-3) } else { ("ms", 1.0) };
    let time = ("time from the call".to_owned(), unit.to_owned());
    let view = |(from, to): (f64, f64)| View { x: Some((from * scale, to * scale)), y: None };

    let log = course.order.log();
    let mut rows = vec![(
        340.0,
        vec![Panel {
            y: ("Speed".into(), "steps/s".into()),
            x: time.clone(),
            curves: speeds(course, scale),
            view: view(across),
            ..Panel::default()
        }],
    )];
    if !log.is_empty() && course.order.set_speed.limit != 0 {
        rows.push((
            300.0,
            vec![Panel {
                y: ("Steps left".into(), String::new()),
                x: time.clone(),
                curves: left(course, scale),
                view: view(across),
                ..Panel::default()
            }],
        ));
    }
    if !wiring.signals.is_empty() {
        let shown = match (window, course.steps.get(FEW - 1), course.steps.get(FEW)) {
            (None, Some(last), Some(next)) => {
                let few = (course.ms(*last) + course.ms(*next)) / 2.0;
                (few * -0.03, few)
            }
            _ => across,
        };
        let (unit, scale) = if shown.1 >= 10_000.0 { ("s", 1e-3) } else { ("ms", 1.0) };
        let lanes = wiring.signals.len() as f64;
        rows.push((
            112.0 + 46.0 * lanes,
            vec![Panel {
                y: ("Pins".into(), wiring.name.clone().unwrap_or_default()),
                x: ("time from the call".into(), unit.into()),
                curves: signals(course, wiring, scale, shown),
                view: View { x: Some((shown.0 * scale, shown.1 * scale)), y: Some((-0.15, lanes)) },
                lanes: wiring.signals.iter().map(|signal| signal.name.clone()).collect(),
                ..Panel::default()
            }],
        ));
    }
    Figure { title: title(course), notes: notes(course), rows }
}

fn title(course: &TimedCourse) -> String {
    let steps = number(course.steps.len() as f64, 0);
    match course.order.case {
        Some(case) => format!("The Arduino driver, case {case}: {steps} steps"),
        None => format!("Timed speed: {steps} steps"),
    }
}

fn notes(course: &TimedCourse) -> Vec<String> {
    let order = &course.order.set_speed;
    let first = course.updates.first();
    let last = course.updates.last();
    let speed = |update: Option<&SpeedUpdate>| {
        update.map_or(String::new(), |u| format!("{:.3}", u.fitted.nanosteps() as f64 / 1e9))
    };
    let mut parts = vec![format!("virtual top {}", order.top)];
    if course.updates.len() > 1 {
        let updates = course.updates.len() - 1;
        parts.push(format!("{updates} updates, one every {} ms", order.update_ms));
        parts.push(format!("{} → {} steps/s", speed(first), speed(last)));
    } else {
        parts.push(format!("{} steps/s", speed(first)));
    }
    parts.push(if course.latched { "latched tops" } else { "tops at once" }.into());
    let mut notes = vec![parts.join(GAP)];
    for (ms, call) in &course.calls {
        notes.push(format!("called back at {ms} ms: {}", called(*call)));
    }
    notes
}

/// The speed of each interval, and that of the log's tops.
fn speeds(course: &TimedCourse, scale: f64) -> Vec<Curve> {
    let mut points = vec![(0.0, 0.0)];
    for row in course.rows() {
        let before = course.ms(row.clock - row.delay) * scale;
        points.push((before, row.speed));
        points.push((course.ms(row.clock) * scale, row.speed));
    }
    if let Some((at, _)) = points.last().copied().filter(|_| !course.moving) {
        points.push((at, 0.0));
    }
    let name = if course.order.log().is_empty() { "speed" } else { "virtual board" };
    let mut curves = vec![Curve {
        name: name.into(),
        colour: PALETTE[0],
        points,
        filled: true,
        ..Curve::default()
    }];
    let hz = f64::from(course.hardware.hz());
    let dots = published(course, scale, |row| hz / f64::from(row[0]));
    curves.extend(dots);
    curves
}

/// The steps left over time, and those of the log.
fn left(course: &TimedCourse, scale: f64) -> Vec<Curve> {
    let limit = f64::from(course.order.set_speed.limit);
    let mut points = vec![(0.0, limit)];
    for row in course.rows() {
        points.push((course.ms(row.clock) * scale, limit - row.step as f64));
    }
    let mut curves = vec![Curve {
        name: "virtual board".into(),
        colour: PALETTE[0],
        points,
        ..Curve::default()
    }];
    curves.extend(published(course, scale, |row| f64::from(row[2])));
    curves
}

/// The dots of the published log.
fn published(course: &TimedCourse, scale: f64, value: impl Fn(&[u32; 5]) -> f64) -> Option<Curve> {
    use stepwright_sim::timed::published::{DUMP_EVERY_MS, FIRST_DUMP_MS};
    let log = course.order.log();
    let at = |n: usize| (FIRST_DUMP_MS + DUMP_EVERY_MS * n as f64) * scale;
    let dots: Vec<_> = log.iter().enumerate().map(|(n, row)| (at(n), value(row))).collect();
    let first = *dots.first()?;
    Some(Curve {
        name: "published log".into(),
        colour: PALETTE[1],
        // A line of no length, for the legend.
        points: vec![first, first],
        dots,
        ..Curve::default()
    })
}

/// A curve for each pin, the first one on top.
fn signals(
    course: &TimedCourse,
    wiring: &TimedWiring,
    scale: f64,
    shown: (f64, f64),
) -> Vec<Curve> {
    let (begin, end) = (shown.0.min(0.0) * scale, shown.1 * scale);
    let lane = |(signal, at): (&WiredSignal, usize)| {
        let base = (wiring.signals.len() - 1 - at) as f64;
        let mut points: Vec<(f64, f64)> = Vec::new();
        for change in &course.changes {
            let high = if signal.is_high(change) { 0.7 } else { 0.0 };
            let (time, level) = (course.ms(change.time) * scale, base + high);
            let before = points.last().map_or(level, |(_, before)| *before);
            if points.is_empty() {
                points.push((begin, level));
            }
            points.extend([(time, before), (time, level)]);
        }
        if let Some((_, level)) = points.last().copied() {
            points.push((end, level));
        }
        Curve {
            name: signal.name.clone(),
            colour: match signal.what {
                SignalLevel::Line(_) => PALETTE[0],
                _ => PALETTE[5],
            },
            points,
            ..Curve::default()
        }
    };
    wiring.signals.iter().zip(0..).map(lane).collect()
}
