//! The crates that must run on a small chip build for one, without a standard
//! library to lean on; and a reader that no firmware has yet holds no code that panics.

use anyhow::{Context, Result};

use crate::toolchain::{ATMEGA328P, CORTEX_M0, Cross};
use crate::wasm;
use crate::workspace::{Workspace, run as run_to_end};

/// What a program for a small chip may take.
const PACKAGES: [&str; 11] = [
    "stepwright",
    "stepwright-austin",
    "stepwright-cycle",
    "stepwright-timed",
    "stepwright-stream",
    "stepwright-protocol",
    "stepwright-device",
    "stepwright-gcode",
    "stepwright-selftest",
    "stepwright-sink",
    "stepwright-tmc2209",
];

/// One chip of 8 bits, and one of 32 without atomic swaps, at once: `core` is one crate and compiles on
/// one processor. They are checked alone; the firmwares have the machine code.
pub fn run(ws: &Workspace) -> Result<()> {
    let cross = Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
    println!("compiler: {}", cross.describe());
    let mut cargo = cross.cargo(ws, "check", &[&ATMEGA328P, &CORTEX_M0]);
    for package in PACKAGES {
        cargo.args(["--package", package]);
    }
    run_to_end(&mut cargo)?;
    wasm::cannot_panic(ws, "stepwright-gcode", "prove")
}
