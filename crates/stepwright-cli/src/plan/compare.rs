//! `plan compare`: compares laws for the same travel.

use std::io::{self, BufWriter, Write};

use clap::builder::PossibleValuesParser;
use stepwright::{Geometry, Speed};
use stepwright_plan::sheet::SheetFormat;
use stepwright_plan::{Comparison, Divide, LawChoice, Watch};
use stepwright_plot::PlotFile;
use stepwright_units::Rounded;

use super::Machine;
use super::laws::{Begin, Breaks, Knee, Power};
use super::limits::Limits;
use super::work::Work;
use crate::failure::{Failure, unless_closed};
use crate::plot;
use crate::quantity::JerkArg;

/// Compare laws: duration, peak speed, smoothness
///
/// Plans the same travel with each law, and prints its duration, its peak speed, the highest
/// acceleration, deceleration (Austin, Eq 3) and jerk between neighbouring delays, the
/// deviation of its delays from those of constant acceleration, largest and root mean square,
/// and the time lost against that time-optimal travel.
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
    /// The laws
    #[arg(required = true, value_name = "LAW")]
    #[arg(value_parser = PossibleValuesParser::new(LawChoice::NAMES))]
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
    /// Jerk limit of s-curve: 80000, 200rad/s3 … (a bare number is steps/s³)
    #[arg(long, value_name = "JERK", allow_hyphen_values = true)]
    jerk: Option<JerkArg>,
    /// How to print it
    #[arg(long, value_enum, default_value_t = SheetFormat::Table, help_heading = "Output")]
    format: SheetFormat,
    /// Draw it: speed and acceleration over time (.svg, .png or .html)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Vec<PlotFile>,
    #[command(flatten)]
    machine: Machine,
}

impl Args {
    /// The law of this name, with its options.
    fn law(&self, name: &str, geometry: &Geometry) -> Result<LawChoice, Failure> {
        let (c0, start) = (self.begin.c0, Rounded::of(Speed::ZERO, "/s"));
        Ok(match name {
            "trapezoid" => LawChoice::Trapezoid { start },
            "s-curve" => {
                let Some(jerk) = &self.jerk else {
                    return Err(Failure::usage("s-curve needs a jerk").hint(
                        "give --jerk, for example twenty times the acceleration: it is there in \
                         50 ms",
                    ));
                };
                LawChoice::SCurve { start, jerk: jerk.resolve(geometry, "--jerk")? }
            }
            "linear-factor" => LawChoice::LinearFactor { c0, knee: self.knee.knee },
            "power" => LawChoice::Power { c0, power: self.power.power },
            "piecewise" => LawChoice::Piecewise { c0, breaks: self.breaks.breaks },
            _ => LawChoice::Austin { c0, divisor: Divide::FourN, changes: Vec::new() },
        })
    }
}

/// Compares the laws and prints the result. Draws it if requested.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (rate, geometry) = (args.machine.timer_hz, args.machine.geometry.geometry()?);
    let limits = args.limits.held(rate, &geometry)?;
    if args.jerk.is_some() && !args.laws.iter().any(|law| law == "s-curve") {
        return Err(Failure::usage("--jerk is for s-curve, which is not compared")
            .hint("leave --jerk out, or name s-curve among the laws"));
    }
    let laws = args.laws.iter().map(|name| args.law(name, &geometry));
    let laws = laws.collect::<Result<Vec<_>, _>>()?;
    let work = Work::default();
    let watch: Watch<'_> = &|what, n, of| work.tell(what, n, of);
    let comparison = Comparison::new(&limits, &laws, watch)?;
    for file in &args.plot {
        plot::save(file, &comparison.figure(args.machine.geometry.unit()))?;
    }
    let mut out = BufWriter::new(io::stdout().lock());
    let written = comparison.sheet().write(&mut out, args.format);
    unless_closed(written.and_then(|()| out.flush()))
}
