//! The firmwares do what they should on the simulated chip, and their figures
//! hold.

use anyhow::Result;

use crate::firmware::Board;
use crate::workspace::{Workspace, run};
use crate::{bench, rig};

/// The same tests on both chips.
pub fn run_tests(ws: &Workspace) -> Result<()> {
    for board in [Board::Uno, Board::Mega] {
        rig::firmware(ws, board, false)?;
        run(rig::cargo(ws, "test").arg("--release").env("STEPWRIGHT_BOARD", board.name()))?;
    }
    // It is a workspace of its own: nothing else looks at its style.
    run(rig::cargo(ws, "clippy").args(["--release", "--all-targets", "--", "-D", "warnings"]))?;
    let mut fmt = ws.cargo(["fmt", "--all", "--check"]);
    run(fmt.current_dir(ws.root.join("firmware/rig")))
}

/// No figure is worse than the stored one.
pub fn run_bench(ws: &Workspace) -> Result<()> {
    bench::avr(ws, true)
}
