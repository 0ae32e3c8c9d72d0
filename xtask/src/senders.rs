//! Foreign senders of G-code drive `stepwright grbl`.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::Result;

use crate::node;
use crate::python;
use crate::setup::{self, Need};
use crate::workspace::{Workspace, run, run_within};

/// What they run on.
pub const NEEDS: &[&Need] = &[setup::PYTHON, setup::NODE];

/// Each sender moves motors in real time.
const LIMIT: Duration = Duration::from_secs(900);

/// Lines of a job in the tests.
const FEW: u32 = 800;

/// Have foreign senders of G-code run a job each on `stepwright grbl`
#[derive(clap::Args)]
pub struct Senders {
    /// Which; all if none is named: pygrbl-streamer, grbl-streamer, gantrix,
    /// grbl-link, cncjs, bcnc
    sender: Vec<String>,
    /// Lines of the job
    #[arg(long, default_value_t = 5_000)]
    lines: u32,
    /// A board that plays streams has the motors, also `cargo xtask sim uno --program stream`
    #[arg(long, value_name = "PATH")]
    port: Option<PathBuf>,
}

impl Senders {
    /// Runs them, one after another.
    pub fn run(&self, ws: &Workspace) -> Result<()> {
        setup::ensure(NEEDS)?;
        if self.sender.is_empty() || self.sender.iter().any(|name| name == "bcnc") {
            setup::ensure(&[setup::BCNC])?;
        }
        drive(ws, self.lines, &self.sender, self.port.as_deref())
    }
}

/// Two of them, with a short job.
pub fn test(ws: &Workspace) -> Result<()> {
    drive(ws, FEW, &["pygrbl-streamer".to_owned(), "cncjs".to_owned()], None)
}

fn drive(ws: &Workspace, lines: u32, senders: &[String], port: Option<&Path>) -> Result<()> {
    python::SENDERS.prepare(ws)?;
    node::CNCJS.prepare(ws)?;
    run(&mut ws.cargo(["build", "--package", "stepwright-cli"]))?;
    let script = ws.root.join("crates/stepwright-cli/tests/senders/senders.py");
    let mut python = Command::new(python::SENDERS.interpreter(ws));
    python.arg(script).arg(ws.built("stepwright")).arg(lines.to_string()).args(senders);
    if let Some(port) = port {
        python.env("STEPWRIGHT_PORT", port);
    }
    run_within(LIMIT, python.env("NODE_PATH", node::CNCJS.modules(ws)))
}
