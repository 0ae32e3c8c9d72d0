//! Tests the firmware for a Pico in rp2040js, processor and PIO in lock-step, and its words for the
//! PIO in a second emulator.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::node::RP2040JS;
use crate::python::PIO;
use crate::qemu;
use crate::senders::{self, On};
use crate::setup::{self, Need};
use crate::small::SmallBoard;
use crate::workspace::{Workspace, run as carry_out};

/// The needs of this step.
pub const NEEDS: &[&Need] = &[setup::CROSS, setup::NODE, setup::PYTHON];

/// The number of words that the second emulator plays: it takes some seconds for a thousand.
const WORDS: &str = "10000";

/// The chords of a sender's job: some five seconds of the Pico's time.
const CHORDS: u32 = 200;

/// Checks edges at the computed cycle, halts and stops with exact counts, and the controller's
/// transcripts.
pub fn run(ws: &Workspace) -> Result<()> {
    RP2040JS.prepare(ws)?;
    PIO.prepare(ws)?;
    SmallBoard::named(ws, "rp2040")?.build(ws)?;
    let folder = ws.root.join("firmware/rp2040");
    let (programs, words) = (ws.target.join("firmware"), ws.target.join("pico-words.json"));
    for script in ["controller.cjs", "pico.cjs"] {
        let mut node = Command::new("node");
        node.env("NODE_PATH", RP2040JS.modules(ws)).arg(folder.join("test").join(script));
        carry_out(node.arg(&programs).arg(&words))?;
    }
    selftest(ws, &programs)?;
    streams(ws, &programs)?;
    let mut second = Command::new(PIO.interpreter(ws));
    carry_out(second.arg(folder.join("test/second_opinion.py")).arg(&words).arg(WORDS))?;
    // A separate workspace, which no other step formats.
    carry_out(ws.cargo(["fmt", "--all", "--check"]).current_dir(&folder))?;
    let mut host = ws.cargo(["test", "--lib", "--target-dir"]);
    carry_out(host.arg(ws.target.join("rp2040-host")).current_dir(&folder))
}

/// Tests streamed runs: the edges are those of the virtual board, the Pico brakes by itself, and
/// the command runs a job on it.
fn streams(ws: &Workspace, programs: &Path) -> Result<()> {
    let (script, modules) = (ws.root.join("firmware/rp2040/test"), RP2040JS.modules(ws));
    let mut test = qemu::cargo(ws, "test", None);
    test.env("STEPWRIGHT_PICO", script.join("stream.cjs")).env("NODE_PATH", &modules);
    carry_out(test.args(["--release", "--test", "pico", "--", "--ignored", "--test-threads=2"]))?;
    let command = ws.shipped()?;
    let mut job = Command::new(PIO.interpreter(ws));
    job.env("NODE_PATH", &modules).arg(script.join("job.py"));
    job.arg(command).arg(programs).arg(script.join("job.nc"));
    carry_out(job.args(["--jerk", "10000mm/s3"]))?;
    senders::on_board(ws, On::Pico, CHORDS)
}

/// The command that starts a Pico with the stream program. The path of a file for its time must be
/// appended.
pub fn in_its_own_time(ws: &Workspace) -> Vec<OsString> {
    let script = ws.root.join("firmware/rp2040/test/stream.cjs");
    vec!["node".into(), script.into(), ws.target.join("firmware").into(), "0".into()]
}

/// Checks that the self-test's line agrees with the pins, that the command accepts it, and that it
/// refuses a line with an edge less.
fn selftest(ws: &Workspace, programs: &Path) -> Result<()> {
    let line = ws.target.join("pico-selftest.txt");
    let mut node = Command::new("node");
    node.env("NODE_PATH", RP2040JS.modules(ws));
    node.arg(ws.root.join("firmware/rp2040/test/selftest.cjs"));
    carry_out(node.arg(programs).arg(&line))?;
    let judge = |file: PathBuf| -> Result<Command> {
        let mut command = Command::new(ws.shipped()?);
        command.arg("selftest").arg(fs::read_to_string(file)?.trim());
        Ok(command)
    };
    carry_out(&mut judge(line.clone())?)?;
    let refused = judge(line.with_extension("txt.spoilt"))?.output()?;
    let said = String::from_utf8_lossy(&refused.stderr);
    ensure!(
        refused.status.code() == Some(1) && said.contains("edges were captured on STEP"),
        "an edge that is missing is not refused: {said}"
    );
    Ok(())
}
