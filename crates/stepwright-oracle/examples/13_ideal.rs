//! Prints the ideal times of the steps of an S-curve.

use stepwright_oracle::{IdealSCurve, JerkLimits};

fn main() {
    let limits =
        JerkLimits { start: 0.0, top: 1000.0, accel: 4000.0, decel: 4000.0, jerk: 80_000.0 };
    let ideal = IdealSCurve::new(limits, 2000.0);
    for step in [0, 1, 10, 100, 1000, 2000] {
        println!("step {step} at {:.6} s", ideal.time(step.into()));
    }
}
