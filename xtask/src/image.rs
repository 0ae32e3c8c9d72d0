//! `cargo xtask image`: the firmwares that `stepwright flash` carries.
//!
//! The compiler puts functions in another order, and inlines others, where the checkout has
//! another path, and a newer compiler makes other code. So the bytes are not compared: beside
//! the images stands a digest of all that they are built from, and of each image.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::digest::Digest;
use crate::firmware::{self, Board, Build};
use crate::program::Program;
use crate::setup;
use crate::workspace::{Workspace, run};

/// Build the firmwares that `stepwright flash` carries, and put them beside its code.
#[derive(clap::Args)]
pub struct Image {
    /// Change nothing, and fail if those that are there were built from other code.
    #[arg(long)]
    check: bool,
}

const BOARDS: [Board; 2] = [Board::Uno, Board::Mega];

/// All that they are built from.
const SOURCES: [&str; 24] = [
    "crates/avr-shrink/src",
    "crates/stepwright/Cargo.toml",
    "crates/stepwright/src",
    "crates/stepwright-austin/Cargo.toml",
    "crates/stepwright-austin/src",
    "crates/stepwright-avr/Cargo.toml",
    "crates/stepwright-avr/src",
    "crates/stepwright-cycle/Cargo.toml",
    "crates/stepwright-cycle/src",
    "crates/stepwright-device/Cargo.toml",
    "crates/stepwright-device/src",
    "crates/stepwright-protocol/Cargo.toml",
    "crates/stepwright-protocol/src",
    "crates/stepwright-stream/Cargo.toml",
    "crates/stepwright-stream/src",
    "crates/stepwright-timed/Cargo.toml",
    "crates/stepwright-timed/src",
    "firmware/avr/Cargo.lock",
    "firmware/avr/Cargo.toml",
    "firmware/avr/build.rs",
    "firmware/avr/src/bin",
    "xtask/src/firmware.rs",
    "xtask/src/program.rs",
    "xtask/src/shrink.rs",
];

impl Image {
    /// Builds and writes, or compares.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        if self.check {
            return check(ws);
        }
        setup::ensure(firmware::NEEDS)?;
        fs::create_dir_all(folder(ws))?;
        for (board, program) in all(ws)? {
            let (built, place) = (build(ws, board, &program)?, place(ws, board, &program));
            fs::write(&place, &built)?;
            println!("{}  {} bytes", place.display(), built.len());
        }
        Ok(fs::write(folder(ws).join(DIGESTS), digests(ws)?)?)
    }
}

/// Those that are carried.
fn all(ws: &Workspace) -> Result<Vec<(Board, Program)>> {
    let mut all = Vec::new();
    for board in BOARDS {
        let programs = Program::all(ws)?.into_iter();
        all.extend(programs.filter(|one| one.is_carried(board)).map(|one| (board, one)));
    }
    Ok(all)
}

/// Whether the images are those that were built, from the code that is there.
pub fn check(ws: &Workspace) -> Result<()> {
    let carried = fs::read_to_string(folder(ws).join(DIGESTS)).unwrap_or_default();
    let now = digests(ws)?;
    ensure!(
        carried == now,
        "the images were built from other code: run `cargo xtask image`\n{carried}now\n{now}"
    );
    Ok(())
}

/// The image of a program, if it is carried and was built from the code that is there.
pub fn carried(ws: &Workspace, board: Board, program: &Program) -> Option<PathBuf> {
    (program.is_carried(board) && check(ws).is_ok()).then(|| place(ws, board, program))
}

/// The file of the digests, beside the images.
const DIGESTS: &str = "digests.txt";

fn folder(ws: &Workspace) -> PathBuf {
    ws.root.join("crates/stepwright-flash/images")
}

fn place(ws: &Workspace, board: Board, program: &Program) -> PathBuf {
    folder(ws).join(program.on(board)).with_extension("bin")
}

/// A program as it lies in flash.
fn build(ws: &Workspace, board: Board, program: &Program) -> Result<Vec<u8>> {
    let built = Build { board, timer: 1, bench: false }.make(ws, program)?;
    let bin = built.elf.with_extension("bin");
    let convert = ["-O", "binary", "-j", ".text", "-j", ".data"];
    run(Command::new("avr-objcopy").args(convert).arg(&built.elf).arg(&bin))?;
    fs::read(&bin).with_context(|| format!("reading {}", bin.display()))
}

/// A line for the sources, and one for each image.
fn digests(ws: &Workspace) -> Result<String> {
    let mut sources = Digest::NEW;
    for source in SOURCES {
        sources.add_all(&ws.root, &ws.root.join(source))?;
    }
    let mut text = format!("sources {:016x}\n", sources.value());
    for (board, program) in all(ws)? {
        let mut image = Digest::NEW;
        image.add(&fs::read(place(ws, board, &program)).unwrap_or_default());
        let _ = writeln!(text, "{} {:016x}", program.on(board), image.value());
    }
    Ok(text)
}
