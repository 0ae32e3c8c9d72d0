//! Tests the firmwares on the simulated chip, and their figures.

use anyhow::{Context, Result};

use super::programs;
use crate::firmware::{Board, Build};
use crate::workspace::{Workspace, run};
use crate::{bench, node, rig};

/// Runs the same tests on both chips, and some of them on the Mega's other timers.
pub fn run_tests(ws: &Workspace) -> Result<()> {
    node::AVR8JS.prepare(ws)?;
    // One test lets the command talk to the chip.
    ws.shipped()?;
    for board in [Board::Uno, Board::Mega] {
        rig::firmware(ws, board, false)?;
    }
    for timer in TIMERS {
        Build { board: Board::Mega, timer, bench: false }.controller(ws)?;
    }
    let built = programs::build(rig::cargo(ws, "test").arg("--release"))?;
    let mut commands = Vec::new();
    for program in &built {
        for board in [Board::Uno, Board::Mega] {
            let mut command = program.command();
            rig::with_firmware(ws, &mut command);
            command.env("STEPWRIGHT_BOARD", board.name());
            command.env("STEPWRIGHT_COMMAND", ws.command());
            command.env("STEPWRIGHT_NODE_MODULES", node::AVR8JS.modules(ws));
            commands.push((format!("{}, {}", program.name, board.name()), command));
        }
    }
    // Another step timer has other registers and another vector, and all else is the same. The
    // tests of every edge and of the line cover that.
    for timer in TIMERS {
        for name in ["rig virtual_board", "rig conversation"] {
            let program = built.iter().find(|program| program.name == name);
            let mut command = program.with_context(|| format!("no test {name}"))?.command();
            rig::with_firmware(ws, &mut command);
            command.env("STEPWRIGHT_BOARD", Board::Mega.name());
            command.env("STEPWRIGHT_TIMER", timer.to_string());
            commands.push((format!("{name}, mega, timer {timer}"), command));
        }
    }
    programs::run(commands)?;
    // A separate workspace, which no other step formats.
    run(rig::cargo(ws, "clippy").args(["--release", "--all-targets", "--", "-D", "warnings"]))?;
    let mut fmt = ws.cargo(["fmt", "--all", "--check"]);
    run(fmt.current_dir(ws.root.join("firmware/rig")))
}

/// The Mega's other 16-bit timers.
const TIMERS: [u8; 3] = [3, 4, 5];

/// Runs the conversation with a simulated Uno only.
pub fn run_one(ws: &Workspace) -> Result<()> {
    let build = Build { board: Board::Uno, timer: 1, bench: false };
    build.controller(ws)?;
    let mut cargo = rig::cargo(ws, "test");
    cargo.args(["--release", "--test", "conversation"]);
    run(cargo.env("STEPWRIGHT_BOARD", Board::Uno.name()))
}

/// Checks that no figure is worse than the stored one.
pub fn run_bench(ws: &Workspace) -> Result<()> {
    bench::avr(ws, true)
}
