//! `plan compare`: laws over one another, for the same travel.
//!
//! Delays are those of the laws' formulas, not yet rounded to ticks, for whole
//! ticks make noise of an acceleration. They are held against constant
//! acceleration, which is time-optimal within the limits: for a law that leaves
//! its last delay out, over one step more.

use std::io::{self, BufWriter, Write};

use clap::builder::PossibleValuesParser;
use stepwright::{Jerk, Speed};

use super::law::{Law, Value};
use super::limits::{Asked, Begin, Limits};
use super::linear_factor::{self, Knee};
use super::piecewise::{self, Breaks};
use super::power::{self, Power};
use super::{Machine, austin, s_curve, trapezoid};
use crate::failure::{Failure, unless_closed};
use crate::figures::law::Motor;
use crate::plot::{Curve, Figure, GAP, PALETTE, Panel, PlotFile, View, number, time_unit};
use crate::quantity::{JerkArg, MachineUnit};
use crate::sheet::{Cell, Format, Sheet};

/// Laws over one another: how long, how fast, how smooth
///
/// The same travel by each: duration, peak speed, the highest acceleration,
/// deceleration (Austin, Eq 3) and jerk between neighbouring delays; how
/// far the delays are from those of constant acceleration, largest and root mean
/// square; and the time lost against it, as the time-optimal travel.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Austin's transitions beside constant acceleration:
    stepwright plan compare trapezoid austin linear-factor power piecewise \\
      --steps 1000 --accel 2000 --top-speed 1000 --plot laws.png
  What a limited jerk costs, and what the transitions approximate:
    stepwright plan compare trapezoid linear-factor s-curve --jerk 20000 \
      --steps 1000 --accel 2000 --top-speed 1000 --plot laws.png
  One transition, in numbers:
    stepwright plan compare trapezoid linear-factor --knee 0.5 \\
      --steps 1000 --accel 2000 --top-speed 1000 --format json")]
pub struct Args {
    /// Which laws
    #[arg(required = true, value_name = "LAW")]
    #[arg(value_parser = PossibleValuesParser::new(LAWS.map(|(name, _)| name)))]
    laws: Vec<String>,
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    knee: Knee,
    #[command(flatten)]
    power: Power,
    #[command(flatten)]
    breaks: Breaks,
    /// How fast the acceleration of s-curve changes: 80000, 200rad/s3 … (steps/s³)
    #[arg(long, value_name = "JERK", allow_hyphen_values = true)]
    jerk: Option<JerkArg>,
    /// How to print it
    #[arg(long, value_enum, default_value_t = Format::Table, help_heading = "Output")]
    format: Format,
    /// Draw it: speed and acceleration over time (.svg, .png or .html)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Vec<PlotFile>,
    #[command(flatten)]
    machine: Machine,
}

/// Makes a law for the limits.
type Make = fn(&Asked, &Args) -> Result<Box<dyn Law>, Failure>;

/// The laws that can be compared: another one is another line.
const LAWS: [(&str, Make); 6] = [
    ("trapezoid", |asked, _| trapezoid::law(asked, Speed::ZERO)),
    ("s-curve", |asked, args| s_curve::law(asked, Speed::ZERO, args.jerk()?)),
    ("austin", |asked, args| austin::law(asked, args.begin.c0, austin::Divide::FourN)),
    ("linear-factor", |asked, args| linear_factor::law(asked, args.begin.c0, args.knee)),
    ("power", |asked, args| power::law(asked, args.begin.c0, args.power)),
    ("piecewise", |asked, args| piecewise::law(asked, args.begin.c0, args.breaks)),
];

impl Args {
    fn jerk(&self) -> Result<Jerk, Failure> {
        let Some(jerk) = &self.jerk else {
            return Err(Failure::usage("s-curve needs a jerk").hint(
                "give --jerk, for example twenty times the acceleration: it is there in 50 ms",
            ));
        };
        Ok(jerk.resolve(&self.machine.geometry.geometry()?, "--jerk")?.value)
    }
}

/// Every delay is looked at.
const MOST: u32 = 1_000_000;

