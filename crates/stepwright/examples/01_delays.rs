//! The smallest program: a profile is an iterator of delays.
//!
//! `cargo run -p stepwright --example 01_delays`

use stepwright::profile::Trapezoid;
use stepwright::{Accel, Rate, Speed};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 12 steps from rest at 1000 steps/s², at most 80 steps/s, timed at 1 MHz.
    let law =
        Trapezoid::new(Rate::MHZ, Speed::ZERO, Speed::from_steps(80)?, Accel::from_steps(1000)?);
    for (n, delay) in law.delays(12)?.enumerate() {
        println!("pulse {:2} after {delay:6} µs", n + 1);
    }
    Ok(())
}
