//! `stepwright plan`: computes a travel before anything moves.
//!
//! | module | what |
//! | --- | --- |
//! | [`laws`] | the own options of each law with an acceleration |
//! | [`limits`] | the options that they share |
//! | `ramp`, `austin_fixed` | the laws that have none |
//! | [`change`] | the option for a change of the acceleration during a ramp |
//! | [`compare`] | compares several laws |
//! | [`work`] | the progress of a long calculation |
//!
//! The laws, their results and the output formats are in `stepwright-plan`. To add a law, add its
//! options to [`laws`] and its help to [`Law`].

mod austin_fixed;
pub mod change;
mod compare;
pub mod laws;
pub mod limits;
mod ramp;
mod work;

use std::io::{self, BufWriter, Write};

use clap::{Subcommand, ValueEnum};
use stepwright::{Geometry, Rate};
use stepwright_plan::{
    Closeness, LawChoice, Plan, PlanValue, Survey, Watch, csv, figure, json, text,
};
use stepwright_plot::PlotFile;

use crate::failure::{Failure, unless_closed};
use crate::plot;
use crate::quantity::{DistanceArg, GeometryArgs, whole_in};
use limits::Limits;
use stepwright_units::measure::hertz;
use work::Work;

/// Plan a travel: print its duration or every delay, plot it
///
/// Nothing moves. A travel of M steps is M pulses, the first at time 0; times
/// are counted in ticks of the step timer.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    law: Law,
}

/// The laws to choose from.
#[derive(Subcommand)]
enum Law {
    /// Constant acceleration to a top speed, and constant deceleration
    ///
    /// The motor starts and ends at the start speed. When the travel is too short
    /// for the top speed, the two ramps meet below it.
    #[command(after_help = "\
Examples:
  Five turns of a 1.8° motor, from rest to 120 rpm and back:
    stepwright plan trapezoid --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm
  The same as a picture:
    stepwright plan trapezoid --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm \\
      --plot ramp.png
  The first delays on a 16 MHz timer:
    stepwright plan trapezoid --steps 4000 --accel 2000 --top-speed 1000 \\
      --timer-hz 16000000 --format csv | head
  A belt of 40 mm a turn, quick to start and gentle to stop:
    stepwright plan trapezoid --steps 3200 --steps-per-rev 3200 --mm-per-rev 40 \\
      --accel 500mm/s2 --decel 250mm/s2 --top-speed 50mm/s")]
    Trapezoid(Of<laws::Trapezoid>),
    Ramp(ramp::Args),
    /// Acceleration and deceleration with limited jerk
    ///
    /// Phases: jerk-up (the acceleration grows), up, jerk-down (it goes back),
    /// cruise, and the same for braking: jerk-up, down, jerk-down. A short travel or a small
    /// jerk leaves some phases out. The travel is the fastest within the limits.
    #[command(after_help = "\
Examples:
  From rest to 1000 steps/s and back, with 4000 steps/s² after 50 ms:
    stepwright plan s-curve --steps 2000 --accel 4000 --top-speed 1000 --jerk 80000
  The same as a picture:
    stepwright plan s-curve --steps 2000 --accel 4000 --top-speed 1000 --jerk 80000 \\
      --plot s-curve.png
  Five turns of a 1.8° motor, quick to start and gentle to stop:
    stepwright plan s-curve --steps 1000 --accel 20rad/s2 --decel 10rad/s2 \\
      --jerk 200rad/s3 --top-speed 120rpm
  What a board would get for it:
    stepwright plan s-curve --steps 4000 --accel 20000 --top-speed 5000 --jerk 400000 \\
      --timer-hz 16000000 --runs")]
    SCurve(Of<laws::SCurve>),
    /// Austin's ramp: each delay from the one before (Eq 12 to 19)
    ///
    /// The motor starts and ends at rest. Steps that the rounding of the ramp down leaves over
    /// are made at the speed reached. The acceleration may change during the ramp up.
    #[command(after_help = "\
Examples:
  Figures 2 to 4 of the article, 0 to 120 rpm in a second:
    stepwright plan austin --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm
  The same with an exact first step, as a table:
    stepwright plan austin --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm \\
      --c0 c1 --format table
  Quick to start and gentle to stop, as a picture:
    stepwright plan austin --steps 1000 --accel 2000 --decel 500 --top-speed 1000 \\
      --plot ramp.png
  A ramp that changes its acceleration twice on its way (Eq 18):
    stepwright plan austin --steps 2000 --accel 1000 --top-speed 1500 \\
      --change 100:3000 --change 300:500 --plot changes.png")]
    Austin(Of<laws::Austin>),
    AustinFixed(austin_fixed::Args),
    /// Acceleration that falls linearly to 0 at the top speed (Eq 22 to 25)
    ///
    /// The ramp down mirrors this: a travel too short for the top speed goes from acceleration to
    /// deceleration without a jump. The speed reached is the article's estimate, some tenths of a
    /// per cent below the top speed.
    #[command(after_help = "\
Examples:
  Figure 8 of the article:
    stepwright plan linear-factor --steps 700 --accel 10rad/s2 --decel 20rad/s2 \\
      --top-speed 10rad/s --plot figure-8.png
  The factor beginning at half of the top speed:
    stepwright plan linear-factor --steps 1000 --accel 2000 --top-speed 1000 --knee 0.5")]
    LinearFactor(Of<laws::LinearFactor>),
    /// Acceleration that a power of the step number ends (Eq 20, 21)
    ///
    /// The speed approaches the top speed asymptotically: the first half of a travel accelerates,
    /// the second decelerates, and with the power 2 a travel of usual length stays far below the
    /// top speed.
    #[command(after_help = "\
Examples:
  A sharper and a softer knee:
    stepwright plan power --steps 2000 --accel 2000 --top-speed 1000 --power 5
    stepwright plan power --steps 2000 --accel 2000 --top-speed 1000 --power 3")]
    Power(Of<laws::PowerTerm>),
    /// Acceleration that is reduced in stages near the top speed (Figure 5)
    ///
    /// Breaks lie at 2, 1.5, 1.25 … times the shortest delay; each divides the
    /// acceleration by 1.375.
    #[command(after_help = "\
Examples:
  Seven breaks, as in the article:
    stepwright plan piecewise --steps 2000 --accel 2000 --top-speed 1000
  Three:
    stepwright plan piecewise --steps 2000 --accel 2000 --top-speed 1000 --breaks 3")]
    Piecewise(Of<laws::Piecewise>),
    Compare(compare::Args),
}

