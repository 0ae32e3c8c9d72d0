//! `stepwright gcode`: plans a G-code job, or runs it on a board or a virtual board.
//!
//! | module | what |
//! | --- | --- |
//! | `axes` | the limits of the axes |
//! | `play` | runs a job on the virtual board |
//! | `port` | streams a job to a board |
//! | `terminal` | follows either run: its progress, and Ctrl-C |
//!
//! The job itself, its plan and its steps are `stepwright_plan::gcode`.

pub mod axes;
mod play;
pub mod port;
mod terminal;

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use stepwright_gcode::Length;
use stepwright_path::{AxisPace, length};
use stepwright_plan::gcode::{JobError, JobPlan, JobTerms};
use stepwright_plan::sheet::SheetFormat;
use stepwright_play::PlayError;
use stepwright_play::gcode::{BOARD, NAMES};
use stepwright_play::stream::{Streamed, spelt};
use stepwright_plot::PlotFile;
use stepwright_sim::Description;

use crate::board::edge_files::EdgePaths;
use crate::failure::{Failure, unless_closed};
use crate::interrupt::{self, While};
use crate::machine::MachineArgs;
use crate::order::motion::seconds;
use crate::order::progress::Line;
use crate::order::target::PortArgs;
use crate::{plot, say};
use axes::AxesArgs;
use play::Wanted;

/// Run a G-code job on a board or a virtual one, or plan it and print its exact duration
///
/// Lines and arcs follow one another without stops, each axis within its limits. The dialect is
/// that of grbl 1.1, with G64 P: with --tolerance 0.01, or "G64 P0.01" as the first line of a job, the path
/// may deviate by 0.01 mm from its lines, and short lines whose coordinates have few digits are passed faster.
/// A job that a controller would refuse is refused before anything moves, with grbl's error number, the line
/// and the column.
#[derive(clap::Args)]
#[command(after_help = "\
Printed positions are the machine's, from its zero and without offsets. Each option of the axes
takes one value for all axes, or three: X,Y,Z. An option that is not given has the value of the
machine file; without a file, that of a belt of 40 mm a turn with 16 microsteps. The spindle (but
for --laser) and the coolant change at rest; the job does not wait at M0 or for a probe. Details:
docs/gcode.md.

--port streams the job to an Uno, a Nano, a Mega, a Pico or a micro:bit with the program `stream`
(`stepwright flash uno --program stream`), or to `stepwright board --pty --program stream`. When
the line falls silent every axis brakes by its own deceleration; the positions stay known.

Ctrl-C brakes along the path; a second one stops dead.

Exit status: 0 all of it was done; 1 the job is refused; 2 the command line is invalid; 130
ended by Ctrl-C.

Examples:
  stepwright gcode examples/gcode/badge.nc --plan
  stepwright gcode - --plan --format json < job.nc
  stepwright gcode examples/gcode/badge.nc --fast --xy badge.svg
  stepwright gcode job.nc --plan --accel 800mm/s2,800mm/s2,200mm/s2
  stepwright gcode job.nc --fast --format csv --vcd edges.vcd
  stepwright gcode job.nc --plan --tolerance 0.01
  stepwright gcode examples/gcode/engrave.nc --laser --fast --xy engrave.svg
  stepwright gcode job.nc --port /dev/ttyACM0
  stepwright gcode job.nc --laser --port /dev/ttyACM0")]
