//! The rig: a workspace of its own, which runs the firmware on a simulated
//! chip.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::firmware::{Board, Build};
use crate::outside;
use crate::program::{CONTROLLER, Program, REFUSED};
use crate::setup::{self, Need};
use crate::workspace::{Workspace, run};

/// What building the firmware and the rig takes.
pub const NEEDS: &[&Need] = &[setup::CROSS, setup::AVR_GCC, setup::SIMAVR];

/// What building the rig alone takes.
pub const SIM_NEEDS: &[&Need] = &[setup::SIMAVR];

/// What its tests take: one of them is for another simulator.
pub const TESTS_NEED: &[&Need] = &[setup::CROSS, setup::AVR_GCC, setup::SIMAVR, setup::NODE];

/// A cargo command for the rig.
pub fn cargo(ws: &Workspace, verb: &str) -> Command {
    let mut cargo = ws.cargo([verb]);
    cargo.current_dir(ws.root.join("firmware/rig"));
    // Its own, as its workspace is.
    cargo.arg("--target-dir").arg(ws.target.join("rig"));
    with_firmware(ws, &mut cargo);
    cargo
}

/// Tells a program of the rig where the firmwares are.
pub fn with_firmware(ws: &Workspace, command: &mut Command) {
    command.env("STEPWRIGHT_FIRMWARE", ws.target.join("firmware"));
}

/// What simulates alone takes fewer crates than what judges.
const SIMULATORS: [&str; 2] = ["sim", "ticks"];

/// Builds a program of the rig; where it is.
pub fn program(ws: &Workspace, name: &str) -> Result<PathBuf> {
    let mut build = cargo(ws, "build");
    build.args(["--release", "--bin", name]);
    if SIMULATORS.contains(&name) {
        build.arg("--no-default-features");
    }
    run(&mut build)?;
    Ok(ws.target.join("rig/release").join(name))
}

/// Builds the firmwares that the rig runs on `board`.
pub fn firmware(ws: &Workspace, board: Board, bench: bool) -> Result<()> {
    let build = Build { board, timer: 1, bench };
    build.controller(ws)?;
    if bench {
        build.make(ws, &Program::named(ws, "cycle")?)?;
        return Ok(());
    }
    // The bench's rates are tested with the bench's build.
    Build { bench: true, ..build }.controller(ws)?;
    let others = Program::all(ws)?;
    let others = others.iter().filter(|program| ![CONTROLLER, REFUSED].contains(&&*program.name));
    for program in others.filter(|program| program.fits(&build)) {
        build.make(ws, program)?;
    }
    if board == Board::Uno { outside::make(ws) } else { Ok(()) }
}
