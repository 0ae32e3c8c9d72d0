//! A plan as a figure: speed and acceleration, and the jerk if it has a limit, over time and over steps.

use stepwright::profile::Phase;
use stepwright_oracle::Number;

use crate::law::{Plan, PlanValue};
use crate::survey::{Sample, Survey};
use crate::text::{counted, lasting, peak};
use stepwright_plot::{Band, Curve, Figure, GAP, PALETTE, Panel, number, time_unit};
use stepwright_units::MachineUnit;

/// Up to this many steps, each is marked with a dot.
const FEW: usize = 80;

/// The figure of a plan.
///
/// The speed is that of the emitted delays. The acceleration is that of the ideal delays, because whole
/// ticks make noise of it.
pub fn draw(plan: &Plan, survey: &Survey, unit: Option<MachineUnit>) -> Figure {
    let seconds = plan.seconds(survey.duration as f64);
    let (time, per_second) = time_unit(seconds);
    let tick = per_second / f64::from(plan.rate.hz());
    // A label like 2 000 000 000 is too wide.
    let many = plan.law.pulses() > 5_000_000;
    let (length, per_unit) = unit.map_or(("steps", 1.0), |unit| (unit.name, unit.steps));
    let step = if many { 1e-6 } else { 1.0 };
    let view = View { plan, survey, tick, step, length, per_unit };
    let time = ("time".to_owned(), time.to_owned());
    let step = ("step".to_owned(), if many { "millions".to_owned() } else { String::new() });
    let row = |height: f64, shown: Shown| {
        (height, vec![view.panel(shown, &time, By::Time), view.panel(shown, &step, By::Steps)])
    };
    let mut rows = vec![row(380.0, Shown::Speed), row(270.0, Shown::Accel)];
    if plan.values.iter().any(|value| value.name == "jerk") {
        rows.push(row(250.0, Shown::Jerk));
    }
    let mut notes = notes(plan, survey);
    notes.extend(unit.map(MachineUnit::note));
    Figure { title: title(plan), notes, rows }
}

/// What a panel shows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shown {
    Speed,
    Accel,
    Jerk,
}

impl Shown {
    /// The name, and the part of the unit after the length.
    fn name(self) -> (&'static str, &'static str) {
        match self {
            Shown::Speed => ("Speed", "/s"),
            Shown::Accel => ("Acceleration", "/s²"),
            Shown::Jerk => ("Jerk", "/s³"),
        }
    }
}

fn title(plan: &Plan) -> String {
    let steps = match plan.law.pulses() {
        1 => "1 step".to_owned(),
        many => format!("{} steps", number(many.into(), 0)),
    };
    let mut name = plan.name.to_owned();
    name[..1].make_ascii_uppercase();
    format!("{name}, {steps}")
}