/// The laws to plan.
enum Chosen<'a> {
    One(&'a dyn Planned),
    Several(&'a compare::Args),
}

impl Law {
    /// The law that was chosen, or the comparison of several.
    fn chosen(&self) -> Chosen<'_> {
        Chosen::One(match self {
            Law::Trapezoid(args) => args,
            Law::Ramp(args) => args,
            Law::SCurve(args) => args,
            Law::Austin(args) => args,
            Law::AustinFixed(args) => args,
            Law::LinearFactor(args) => args,
            Law::Power(args) => args,
            Law::Piecewise(args) => args,
            Law::Compare(args) => return Chosen::Several(args),
        })
    }
}

/// A law's options.
trait Planned {
    /// The options that every law has.
    fn common(&self) -> &Common;

    /// The distance, as typed.
    fn distance(&self) -> &DistanceArg;

    /// The plan of the travel, with the values of the options.
    fn plan(&self, rate: Rate, geometry: &Geometry, watch: Watch<'_>) -> Result<Plan, Failure>;
}

/// The own options of a law with an acceleration and a top speed.
trait Choice: clap::Args {
    /// The law that they choose.
    fn choice(&self, geometry: &Geometry) -> Result<LawChoice, Failure>;
}

/// The options of such a law.
#[derive(clap::Args)]
struct Of<L: Choice> {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    own: L,
    #[command(flatten)]
    common: Common,
}

impl<L: Choice> Planned for Of<L> {
    fn common(&self) -> &Common {
        &self.common
    }

    fn distance(&self) -> &DistanceArg {
        self.limits.distance()
    }