/// Compares, prints, and draws if asked to.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (rate, geometry) = (args.machine.timer_hz, args.machine.geometry.geometry()?);
    let asked = args.limits.held(rate, &geometry)?;
    if asked.steps > MOST {
        return Err(Failure::new(format!("{} steps are too many to compare", asked.steps))
            .hint(format!("every step is looked at: give {MOST} or fewer")));
    }
    let constant = |steps| -> Result<Course, Failure> {
        let asked = Asked { steps, ..asked.clone() };
        Ok(Course::of("", trapezoid::law(&asked, Speed::ZERO)?.as_ref(), &asked))
    };
    let constant = [constant(asked.steps)?, constant(asked.steps + 1)?];
    let mut courses = Vec::new();
    for name in &args.laws {
        let made = LAWS.iter().find(|(known, _)| known == name);
        let Some((name, make)) = made else { continue };
        courses.push(Course::of(name, make(&asked, args)?.as_ref(), &asked));
    }
    for file in &args.plot {
        file.save(&draw(&asked, &courses, args.machine.geometry.unit()))?;
    }
    let mut out = BufWriter::new(io::stdout().lock());
    let written = sheet(&asked, &courses, &constant).write(&mut out, args.format);
    unless_closed(written.and_then(|()| out.flush()))
}

/// A travel by one law.
struct Course {
    name: &'static str,
    motor: Motor,
    /// Whether the last delay of the formula is left out.
    holds: bool,
    /// By formula, in ticks.
    delays: Vec<f64>,
    /// As the core emits it, in seconds.
    duration: f64,
    peak: f64,
}

impl Course {
    fn of(name: &'static str, law: &dyn Law, asked: &Asked) -> Course {
        let motor = asked.motor();
        let times: Vec<_> = (0..law.pulses()).map(|n| law.ideal(n)).collect();
        let delays = times.windows(2).map(|t| (t[1] - t[0]).to_f64()).collect();
        let ticks: u64 = law.delays().map(u64::from).sum();
        let holds = law.holds();
        Course { name, motor, holds, delays, duration: ticks as f64 / motor.hz, peak: law.peak() }
    }

    /// Eq 3 between neighbouring delays.
    fn accels(&self) -> impl Iterator<Item = f64> + '_ {
        self.delays.windows(2).map(|c| self.motor.accel(c[0], c[1]))
    }

    /// The change of that per second, at its largest.
    fn jerk(&self) -> f64 {
        let accels: Vec<_> = self.accels().collect();
        let jerks = accels.windows(2).zip(self.delays.iter().skip(1));
        jerks.map(|(a, c)| ((a[1] - a[0]) * self.motor.hz / c).abs()).fold(0.0, f64::max)
    }

    /// Each delay's part above that of another course.
    fn errors<'a>(&'a self, of: &'a Course) -> impl Iterator<Item = f64> + 'a {
        self.delays.iter().zip(&of.delays).map(|(c, exact)| c / exact - 1.0)
    }

    fn row(&self, [constant, longer]: &[Course; 2]) -> Vec<Cell> {
        let exact = if self.holds { longer } else { constant };
        let highest = |sign: f64| self.accels().map(|a| a * sign).fold(0.0, f64::max);
        let (mut worst, mut at, mut squares) = (0.0f64, Cell::Empty, 0.0);
        for (error, step) in self.errors(exact).zip(2u32..) {
            if error.abs() > worst.abs() {
                (worst, at) = (error, step.into());
            }
            squares += error * error;
        }
        let rms = (squares / self.delays.len().max(1) as f64).sqrt();
        let lost = self.duration - constant.duration;
        let share = if constant.duration > 0.0 { lost / constant.duration } else { 0.0 };
        vec![
            self.name.into(),
            Cell::fixed(self.duration, 6),
            Cell::fixed(self.peak, 3),
            Cell::digits(highest(1.0), 5),
            Cell::digits(highest(-1.0), 5),
            Cell::digits(self.jerk(), 5),
            Cell::fixed(worst * 100.0, 4),
            at,
            Cell::fixed(rms * 100.0, 4),
            Cell::fixed(lost, 6),
            Cell::fixed(share * 100.0, 3),
        ]
    }

    /// Speed in the middle of each interval, from rest to rest.
    fn speeds(&self, per_second: f64) -> Vec<(f64, f64)> {
        let mut points = vec![(0.0, 0.0)];
        let mut time = 0.0;
        for c in &self.delays {
            points.push(((time + c / 2.0) / self.motor.hz * per_second, self.motor.speed(*c)));
            time += c;
        }
        points.push((time / self.motor.hz * per_second, 0.0));
        points
    }

    fn slopes(&self, per_second: f64) -> Vec<(f64, f64)> {
        let mut time = 0.0;
        let at = |(c, accel): (&f64, f64)| {
            time += c;
            (time / self.motor.hz * per_second, accel)
        };
        let mut points: Vec<_> = self.delays.iter().zip(self.accels()).map(at).collect();
        // Within the first and the last delay it is not known to be another.
        if let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) {
            let all: f64 = self.delays.iter().sum();
            points.insert(0, (0.0, first.1));
            points.push((all / self.motor.hz * per_second, last.1));
        }
        points
    }
}

