//! The runs that a board plays: a ramp as a few runs of (interval, add, count).
//!
//! `cargo run -p stepwright --example 03_runs`

use stepwright::profile::{Cursor, Fit, RampSteps};
use stepwright::run::Steps;
use stepwright::{Rate, Speed};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rate = Rate::from_hz(16_000_000)?;
    // The Nano slave's example: 50 to 1000 steps/s over 200 steps.
    let law = RampSteps::new(rate, Speed::from_steps(50)?, Speed::from_steps(1000)?, 200)?;
    let path = law.path(4000)?;
    let runs: Vec<_> = Cursor::new(path, Fit::board(rate)).collect();
    for run in runs.iter().take(8) {
        let interval = run.interval() as f64 / 65_536.0;
        let add = f64::from(run.add()) / 65_536.0;
        println!("{:4} steps, {interval:11.3} ticks, {add:+9.4} a step", run.count());
    }
    println!("… {} runs for {} pulses", runs.len(), path.pulses());

    // Played step by step they end when the closed form says.
    let ticks: u64 = Steps::new(runs).map(u64::from).sum();
    println!("the last pulse at {ticks}, by the closed form {}", path.time_of(3999));
    assert!(ticks.abs_diff(path.time_of(3999)) <= 16);
    Ok(())
}
