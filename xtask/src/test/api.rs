//! Schemathesis tests the API of `stepwright serve` with all requests that its description permits,
//! and others.

use std::process::Command;
use std::time::Duration;

use anyhow::Result;

use crate::python;
use crate::workspace::{Workspace, run_within};

/// The time limit; it takes half a minute on an idle machine.
const LIMIT: Duration = Duration::from_secs(600);

/// Checks that nothing moves without control, and that every answer is as described.
pub fn run(ws: &Workspace) -> Result<()> {
    python::API.prepare(ws)?;
    let command = ws.shipped()?;
    let mut check = Command::new(python::API.interpreter(ws));
    check.current_dir(&ws.target).arg(ws.root.join("crates/stepwright-serve/tests/api/check.py"));
    run_within(LIMIT, check.arg(command))
}
