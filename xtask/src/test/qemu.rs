//! Tests the firmware for 32-bit chips on boards that QEMU simulates.

use anyhow::Result;

use super::programs;
use crate::bench;
use crate::qemu;
use crate::small::SmallBoard;
use crate::workspace::{Workspace, run};

/// Checks that the controller answers and steps like the virtual board, that the step timers keep
/// their contract, and that no figure is worse than the stored one.
pub fn run_tests(ws: &Workspace) -> Result<()> {
    let root = qemu::prepare(ws)?;
    for board in SmallBoard::all(ws)?.iter().filter(|board| board.in_qemu) {
        board.build(ws)?;
    }
    qemu::plugin(ws)?;
    let mut test = qemu::cargo(ws, "test", root.as_deref());
    // Including the plugin's tests.
    let built = programs::build(test.args(["--release", "--workspace"]))?;
    let commands = built.iter().map(|program| {
        let mut command = program.command();
        qemu::tell(ws, &mut command, root.as_deref());
        (program.name.clone(), command)
    });
    programs::run_by_the_clock(commands.collect())?;
    bench::cortex_m(ws, true)?;
    let mut controller = ws.cargo(["test", "--target-dir"]);
    controller.arg(ws.target.join("qemu")).current_dir(ws.root.join("firmware/controller"));
    run(controller.args(["--release", "--lib"]))?;
    // Separate workspaces, which no other step formats. The boards' workspaces are in the step
    // `chips`.
    for folder in ["qemu", "controller"] {
        let folder = ws.root.join("firmware").join(folder);
        run(ws.cargo(["fmt", "--all", "--check"]).current_dir(&folder))?;
    }
    run(qemu::cargo(ws, "clippy", None).args([
        "--release",
        "--workspace",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ]))
}
