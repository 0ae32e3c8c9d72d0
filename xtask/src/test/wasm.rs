//! Checks that the page's planner agrees with the host's, delay for delay, that its virtual board
//! agrees with the command's, tick for tick, and that its host library drives that board.

use std::fs::{self, File};
use std::process::{Command, Stdio};

use anyhow::{Result, ensure};

use crate::wasm;
use crate::workspace::{Workspace, line, output, run};

/// The moves of each law.
const MOVES: &str = "10000";

/// Checks that the carried modules were built from the present code, import nothing from the page,
/// and tolerate any number; that the first plans like the host, the second is the board of the
/// command, and the third moves it.
pub fn run_tests(ws: &Workspace) -> Result<()> {
    wasm::check(ws)?;
    let folder = ws.target.join("wasm");
    fs::create_dir_all(&folder)?;
    let list = folder.join("moves.jsonl");
    let mut moves =
        ws.cargo(["run", "--package", "stepwright-wasm", "--example", "01_moves", "--", MOVES]);
    eprintln!("$ {} > {}", line(&moves), list.display());
    let status = moves.stdin(Stdio::null()).stdout(File::create(&list)?).status()?;
    ensure!(status.success(), "no moves: {status}");
    let script = ws.root.join("crates/stepwright-wasm/tests/equal.mjs");
    run(Command::new("node").arg(script).arg(wasm::PLAN.place(ws)).arg(list).arg(MOVES))?;
    let command = ws.shipped()?;
    let script = ws.root.join("crates/stepwright-wasm-board/tests/equal.mjs");
    run(Command::new("node").arg(script).arg(wasm::BOARD.place(ws)).arg(command))?;
    let host = ws.root.join("crates/stepwright-wasm-host");
    let said = output(Command::new("node").arg(host.join("examples/19_in_javascript.mjs")))?;
    ensure!(said == "reached 2000\n", "the example of the host library says {said}");
    run(Command::new("node").arg(host.join("tests/stands.mjs")))
}
