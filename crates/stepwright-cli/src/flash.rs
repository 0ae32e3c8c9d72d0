//! `stepwright flash`: writes a firmware to a board, without a compiler.

mod pico;

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::json;
use stepwright_flash::loader::LoaderError;
use stepwright_flash::{Firmware, FlashBoard, FlashProgram, NoProgram};
use stepwright_host::link::serial::Share;

use crate::failure::Failure;
use crate::order::progress::Line;
use crate::order::target::Format;
use crate::say;

/// Write a firmware to an Uno, a Nano, a Mega or a Pico
///
/// The firmware comes with this command, and needs no compiler. It replaces the program that
/// is on the board; settings that the board keeps stay.
#[derive(clap::Args)]
#[command(after_help = "\
avrdude writes an Arduino's firmware if it is installed. Otherwise this command writes it, reads
it back and compares. The board needs a boot loader. Every Arduino, and every copy of one, is sold
with one.

A Raspberry Pi Pico is a drive, RPI-RP2, if it is plugged in with BOOTSEL held. The firmware
is copied there, and the board restarts with it.

Examples:
  stepwright flash uno --port /dev/ttyACM0
  stepwright flash nano --old-boot-loader --port /dev/ttyUSB0
  stepwright flash mega --program cycles --port /dev/ttyACM0
  stepwright flash uno --port /dev/ttyACM0 --dry-run
  stepwright flash pico
  stepwright flash pico --drive /media/me/RPI-RP2
  stepwright flash pico --program selftest")]
pub struct Args {
    /// The board
    board: Board,
    /// Serial port of the board: /dev/ttyACM0, COM3
    #[arg(long, value_name = "PATH", conflicts_with = "drive", required_if_eq_any([("board", "uno"), ("board", "nano"), ("board", "mega")]))]
    port: Option<PathBuf>,
    /// Drive of a Pico, if there are several: /media/me/RPI-RP2, E:\
    #[arg(long, value_name = "PATH")]
    drive: Option<PathBuf>,
    /// Which firmware
    #[arg(long, value_name = "NAME", value_enum, default_value_t = FlashProgram::Slave)]
    program: FlashProgram,
    /// A Nano from before 2018, whose boot loader listens at 57600 bits/s and leaves 1.5 KB less
    /// room. A program that is larger is refused, with how to replace the boot loader
    #[arg(long)]
    old_boot_loader: bool,
    /// Write without avrdude, even if it is installed
    #[arg(long)]
    own: bool,
    /// Print what would be done; the board is not touched
    #[arg(long)]
    dry_run: bool,
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// A board that there is a firmware for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Board {
    /// Arduino Uno, or a copy of it with an ATmega328P
    Uno,
    /// Arduino Nano, likewise
    Nano,
    /// Arduino Mega 2560
    Mega,
    /// Raspberry Pi Pico
    Pico,
}

impl Board {
    /// The board of a boot loader on a serial line; `None` for one that is a drive.
    fn on_a_line(self) -> Option<FlashBoard> {
        match self {
            Board::Uno => Some(FlashBoard::Uno),
            Board::Nano => Some(FlashBoard::Nano),
            Board::Mega => Some(FlashBoard::Mega),
            Board::Pico => None,
        }
    }
}

/// A firmware, and the board on a serial line to write it to.
struct Order {
    board: FlashBoard,
    port: PathBuf,
    program: FlashProgram,
    image: Firmware,
}

/// avrdude's options for a board's chip and boot loader.
fn programmer(board: FlashBoard) -> [&'static str; 4] {
    match board {
        FlashBoard::Uno | FlashBoard::Nano => ["-p", "m328p", "-c", "arduino"],
        FlashBoard::Mega => ["-p", "m2560", "-c", "wiring"],
    }
}

/// Writes the firmware, and prints what was written.
pub fn run(args: Args) -> Result<(), Failure> {
    if args.old_boot_loader && args.board != Board::Nano {
        return Err(Failure::usage("--old-boot-loader is for a Nano"));
    }
    let Some(board) = args.board.on_a_line() else { return pico::run(&args) };
    let Some(port) = args.port else {
        return Err(Failure::usage("--port PATH is missing: `stepwright ports` lists them"));
    };
    let image = Firmware::of(board, args.old_boot_loader, args.program)?;
    let avrdude = !args.own && has_avrdude();
    if args.format == Format::Text {
        let (name, size, hash) = (board.name(), image.bytes().len(), image.hash());
        let program = args.program.name();
        say::result(format_args!("image       {name} {program}, {size} bytes, SHA-256 {hash}"));
    }
    let by = if avrdude { "avrdude" } else { "stepwright" };
    let order = Order { board, port, program: args.program, image };
    if !args.dry_run {
        match avrdude {
            true => by_avrdude(&order)?,
            false => by_ourselves(&order)?,
        }
    }
    let state = if args.dry_run { "dry-run" } else { "written" };
    let port = order.port.display();
    match args.format {
        Format::Json => say::json(json!({
            "board": board.name(),
            "program": order.program.name(),
            "bytes": image.bytes().len(),
            "sha256": image.hash(),
            "by": by,
            "state": state,
        })),
        Format::Text if args.dry_run => {
            let baud = image.baud();
            say::result(format_args!("dry run     {by} would write it to {port} at {baud} bits/s"));
        }
        Format::Text => {
            say::result(format_args!("written     by {by}, and compared"));
            say::note(format_args!("try it with: {}", seen_with(order.program, &port.to_string())));
        }
    }
    Ok(())
}

