//! The steps that are single cargo commands.

use anyhow::Result;

use super::programs;
use crate::workspace::{Workspace, run};

/// Checks the format. `cargo fmt --all` repairs it, in the folder that is printed.
pub fn fmt(ws: &Workspace) -> Result<()> {
    // The firmware with the board support is a separate workspace.
    for folder in [".", "firmware/avr"] {
        run(ws.cargo(["fmt", "--all", "--check"]).current_dir(ws.root.join(folder)))?;
    }
    Ok(())
}

/// Lints, in tests and examples too. A warning is an error.
pub fn clippy(ws: &Workspace) -> Result<()> {
    run(&mut ws.cargo(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
}

/// Unit, property and documentation tests, in the dev profile on purpose: it is optimised here, and
/// keeps overflow checks and debug assertions. Tests that run the command use the one that ships.
pub fn unit(ws: &Workspace) -> Result<()> {
    let shipped = ws.shipped()?;
    let built = programs::build(&mut ws.cargo(["test", "--workspace"]))?;
    let commands = built.iter().map(|program| {
        let mut command = program.command();
        command.env("STEPWRIGHT_COMMAND", &shipped);
        (program.name.clone(), command)
    });
    let ran = programs::run_by_the_clock(commands.collect());
    let doc = run(&mut ws.cargo(["test", "--workspace", "--doc", "--no-fail-fast"]));
    ran.and(doc)
}

/// The unit tests at the end of each file.
pub fn units_alone(ws: &Workspace) -> Result<()> {
    run(&mut ws.cargo(["test", "--workspace", "--no-fail-fast", "--lib", "--bins"]))
}

/// Compares the output of the command with the stored texts.
pub fn golden(ws: &Workspace) -> Result<()> {
    // With a single package, its dependencies would be rebuilt with fewer features.
    run(&mut ws.cargo(["test", "--workspace", "--test", "golden"]))
}

/// Builds the documentation with its links. A warning is an error.
pub fn doc(ws: &Workspace) -> Result<()> {
    run(ws.cargo(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
}

/// The long fuzz tests of the protocol and of the pass over assembly. They are seeded, so that a
/// failure can be repeated, and use the stable toolchain, so that they run on every machine
/// (cargo-fuzz needs a nightly and minutes to install). `STEPWRIGHT_FUZZ_CASES` is the number of
/// conversations, `AVR_SHRINK_PROGRAMS` the number of programs. Without them, in `unit`, the tests
/// are brief.
pub fn fuzz(ws: &Workspace) -> Result<()> {
    run(ws
        .cargo(["test", "--release", "--package", "stepwright-protocol", "--test", "fuzz"])
        .env("STEPWRIGHT_FUZZ_CASES", "500000"))?;
    run(ws
        .cargo(["test", "--release", "--package", "avr-shrink", "--test", "whole"])
        .env("AVR_SHRINK_PROGRAMS", "5000"))
}
