//! `stepwright flash`: writes a firmware to a board, without a compiler.
//!
//! | module | what |
//! | --- | --- |
//! | [`image`] | the firmwares that this command carries |
//! | [`loader`] | what the boot loaders have in common |
//! | [`stk500`] | the boot loader of an Uno and a Nano |
//! | [`stk500v2`] | the boot loader of a Mega |

mod image;
mod loader;
mod stk500;
mod stk500v2;

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use clap::ValueEnum;
use serde_json::json;

use crate::failure::Failure;
use crate::order::progress::Line;
use crate::order::target::Format;
use crate::say;
use image::{Image, Program};
use loader::{LinkError, Loader};
use stepwright_host::link::serial::{SerialLink, Share};
use stk500::Stk500;
use stk500v2::Stk500v2;

/// Write a firmware to an Uno, a Nano or a Mega
///
/// The firmware comes with this command, and needs no compiler. It replaces the program that
/// is on the board; settings that the board keeps stay.
#[derive(clap::Args)]
#[command(after_help = "\
Avrdude writes it if it is installed. Else this command does, and compares all of it
afterwards. With --own avrdude is not looked for.

The board must have its boot loader: one bought as an Arduino, or as a copy of one, has.

Examples:
  stepwright flash uno --port /dev/ttyACM0
  stepwright flash nano --old-boot-loader --port /dev/ttyUSB0
  stepwright flash mega --program cycles --port /dev/ttyACM0
  stepwright flash uno --port /dev/ttyACM0 --dry-run")]
pub struct Args {
    /// Which board it is
    board: Board,
    /// Serial port of the board
    #[arg(long, value_name = "PATH")]
    port: PathBuf,
    /// Which firmware
    #[arg(long, value_name = "NAME", value_enum, default_value_t = Program::Slave)]
    program: Program,
    /// A Nano from before 2018, whose boot loader listens at 57600 bits/s and leaves 1.5 KB less:
    /// its controller has no safety features
    #[arg(long)]
    old_boot_loader: bool,
    /// Leave avrdude alone
    #[arg(long)]
    own: bool,
    /// Say what would be done, and leave the board alone
    #[arg(long)]
    dry_run: bool,
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// A board that there is a firmware for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Board {
    /// Arduino Uno, or a copy of it with an ATmega328P
    Uno,
    /// Arduino Nano, likewise
    Nano,
    /// Arduino Mega 2560
    Mega,
}

impl Board {
    fn name(self) -> &'static str {
        match self {
            Board::Uno => "uno",
            Board::Nano => "nano",
            Board::Mega => "mega",
        }
    }

    /// What avrdude calls its chip and its boot loader.
    fn programmer(self) -> [&'static str; 4] {
        match self {
            Board::Uno | Board::Nano => ["-p", "m328p", "-c", "arduino"],
            Board::Mega => ["-p", "m2560", "-c", "wiring"],
        }
    }
}

/// How often the boot loader is looked for: it listens for about a second after a reset.
const RESETS: usize = 3;

/// Writes the firmware, and says what was written.
pub fn run(args: Args) -> Result<(), Failure> {
    if args.old_boot_loader && args.board != Board::Nano {
        return Err(Failure::usage("--old-boot-loader is for a Nano"));
    }
    let image = Image::of(args.board, args.old_boot_loader, args.program)?;
    let baud = if args.old_boot_loader { 57_600 } else { 115_200 };
    let avrdude = !args.own && has_avrdude();
    if args.format == Format::Text {
        let (name, size, hash) = (args.board.name(), image.bytes().len(), image.hash());
        let program = args.program.name();
        say::result(format_args!("image       {name} {program}, {size} bytes, SHA-256 {hash}"));
    }
    let by = if avrdude { "avrdude" } else { "stepwright" };
    if !args.dry_run {
        match avrdude {
            true => by_avrdude(&args, &image, baud)?,
            false => by_ourselves(&args, &image, baud)?,
        }
    }
    let state = if args.dry_run { "dry-run" } else { "written" };
    match args.format {
        Format::Json => say::json(json!({
            "board": args.board.name(),
            "program": args.program.name(),
            "bytes": image.bytes().len(),
            "sha256": image.hash(),
            "by": by,
            "state": state,
        })),
        Format::Text if args.dry_run => {
            let port = args.port.display();
            say::result(format_args!("dry run     {by} would write it to {port} at {baud} bits/s"));
        }
        Format::Text => {
            say::result(format_args!("written     by {by}, and compared"));
            let port = args.port.display();
            say::note(format_args!("try it with: {}", args.program.seen_with(&port.to_string())));
        }
    }
    Ok(())
}