/// Whether avrdude can be started.
fn has_avrdude() -> bool {
    let started = Command::new("avrdude").stdout(Stdio::null()).stderr(Stdio::null()).status();
    started.is_ok()
}

/// Lets avrdude write and verify.
fn by_avrdude(order: &Order) -> Result<(), Failure> {
    let Order { board, port, image, .. } = order;
    let mut file = tempfile::Builder::new()
        .prefix("stepwright-")
        .suffix(".bin")
        .tempfile()
        .map_err(|error| Failure::new(format!("can't make a file for avrdude: {error}")))?;
    file.write_all(image.bytes())
        .and_then(|()| file.flush())
        .map_err(|error| Failure::file("write", file.path(), &error))?;
    let flash = format!("flash:w:{}:r", file.path().display());
    let mut avrdude = Command::new("avrdude");
    avrdude.args(programmer(*board)).args(["-b", &image.baud().to_string(), "-D"]);
    avrdude.arg("-P").arg(port).args(["-U", &flash]).stdout(Stdio::null());
    match avrdude.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Failure::new(format!("avrdude has not written it ({status})")).hint(
            "what it says is above. Is it this board (uno, nano, mega), and this port? An old \
             Nano takes --old-boot-loader",
        )),
        Err(error) => {
            Err(Failure::new(format!("can't start avrdude: {error}")).hint("--own does without it"))
        }
    }
}

/// Writes with this command's own code for the boot loader.
fn by_ourselves(order: &Order) -> Result<(), Failure> {
    let Order { board, port, image, .. } = order;
    let link = crate::order::target::serial(port, image.baud(), Share::Alone)?;
    let mut line = Line::new();
    let written = image.write(link, |stage, done| {
        let text = format!("{stage} {} %", 100 * done / image.bytes().len());
        line.show(&[&text], &text, false);
    });
    line.end();
    written.map_err(|trouble| explain(&port.display().to_string(), *board, trouble))
}

/// The failure for an error of a boot loader, with a hint.
fn explain(port: &str, board: FlashBoard, trouble: LoaderError) -> Failure {
    let name = board.name();
    match trouble {
        LoaderError::Silent => {
            Failure::new(format!("no boot loader answers on {port}")).hint(format!(
                "is it {} {name}, on this port (`stepwright ports`)? Press its reset button as the \
             command starts; an old Nano takes --old-boot-loader",
                if board == FlashBoard::Uno { "an" } else { "a" }
            ))
        }
        LoaderError::Chip(signature) => {
            let [a, b, c] = signature;
            let wanted = if board == FlashBoard::Mega { "ATmega2560" } else { "ATmega328P" };
            Failure::new(format!("the chip on {port} is no {wanted}: {a:02X} {b:02X} {c:02X}"))
                .hint("nothing was written. Which board is it: uno, nano or mega?")
        }
        LoaderError::Differs(at) => {
            Failure::new(format!("what was written to {port} differs from byte {at} on"))
                .hint("write it again; if it stays so, the chip's flash is worn out")
        }
        LoaderError::Refused => Failure::new(format!("the boot loader on {port} refused to go on"))
            .hint("press the board's reset button and write it again; if it stays so, avrdude may know its boot loader"),
        LoaderError::Odd => Failure::new(format!("the boot loader on {port} lost its step"))
            .hint("write it again, with a shorter cable or on another port of the computer"),
        LoaderError::Line(error) => Failure::new(format!("{port}: {error}"))
            .hint("was it unplugged? Plug it in and write it again"),
    }
}

/// A command that shows the program at work on a port.
fn seen_with(program: FlashProgram, port: &str) -> String {
    match program {
        FlashProgram::Slave => format!("stepwright status --port {port}"),
        FlashProgram::Timed => format!("stepwright timed --case 1 --port {port}"),
        FlashProgram::Cycles => format!("stepwright cycle FILE --port {port}"),
        FlashProgram::Laws => format!("stepwright move 400 --law austin --port {port}"),
        FlashProgram::Transitions => {
            format!("stepwright move 400 --law linear-factor --port {port}")
        }
        FlashProgram::PowerTerm => format!("stepwright move 400 --law power --port {port}"),
        FlashProgram::Stream => format!("stepwright gcode FILE --port {port}"),
        FlashProgram::Selftest => format!("stepwright selftest --port {port}"),
    }
}

impl From<NoProgram> for Failure {
    fn from(error: NoProgram) -> Failure {
        let hint = match &error {
            NoProgram::Board { there, .. } => {
                let names: Vec<&str> = there.iter().map(|program| program.name()).collect();
                format!("--program is one of {}", names.join(", "))
            }
            NoProgram::OldBootLoader { .. } => {
                "write the Nano's new boot loader once, with another \
                 Arduino: docs/guide/src/first-motor.md, \"A Nano from before 2018\"; then leave \
                 --old-boot-loader out"
                    .into()
            }
        };
        Failure::usage(error.to_string()).hint(hint)
    }
}
