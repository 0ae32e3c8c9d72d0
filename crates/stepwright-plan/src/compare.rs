//! Compares laws for the same travel.
//!
//! The delays are those of the laws' formulas, not rounded to ticks: whole ticks make noise of an
//! acceleration. They are compared with constant acceleration, which is time-optimal within the limits; for a
//! law that leaves out its last delay, with constant acceleration over one step more.

use stepwright::Speed;
use stepwright_oracle::Number;
use stepwright_plot::{Curve, Figure, GAP, PALETTE, Panel, View, number, time_unit};
use stepwright_units::MachineUnit;

use crate::PlanError;
use crate::asked::PlanLimits;
use crate::equations::Counter;
use crate::law::{PlanValue, PlannedLaw};
use crate::laws::{LawChoice, trapezoid};
use crate::sheet::{Cell, Sheet};
use crate::watch::Watch;

/// The most steps: every delay is computed.
const MOST: u32 = 1_000_000;

/// The same travel by several laws.
pub struct Comparison {
    limits: PlanLimits,
    courses: Vec<Course>,
    /// Constant acceleration over the travel, and over one step more.
    constant: [Course; 2],
}

impl Comparison {
    /// Computes all delays of each law.
    ///
    /// # Errors
    /// [`PlanError::TooMany`]: more than a million steps; those of [`LawChoice::law`].
    pub fn new(
        limits: &PlanLimits,
        laws: &[LawChoice],
        watch: Watch<'_>,
    ) -> Result<Comparison, PlanError> {
        if limits.steps > MOST {
            return Err(PlanError::TooMany { steps: limits.steps, most: MOST });
        }
        let constant = |steps| -> Result<Course, PlanError> {
            let limits = PlanLimits { steps, ..limits.clone() };
            Ok(Course::of("", trapezoid::law(&limits, Speed::ZERO)?.as_ref(), &limits))
        };
        let course =
            |law: &LawChoice| Ok(Course::of(law.name(), law.law(limits, watch)?.as_ref(), limits));
        Ok(Comparison {
            limits: limits.clone(),
            courses: laws.iter().map(course).collect::<Result<_, PlanError>>()?,
            constant: [constant(limits.steps)?, constant(limits.steps + 1)?],
        })
    }

    /// The table.
    pub fn sheet(&self) -> Sheet {
        sheet(&self.limits, &self.courses, &self.constant)
    }

    /// Speed and acceleration over time, in the unit of a machine if one is given.
    pub fn figure(&self, unit: Option<MachineUnit>) -> Figure {
        draw(&self.limits, &self.courses, unit)
    }
}

/// A travel by one law.
struct Course {
    name: &'static str,
    motor: Counter,
    /// Whether the law leaves out the last delay of the formula.
    holds: bool,
    /// The delays of the formula in ticks.
    delays: Vec<f64>,
    /// The duration as the core emits it, in seconds.
    duration: f64,
    peak: f64,
}

impl Course {
    fn of(name: &'static str, law: &dyn PlannedLaw, limits: &PlanLimits) -> Course {
        let motor = limits.motor();
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

    /// The largest change of acceleration per second.
    fn jerk(&self) -> f64 {
        let accels: Vec<_> = self.accels().collect();
        let jerks = accels.windows(2).zip(self.delays.iter().skip(1));
        jerks.map(|(a, c)| ((a[1] - a[0]) * self.motor.hz / c).abs()).fold(0.0, f64::max)
    }

    /// The relative difference of each delay from that of another course.
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

    /// Speed in the middle of each interval, from standstill to standstill.
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
        // Before the first and after the last point the acceleration is taken as constant.
        if let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) {
            let all: f64 = self.delays.iter().sum();
            points.insert(0, (0.0, first.1));
            points.push((all / self.motor.hz * per_second, last.1));
        }
        points
    }
}

fn sheet(limits: &PlanLimits, courses: &[Course], constant: &[Course; 2]) -> Sheet {
    let mut sheet = Sheet::new("Laws for the same travel");
    sheet.fact("steps", "steps", limits.steps, "");
    let keys = ["top_speed", "acceleration", "deceleration"];
    for (key, PlanValue { name, shown, held, .. }) in keys.into_iter().zip(limits.values()) {
        sheet.fact(key, name, Cell::Real(held, shown), "");
    }
    sheet.fact("timer_hz", "timer", limits.rate.hz(), "Hz");
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

fn draw(limits: &PlanLimits, courses: &[Course], shown: Option<MachineUnit>) -> Figure {
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
        limits.values().iter().map(|value| format!("{} {}", value.name, value.shown)).collect();
    Figure {
        title: format!("{} steps by {} laws", number(limits.steps.into(), 0), courses.len()),
        notes: [values.join(GAP)].into_iter().chain(shown.map(MachineUnit::note)).collect(),
        rows: vec![
            (430.0, vec![panel("Speed", "/s", Course::speeds)]),
            (330.0, vec![panel("Acceleration", "/s²", Course::slopes)]),
        ],
    }
}
