//! `stepwright timed`: the Arduino driver's set-speed order, on the virtual board or a real one.
//!
//! | module | what |
//! | --- | --- |
//! | [`order`] | the options as an order |
//! | [`wiring`] | `--drive`: the pins and their signals |
//! | [`port`] | the same on a real board |
//!
//! The result, its formats and its plot are `stepwright_play::timed`.

mod order;
mod port;
#[cfg(test)]
mod tests;
mod wiring;

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use stepwright_timed::SetSpeed;

use crate::calc::ClockArgs;
use crate::failure::{Failure, unless_closed};
use crate::interrupt::{self, While};
use crate::order::target;
use crate::plot;
use crate::quantity::whole_in;
use crate::say;
use order::OrderArgs;
use port::Board;
use stepwright_host::link::serial::Share;
use stepwright_machine::BAUD;
use stepwright_play::timed::figure::{self, PlotWindow};
use stepwright_play::timed::{Moments, TimedCourse, TimedPlay, output};
use stepwright_plot::PlotFile;
use wiring::WiringArgs;

/// Change a motor's speed at fixed intervals, as the Arduino driver does
///
/// Steps come at a virtual top (clocks between two steps), which grows or shrinks at a fixed
/// interval, until a number of steps or milliseconds have passed: on the virtual board, or with
/// --port on a board that runs the program `timed`, whose motor rests when the command ends.
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
  Stop, as the driver does at speed 0:
    stepwright timed --speed 0 --port /dev/ttyACM0
  On a board, after `stepwright flash uno --program timed --port /dev/ttyACM0`:
    stepwright timed --case 1 --latched --log 166.9+1001 --port /dev/ttyACM0

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
    #[arg(value_parser = whole_in::<u32>(1..=100_000_000))]
    for_ms: Option<u32>,
    /// Print the Arduino driver's debug dump at these ms after the call: 100,250.5,900 or
    /// FIRST+EVERY, like 166.9+1001
    #[arg(long, value_name = "WHEN", help_heading = "Output")]
    log: Option<Moments>,
    /// Serial port of a board that runs the program `timed`
    #[arg(long, value_name = "PATH", help_heading = "Board")]
    port: Option<PathBuf>,
    /// Speed of the serial port in bits/s
    #[arg(long, value_name = "N", default_value_t = target::RATE, requires = "port")]
    #[arg(value_parser = whole_in::<u32>(BAUD), help_heading = "Board")]
    baud: u32,
    /// The timer of the board's motor: 1, on a Mega also 3, 4 or 5
    #[arg(long, value_name = "N", default_value_t = 1, requires = "port", help_heading = "Board")]
    on_timer: u8,
    /// Record every edge of the pins that --drive names, for GTKWave or PulseView
    #[arg(long, value_name = "FILE", requires = "drive", conflicts_with = "port")]
    #[arg(help_heading = "Output")]
    vcd: Option<PathBuf>,
    /// Record the edges as MCAP, for Foxglove or PlotJuggler
    #[arg(long, value_name = "FILE", requires = "drive", conflicts_with = "port")]
    #[arg(help_heading = "Output")]
    mcap: Option<PathBuf>,
    /// How to print it
    #[arg(long, value_enum, default_value_t = Format::Summary, help_heading = "Output")]
    format: Format,
    /// Draw it: speed, and with --drive the signals of the pins (.svg, .png or .html)
    #[arg(long, value_name = "FILE", conflicts_with = "port", help_heading = "Output")]
    plot: Vec<PlotFile>,
    /// Time span of the plot, in ms from the call: 0..40
    #[arg(long, value_name = "FROM..TO", requires = "plot", help_heading = "Output")]
    window: Option<PlotWindow>,
}

/// How a motion is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// The values as understood, and the results; with --log the dumps
    Summary,
    /// Every step in columns; with --log the dumps
    Table,
    /// Every step as step,time,delay,speed,phase and, with --drive, the levels of its pins; with
    /// --log a dump a line
    Csv,
    /// The summary, updates, dumps and every step
    Json,
}

impl Args {
    /// Connects to the board on a port.
    fn meet(&self, path: &Path) -> Result<Board, Failure> {
        if matches!(self.format, Format::Table | Format::Csv) && self.log.is_none() {
            return Err(Failure::usage("a board does not tell when each of its steps came")
                .hint("add --log 0+100 for its debug dumps, or leave --format out"));
        }
        Board::meet(Box::new(target::serial(path, self.baud, Share::Alone)?))
    }
}

/// Carries out the order and prints the result. Draws it if requested.
pub fn run(args: Args) -> Result<(), Failure> {
    let hardware = args.clock.hardware()?;
    let order = args.order.order(&hardware)?;
    let mut board = args.port.as_ref().map(|path| args.meet(path)).transpose()?;
    if order.set_speed == SetSpeed::STOP {
        match &mut board {
            Some(board) => board.stop(args.on_timer)?,
            None => say::note("a virtual board begins at rest: there is nothing to stop"),
        }
        say::result("the motor stands, its driver is off");
        return Ok(());
    }
    let wiring = args.wiring.wiring(board.as_ref().and_then(Board::arduino))?;
    let play = TimedPlay {
        hardware,
        latched: args.latched,
        order: &order,
        wiring: &wiring,
        for_ms: args.for_ms,
        log: args.log.as_ref(),
    };
    let course = match (&mut board, wiring.wire) {
        (None, _) => TimedCourse::play(&play)?,
        (Some(board), Some(wire)) => {
            interrupt::listen(While::Holding)?;
            board.play(&play, args.on_timer, wire)?
        }
        (Some(_), None) => {
            return Err(Failure::usage("which pins? a board has to know").hint(
                "name them: bridge:D8,D9,D10,D11, l6219:D8,D9,D10,D11,D12,D13, or \
                 pattern:ROWS/OUTPUTS@B for those of port B",
            ));
        }
    };
    if let Some(path) = &args.vcd {
        let file = File::create(path).map_err(|error| Failure::file("write", path, &error))?;
        let mut out = BufWriter::new(file);
        let written = output::vcd(&mut out, &course, &wiring).and_then(|()| out.flush());
        written.map_err(|error| Failure::file("write", path, &error))?;
    }
    if let Some(path) = &args.mcap {
        let file = File::create(path).map_err(|error| Failure::file("write", path, &error))?;
        let written = output::mcap(BufWriter::new(file), &course, &wiring);
        written.map_err(|error| Failure::file("write", path, &error))?;
    }
    for file in &args.plot {
        plot::save(file, &figure::draw(&course, &wiring, args.window))?;
    }
    let mut out = BufWriter::with_capacity(1 << 16, io::stdout().lock());
    let written = match (args.format, args.log.is_some()) {
        (Format::Summary, false) => output::summary(&mut out, &course),
        (Format::Table, false) => output::table(&mut out, &course),
        (Format::Summary | Format::Table, true) => output::dumps(&mut out, &course),
        (Format::Csv, false) => output::csv(&mut out, &course, &wiring),
        (Format::Csv, true) => output::dumps_csv(&mut out, &course),
        (Format::Json, _) => output::json(&mut out, &course),
    };
    unless_closed(written.and_then(|()| out.flush()))
}
