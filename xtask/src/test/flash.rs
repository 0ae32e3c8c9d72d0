//! `stepwright flash` writes a whole firmware through a real boot loader on the simulated chip.

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::firmware::{Board, Build};
use crate::rig;
use crate::setup::BOOT_LOADER;
use crate::workspace::{self, Guard, Workspace, output, run_within};

/// A chip that is simulated in real time takes half a minute, a loaded machine longer.
const LIMIT: Duration = Duration::from_secs(300);

/// The boot loader listens for a moment after a reset: the button is pressed so often.
const PRESSES: usize = 4;

/// Writes, compares, and then the firmware answers.
pub fn run(ws: &Workspace) -> Result<()> {
    // The simulator asks for one.
    Build { board: Board::Uno, timer: 1, bench: false }.controller(ws)?;
    let sim = rig::program(ws, "sim")?;
    workspace::run(&mut ws.cargo(["build", "--package", "stepwright-cli"]))?;
    let mut sim = Command::new(sim);
    rig::with_firmware(ws, &mut sim);
    sim.args(["uno", "--boot-loader", BOOT_LOADER]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut sim = Guard(sim.spawn().context("starting the simulator")?);
    let mut acts = sim.0.stdin.take().context("the simulator has no stdin")?;
    let mut stdout = BufReader::new(sim.0.stdout.take().context("the simulator has no stdout")?);
    let mut first = String::new();
    stdout.read_line(&mut first)?;
    let Some(port) = first.trim_end().strip_prefix("pty ") else {
        bail!("the simulator's first line is {first:?}, not `pty PATH`");
    };
    let stepwright = ws.built("stepwright");
    let order = |words: &[&str]| {
        let mut command = Command::new(&stepwright);
        command.args(words).args(["--port", port]).env("STEPWRIGHT_MACHINE", "none");
        command
    };
    // By its own client: avrdude can't press reset on a pseudo-terminal, and whether it comes
    // in the moment in which the boot loader listens depends on the machine's load.
    for press in 1.. {
        writeln!(acts, "reset")?;
        match run_within(LIMIT, &mut order(&["flash", "nano", "--old-boot-loader", "--own"])) {
            Ok(()) => break,
            Err(error) if press == PRESSES => return Err(error),
            Err(error) => println!("again: {error}"),
        }
    }
    let status = output(&mut order(&["status"]))?;
    print!("{status}");
    if !status.contains("board       stepwright ") {
        bail!("what was written does not answer as the firmware does");
    }
    Ok(())
}