/// Whether avrdude can be started.
fn has_avrdude() -> bool {
    let started = Command::new("avrdude").stdout(Stdio::null()).stderr(Stdio::null()).status();
    started.is_ok()
}

/// Has avrdude write and compare.
fn by_avrdude(args: &Args, image: &Image, baud: u32) -> Result<(), Failure> {
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
    avrdude.args(args.board.programmer()).args(["-b", &baud.to_string(), "-D"]);
    avrdude.arg("-P").arg(&args.port).args(["-U", &flash]).stdout(Stdio::null());
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

/// Speaks with the boot loader.
fn by_ourselves(args: &Args, image: &Image, baud: u32) -> Result<(), Failure> {
    let link = crate::order::target::serial(&args.port, baud, Share::Alone)?;
    let written = match args.board {
        Board::Uno | Board::Nano => through(Stk500::new(link), image),
        Board::Mega => through(Stk500v2::new(link), image),
    };
    let port = args.port.display().to_string();
    written.map_err(|trouble| explain(&port, args.board, trouble))
}

/// Writes and compares through a boot loader, and has the program begin.
fn through(mut loader: impl Loader<Link = SerialLink>, image: &Image) -> Result<(), LinkError> {
    let mut met = Err(LinkError::Silent);
    for _ in 0..RESETS {
        loader.link().reset();
        met = loader.meet();
        if met.is_ok() {
            break;
        }
    }
    met?;
    let mut line = Line::new();
    let mut tell = |word: &str, done: usize| {
        let text = format!("{word} {} %", 100 * done / image.bytes().len());
        line.show(&[&text], &text, false);
    };
    let written = loader
        .write(image.bytes(), &mut |done| tell("writing", done))
        .and_then(|()| loader.compare(image.bytes(), &mut |done| tell("comparing", done)))
        .and_then(|()| loader.leave());
    line.end();
    written?;
    // Its program begins.
    thread::sleep(Duration::from_millis(200));
    Ok(())
}

/// What is wrong with a boot loader, and what to do.
fn explain(port: &str, board: Board, trouble: LinkError) -> Failure {
    let name = board.name();
    match trouble {
        LinkError::Silent => {
            Failure::new(format!("no boot loader answers on {port}")).hint(format!(
                "is it {} {name}, on this port (`stepwright ports`)? Press its reset button as the \
             command starts; an old Nano takes --old-boot-loader",
                if board == Board::Uno { "an" } else { "a" }
            ))
        }
        LinkError::Chip(signature) => {
            let [a, b, c] = signature;
            let wanted = if board == Board::Mega { "ATmega2560" } else { "ATmega328P" };
            Failure::new(format!("the chip on {port} is no {wanted}: {a:02X} {b:02X} {c:02X}"))
                .hint("nothing was written. Which board is it: uno, nano or mega?")
        }
        LinkError::Differs(at) => {
            Failure::new(format!("what was written to {port} differs from byte {at} on"))
                .hint("write it again; if it stays so, the chip's flash is worn out")
        }
        LinkError::Refused => Failure::new(format!("the boot loader on {port} refused to go on"))
            .hint("press the board's reset button and write it again; if it stays so, avrdude may know its boot loader"),
        LinkError::Odd => Failure::new(format!("the boot loader on {port} lost its step"))
            .hint("write it again, with a shorter cable or on another port of the computer"),
        LinkError::Line(error) => Failure::new(format!("{port}: {error}"))
            .hint("was it unplugged? Plug it in and write it again"),
    }
}
