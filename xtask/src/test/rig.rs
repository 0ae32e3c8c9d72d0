//! The firmwares do what they should on the simulated chip, and their figures
//! hold.

use anyhow::Result;

use crate::firmware::{Board, Build};
use crate::workspace::{Workspace, run};
use crate::{bench, node, rig};

/// The same tests on both chips, and some of them on the Mega's other timers.
pub fn run_tests(ws: &Workspace) -> Result<()> {
    node::AVR8JS.prepare(ws)?;
    // One of them has the command talk to the chip.
    run(&mut ws.cargo(["build", "--package", "stepwright-cli"]))?;
    for board in [Board::Uno, Board::Mega] {
        rig::firmware(ws, board, false)?;
        let mut cargo = rig::cargo(ws, "test");
        cargo.args(["--release", "--no-fail-fast"]).env("STEPWRIGHT_BOARD", board.name());
        cargo.env("STEPWRIGHT_COMMAND", ws.built("stepwright"));
        run(cargo.env("STEPWRIGHT_NODE_MODULES", node::AVR8JS.modules(ws)))?;
    }
    // Another step timer is other registers and another vector, and all else is
    // the same: what looks at every edge, and the line, tell.
    for timer in [3, 4, 5] {
        let build = Build { board: Board::Mega, timer, bench: false };
        build.controller(ws)?;
        let mut cargo = rig::cargo(ws, "test");
        cargo.args([
            "--release",
            "--no-fail-fast",
            "--test",
            "virtual_board",
            "--test",
            "conversation",
        ]);
        cargo.env("STEPWRIGHT_BOARD", Board::Mega.name());
        run(cargo.env("STEPWRIGHT_TIMER", timer.to_string()))?;
    }
    // It is a workspace of its own: nothing else looks at its style.
    run(rig::cargo(ws, "clippy").args(["--release", "--all-targets", "--", "-D", "warnings"]))?;
    let mut fmt = ws.cargo(["fmt", "--all", "--check"]);
    run(fmt.current_dir(ws.root.join("firmware/rig")))
}

/// The conversation with a simulated Uno alone.
pub fn run_one(ws: &Workspace) -> Result<()> {
    let build = Build { board: Board::Uno, timer: 1, bench: false };
    build.controller(ws)?;
    let mut cargo = rig::cargo(ws, "test");
    cargo.args(["--release", "--test", "conversation"]);
    run(cargo.env("STEPWRIGHT_BOARD", Board::Uno.name()))
}

/// No figure is worse than the stored one.
pub fn run_bench(ws: &Workspace) -> Result<()> {
    bench::avr(ws, true)
}
