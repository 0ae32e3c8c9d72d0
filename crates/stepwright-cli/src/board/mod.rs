//! `stepwright board`: a virtual board as a separate program.

pub mod edge_files;
#[cfg(unix)]
mod pty;
pub mod recording;
mod stdio;

use std::path::PathBuf;

use stepwright::Rate;
use stepwright_sim::{AxisDrive, Description};

use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::quantity::whole_in;
use crate::say;
use edge_files::EdgePaths;
use recording::{Heading, Recording};
use stepwright_host::link::bench::{Bench, TimerWidth};
use stepwright_host::link::pace::Paced;
use stepwright_host::link::simulated::Simulated;
use stepwright_plot::PlotFile;
use stepwright_sim::Switch;
use stepwright_units::measure::hertz;

/// The board, whose time passes.
type Board = Paced<Bench<Recording>>;

/// Run a virtual board, on standard input and output or on a pseudo-terminal
#[derive(clap::Args)]
#[command(after_help = "\
The board is an Arduino Uno with three axes: the real engine and the real serial
protocol, with simulated pins and time. Every line ends with CR and is answered.

--stdio   A script on standard input is carried out; at its end the board runs to
          rest, prints `position N ready` on standard error (and `axis 2 position N
          ready` for others that moved), and ends. A motor that would run without
          end is then braked, and the status is 1; also if the last line has no CR.
          A line feed means nothing, but takes its time on the line: 11520 line
          feeds wait a second.
          At a terminal, Enter ends a line and Ctrl-D the conversation.
--pty     The first line on standard output is `pty PATH`; any program that talks
          to a serial port can open that path, again and again. Ctrl-C ends it.
--program stream
          The board plays what a host streams (`stepwright gcode FILE --port`), and of
          the protocol's lines knows only F, V, I, Z, K and ?.
--fast    Time passes as fast as this computer can simulate. With a script, time is
          counted by the script's bytes at 115200 baud, so that the same script always
          has the same result.

Examples:
  printf 'PO\\rS5\\rT100\\rR200\\rG+4000\\rE\\r' | stepwright board --stdio --fast
  stepwright board --stdio
  stepwright board --pty --vcd edges.vcd
  stepwright board --pty --switch 1:-300")]
pub struct Args {
    #[command(flatten)]
    way: Way,
    /// Simulate as fast as this computer can, instead of in real time
    #[arg(long)]
    fast: bool,
    /// Program of the board; slave is the controller
    #[arg(long, value_name = "NAME", default_value = "slave", help_heading = "The board")]
    #[arg(value_parser = ["slave", "stream"])]
    program: String,
    /// Rate of its step timer in ticks/s. A step takes 8.3 µs at any rate, as on an Uno
    #[arg(long, value_name = "HZ", default_value = "16MHz", help_heading = "The board")]
    #[arg(value_parser = hertz)]
    timer_hz: u32,
    /// Width of its step timer
    #[arg(long, value_name = "BITS", default_value = "16", help_heading = "The board")]
    #[arg(value_parser = ["16", "32"])]
    timer_bits: String,
    /// How many axes it has
    #[arg(long, value_name = "N", default_value_t = 3, help_heading = "The board")]
    #[arg(value_parser = whole_in::<u8>(1..=3))]
    axes: u8,
    /// Limit switch that the axis closes at this position and beyond, in steps; the board uses
    /// it if its setting `switches` has the axis
    #[arg(long, value_name = "AXIS:PLACE", help_heading = "The board")]
    switch: Vec<Switch>,
    /// Drive of an axis in place of STEP and DIR: unipolar, bridge, each also with -wave or
    /// -half, shield
    #[arg(long, value_name = "AXIS:DRIVE", help_heading = "The board")]
    drive: Vec<AxisDrive>,
    /// Record every edge of its pins, for GTKWave or PulseView
    #[arg(long, value_name = "FILE", help_heading = "Recordings")]
    vcd: Option<PathBuf>,
    /// Record the edges as MCAP, for Foxglove or PlotJuggler
    #[arg(long, value_name = "FILE", help_heading = "Recordings")]
    mcap: Option<PathBuf>,
    /// Plot the speed of its motors over time: .svg, .png or .html
    #[arg(long, value_name = "FILE", help_heading = "Recordings")]
    plot: Option<PlotFile>,
}

/// Where the board's serial line leads.
#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct Way {
    /// On standard input and output
    #[arg(long)]
    stdio: bool,
    /// On a pseudo-terminal, which any serial program can open
    #[arg(long)]
    pty: bool,
}

impl Args {
    fn width(&self) -> TimerWidth {
        if self.timer_bits == "16" { TimerWidth::Narrow } else { TimerWidth::Wide }
    }

    fn description(&self) -> Result<Description, Failure> {
        let uno = Description::uno();
        let was = u64::from(uno.board.rate.hz());
        let rate = Rate::from_hz(self.timer_hz).map_err(|error| {
            Failure::usage(error.to_string()).hint("give --timer-hz, for example 1000000")
        })?;
        // The default timer: the third axis' timer and the costs of a step are also those of an
        // Uno.
        if (rate, self.width()) == (uno.board.rate, TimerWidth::Narrow) {
            return Ok(Description { axes: self.axes, ..uno });
        }
        // The same time in ticks of this rate, rounded up, so that a step never costs less.
        let cost = |ticks: u32| (u64::from(ticks) * u64::from(rate.hz())).div_ceil(was) as u32;
        let description = Description::at(rate, uno.board.cost.map(cost));
        Ok(Description { axes: self.axes, ..description })
    }
}

/// Runs the virtual board until its input ends or Ctrl-C is pressed.
pub fn run(args: Args) -> Result<(), Failure> {
    if args.way.pty && !cfg!(unix) {
        return Err(Failure::usage("this system has no pseudo-terminals")
            .hint("--stdio, or `stepwright serve`: a virtual board for a browser and over HTTP"));
    }
    let description = args.description()?.with_drives(&args.drive);
    let width = args.width();
    let heading = Heading { title: "The virtual board".to_owned(), ..Heading::default() };
    let plot = args.plot.as_ref().map(|file| (file, heading));
    let streams = args.program == "stream";
    let (vcd, mcap) = (args.vcd.as_deref(), args.mcap.as_deref());
    let recording = Recording::begin(&description, EdgePaths { vcd, mcap, laser: streams }, plot)?;
    interrupt::listen(While::Waiting)?;
    let bench = match streams {
        true => Bench::stream(description, recording),
        false => Bench::new(description, width, recording),
    };
    let bench = bench.with_switches(&args.switch);
    let mut board = Paced::new(bench, args.fast);
    let served = if args.way.stdio { stdio::serve(&mut board) } else { serve_pty(&mut board) };
    board.board.report().iter().for_each(say::note);
    let cut = interrupt::asked() && board.board.is_busy();
    served.and(board.board.finish().map_err(Failure::recording))?;
    if cut {
        return Err(Failure::interrupted("the board was ended while a motor moved")
            .hint("`stepwright stop --port PATH` brakes it before"));
    }
    Ok(())
}

#[cfg(unix)]
fn serve_pty(board: &mut Board) -> Result<(), Failure> {
    pty::serve(board)
}

#[cfg(not(unix))]
fn serve_pty(_: &mut Board) -> Result<(), Failure> {
    // Refused before.
    Ok(())
}
