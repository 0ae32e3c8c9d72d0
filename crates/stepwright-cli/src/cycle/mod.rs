//! `stepwright cycle`: motor cycles from a file (stepper_h).
//!
//! | module | what |
//! | --- | --- |
//! | `text` | reads the file; `stepwright-cyclefile` parses it |
//! | `voice` | prints messages while `stepwright-play` plays the file |
//! | `taken` | records the motion: csv, vcd, plots |

pub mod taken;
mod text;
pub mod voice;

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use crate::board::edge_files::EdgePaths;
use crate::failure::Failure;
use crate::interrupt::{self, While};
use crate::order::target;
use crate::plot;
use crate::quantity::whole_in;
use crate::say;
use stepwright_cycle::line::NAME;
use stepwright_cyclefile::CyclePlan;
use stepwright_host::Session;
use stepwright_host::link::serial::Share;
use stepwright_host::programs::CycleSession;
use stepwright_machine::BAUD;
use stepwright_play::PlayFormat;
use stepwright_play::cycle::{self, CyclePlayer, CyclesOnBoard, PlayText};
use stepwright_plot::PlotFile;
use taken::{Taken, Wanted};
use voice::Aloud;

/// Play motor cycles from a file, on a virtual board or a real one
///
/// The file defines the motors, what each does in each cycle, and what happens at its
/// end. Positions are printed every second while motors move, and every ten seconds
/// while none does. With --port a board that runs the program `cycles` plays it;
/// Ctrl-C ends the cycle.
#[derive(clap::Args)]
#[command(after_help = "\
A file:
  [[motor]]
  name = \"X\"
  step = 7500                 # nm a step leads, or any unit of yours
  smallest-delay-us = 1000

  [[cycle]]
  move.X = { steps = 20000 }

In place of `steps`: whirl = \"forward\"; delays-us = [..] with each and
direction; series = [{ steps = 4, delay-us = 900 }, { wait = 2, delay-us = 500 }].
Cycles are simulated as fast as this computer can. Details: docs/cycles.md.

Exit status: 0 all went as it should; 1 a cycle was refused or cancelled; 2 the
command line is invalid.

Examples:
  stepwright cycle examples/cycles/readme.toml
  stepwright cycle examples/cycles/triangle.toml --xy triangle.svg
  stepwright cycle examples/cycles/series.toml --format csv --vcd edges.vcd
  On a board, after `stepwright flash mega --program cycles --port /dev/ttyACM0`:
    stepwright cycle examples/cycles/readme.toml --port /dev/ttyACM0")]
pub struct Args {
    /// The file; - is standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// How to print it
    #[arg(long, value_enum, default_value_t = Format::List, help_heading = "Output")]
    format: Format,
    /// Draw positions, speeds and accelerations over time (.svg, .png or .html)
    #[arg(long, value_name = "FILE", conflicts_with = "port", help_heading = "Output")]
    plot: Option<PlotFile>,
    /// Record every edge of the pins, for GTKWave or PulseView
    #[arg(long, value_name = "FILE", conflicts_with = "port", help_heading = "Output")]
    vcd: Option<PathBuf>,
    /// Record the edges as MCAP, for Foxglove or PlotJuggler
    #[arg(long, value_name = "FILE", conflicts_with = "port", help_heading = "Output")]
    mcap: Option<PathBuf>,
    /// Draw the path of two motors (.svg, .png or .html)
    #[arg(long, value_name = "FILE", conflicts_with = "port", help_heading = "Output")]
    xy: Option<PlotFile>,
    /// Which two motors --xy draws; the first two if it is not given
    #[arg(long, value_name = "X,Y", requires = "xy", value_delimiter = ',')]
    #[arg(help_heading = "Output")]
    xy_motors: Vec<String>,
    /// End a cycle that still runs after this many seconds, simulated ones on the virtual board
    #[arg(long, value_name = "S", default_value_t = 3600)]
    #[arg(value_parser = whole_in::<u32>(1..=1_000_000))]
    limit: u32,
    /// Serial port of a board that runs the program `cycles`
    #[arg(long, value_name = "PATH", help_heading = "Board")]
    port: Option<PathBuf>,
    /// Speed of the serial port in bits/s
    #[arg(long, value_name = "N", default_value_t = target::RATE, requires = "port")]
    #[arg(value_parser = whole_in::<u32>(BAUD), help_heading = "Board")]
    baud: u32,
}

/// How cycles are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Positions each second, as stepper_h prints them
    List,
    /// Every event: time_us,motor,event,value,position; of a board positions at each look
    Csv,
    /// The result of each motor and cycle
    Json,
}

