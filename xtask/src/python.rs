//! A Python with pyserial, in a virtual environment of its own: `target/venv`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::workspace::{Workspace, run, succeeds};

/// Pinned, and the same for a person who follows the example by hand.
const REQUIREMENTS: &str = "examples/requirements.txt";

/// A Python that can make virtual environments: the user's, else Debian's.
pub fn base() -> Option<&'static str> {
    let able = |python: &&str| succeeds(python, &["-c", "import venv, ensurepip"]);
    ["python3", "/usr/bin/python3"].into_iter().find(able)
}

/// The environment's interpreter.
pub fn interpreter(ws: &Workspace) -> PathBuf {
    ws.target.join("venv/bin/python")
}

/// Whether the environment works and holds what `examples/requirements.txt`
/// asks for today.
fn ready(ws: &Workspace) -> bool {
    let read = |path: &Path| fs::read(path).ok();
    let asked = read(&ws.root.join(REQUIREMENTS));
    asked.is_some()
        && asked == read(&stamp(ws))
        && succeeds(interpreter(ws), &["-c", "import serial"])
}

/// Makes the environment, unless it is ready.
pub fn prepare(ws: &Workspace) -> Result<()> {
    if ready(ws) {
        return Ok(());
    }
    let base = base().context("no Python that can make virtual environments")?;
    run(Command::new(base).args(["-m", "venv", "--clear"]).arg(ws.target.join("venv")))?;
    let requirements = ws.root.join(REQUIREMENTS);
    run(Command::new(interpreter(ws))
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"])
        .arg(&requirements))?;
    // Last, so that an install that was cut short is done again.
    fs::copy(&requirements, stamp(ws))?;
    ensure!(ready(ws), "{} can't import serial", interpreter(ws).display());
    Ok(())
}

/// A copy of the requirements that the environment was made from.
fn stamp(ws: &Workspace) -> PathBuf {
    ws.target.join("venv/requirements.txt")
}
