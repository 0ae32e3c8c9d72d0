//! `stepwright plan`: computes a travel before anything moves.
//!
//! | module | what |
//! | --- | --- |
//! | `trapezoid`, `ramp`, `austin` … | the options of one law each |
//! | [`limits`] | the options that most of them share |
//! | [`change`] | the option for a change of the acceleration during a ramp |
//! | [`compare`] | compares several laws |
//! | [`work`] | the progress of a long calculation |
//!
//! The laws, their results and the output formats are in `stepwright-plan`. To add a law, add a
//! file beside `trapezoid` and a line in [`Law`].

mod austin;
mod austin_fixed;
pub mod change;
mod compare;
pub mod limits;
pub mod linear_factor;
mod piecewise;
mod power;
mod ramp;
mod s_curve;
mod trapezoid;
mod work;

use std::io::{self, BufWriter, Write};

use clap::{Subcommand, ValueEnum};
use stepwright::{Geometry, Rate};
use stepwright_plan::{Closeness, Plan, PlanValue, Survey, Watch, csv, figure, json, text};
use stepwright_plot::PlotFile;

use crate::failure::{Failure, unless_closed};
use crate::plot;
use crate::quantity::{DistanceArg, GeometryArgs, whole_in};
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
    Trapezoid(trapezoid::Args),
    Ramp(ramp::Args),
    SCurve(s_curve::Args),
    Austin(austin::Args),
    AustinFixed(austin_fixed::Args),
    LinearFactor(linear_factor::Args),
    Power(power::Args),
    Piecewise(piecewise::Args),
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