impl Format {
    fn played(self) -> PlayFormat {
        match self {
            Format::List => PlayFormat::List,
            Format::Csv => PlayFormat::Csv,
            Format::Json => PlayFormat::Json,
        }
    }
}

/// Reads and plays the file. Draws if requested.
pub fn run(args: Args) -> Result<(), Failure> {
    let text = text::read(&args.file)?;
    let mut plan = stepwright_cyclefile::read(&text)?;
    if let Some(path) = &args.port {
        return on_board(&args, path, &mut plan, &text);
    }
    let pair = pair(&args, &plan)?;
    for file in args.plot.iter().chain(&args.xy) {
        file.check()?;
    }
    let inverted = plan.motors.iter().enumerate().map(|(n, m)| u8::from(m.inverted) << n).sum();
    let wanted = Wanted {
        inverted,
        edges: EdgePaths { vcd: args.vcd.as_deref(), mcap: args.mcap.as_deref(), laser: false },
        motions: args.plot.is_some(),
        events: args.format == Format::Csv || args.xy.is_some(),
    };
    let taken = Taken::begin(plan.rate, plan.names.len() as u8, &wanted)?;
    interrupt::listen(While::Waiting)?;
    let mut stages = std::mem::take(&mut plan.stages);
    let mut session =
        CyclePlayer::new(&plan, &text, taken, args.format.played(), &Aloud, pair, args.limit);
    let played = session.play(&mut stages);
    // The recordings are also written after an error.
    let name = title(&args.file);
    let seconds = session.seconds();
    let finished = session.tape(|taken| taken.finish(seconds));
    if let Some(file) = &args.plot {
        session.tape(|taken| taken.plot(file, &format!("{name}: motor cycles"), &plan, seconds))?;
    }
    if let (Some(file), Some(way)) = (&args.xy, session.way()) {
        let title = format!("{name}: the way of {} and {}", way.names.0, way.names.1);
        plot::save_picture(file, &title, &way.picture(&title))?;
    }
    if args.format == Format::Json {
        say::result(session.json());
    }
    played?;
    finished
}

/// The title of a plot: the file's name without folders and extension.
fn title(file: &Path) -> String {
    let stem = file.file_stem().filter(|_| file != Path::new("-"));
    let mut name = stem.map_or_else(|| "Input".into(), |stem| stem.to_string_lossy());
    if let Some(first) = name.get(..1) {
        let upper = first.to_uppercase();
        name = format!("{upper}{}", &name[1..]).into();
    }
    name.into_owned()
}

/// Opens the port, and connects to its board.
pub fn meet(port: &Path, baud: u32) -> Result<CycleSession, Failure> {
    let mut session = Session::new(Box::new(target::serial(port, baud, Share::Alone)?));
    let name = session.name();
    let about = target::met_program(&mut session, NAME, |_| "cycles")?;
    let board = CycleSession::of(session, about);
    Ok(board.map_err(|problem| cycle::failure(&name, problem))?)
}

/// Plays the file on a board.
fn on_board(
    args: &Args,
    path: &Path,
    plan: &mut CyclePlan,
    text: &PlayText,
) -> Result<(), Failure> {
    let mut stages = std::mem::take(&mut plan.stages);
    let board = meet(path, args.baud)?;
    interrupt::listen(While::Holding)?;
    let format = args.format.played();
    let mut session = CyclesOnBoard::new(board, plan, text, format, &Aloud, args.limit);
    let played = session.play(&mut stages);
    if args.format == Format::Json {
        say::result(session.json());
    }
    Ok(played?)
}

/// The two motors whose path is drawn.
fn pair(args: &Args, plan: &CyclePlan) -> Result<Option<(u8, u8)>, Failure> {
    if args.xy.is_none() {
        return Ok(None);
    }
    let find = |name: &String| {
        plan.names.iter().position(|known| known == name).ok_or_else(|| {
            Failure::new(format!("there is no motor {name:?} in this file"))
                .hint(format!("it has {}", plan.names.join(", ")))
        })
    };
    match args.xy_motors.as_slice() {
        [x, y] if x == y => Err(Failure::usage("--xy-motors takes two motors, not one twice")),
        [x, y] => Ok(Some((find(x)? as u8, find(y)? as u8))),
        [_, ..] => Err(Failure::usage("--xy-motors takes two names, like X,Y")),
        _ if plan.names.len() < 2 => {
            Err(Failure::new("--xy draws the way of two motors, and this file has one"))
        }
        _ => Ok(Some((0, 1))),
    }
}
