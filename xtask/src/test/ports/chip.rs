//! A simulated chip with a program, behind a port, and the command that drives it.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use super::dump::Dump;
use crate::firmware::Board;
use crate::workspace::{Guard, Workspace, line};

/// The time limit: the longest case takes 30 simulated seconds, a fifth of that in real time if
/// nothing else runs.
const LIMIT: Duration = Duration::from_secs(240);
/// The time limit for a simulator to finish its dump.
const END: Duration = Duration::from_secs(20);

/// What a command printed, and its exit status.
pub struct Ended {
    pub status: Option<i32>,
    pub text: String,
}

/// Runs the command with these arguments. Its output goes to a file below `target`.
pub fn command(ws: &Workspace, words: &[&str]) -> Result<Ended> {
    let said = ws.target.join("ports.txt");
    let file = File::create(&said)?;
    let mut command = Command::new(ws.command());
    // Without the user's machine file.
    command.args(words).env("STEPWRIGHT_MACHINE", "none").current_dir(&ws.root);
    command.stdin(Stdio::null());
    command.stdout(file.try_clone()?).stderr(file);
    let child = command.spawn().with_context(|| format!("starting {}", line(&command)))?;
    let status = Guard(child).wait_within(LIMIT)?;
    let text = fs::read_to_string(&said)?;
    match status {
        Some(status) => Ok(Ended { status: status.code(), text }),
        None => bail!("{} does not end:\n{text}", line(&command)),
    }
}

/// Runs the command on a separate terminal, made by `script` of Debian's essential bsdutils. The
/// keys are pressed once the command has printed `begun`, 50 ms apart, like the repeats of a held
/// key.
pub fn typed(ws: &Workspace, words: &[&str], begun: &str, keys: &[&str]) -> Result<Ended> {
    let said = ws.target.join("ports.txt");
    let quoted: Vec<_> = words.iter().map(|word| format!("'{word}'")).collect();
    let words = format!("'{}' {}", ws.command().display(), quoted.join(" "));
    let mut command = Command::new("script");
    command.args(["--quiet", "--return", "--command", &words, "/dev/null"]);
    command.env("STEPWRIGHT_MACHINE", "none").env("TERM", "xterm").current_dir(&ws.root);
    command.stdin(Stdio::piped()).stdout(File::create(&said)?).stderr(Stdio::null());
    let child = command.spawn().with_context(|| format!("starting {}", line(&command)))?;
    let mut child = Guard(child);
    let mut hand = child.0.stdin.take().context("its terminal")?;
    let text = || Ok::<_, anyhow::Error>(String::from_utf8_lossy(&fs::read(&said)?).into_owned());
    let asked = Instant::now();
    while !text()?.contains(begun) {
        if asked.elapsed() > LIMIT {
            bail!("{words} does not say {begun:?}:\n{}", text()?);
        }
        sleep(Duration::from_millis(20));
    }
    for key in keys {
        hand.write_all(key.as_bytes())?;
        sleep(Duration::from_millis(50));
    }
    // The input stays open until the command has ended, because its end counts as a key.
    match child.wait_within(LIMIT)? {
        Some(status) => Ok(Ended { status: status.code(), text: text()? }),
        None => bail!("{words} does not end:\n{}", text()?),
    }
}

/// A running simulator.
pub struct SimChip {
    sim: Guard,
    /// The output of its summary.
    _out: BufReader<ChildStdout>,
    port: String,
    dump: PathBuf,
}

impl SimChip {
    /// Switches on a board with the program `elf` and these limit switches, as fast as this machine
    /// can.
    pub fn new(
        ws: &Workspace,
        sim: &Path,
        board: Board,
        elf: &Path,
        switches: &[&str],
    ) -> Result<SimChip> {
        let dump = ws.target.join("ports-chip.vcd");
        let mut command = Command::new(sim);
        command.arg(board.name()).arg("--elf").arg(elf).arg("--fast").arg("--vcd").arg(&dump);
        for switch in switches {
            command.args(["--switch", switch]);
        }
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let child = command.spawn().with_context(|| format!("starting {}", line(&command)))?;
        let mut sim = Guard(child);
        let mut out = BufReader::new(sim.0.stdout.take().context("the simulator's output")?);
        let mut said = String::new();
        out.read_line(&mut said)?;
        let Some(port) = said.trim_end().strip_prefix("pty ") else {
            bail!("the simulator says no port, but {said:?}");
        };
        Ok(SimChip { port: port.to_owned(), sim, _out: out, dump })
    }

    /// The port for the command.
    pub fn port(&self) -> &str {
        &self.port
    }

    /// Switches the board off. Returns the dump of its pins.
    pub fn end(mut self) -> Result<Dump> {
        let mut acts = self.sim.0.stdin.take().context("the simulator's input")?;
        writeln!(acts, "end")?;
        match self.sim.wait_within(END)? {
            Some(status) if status.success() => Dump::read(&self.dump),
            Some(status) => bail!("the simulator: {status}"),
            None => bail!("the simulator does not end"),
        }
    }
}
