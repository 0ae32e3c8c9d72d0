//! `cargo xtask rs274`: compares the moves of LinuxCNC's example files by its interpreter and by
//! this project's reader.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, ensure};

use crate::setup::{self, LINUXCNC, LINUXCNC_FILES};
use crate::workspace::{Workspace, output, run};

/// Compare our G-code reader with LinuxCNC's interpreter, over its example files.
#[derive(clap::Args)]
pub struct Rs274 {}

impl Rs274 {
    /// Installs LinuxCNC if it is missing, and runs the test of the reader on its files.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        setup::ensure(&[LINUXCNC])?;
        let files = output(Command::new("dpkg-query").args(LINUXCNC_FILES))?;
        let is_job = |name: &&str| name.ends_with(".ngc") && Path::new(name).is_file();
        let jobs: Vec<_> = files.lines().filter(is_job).collect();
        ensure!(!jobs.is_empty(), "linuxcnc-uspace has no .ngc file");
        let mut test = ws.cargo(["test", "--package", "stepwright-gcode", "--test", "rs274"]);
        run(test.args(["--", "--nocapture"]).env("STEPWRIGHT_NGC_FILES", jobs.join("\n")))
    }
}