fn notes(plan: &Plan, survey: &Survey) -> Vec<String> {
    let twice = |v: &PlanValue| {
        v.name == "deceleration"
            && plan.values.iter().any(|w| w.name == "acceleration" && w.shown == v.shown)
    };
    // A start speed of 0 needs no mention.
    let values = plan.values.iter().filter(|v| !twice(v) && v.held != 0.0);
    let values: Vec<_> = values.map(|v| format!("{} {}", v.name, v.shown)).collect();
    let mut notes = vec![
        values.join(GAP),
        format!(
            "duration {}{GAP}peak speed {}{GAP}braking {}{GAP}\
             largest error {:.2} ticks of a {} Hz timer",
            lasting(plan.seconds(survey.duration as f64), 3),
            peak(plan),
            counted(plan.law.braking()),
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
    /// A tick and a step in the units of their axes.
    tick: f64,
    step: f64,
    /// The unit of length, and its steps.
    length: &'static str,
    per_unit: f64,
}

impl View<'_> {
    fn panel(&self, shown: Shown, x: &(String, String), by: By) -> Panel {
        let (speed, (name, per)) = (shown == Shown::Speed, shown.name());
        let mut points = match shown {
            Shown::Speed => self.speeds(by),
            Shown::Accel => self.accels(by),
            Shown::Jerk => self.jerks(by),
        };
        points.iter_mut().for_each(|(_, value)| *value /= self.per_unit);
        let few = speed && points.len() <= FEW;
        let inner = points.len().saturating_sub(1);
        Panel {
            y: (name.into(), format!("{}{per}", self.length)),
            x: x.clone(),
            bands: self.bands(by),
            named: speed,
            curves: vec![Curve {
                name: name.into(),
                colour: PALETTE[shown as usize],
                // Without the ends, which are no delays.
                dots: if few && inner > 1 { points[1..inner].to_vec() } else { Vec::new() },
                points,
                filled: true,
                ..Curve::default()
            }],
            ..Panel::default()
        }
    }

    /// The x value of a pulse.
    fn x(&self, by: By, sample: &Sample) -> f64 {
        match by {
            By::Time => sample.time as f64 * self.tick,
            By::Steps => (f64::from(sample.n) + 1.0) * self.step, // as in the table
        }
    }

    /// Speed between neighbouring samples, at the middle between them.
    fn speeds(&self, by: By) -> Vec<(f64, f64)> {
        let samples = self.clear();
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

    /// The samples; of more than a few, only samples that lie so far apart that a tick more or less can't
    /// be seen.
    fn clear(&self) -> Vec<Sample> {
        let samples = &self.survey.samples;
        let enough = if samples.len() <= FEW { 0 } else { (self.survey.duration / 100).min(300) };
        let mut clear: Vec<Sample> = Vec::with_capacity(samples.len());
        for &sample in samples {
            if clear.last().is_none_or(|last| sample.time - last.time >= enough) {
                clear.push(sample);
            }
        }
        // The end always belongs to the curve, even if the last stretch gets longer.
        if clear.len() > 1 {
            clear.pop();
        }
        clear.extend(samples.last().filter(|_| samples.len() > 1));
        clear
    }

    /// The change of the ideal speed from the stretch before a sample to the stretch after it, between the
    /// middles of the two.
    fn accels(&self, by: By) -> Vec<(f64, f64)> {
        let samples = &self.survey.samples;
        let stretch = |a: &Sample, b: &Sample| self.stretch(a, b);
        let middle = |a: &Sample, b: &Sample| (self.x(by, a) + self.x(by, b)) / 2.0;
        let mut points = Vec::new();
        if let [a, b] = samples.as_slice() {
            // One interval: up to twice its mean speed in the middle, and back.
            let (end, (mean, seconds)) = (self.plan.law.ends(), stretch(a, b));
            let accel = 4.0 * (mean - end) / seconds;
            let (x, half) = ((self.x(by, a), self.x(by, b)), middle(a, b));
            return vec![(x.0, accel), (half, accel), (half, -accel), (x.1, -accel)];
        }
        for three in samples.windows(3) {
            let (a, b, c) = (&three[0], &three[1], &three[2]);
            let ((v1, t1), (v2, t2)) = (stretch(a, b), stretch(b, c));
            let accel = 2.0 * (v2 - v1) / (t1 + t2);
            points.extend([(middle(a, b), accel), (middle(b, c), accel)]);
        }
        // At the ends, the acceleration of the neighbouring points.
        if let [first, .., last] = points.as_mut_slice() {
            first.0 = self.x(by, &samples[0]);
            last.0 = self.x(by, &samples[samples.len() - 1]);
        }
        points
    }

    /// The ideal's mean speed between two samples, and the seconds between them.
    fn stretch(&self, a: &Sample, b: &Sample) -> (f64, f64) {
        let seconds = (b.ideal - a.ideal).to_f64() / f64::from(self.plan.rate.hz());
        (f64::from(b.n - a.n) / seconds, seconds)
    }

    /// The jerk of the cubic through four samples of the ideal, between the inner two.
    fn jerks(&self, by: By) -> Vec<(f64, f64)> {
        let samples = &self.survey.samples;
        let mut points = Vec::new();
        for four in samples.windows(4) {
            let [(v1, t1), (v2, t2), (v3, t3)] =
                [0, 1, 2].map(|n| self.stretch(&four[n], &four[n + 1]));
            let bends = ((v2 - v1) / (t1 + t2), (v3 - v2) / (t2 + t3));
            let jerk = 6.0 * (bends.1 - bends.0) / (t1 + t2 + t3);
            points.extend([(self.x(by, &four[1]), jerk), (self.x(by, &four[2]), jerk)]);
        }
        // At the ends, the jerk of the neighbouring points.
        if let [first, .., last] = points.as_mut_slice() {
            first.0 = self.x(by, &samples[0]);
            last.0 = self.x(by, &samples[samples.len() - 1]);
        }
        points
    }

    fn bands(&self, by: By) -> Vec<Band> {
        let (mut ticks, mut pulses) = (0u64, 0u32);
        let mut bands = Vec::new();
        for part in &self.survey.parts {
            let at = |ticks: u64, pulses: u32| match by {
                By::Time => ticks as f64 * self.tick,
                By::Steps => f64::from(pulses.max(1)) * self.step,
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
                    Phase::JerkUp | Phase::JerkDown => [0xf0, 0xf2, 0xf9],
                },
            });
        }
        bands
    }
}
