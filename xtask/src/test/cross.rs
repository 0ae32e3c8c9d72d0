//! The crates that must run on a small chip build for one, without a standard
//! library to lean on; and a reader that no firmware has yet holds no code that panics.

use anyhow::Result;

use crate::toolchain::{ATMEGA328P, CORTEX_M0, cross_build};
use crate::wasm;
use crate::workspace::Workspace;

/// One chip of 8 bits, and one of 32 without atomic swaps.
pub fn run(ws: &Workspace) -> Result<()> {
    cross_build(
        ws,
        &[&ATMEGA328P, &CORTEX_M0],
        &[
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
        ],
        "release",
    )?;
    wasm::cannot_panic(ws, "stepwright-gcode", "prove")
}