fn sheet(asked: &Asked, courses: &[Course], constant: &[Course; 2]) -> Sheet {
    let mut sheet = Sheet::new("Laws for the same travel");
    sheet.fact("steps", "steps", asked.steps, "");
    let keys = ["top_speed", "acceleration", "deceleration"];
    for (key, Value { name, shown, held, .. }) in keys.into_iter().zip(asked.values()) {
        sheet.fact(key, name, Cell::Real(held, shown), "");
    }
    sheet.fact("timer_hz", "timer", asked.rate.hz(), "Hz");
    sheet.columns = vec![
        ("law", "law"),
        ("duration_s", "time, s"),
        ("peak_speed", "peak, steps/s"),
        ("peak_acceleration", "up, /s²"),
        ("peak_deceleration", "down, /s²"),
        ("peak_jerk", "jerk, /s³"),
        ("largest_error_percent", "error, %"),
        ("largest_error_step", "step"),
        ("rms_error_percent", "RMS, %"),
        ("time_lost_s", "lost, s"),
        ("time_lost_percent", "lost, %"),
    ];
    sheet.rows = courses.iter().map(|course| course.row(constant)).collect();
    sheet.notes = vec![
        "up, down, jerk: the largest between neighbouring delays (Eq 3), in steps.".into(),
        "error, RMS: of the delays, against constant acceleration; lost: against its time.".into(),
    ];
    if courses.iter().any(|course| course.holds) {
        let hold = "Austin's laws leave out their last delay, the hold after the last pulse.";
        sheet.notes.push(hold.into());
    }
    sheet
}

fn draw(asked: &Asked, courses: &[Course], shown: Option<MachineUnit>) -> Figure {
    let longest = courses.iter().map(|course| course.duration).fold(0.0, f64::max);
    let (unit, per_second) = time_unit(longest);
    let (length, steps) = shown.map_or(("steps", 1.0), |shown| (shown.name, shown.steps));
    let panel = |name: &str, per: &str, points: fn(&Course, f64) -> Vec<(f64, f64)>| {
        let curves = courses.iter().zip(PALETTE.iter().cycle()).map(|(course, colour)| Curve {
            name: course.name.into(),
            colour: *colour,
            points: points(course, per_second).iter().map(|(t, v)| (*t, v / steps)).collect(),
            dashed: course.name == "trapezoid",
            ..Curve::default()
        });
        Panel {
            y: (name.into(), format!("{length}{per}")),
            x: ("time".into(), unit.into()),
            curves: curves.collect(),
            view: View { x: Some((0.0, (longest * per_second).max(f64::MIN_POSITIVE))), y: None },
            ..Panel::default()
        }
    };
    let values: Vec<_> =
        asked.values().iter().map(|value| format!("{} {}", value.name, value.shown)).collect();
    Figure {
        title: format!("{} steps by {} laws", number(asked.steps.into(), 0), courses.len()),
        notes: [values.join(GAP)].into_iter().chain(shown.map(MachineUnit::note)).collect(),
        rows: vec![
            (430.0, vec![panel("Speed", "/s", Course::speeds)]),
            (330.0, vec![panel("Acceleration", "/s²", Course::slopes)]),
        ],
    }
}
