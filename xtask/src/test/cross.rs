//! Checks that the crates for small chips build for one, without a standard library, and that a
//! reader that no firmware uses yet contains no code that panics.

use anyhow::Result;

use crate::toolchain::{ATMEGA328P, CORTEX_M0, cross_build};
use crate::wasm;
use crate::workspace::Workspace;

/// For one 8-bit chip, and one 32-bit chip without atomic swaps.
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
