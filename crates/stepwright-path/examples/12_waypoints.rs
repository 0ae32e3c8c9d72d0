//! Waypoints in, steps out: corners and chords are passed at the speed that each axis can take.
//!
//! `cargo run -p stepwright-path --example 12_waypoints`

use stepwright_path::{AxisPace, Route};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 80 steps/mm; at most 200 mm/s and 1000 mm/s², and a jump of 5 mm/s.
    let axis = AxisPace::per_unit(80.0, 200.0, 1_000.0, 5.0);
    let mut route = Route::new([axis; 2])?;
    // A circle of 20 mm in chords of half a degree, at 100 mm/s.
    let places = (0..=720).map(|n| f64::from(n).to_radians() / 2.0);
    for [x, y] in places.map(|angle| [20.0 * angle.sin(), 20.0 - 20.0 * angle.cos()]) {
        route.line_to([x, y], 100.0)?;
        for step in route.by_ref() {
            // A program sends the step to the motor of this axis.
            let _ = (step.time, step.axis, step.forward);
        }
    }
    route.close();
    let count = route.by_ref().count();
    println!("the last {count} steps end after {:.3} s, at {:?}", route.time(), route.positions());
    Ok(())
}
