//! Checks a dump of the virtual board's edges with an independent logic analyser: sigrok-cli with
//! its decoder of STEP and DIR.

use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::workspace::{self, Workspace, output};

/// Steps of the move, and its top speed in steps/s.
const MOVE: (i64, f64) = (1500, 1000.0);
/// A tick of 16 MHz in the dump's unit: the decoder gets one sample for each tick.
const SAMPLES: &str = "vcd:downsample=625";

/// Checks that the decoder counts every step, from 0, and sees no speed above the top speed.
pub fn run(ws: &Workspace) -> Result<()> {
    let command = ws.shipped()?;
    let dump = ws.root.join("target/sigrok.vcd");
    let steps = MOVE.0.to_string();
    let mut order = Command::new(command);
    workspace::run(order.args(["move", &steps, "--fast", "--vcd"]).arg(&dump))?;
    let mut sigrok = Command::new("sigrok-cli");
    sigrok.arg("-i").arg(&dump).args(["-I", SAMPLES]);
    sigrok.args(["-P", "stepper_motor:step=step1:dir=dir1", "-A", "stepper_motor"]);
    let text = output(&mut sigrok)?;
    let numbers = |unit: &str| -> Vec<f64> {
        let number = |line: &str| line.split(": ").nth(1)?.strip_suffix(unit)?.parse().ok();
        text.lines().filter_map(number).collect()
    };
    let positions = numbers(" steps");
    let last = positions.last().context("sigrok-cli saw no step")?;
    // The decoder prints a position once it has a speed, so from the second step on, which is 1.
    let most = MOVE.0 - 1;
    ensure!(positions.len() as i64 == most && *last == most as f64, "the last is {last}");
    let fastest = numbers(" steps/s").into_iter().fold(0.0, f64::max);
    ensure!((fastest - MOVE.1).abs() <= 1.0, "the fastest are {fastest} steps/s");
    println!("{last} places, at most {fastest} steps/s");
    Ok(())
}
