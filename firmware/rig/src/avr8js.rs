//! Runs a firmware of the Uno on avr8js, another simulator: for timers in fast PWM, which simavr
//! does not report.

use std::env;
use std::ffi::OsString;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::board::Pin;
use crate::firmware;

/// The variable with the folder `node_modules` that has avr8js.
pub const MODULES: &str = "STEPWRIGHT_NODE_MODULES";

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/avr8js/run.js");

/// The observed behaviour of a firmware.
#[derive(Clone, Debug)]
pub struct Run {
    /// Every change of a watched pin: its cycle, the pin's index, its level. They are low at first.
    pub changes: Vec<(u64, u8, bool)>,
    /// The output on its line.
    pub said: String,
}

/// Runs the firmware of this name for this many milliseconds after its reset.
///
/// # Errors
/// There is no Node, or no avr8js, or no such firmware; the text says how to get it.
pub fn run(name: &str, millis: u32, pins: &[Pin]) -> Result<Run> {
    let modules = env::var_os(MODULES).unwrap_or_else(|| {
        OsString::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/avr8js/node_modules"))
    });
    let hex = firmware::path(name).with_extension("hex");
    let mut node = Command::new("node");
    node.env("NODE_PATH", modules).arg(SCRIPT).arg(hex).arg(millis.to_string());
    node.args(pins.iter().map(|Pin(port, bit)| format!("{port}{bit}")));
    let output = node.output().context("there is no node: `cargo xtask setup` gets it")?;
    ensure!(
        output.status.success(),
        "{}\nwhat is missing `cargo xtask setup` gets, or `cargo xtask firmware uno`; {MODULES} \
         names the folder with avr8js if it is not target/avr8js/node_modules",
        String::from_utf8_lossy(&output.stderr)
    );
    let said: Value = serde_json::from_slice(&output.stdout).context("what does run.js say?")?;
    let changes = said["changes"].as_array().context("no changes")?.iter().map(change);
    Ok(Run {
        changes: changes.collect::<Option<_>>().context("a change is none")?,
        said: said["said"].as_str().context("no line")?.to_owned(),
    })
}

fn change(of: &Value) -> Option<(u64, u8, bool)> {
    Some((of[0].as_u64()?, of[1].as_u64()? as u8, of[2].as_bool()?))
}
