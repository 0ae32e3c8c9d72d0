//! The firmware for chips of 32 bits on boards that QEMU simulates.

use anyhow::Result;

use super::programs;
use crate::bench;
use crate::qemu;
use crate::small::SmallBoard;
use crate::workspace::{Workspace, run};

/// The controller answers and steps as the virtual board, and the step timers keep their contract;
/// no figure is worse than the stored one.
pub fn run_tests(ws: &Workspace) -> Result<()> {
    let root = qemu::prepare(ws)?;
    for board in SmallBoard::all(ws)?.iter().filter(|board| board.in_qemu) {
        board.build(ws)?;
    }
    qemu::plugin(ws)?;
    let mut test = qemu::cargo(ws, "test", root.as_deref());
    // The plugin's too.
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
    // Workspaces of their own: nothing else looks at their style. The boards' is the step `chips`.
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
