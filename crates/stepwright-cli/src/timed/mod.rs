//! `stepwright timed`: the Arduino driver's set-speed order on the virtual board.
//!
//! | module | what |
//! | --- | --- |
//! | [`order`] | the options as an order |
//! | [`wiring`] | `--drive`: which pins, and what they get |
//! | [`course`] | what happens: steps, updates, dumps, calls |
//! | `output` | the formats |
//! | [`figure`] | the plot |

mod course;
mod figure;
mod order;
mod output;
mod wiring;

use std::io::{self, BufWriter, Write};

use clap::ValueEnum;

use crate::calc::ClockArgs;
use crate::failure::{Failure, unless_closed};
use crate::plot::PlotFile;
use course::{Course, Moments};
use order::OrderArgs;
use wiring::WiringArgs;

/// Change a motor's speed on a clock, as the Arduino driver does
///
/// The order is carried out on the virtual board: steps at a virtual top (clocks between two
/// steps), which grows or shrinks at a fixed interval, until a number of steps or
/// milliseconds have passed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  A fixed 250 steps/s for 100 turns:
    stepwright timed --speed 250 --steps 20000
  From 1.8 rpm up, four times a second, 29 updates (the manual's example):
    stepwright timed --top 2666666 --faster 91264 --every-ms 250 --updates 29
  The article's first validation case, its debug dump at the log's times:
    stepwright timed --case 1 --latched --log 166.9+1001
  The pins of a unipolar motor in half steps:
    stepwright timed --speed 100 --steps 16 --drive unipolar-half:D4,D39,D40,D41 \\
      --board mega --plot pins.svg

Result codes: 0 fine; 1 the speed stays as it is, for want of updates; 2 the updates lead
out of the valid range, where the driver faults and keeps its speed; below 0 refused.")]
pub struct Args {
    #[command(flatten)]
    order: OrderArgs,
    #[command(flatten)]
    wiring: WiringArgs,
    /// A new top waits in the compare register, as in fast PWM: the step after an update
    /// lasts the old top at the new prescaler
    #[arg(long, help_heading = "Timer")]
    latched: bool,
    #[command(flatten)]
    clock: ClockArgs,
    /// How long to watch, in ms from the call [default: until the end, or 2 s beyond the
    /// last update]
    #[arg(long, value_name = "MS", help_heading = "Output")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    for_ms: Option<u32>,
    /// Print the Arduino driver's debug dump at these ms after the call: 100,250.5,900 or
    /// FIRST+EVERY, like 166.9+1001
    #[arg(long, value_name = "WHEN", help_heading = "Output")]
    log: Option<Moments>,
    /// How to print it
    #[arg(long, value_enum, default_value_t = Format::Summary, help_heading = "Output")]
    format: Format,
    /// Draw it: speed, and with --drive the signals of the pins (.svg, .png or .html)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Vec<PlotFile>,
    /// What stretch of time the plot shows, in ms from the call: 0..40
    #[arg(long, value_name = "FROM..TO", requires = "plot", help_heading = "Output")]
    window: Option<figure::Window>,
}

/// How a motion is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// What was understood, and what comes of it; with --log the dumps
    Summary,
    /// Every step in columns; with --log the dumps
    Table,
    /// Every step as step,time,delay,speed,phase; with --log a dump a line
    Csv,
    /// The summary, updates, dumps and every step
    Json,
}

/// Carries it out, prints, and draws if asked to.
pub fn run(args: Args) -> Result<(), Failure> {
    let hardware = args.clock.hardware()?;
    let order = args.order.order(&hardware)?;
    let wiring = args.wiring.wiring()?;
    let course = Course::play(&course::Play {
        hardware,
        latched: args.latched,
        order: &order,
        wiring: &wiring,
        for_ms: args.for_ms,
        log: args.log.as_ref(),
    })?;
    for file in &args.plot {
        file.save(&figure::draw(&course, &wiring, args.window))?;
    }
    let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
    let written = match (args.format, args.log.is_some()) {
        (Format::Summary, false) => output::summary(&mut out, &course),
        (Format::Table, false) => output::table(&mut out, &course),
        (Format::Summary | Format::Table, true) => output::dumps(&mut out, &course),
        (Format::Csv, false) => output::csv(&mut out, &course),
        (Format::Csv, true) => output::dumps_csv(&mut out, &course),
        (Format::Json, _) => output::json(&mut out, &course),
    };
    unless_closed(written.and_then(|()| out.flush()))
}
