//! Schemathesis asks the API of `stepwright serve` all that its description allows, and more.

use std::process::Command;
use std::time::Duration;

use anyhow::Result;

use crate::python;
use crate::workspace::{Workspace, run_within};

/// Half a minute on an idle machine.
const LIMIT: Duration = Duration::from_secs(600);

/// Nothing moves without control, and every answer is as described.
pub fn run(ws: &Workspace) -> Result<()> {
    python::API.prepare(ws)?;
    let command = ws.shipped()?;
    let mut check = Command::new(python::API.interpreter(ws));
    check.current_dir(&ws.target).arg(ws.root.join("crates/stepwright-serve/tests/api/check.py"));
    run_within(LIMIT, check.arg(command))
}
