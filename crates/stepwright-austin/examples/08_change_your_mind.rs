//! A motor whose target changes on the way, under Austin's law: each delay is computed when it is
//! asked for, so a change takes effect with the next step.
//!
//! `cargo run -p stepwright-austin --example 08_change_your_mind`
//!
//! With any argument it prints a cycle file of its delays instead, which `stepwright cycle` plays
//! and draws.

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::Motion;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cycle = std::env::args().len() > 1;
    if cycle {
        println!("[[motor]]\nname = \"motor\"\nstep = 1\nsmallest-delay-us = 500\n");
        println!("[[cycle]]\nmove.motor = {{ series = [");
    }
    // At most 500 steps/s, up and down at 1000 steps/s², timed at 1 MHz.
    let mut motion = Motion::new(Rate::MHZ, Speed::from_steps(500)?, Accel::from_steps(1000)?)?;
    motion.retarget(1000);
    let (mut time, mut furthest) = (0u64, 0);
    // On a chip: set the direction, wait for the delay, pulse.
    while let Some(delay) = motion.next() {
        time += u64::from(delay);
        let place = motion.position();
        if cycle {
            let step = if motion.is_forward() { 1 } else { -1 };
            println!("    {{ steps = {step}, delay-us = {delay} }},");
        }
        furthest = furthest.max(place);
        let said = match (place, motion.is_forward()) {
            (200, true) => {
                motion.set_top_speed(Speed::from_steps(1000)?)?;
                "faster"
            }
            (600, true) => {
                motion.set_decel(Accel::from_steps(2000)?)?;
                motion.retarget(-100);
                "back, and behind where it began"
            }
            (300, false) => {
                motion.stop();
                "a soft stop"
            }
            _ => continue,
        };
        if !cycle {
            println!("{:4} ms: at {place}, {} steps/s: {said}", time / 1000, motion.speed());
        }
    }
    if cycle {
        println!("] }}");
        return Ok(());
    }
    println!("{:4} ms: at rest at {}, {furthest} at the furthest", time / 1000, motion.position());
    assert_eq!(motion.position(), motion.target());
    Ok(())
}
