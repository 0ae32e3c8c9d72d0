//! Runs the numbered examples (`01_first_steps.rs` …) to their end.

use std::fs;
use std::process::Command;
use std::time::Duration;

use anyhow::{Result, ensure};
use serde_json::Value;

use crate::workspace::{self, Workspace, run_within};

/// The time limit: an example is to be read and tried, so it must be quick.
const LIMIT: Duration = Duration::from_secs(60);

/// Builds all examples, and runs the numbered ones in order in a separate folder, which takes the
/// files that they write.
pub fn run(ws: &Workspace) -> Result<()> {
    let names = numbered(&ws.metadata);
    ensure!(!names.is_empty(), "no package has a numbered example (examples/01_name.rs)");
    workspace::run(&mut ws.cargo(["build", "--workspace", "--examples"]))?;
    let folder = ws.target.join("xtask/examples");
    fs::create_dir_all(&folder)?;
    for name in names {
        let program = ws.built("examples").join(name);
        run_within(LIMIT, Command::new(program).current_dir(&folder))?;
    }
    Ok(())
}

/// The names of all examples that begin with two digits and `_`, sorted.
fn numbered(metadata: &Value) -> Vec<&str> {
    let mut names: Vec<&str> = list(&metadata["packages"])
        .flat_map(|package| list(&package["targets"]))
        .filter(|target| list(&target["kind"]).any(|kind| kind == "example"))
        .filter_map(|target| target["name"].as_str())
        .filter(|name| matches!(name.as_bytes(), [b'0'..=b'9', b'0'..=b'9', b'_', ..]))
        .collect();
    names.sort_unstable();
    names
}

/// The items of a JSON list; none for any other value.
fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_numbered_examples_run_and_in_order() {
        let target = |kind: &str, name: &str| serde_json::json!({ "kind": [kind], "name": name });
        let metadata = serde_json::json!({ "packages": [
            { "targets": [target("example", "02_plan"), target("example", "helper")] },
            { "targets": [target("example", "01_move"), target("test", "03_not_one")] },
        ] });
        assert_eq!(numbered(&metadata), ["01_move", "02_plan"]);
        assert!(numbered(&serde_json::json!({})).is_empty());
    }
}
