//! The rig: a separate workspace that runs the firmware on a simulated chip.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::firmware::{Board, Build};
use crate::outside;
use crate::program::{CONTROLLER, Program, REFUSED};
use crate::setup::{self, Need};
use crate::workspace::{Workspace, run};

/// The needs for building the firmware and the rig.
pub const NEEDS: &[&Need] = &[setup::CROSS, setup::AVR_GCC, setup::SIMAVR];

/// The needs for building the rig alone.
pub const SIM_NEEDS: &[&Need] = &[setup::SIMAVR];

/// The needs of the rig's tests, one of which uses another simulator.
pub const TESTS_NEED: &[&Need] = &[setup::CROSS, setup::AVR_GCC, setup::SIMAVR, setup::NODE];

/// A cargo command for the rig.
pub fn cargo(ws: &Workspace, verb: &str) -> Command {
    let mut cargo = ws.cargo([verb]);
    cargo.current_dir(ws.root.join("firmware/rig"));
    // A separate target folder, since the rig is a separate workspace.
    cargo.arg("--target-dir").arg(ws.target.join("rig"));
    with_firmware(ws, &mut cargo);
    cargo
}

/// Tells a program of the rig the folder of the firmwares.
pub fn with_firmware(ws: &Workspace, command: &mut Command) {
    command.env("STEPWRIGHT_FIRMWARE", ws.target.join("firmware"));
}

/// Programs that only simulate; they need fewer crates than the tests.
const SIMULATORS: [&str; 2] = ["sim", "ticks"];

/// Builds a program of the rig. Returns its path.
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
    // The rates of the bench are tested with the build of the bench.
    Build { bench: true, ..build }.controller(ws)?;
    let others = Program::all(ws)?;
    let others = others.iter().filter(|program| ![CONTROLLER, REFUSED].contains(&&*program.name));
    for program in others.filter(|program| program.fits(&build)) {
        build.make(ws, program)?;
    }
    if board == Board::Uno { outside::make(ws) } else { Ok(()) }
}
