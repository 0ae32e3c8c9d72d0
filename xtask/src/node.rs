//! A Node with avr8js, which simulates what simavr does not: `target/avr8js`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, ensure};

use crate::workspace::{Workspace, run, succeeds};

/// What is installed, pinned: `npm ci` takes exactly that.
const FOLDER: &str = "firmware/rig/avr8js";
const FILES: [&str; 2] = ["package.json", "package-lock.json"];

/// Whether there is a Node that avr8js runs on, with its npm.
pub fn found() -> bool {
    let new = "process.exit(Number(process.versions.node.split('.')[0]) >= 18 ? 0 : 1)";
    succeeds("node", &["-e", new]) && succeeds("npm", &["--version"])
}

/// Where the modules are, for `STEPWRIGHT_NODE_MODULES`.
pub fn modules(ws: &Workspace) -> PathBuf {
    ws.target.join("avr8js/node_modules")
}

/// Whether what is installed is what the repository asks for today.
fn ready(ws: &Workspace) -> bool {
    let read = |path: &Path| fs::read(path).ok();
    let here = |file: &str| read(&ws.root.join(FOLDER).join(file));
    // npm's own stamp, which it writes last.
    modules(ws).join(".package-lock.json").is_file()
        && FILES.iter().all(|file| {
            here(file).is_some() && here(file) == read(&ws.target.join("avr8js").join(file))
        })
}

/// Installs avr8js, unless it is there.
pub fn prepare(ws: &Workspace) -> Result<()> {
    if ready(ws) {
        return Ok(());
    }
    let folder = ws.target.join("avr8js");
    fs::create_dir_all(&folder)?;
    for file in FILES {
        fs::copy(ws.root.join(FOLDER).join(file), folder.join(file))?;
    }
    run(Command::new("npm").current_dir(&folder).args(["ci", "--no-audit", "--no-fund"]))?;
    ensure!(ready(ws), "npm has not installed avr8js into {}", folder.display());
    Ok(())
}
