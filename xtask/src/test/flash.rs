//! Tests that `stepwright flash` writes complete firmwares through real boot loaders on the
//! simulated chips.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::firmware::{Board, Build};
use crate::rig;
use crate::setup::{MEGA_LOADER, NANO_LOADER};
use crate::workspace::{Guard, Workspace, output, run_within};

/// The time limit: a chip that is simulated in real time takes half a minute, on a loaded machine
/// longer.
const LIMIT: Duration = Duration::from_secs(300);

/// How often the reset button is pressed; the boot loader listens for a moment after a reset.
const PRESSES: usize = 4;

/// A board with a boot loader.
struct Case {
    /// The simulator's name of the board.
    chip: &'static str,
    boot_loader: &'static str,
    /// The arguments after `stepwright flash`.
    words: &'static [&'static str],
    /// The command to the firmware afterwards, and a part of its answer.
    asked: &'static [&'static str],
    answer: &'static str,
}

const CASES: [Case; 2] = [
    Case {
        chip: "uno",
        boot_loader: NANO_LOADER,
        words: &["nano", "--old-boot-loader", "--program", "timed"],
        asked: &["timed", "--speed", "100", "--steps", "10"],
        answer: "0x10 REACHED",
    },
    Case {
        chip: "mega",
        boot_loader: MEGA_LOADER,
        words: &["mega"],
        asked: &["status"],
        answer: "board       stepwright ",
    },
];

/// Writes and compares the firmware, and checks that it answers.
pub fn run(ws: &Workspace) -> Result<()> {
    // The simulator needs a firmware.
    Build { board: Board::Uno, timer: 1, bench: false }.controller(ws)?;
    let sim = rig::program(ws, "sim")?;
    ws.shipped()?;
    CASES.iter().try_for_each(|case| through(ws, &sim, case).context(case.chip))
}

fn through(ws: &Workspace, sim: &Path, case: &Case) -> Result<()> {
    let mut sim = Command::new(sim);
    rig::with_firmware(ws, &mut sim);
    sim.args([case.chip, "--boot-loader", case.boot_loader]);
    sim.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut sim = Guard(sim.spawn().context("starting the simulator")?);
    let mut acts = sim.0.stdin.take().context("the simulator has no stdin")?;
    let mut stdout = BufReader::new(sim.0.stdout.take().context("the simulator has no stdout")?);
    let mut first = String::new();
    stdout.read_line(&mut first)?;
    let Some(port) = first.trim_end().strip_prefix("pty ") else {
        bail!("the simulator's first line is {first:?}, not `pty PATH`");
    };
    let stepwright = ws.command();
    let order = |words: &[&str]| {
        let mut command = Command::new(&stepwright);
        command.args(words).args(["--port", port]).env("STEPWRIGHT_MACHINE", "none");
        command
    };
    // Uses the command's own client, because avrdude can't press reset on a pseudo-terminal.
    // Whether the client hits the moment in which the boot loader listens depends on the machine's
    // load.
    for press in 1.. {
        writeln!(acts, "reset")?;
        match run_within(LIMIT, order(&["flash", "--own"]).args(case.words)) {
            Ok(()) => break,
            Err(error) if press == PRESSES => return Err(error),
            Err(error) => println!("again: {error}"),
        }
    }
    let answer = output(&mut order(case.asked))?;
    print!("{answer}");
    if !answer.contains(case.answer) {
        bail!("what was written does not answer as the firmware does");
    }
    Ok(())
}
