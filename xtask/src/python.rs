//! Python packages, each set in a separate virtual environment under `target`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::workspace::{Workspace, alone_in, run, succeeds};

/// A virtual environment.
pub struct Environment {
    /// Its folder under `target`.
    name: &'static str,
    /// The file of its pinned packages, which a user can install from as well.
    requirements: &'static str,
    /// A module that it contains.
    module: &'static str,
}

/// pyserial, for masters in Python.
pub const SERIAL: Environment =
    Environment { name: "venv", requirements: "examples/requirements.txt", module: "serial" };

/// An emulator of the Pico's PIO.
pub const PIO: Environment = Environment {
    name: "venv-pio",
    requirements: "firmware/rp2040/test/requirements.txt",
    module: "pioemu",
};

/// Senders of G-code.
pub const SENDERS: Environment = Environment {
    name: "venv-senders",
    requirements: "crates/stepwright-cli/tests/senders/requirements.txt",
    module: "pygrbl_streamer",
};

/// Schemathesis, which tests the API of `stepwright serve`.
pub const API: Environment = Environment {
    name: "venv-api",
    requirements: "crates/stepwright-serve/tests/api/requirements.txt",
    module: "schemathesis",
};

/// The tools that build and test the wheel of `python/`.
pub const MOTION: Environment = Environment {
    name: "venv-motion",
    requirements: "python/tests/requirements.txt",
    module: "maturin",
};

/// A Python that can make virtual environments: the user's, else Debian's.
pub fn base() -> Option<&'static str> {
    let able = |python: &&str| succeeds(python, &["-c", "import venv, ensurepip"]);
    ["python3", "/usr/bin/python3"].into_iter().find(able)
}

/// Makes an empty virtual environment. Returns its interpreter.
pub fn clean(ws: &Workspace, name: &str) -> Result<PathBuf> {
    let base = base().context("no Python that can make virtual environments")?;
    let folder = ws.target.join(name);
    run(Command::new(base).args(["-m", "venv", "--clear"]).arg(&folder))?;
    Ok(folder.join("bin/python"))
}

impl Environment {
    /// Its interpreter.
    pub fn interpreter(&self, ws: &Workspace) -> PathBuf {
        ws.target.join(self.name).join("bin/python")
    }

    /// Whether it works and has the packages that are required now.
    fn ready(&self, ws: &Workspace) -> bool {
        let read = |path: &Path| fs::read(path).ok();
        let asked = read(&ws.root.join(self.requirements));
        asked.is_some()
            && asked == read(&self.stamp(ws))
            && succeeds(self.interpreter(ws), &["-c", &format!("import {}", self.module)])
    }

    /// Makes the environment, unless it is ready.
    pub fn prepare(&self, ws: &Workspace) -> Result<()> {
        // Steps of both lanes may make the same environment. The lock is outside its folder, which
        // `clean` removes.
        let _alone = alone_in(&ws.target.join("xtask").join(self.name))?;
        if self.ready(ws) {
            return Ok(());
        }
        clean(ws, self.name)?;
        let requirements = ws.root.join(self.requirements);
        run(Command::new(self.interpreter(ws))
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"])
            .arg(&requirements))?;
        // Copied last, so that an interrupted install is repeated.
        fs::copy(&requirements, self.stamp(ws))?;
        ensure!(self.ready(ws), "{} can't import {}", self.interpreter(ws).display(), self.module);
        Ok(())
    }

    /// A copy of the requirements that the environment was made from.
    fn stamp(&self, ws: &Workspace) -> PathBuf {
        ws.target.join(self.name).join("requirements.txt")
    }
}
