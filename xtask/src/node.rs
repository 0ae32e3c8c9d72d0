//! Packages of npm for Node, each set in a separate folder under `target`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::workspace::{Workspace, alone_in, run, succeeds};

/// Packages that are installed together. Their versions are pinned: `npm ci` takes exactly those.
pub struct Packages {
    /// Their folder under `target`.
    name: &'static str,
    /// The folder of their two files.
    folder: &'static str,
}

/// avr8js, which simulates what simavr does not.
pub const AVR8JS: Packages = Packages { name: "avr8js", folder: "firmware/rig/avr8js" };

/// rp2040js, which simulates a Pico.
pub const RP2040JS: Packages = Packages { name: "rp2040js", folder: "firmware/rp2040/test" };

/// Playwright, which drives a browser.
pub const PLAYWRIGHT: Packages =
    Packages { name: "playwright", folder: "crates/stepwright-serve/tests/page" };

/// CNCjs, which sends G-code.
pub const CNCJS: Packages =
    Packages { name: "cncjs", folder: "crates/stepwright-cli/tests/senders" };

/// Pyright, which checks types in Python.
pub const PYRIGHT: Packages = Packages { name: "pyright", folder: "python/tests/pyright" };

const FILES: [&str; 2] = ["package.json", "package-lock.json"];

/// Whether there is a suitable Node with npm.
pub fn found() -> bool {
    let new = "process.exit(Number(process.versions.node.split('.')[0]) >= 18 ? 0 : 1)";
    succeeds("node", &["-e", new]) && succeeds("npm", &["--version"])
}

impl Packages {
    /// The folder of the modules, for `NODE_PATH`.
    pub fn modules(&self, ws: &Workspace) -> PathBuf {
        ws.target.join(self.name).join("node_modules")
    }

    /// Whether the installed packages are those that the repository requires now.
    fn ready(&self, ws: &Workspace) -> bool {
        let read = |path: &Path| fs::read(path).ok();
        let here = |file: &str| read(&ws.root.join(self.folder).join(file));
        // npm writes this file last.
        self.modules(ws).join(".package-lock.json").is_file()
            && FILES.iter().all(|file| {
                here(file).is_some() && here(file) == read(&ws.target.join(self.name).join(file))
            })
    }

    /// Installs the packages, unless they are installed.
    pub fn prepare(&self, ws: &Workspace) -> Result<()> {
        let folder = ws.target.join(self.name);
        // Steps of both lanes may install the same packages.
        let _alone = alone_in(&folder)?;
        if self.ready(ws) {
            return Ok(());
        }
        for file in FILES {
            fs::copy(ws.root.join(self.folder).join(file), folder.join(file))?;
        }
        run(Command::new("npm").current_dir(&folder).args(["ci", "--no-audit", "--no-fund"]))?;
        ensure!(self.ready(ws), "npm has not installed {} into {}", self.name, folder.display());
        Ok(())
    }
}