pub struct Args {
    /// The job; - is standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Plan it; nothing moves
    #[arg(long, conflicts_with_all = ["fast", "vcd", "mcap", "xy", "port"])]
    plan: bool,
    /// Simulate as fast as this computer can, instead of in real time
    #[arg(long, conflicts_with = "port")]
    fast: bool,
    /// How far the path may deviate from the job's lines, until the job orders G61 or G64; short lines are
    /// passed faster. 0: exactly the lines
    #[arg(long, value_name = "MM", default_value = "0", value_parser = tolerance, allow_hyphen_values = true)]
    tolerance: Length,
    #[command(flatten)]
    laser: LaserArgs,
    #[command(flatten)]
    axes: AxesArgs,
    #[command(flatten)]
    port: PortArgs,
    /// How to print it; csv is the extents of a plan, and every edge of a run
    #[arg(long, value_enum, default_value_t = SheetFormat::Table, help_heading = "Output")]
    format: SheetFormat,
    /// Draw the path of X and Y, coloured by the speed or the laser's power (.svg, .png or .html)
    #[arg(long, value_name = "FILE", help_heading = "Output", conflicts_with = "port")]
    xy: Option<PlotFile>,
    /// Record every edge of the pins, for GTKWave or PulseView
    #[arg(long, value_name = "FILE", help_heading = "Output", conflicts_with = "port")]
    vcd: Option<PathBuf>,
    /// Record the edges as MCAP, for Foxglove or PlotJuggler
    #[arg(long, value_name = "FILE", help_heading = "Output", conflicts_with = "port")]
    mcap: Option<PathBuf>,
}

/// A laser instead of a spindle.
#[derive(clap::Args)]
#[command(next_help_heading = "Laser")]
struct LaserArgs {
    /// M3, M4, M5 and S are a laser's power along the path, which goes on at speed: M3 constant, M4 in
    /// proportion to the speed, off at rest and in G0. With --port: a Mega has an output, D46
    #[arg(long)]
    laser: bool,
    /// S of its full power, as grbl's $30
    #[arg(long, value_name = "S", default_value = "1000", value_parser = most, requires = "laser", allow_hyphen_values = true)]
    laser_max: f64,
}

fn most(text: &str) -> Result<f64, String> {
    let wrong = || format!("{text:?} is no S of full power: 0.001 to 1000000");
    let most: f64 = text.parse().map_err(|_| wrong())?;
    if (0.001..=1e6).contains(&most) { Ok(most) } else { Err(wrong()) }
}

fn tolerance(text: &str) -> Result<Length, String> {
    let wrong = || format!("{text:?} is no tolerance: 0 to 1000 mm");
    let number = text.strip_suffix("mm").unwrap_or(text).trim_end();
    let mm: f64 = number.parse().map_err(|_| wrong())?;
    length(mm).filter(|_| (0.0..=1e3).contains(&mm)).ok_or_else(wrong)
}

/// Plans the job. Runs it unless only the plan was requested.
pub fn run(args: Args, machine: &MachineArgs) -> Result<(), Failure> {
    let name = args.file.display().to_string();
    if let Some(file) = &args.xy {
        file.check()?;
    }
    let laser = args.laser.laser.then_some(args.laser.laser_max);
    let axes = args.axes.paces(machine)?;
    let terms = JobTerms { laser, tolerance: args.tolerance };
    if args.plan {
        let plan = read(&args.file, |bytes| plan(bytes, axes, &terms, &name))?;
        let mut out = io::stdout().lock();
        let sheet = plan.sheet(format!("G-code job {name}"), BOARD);
        return unless_closed(sheet.write(&mut out, args.format).and_then(|()| out.flush()));
    }
    // The job is planned while it is read; an error ends the reading.
    let mut job = Vec::new();
    let plan = read(&args.file, |bytes| {
        plan(&mut bytes.inspect(|byte| job.push(*byte)), axes, &terms, &name)
    })?;
    // A board at a port refuses it by its own costs.
    if let Some(refused) = plan.refused.filter(|_| args.port.port.is_none()) {
        return Err(PlayError::refused_job(&name, &refused)
            .hint("a lower --top-speed of this axis, or fewer steps a turn")
            .into());
    }
    if args.format == SheetFormat::Table {
        let on = args.port.port.as_ref().map_or("the virtual board".into(), |port| {
            format!("the board on {}, streamed", port.display())
        });
        say::result(format_args!("G-code job {name} on {on}"));
        say::result(format_args!("  {:<12}{:.6} s", "time", plan.time));
        say::result(format_args!("  {:<12}{}", "lines", plan.survey.lines));
    }
    interrupt::listen(While::Holding)?;
    if args.port.port.is_some() {
        if args.format == SheetFormat::Csv {
            return Err(Failure::usage(
                "a board tells no edges: --format csv is for the virtual one",
            ));
        }
        let streamed = port::stream(&args.port, job, axes, &plan)?;
        let own = json!({ "sent_again": streamed.again });
        return report(&args, &plan, &axes, &streamed, own);
    }
    let wanted = Wanted {
        csv: args.format == SheetFormat::Csv,
        fast: args.fast,
        edges: EdgePaths {
            vcd: args.vcd.as_deref(),
            mcap: args.mcap.as_deref(),
            laser: laser.is_some(),
        },
        way: args.xy.is_some(),
    };
    let played = play::play(job, axes, &plan, &wanted)?;
    if let (Some(file), Some(way)) = (&args.xy, &played.way) {
        let what = if laser.is_some() { "the laser's power on the way" } else { "the way" };
        let title = format!("{name}: {what} of X and Y");
        plot::save_picture(file, &title, &way.picture(&title))?;
    }
    let own = json!({
        "lead_ticks": played.lead,
        "ticks": played.ticks,
        "ticks_per_second": played.rate.hz(),
    });
    report(&args, &plan, &axes, &played.ran, own)
}