    fn plan(&self, rate: Rate, geometry: &Geometry, watch: Watch<'_>) -> Result<Plan, Failure> {
        let limits = self.limits.held(rate, geometry)?;
        Ok(self.own.choice(geometry)?.plan(&limits, geometry, watch)?)
    }
}

/// How far.
#[derive(clap::Args)]
struct Steps {
    /// Steps to travel, 0 to 2147483647, or like 90deg, 10mm
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    steps: DistanceArg,
}

impl Steps {
    fn held(&self, geometry: &Geometry) -> Result<u32, Failure> {
        let held = self.steps.resolve(geometry, "--steps")?;
        let steps = u32::try_from(held.value).ok().filter(|steps| *steps <= i32::MAX as u32);
        steps.ok_or_else(|| {
            Failure::usage(format!("--steps {}: a travel has 0 to 2147483647 steps", held.given))
                .hint(match held.value < 0 {
                    true => "the way back is planned like the way there: leave the minus out",
                    false => "give fewer",
                })
        })
    }
}

/// What every law's plan takes.
#[derive(clap::Args)]
struct Common {
    /// How to print it
    #[arg(long, value_enum, default_value_t = Format::Summary, help_heading = "Output")]
    format: Format,
    /// Draw it: speed and acceleration over time and over steps (.svg, .png or .html)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Vec<PlotFile>,
    /// Show the runs that a board gets instead of single steps
    #[arg(long, help_heading = "Output")]
    runs: bool,
    /// With --runs: how far a step may be off its time, in µs (at least one tick)
    #[arg(long, value_name = "US", default_value_t = 1, requires = "runs")]
    #[arg(value_parser = whole_in::<u32>(1..=10_000), help_heading = "Output")]
    max_error_us: u32,
    #[command(flatten)]
    machine: Machine,
}

/// What carries a plan out.
#[derive(clap::Args)]
struct Machine {
    /// Ticks per second of the step timer, 100000 to 200000000, or like 16MHz
    #[arg(long, value_name = "HZ", default_value = "1000000", value_parser = rate)]
    #[arg(help_heading = "Motor")]
    timer_hz: Rate,
    #[command(flatten)]
    geometry: GeometryArgs,
}

/// How a plan is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// The values as understood, and the results
    Summary,
    /// Every step in columns
    Table,
    /// Every step as step,delay,time,speed,phase
    Csv,
    /// The summary and every step
    Json,
}

fn rate(text: &str) -> Result<Rate, String> {
    let rate = hertz(text).ok().and_then(|hz| Rate::from_hz(hz).ok());
    rate.ok_or_else(|| "a timer has 100000 Hz to 200 MHz: give 16000000 or 16MHz".to_owned())
}

/// Plans and prints the travel. Draws it if requested.
pub fn run(args: Args) -> Result<(), Failure> {
    let chosen = match args.law.chosen() {
        Chosen::One(law) => law,
        Chosen::Several(laws) => return compare::run(laws),
    };
    let common = chosen.common();
    let (rate, geometry) = (common.machine.timer_hz, common.machine.geometry.geometry()?);
    let unit = common.machine.geometry.unit();
    let work = Work::default();
    let watch: Watch<'_> = &|what, n, of| work.tell(what, n, of);
    let mut plan = chosen.plan(rate, &geometry, watch)?;
    let distance = chosen.distance().resolve(&geometry, "--steps")?;
    if distance.converted() {
        plan.values.insert(0, PlanValue::distance(&distance));
    }
    let fit = common.runs.then(|| {
        let ticks = u64::from(rate.hz()) * u64::from(common.max_error_us) / 1_000_000;
        let error = (ticks as u32).max(1);
        Closeness { error, longest: rate.hz() / 125 } // as Fit::board, which has 1 µs
    });
    // Only a plain list of delays needs no survey beforehand.
    let bare = common.format == Format::Csv && common.plot.is_empty();
    let survey = (!bare).then(|| Survey::of(&plan, watch));
    drop(work);
    for (file, survey) in common.plot.iter().zip(survey.iter().cycle()) {
        plot::save(file, &figure::draw(&plan, survey, unit))?;
    }
    let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
    let written = match (common.format, &survey) {
        (Format::Csv, _) | (_, None) => csv::write(&mut out, &plan, fit),
        (Format::Summary, Some(survey)) => text::summary(&mut out, &plan, survey, fit),
        (Format::Table, Some(survey)) => text::table(&mut out, &plan, survey, fit),
        (Format::Json, Some(survey)) => json::write(&mut out, &plan, survey, fit, unit),
    };
    unless_closed(written.and_then(|()| out.flush()))
}
