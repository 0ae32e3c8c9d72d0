//! `cargo xtask image`: the firmwares that `stepwright flash` carries.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::firmware::{self, Board, Build, Program};
use crate::setup;
use crate::workspace::{Workspace, run};

/// Build the firmwares that `stepwright flash` carries, and put them beside its code.
#[derive(clap::Args)]
pub struct Image {
    /// Change nothing, and fail if those that are there differ.
    #[arg(long)]
    check: bool,
}

/// Those that are carried.
const BOARDS: [Board; 3] = [Board::Uno, Board::Nano, Board::Mega];

impl Image {
    /// Builds, and writes or compares.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        setup::ensure(firmware::NEEDS)?;
        for board in BOARDS {
            let (built, place) = (build(ws, board)?, place(ws, board));
            if self.check {
                compare(&built, &place)?;
            } else {
                fs::create_dir_all(place.parent().context("a folder")?)?;
                fs::write(&place, &built)?;
            }
            println!("{}  {} bytes", place.display(), built.len());
        }
        Ok(())
    }
}

/// Compares those that are carried with what the code gives.
pub fn check(ws: &Workspace) -> Result<()> {
    Image { check: true }.run(ws)
}

fn place(ws: &Workspace, board: Board) -> PathBuf {
    ws.root.join("crates/stepwright-cli/images").join(board.name()).with_extension("bin")
}

/// The controller as it lies in flash.
fn build(ws: &Workspace, board: Board) -> Result<Vec<u8>> {
    let built = Build { board, timer: 1, bench: false }.make(ws, Program::Slave)?;
    let bin = built.elf.with_extension("bin");
    let convert = ["-O", "binary", "-j", ".text", "-j", ".data"];
    run(Command::new("avr-objcopy").args(convert).arg(&built.elf).arg(&bin))?;
    fs::read(&bin).with_context(|| format!("reading {}", bin.display()))
}

fn compare(built: &[u8], place: &PathBuf) -> Result<()> {
    let carried = fs::read(place).unwrap_or_default();
    ensure!(
        carried == built,
        "{} is not what the firmware's code gives ({} bytes, not {}): run `cargo xtask image`",
        place.display(),
        carried.len(),
        built.len()
    );
    Ok(())
}
