//! A plan as a figure: speed and acceleration, over time and over steps.

use stepwright::profile::Phase;

use super::law::Plan;
use super::survey::{Sample, Survey};
use super::text::{peak, trimmed};
use crate::plot::{Band, Curve, Figure, PALETTE, Panel, number, time_unit};

/// Up to so many steps, each is marked with a dot.
const FEW: usize = 80;

/// The figure of a plan.
///
/// The speed is that of the emitted delays; the acceleration that of the
/// ideal, since whole ticks make noise of it.
pub fn draw(plan: &Plan, survey: &Survey) -> Figure {
    let seconds = plan.seconds(survey.duration as f64);
    let (unit, per_second) = time_unit(seconds);
    let tick = per_second / f64::from(plan.rate.hz());
    let view = View { plan, survey, tick };
    let time = ("time".to_owned(), unit.to_owned());
    let step = ("steps".to_owned(), String::new());
    let speed = |x: &(String, String), by| view.panel("Speed", "steps/s", x, by);
    let accel = |x: &(String, String), by| view.panel("Acceleration", "steps/s²", x, by);
    Figure {
        title: title(plan),
        notes: notes(plan, survey),
        rows: vec![
            (380.0, vec![speed(&time, By::Time), speed(&step, By::Steps)]),
            (270.0, vec![accel(&time, By::Time), accel(&step, By::Steps)]),
        ],
    }
}

fn title(plan: &Plan) -> String {
    let steps = number(f64::from(plan.law.pulses()), 0);
    let mut name = plan.name.to_owned();
    name[..1].make_ascii_uppercase();
    format!("{name}, {steps} steps")
}

fn notes(plan: &Plan, survey: &Survey) -> Vec<String> {
    let values: Vec<_> = plan.values.iter().map(|v| format!("{} {}", v.name, v.shown)).collect();
    let seconds = trimmed(plan.seconds(survey.duration as f64), 3);
    let mut notes = vec![
        values.join("   ·   "),
        format!(
            "duration {seconds} s   ·   peak speed {}   ·   braking {} steps   ·   \
             largest error {:.2} ticks of a {} Hz timer",
            peak(plan),
            plan.law.braking(),
            survey.worst.ticks,
            number(plan.rate.hz().into(), 0),
        ),
    ];
    notes.extend(plan.note.clone());
    notes
}

/// What an x axis shows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum By {
    Time,
    Steps,
}

struct View<'a> {
    plan: &'a Plan,
    survey: &'a Survey,
    /// A tick in the unit of the time axis.
    tick: f64,
}

impl View<'_> {
    fn panel(&self, name: &str, unit: &str, x: &(String, String), by: By) -> Panel {
        let speed = name == "Speed";
        let points = if speed { self.speeds(by) } else { self.accels(by) };
        let few = speed && points.len() <= FEW;
        let inner = points.len().saturating_sub(1);
        Panel {
            y: (name.into(), unit.into()),
            x: x.clone(),
            bands: self.bands(by),
            named: speed,
            curves: vec![Curve {
                name: name.into(),
                colour: PALETTE[usize::from(!speed)],
                // Not the ends, which are no delays.
                dots: if few && inner > 1 { points[1..inner].to_vec() } else { Vec::new() },
                points,
                filled: true,
            }],
        }
    }

    /// Where a pulse lies on the x axis.
    fn x(&self, by: By, sample: &Sample) -> f64 {
        match by {
            By::Time => sample.time as f64 * self.tick,
            By::Steps => f64::from(sample.n),
        }
    }

    /// Speed between neighbouring samples, in the middle between them.
    fn speeds(&self, by: By) -> Vec<(f64, f64)> {
        let samples = &self.survey.samples;
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            return Vec::new();
        };
        let hz = f64::from(self.plan.rate.hz());
        let end = self.plan.law.ends();
        let mut points = vec![(self.x(by, first), end)];
        for pair in samples.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            let ticks = (b.time - a.time).max(1) as f64;
            let x = (self.x(by, a) + self.x(by, b)) / 2.0;
            points.push((x, f64::from(b.n - a.n) * hz / ticks));
        }
        points.push((self.x(by, last), end));
        points
    }

    /// Change of the ideal's speed from the stretch before a sample to the
    /// stretch behind it.
    fn accels(&self, by: By) -> Vec<(f64, f64)> {
        let samples = &self.survey.samples;
        let hz = f64::from(self.plan.rate.hz());
        let stretch = |a: &Sample, b: &Sample| {
            let seconds = (b.ideal - a.ideal).to_f64() / hz;
            (f64::from(b.n - a.n) / seconds, seconds)
        };
        let mut points = Vec::new();
        for three in samples.windows(3) {
            let (a, b, c) = (&three[0], &three[1], &three[2]);
            let ((v1, t1), (v2, t2)) = (stretch(a, b), stretch(b, c));
            points.push((self.x(by, b), 2.0 * (v2 - v1) / (t1 + t2)));
        }
        // At the ends it is what it is beside them.
        if let (Some(&(_, left)), Some(&(_, right))) = (points.first(), points.last()) {
            points.insert(0, (self.x(by, &samples[0]), left));
            points.push((self.x(by, &samples[samples.len() - 1]), right));
        }
        points
    }

    fn bands(&self, by: By) -> Vec<Band> {
        let (mut ticks, mut pulses) = (0u64, 0u32);
        let mut bands = Vec::new();
        for part in &self.survey.parts {
            let at = |ticks: u64, pulses: u32| match by {
                By::Time => ticks as f64 * self.tick,
                By::Steps => f64::from(pulses.saturating_sub(1)),
            };
            let from = at(ticks, pulses);
            ticks += part.ticks;
            pulses += part.pulses;
            bands.push(Band {
                from,
                to: at(ticks, pulses),
                name: part.phase.name().into(),
                tint: match part.phase {
                    Phase::Up => [0xec, 0xf7, 0xf0],
                    Phase::Cruise => [0xff, 0xff, 0xff],
                    Phase::Down => [0xfd, 0xf2, 0xe9],
                },
            });
        }
        bands
    }
}