/// Reads the file. A read error ends the reading, and takes precedence over other errors.
fn read<T>(
    path: &Path,
    with: impl FnOnce(&mut dyn Iterator<Item = u8>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let bytes: Box<dyn Read> = if path == Path::new("-") {
        Box::new(io::stdin().lock())
    } else {
        Box::new(File::open(path).map_err(|error| Failure::file("read", path, &error))?)
    };
    let mut unread = None;
    let result = with(
        &mut BufReader::with_capacity(1 << 16, bytes)
            .bytes()
            .map_while(|byte| byte.map_err(|e| unread = Some(e)).ok()),
    );
    match unread {
        Some(error) => Err(Failure::file("read", path, &error)),
        None => result,
    }
}

/// Plans the job. Shows the progress of a long one.
fn plan(
    bytes: &mut dyn Iterator<Item = u8>,
    axes: [AxisPace; 3],
    terms: &JobTerms,
    name: &str,
) -> Result<JobPlan, Failure> {
    let begun = Instant::now();
    let mut line = Line::new();
    let board = Description::uno().board;
    let planned = JobPlan::on(bytes, axes, terms, &board, |lines, time| {
        if begun.elapsed() > Duration::from_secs(1) {
            let said = format!("planned {lines} lines, {} of the job", seconds(time));
            line.show(&[&said], &said, false);
        }
    });
    line.end();
    planned.map_err(|error| failure(name, &error))
}

/// The failure of a job. Axes that can't be planned are invalid options.
fn failure(name: &str, error: &JobError) -> Failure {
    let failure = PlayError::job(name, error);
    if matches!(error, JobError::Move(0, _)) {
        return Failure::usage(failure.message);
    }
    failure.into()
}

/// Prints the result of a run, with the JSON that only this kind of board has.
fn report(
    args: &Args,
    plan: &JobPlan,
    axes: &[AxisPace; 3],
    ran: &Streamed,
    own: Value,
) -> Result<(), Failure> {
    let state = if ran.braked { "stopped" } else { "ready" };
    match args.format {
        SheetFormat::Table => {
            say::result(format_args!("  {:<12}{:.6} s", "took", ran.seconds));
            if args.port.port.is_some() {
                say::result(format_args!("  {:<12}{}", "late steps", ran.late));
            }
            say::result(format_args!("position {} {state}", spelt(ran.position)));
        }
        SheetFormat::Json => {
            let millimetres = [0, 1, 2].map(|n| ran.position[n].map(|at| at as f64 * axes[n].step));
            let mut told = json!({
                "file": args.file.display().to_string(),
                "lines": plan.survey.lines,
                "planned_seconds": plan.time,
                "seconds": ran.seconds,
                "axes": NAMES,
                "position": ran.position,
                "position_mm": millimetres,
                "late": ran.late,
                "state": state,
            });
            if let (Value::Object(told), Value::Object(own)) = (&mut told, own) {
                told.extend(own);
            }
            say::json(told);
        }
        SheetFormat::Csv => {}
    }
    if ran.braked {
        return Err(Failure::interrupted("braked before the end of the job")
            .hint("the positions are known"));
    }
    Ok(())
}
