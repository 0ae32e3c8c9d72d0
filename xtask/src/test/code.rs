//! The steps that are a cargo command each.

use anyhow::Result;

use super::programs;
use crate::workspace::{Workspace, run};

/// `cargo fmt --all` puts right what this finds, in the folder that it names.
pub fn fmt(ws: &Workspace) -> Result<()> {
    // Workspaces of their own: the firmware with the board support, and the Python package.
    for folder in [".", "firmware/avr", "python"] {
        run(ws.cargo(["fmt", "--all", "--check"]).current_dir(ws.root.join(folder)))?;
    }
    Ok(())
}

/// Lints, in tests and examples too; a warning is an error.
pub fn clippy(ws: &Workspace) -> Result<()> {
    run(&mut ws.cargo(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
}

/// Unit, property and documentation tests. The dev profile on purpose: it is
/// optimised here, and keeps overflow checks and debug assertions on. What drives the command from
/// outside drives the one that ships.
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

/// The tests at the end of each file.
pub fn units_alone(ws: &Workspace) -> Result<()> {
    run(&mut ws.cargo(["test", "--workspace", "--no-fail-fast", "--lib", "--bins"]))
}

/// The texts that the command prints, against those stored.
pub fn golden(ws: &Workspace) -> Result<()> {
    // Of one package alone its dependencies would be built again, with fewer features.
    run(&mut ws.cargo(["test", "--workspace", "--test", "golden"]))
}

/// Documentation, with its links; a warning is an error.
pub fn doc(ws: &Workspace) -> Result<()> {
    run(ws.cargo(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
}

/// The protocol's own fuzz test at length, and that of the pass over assembly: seeded, so that a
/// failure can be repeated, and on the stable toolchain, so that they run on every machine
/// (cargo-fuzz takes a nightly and minutes to install).
/// `STEPWRIGHT_FUZZ_CASES` is how many conversations are tried, `AVR_SHRINK_PROGRAMS` how many
/// programs; without them, in `unit`, they are brief.
pub fn fuzz(ws: &Workspace) -> Result<()> {
    run(ws
        .cargo(["test", "--release", "--package", "stepwright-protocol", "--test", "fuzz"])
        .env("STEPWRIGHT_FUZZ_CASES", "500000"))?;
    run(ws
        .cargo(["test", "--release", "--package", "avr-shrink", "--test", "whole"])
        .env("AVR_SHRINK_PROGRAMS", "5000"))
}
