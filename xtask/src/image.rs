//! `cargo xtask image`: builds the firmwares that `stepwright flash` carries.
//!
//! The order and the inlining of functions depend on the path of the checkout, and a newer compiler
//! makes other code. So the bytes are not compared. Beside the images is a digest of all their
//! sources, and of each image.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::digest::Digest;
use crate::elf;
use crate::firmware::{self, Board, Build};
use crate::program::Program;
use crate::qemu;
use crate::setup;
use crate::small::SmallBoard;
use crate::workspace::{Workspace, run};

/// Build the firmwares that `stepwright flash` carries, and put them beside its code.
#[derive(clap::Args)]
pub struct Image {
    /// Change nothing, and fail if those that are there were built from other code.
    #[arg(long)]
    check: bool,
    /// Build the Pico's alone.
    #[arg(long)]
    pico: bool,
}

const BOARDS: [Board; 2] = [Board::Uno, Board::Mega];

/// The sources of the AVR images.
const SOURCES: [&str; 26] = [
    "crates/avr-shrink/Cargo.toml",
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
    "xtask/src/toolchain.rs",
];

/// The sources of the Pico's images.
const PICO_SOURCES: [&str; 23] = [
    "crates/stepwright/Cargo.toml",
    "crates/stepwright/src",
    "crates/stepwright-device/Cargo.toml",
    "crates/stepwright-device/src",
    "crates/stepwright-protocol/Cargo.toml",
    "crates/stepwright-protocol/src",
    "crates/stepwright-selftest/Cargo.toml",
    "crates/stepwright-selftest/src",
    "crates/stepwright-sink/Cargo.toml",
    "crates/stepwright-sink/src",
    "crates/stepwright-stream/Cargo.toml",
    "crates/stepwright-stream/src",
    "firmware/controller/Cargo.toml",
    "firmware/controller/src",
    "firmware/rp2040/Cargo.lock",
    "firmware/rp2040/Cargo.toml",
    "firmware/rp2040/build.rs",
    "firmware/rp2040/device.x",
    "firmware/rp2040/memory.x",
    "firmware/rp2040/src",
    "xtask/src/elf.rs",
    "xtask/src/small.rs",
    "xtask/src/toolchain.rs",
];

/// The prefix of the names of the Pico's images.
const PICO: &str = "pico";

/// The Pico's programs that are carried, and the names of their images.
const PICO_PROGRAMS: [(&str, &str); 3] =
    [("controller", PICO), ("stream", "pico-stream"), ("selftest", "pico-selftest")];

impl Image {
    /// Builds and writes the images, or compares the digests.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        if self.check {
            return check(ws);
        }
        fs::create_dir_all(folder(ws))?;
        let digests = folder(ws).join(DIGESTS);
        let mut lines = fs::read_to_string(&digests).unwrap_or_default();
        if self.pico {
            let others = lines.lines().filter(|line| !line.starts_with(PICO));
            lines = others.map(|line| format!("{line}\n")).collect();
        } else {
            setup::ensure(firmware::NEEDS)?;
            for (board, program) in all(ws)? {
                let (built, place) = (build(ws, board, &program)?, place(ws, board, &program));
                fs::write(&place, &built)?;
                println!("{}  {} bytes", place.display(), built.len());
            }
            lines = avr_digests(ws)?;
        }
        setup::ensure(qemu::BUILD_NEEDS)?;
        let elves = SmallBoard::named(ws, "rp2040")?.build(ws)?;
        for (program, name) in PICO_PROGRAMS {
            let elf = elves.iter().find(|elf| elf.ends_with(format!("rp2040-{program}.elf")));
            let elf = elf.with_context(|| format!("the Pico's {program} was not built"))?;
            let (built, place) = (elf::flat(&fs::read(elf)?, PICO_FLASH)?, pico(ws, name));
            fs::write(&place, &built)?;
            println!("{}  {} bytes", place.display(), built.len());
        }
        Ok(fs::write(digests, lines + &pico_digests(ws)?)?)
    }
}

/// The address of a Pico's flash.
const PICO_FLASH: u32 = 0x1000_0000;

/// The path of an image of the Pico.
fn pico(ws: &Workspace, name: &str) -> PathBuf {
    folder(ws).join(name).with_extension("bin")
}

/// The AVR programs that are carried, with their boards.
fn all(ws: &Workspace) -> Result<Vec<(Board, Program)>> {
    let mut all = Vec::new();
    for board in BOARDS {
        let programs = Program::all(ws)?.into_iter();
        all.extend(programs.filter(|one| one.is_carried(board)).map(|one| (board, one)));
    }
    Ok(all)
}

/// Checks that the images are those that were built from the present code.
pub fn check(ws: &Workspace) -> Result<()> {
    let carried = fs::read_to_string(folder(ws).join(DIGESTS)).unwrap_or_default();
    let now = digests(ws)?;
    ensure!(
        carried == now,
        "the images were built from other code: run `cargo xtask image`\n{carried}now\n{now}"
    );
    Ok(())
}

/// The image of a program, if it is carried and was built from the present code.
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

/// Builds a program, and returns the content of its flash.
fn build(ws: &Workspace, board: Board, program: &Program) -> Result<Vec<u8>> {
    let built = Build { board, timer: 1, bench: false }.make(ws, program)?;
    let bin = built.elf.with_extension("bin");
    let convert = ["-O", "binary", "-j", ".text", "-j", ".data"];
    run(Command::new("avr-objcopy").args(convert).arg(&built.elf).arg(&bin))?;
    fs::read(&bin).with_context(|| format!("reading {}", bin.display()))
}

/// A line for the sources and one for each image, for the AVRs and for the Pico.
fn digests(ws: &Workspace) -> Result<String> {
    Ok(avr_digests(ws)? + &pico_digests(ws)?)
}

fn pico_digests(ws: &Workspace) -> Result<String> {
    let mut text = format!("{PICO}-sources {:016x}\n", digest(ws, &PICO_SOURCES)?);
    for (_, name) in PICO_PROGRAMS {
        let mut image = Digest::NEW;
        image.add(&fs::read(pico(ws, name)).unwrap_or_default());
        let _ = writeln!(text, "{name} {:016x}", image.value());
    }
    Ok(text)
}

/// The digest of all these files.
fn digest(ws: &Workspace, sources: &[&str]) -> Result<u64> {
    let mut digest = Digest::NEW;
    for source in sources {
        digest.add_all(&ws.root, &ws.root.join(source))?;
    }
    Ok(digest.value())
}

fn avr_digests(ws: &Workspace) -> Result<String> {
    let mut text = format!("sources {:016x}\n", digest(ws, &SOURCES)?);
    for (board, program) in all(ws)? {
        let mut image = Digest::NEW;
        image.add(&fs::read(place(ws, board, &program)).unwrap_or_default());
        let _ = writeln!(text, "{} {:016x}", program.on(board), image.value());
    }
    Ok(text)
}
