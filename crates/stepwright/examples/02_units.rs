//! Turns and millimetres are converted to steps once, on entry; the stored values are printed.
//!
//! `cargo run -p stepwright --example 02_units`

use stepwright::{Geometry, Turn};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A 1.8° motor at 1/16 steps on a belt that moves 40 mm per turn.
    let axis = Geometry::new(3200)?.travelling_nm(40_000_000)?;
    // Thousandths of the unit: 50 mm/s, 120 rpm, 12.566 rad/s².
    let belt = axis.speed(50_000, Turn::Millimetre)?;
    let turns = axis.speed(120_000, Turn::Rpm)?;
    let accel = axis.accel(12_566, Turn::Radian)?;
    println!("50 mm/s is {belt} steps/s, 120 rpm is {turns}, 12.566 rad/s² is {accel} steps/s²");
    assert_eq!((belt.millisteps(), turns.millisteps()), (4_000_000, 6_400_000));

    // A value out of range is refused, with the allowed range.
    let error = axis.speed(u64::MAX, Turn::Rpm).unwrap_err();
    println!("too much: {error}");
    Ok(())
}
