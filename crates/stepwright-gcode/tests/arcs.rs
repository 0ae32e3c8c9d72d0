//! Arcs: planes, directions, centres and radii, tolerances to the picometre.

use crate::common::{read, table};

#[test]
fn arcs_by_their_centre() {
    table(&[
        ("G2 F9 X2 I1", "cw F9 X2 Y0 Z0 about X1 Y0"),
        ("G3 F9 X1 Y1 J1", "ccw F9 X1 Y1 Z0 about X0 Y1"),
        ("X5 Y6\nG3 F9 X5 Y8 I0 J1", "rapid X5 Y6 Z0\nccw F9 X5 Y8 Z0 about X5 Y7"),
        // Offsets count from the start, whatever the axis words do.
        ("X5 Y6\nG91 G2 F9 X2 I1", "rapid X5 Y6 Z0\ncw F9 X7 Y6 Z0 about X6 Y6"),
        ("G18 G2 F9 Z2 K1", "cw F9 X0 Y0 Z2 about Z1 X0"),
        ("G18 G3 F9 X1 Z1 I1", "ccw F9 X1 Y0 Z1 about Z0 X1"),
        ("G19 G2 F9 Y2 J1", "cw F9 X0 Y2 Z0 about Y1 Z0"),
        ("G19 G3 F9 Z2 K1", "ccw F9 X0 Y0 Z2 about Y0 Z1"),
        ("G20 G2 F1 X2 I1", "cw F25.4 X50.8 Y0 Z0 about X25.4 Y0"),
        // A helix, and one in another plane.
        ("G2 F9 X2 I1 Z-5", "cw F9 X2 Y0 Z-5 about X1 Y0"),
        ("G19 G2 F9 Y2 J1 X-5", "cw F9 X-5 Y2 Z0 about Y1 Z0"),
        // A full circle, and a full turn of a helix.
        ("G2 F9 X0 I1", "cw F9 X0 Y0 Z0 about X1 Y0"),
        ("G3 F9 Y0 Z2 I1", "ccw F9 X0 Y0 Z2 about X1 Y0"),
        // Offsets of coordinates move the centre with the arc.
        (
            "G10 L2 P1 X10\nX0\nG2 F9 X2 I1",
            "G54 = X10 Y0 Z0\nrapid X10 Y0 Z0\ncw F9 X12 Y0 Z0 about X11 Y0",
        ),
    ]);
}

#[test]
fn arcs_by_their_radius() {
    table(&[
        // From a corner of a square to the opposite one.
        ("G2 F9 X1 Y1 R1", "cw F9 X1 Y1 Z0 about X1 Y0"),
        ("G3 F9 X1 Y1 R1", "ccw F9 X1 Y1 Z0 about X0 Y1"),
        ("G2 F9 X1 Y1 R-1", "cw F9 X1 Y1 Z0 about X0 Y1"),
        ("G3 F9 X1 Y1 R-1", "ccw F9 X1 Y1 Z0 about X1 Y0"),
        ("G18 G2 F9 X1 Z1 R1", "cw F9 X1 Y0 Z1 about Z1 X0"),
        ("G19 G3 F9 Y1 Z1 R1", "ccw F9 X0 Y1 Z1 about Y0 Z1"),
        // A half circle, to the picometre.
        ("G2 F9 X2 R1", "cw F9 X2 Y0 Z0 about X1 Y0"),
        ("G2 F9 X2 R0.999999999", "error 34 at 1:10"),
        ("G2 F9 X2.000000001 R-1", "error 34 at 1:20"),
        // 3, 4, 5.
        ("G3 F9 X6 R5", "ccw F9 X6 Y0 Z0 about X3 Y4"),
        ("G3 F9 X6 R-5", "ccw F9 X6 Y0 Z0 about X3 Y-4"),
        ("G3 F9 X-6000 R-5000", "ccw F9 X-6000 Y0 Z0 about X-3000 Y4000"),
        // √(1.154700538² − 1) = 0.577350268431… over the middle.
        ("G3 F9 X2 R1.154700538", "ccw F9 X2 Y0 Z0 about X1 Y0.577350268"),
        ("G3 F9 X600000 R500000", "ccw F9 X600000 Y0 Z0 about X300000 Y400000"),
    ]);
}

#[test]
fn arcs_that_are_none() {
    table(&[
        ("G2 X2 I1", "error 22 at 1:1"),
        ("G2 F9 Z1 I1", "error 32 at 1:7"),
        ("G18 G2 F9 Y1 I1", "error 32 at 1:11"),
        ("G2 F9 X1 Z1", "error 35 at 1:1"),
        ("G2 F9 X1 K1", "error 35 at 1:1"),
        ("F9 G19 G2 Y1 I1", "error 35 at 1:8"),
        ("G2 F9 X1 I0 J0", "error 33 at 1:1"),
        ("G2 F9 X0 Y0 R5", "error 33 at 1:1"),
        ("G2 F9 X1 R0", "error 34 at 1:10"),
        ("G2 F9 X0 Y0 I0", "error 33 at 1:1"),
    ]);
}

/// Ends at distance `r` from the centre and at these from it: the farthest and the nearest that
/// are allowed.
#[test]
fn both_ends_are_equally_far_from_the_centre() {
    for (radius, farthest, nearest) in [
        (1, 1_005_000_000_i64, 995_000_000),
        (4, 4_005_000_000, 3_995_000_000),
        (10, 10_010_000_000, 9_990_000_000),
        (100, 100_100_000_000, 99_900_000_000),
        (1_000, 1_000_500_000_000, 999_500_000_000),
        (100_000, 100_000_500_000_000, 99_999_500_000_000),
    ] {
        for (distance, good) in
            [(farthest, true), (farthest + 1, false), (nearest, true), (nearest - 1, false)]
        {
            let end = i64::from(radius) * 1_000_000_000 + distance;
            let end = format!("{}.{:09}", end / 1_000_000_000, end % 1_000_000_000);
            let said = read(&format!("G3 F9 X{end} I{radius}"));
            let taken = said.starts_with("ccw");
            assert!(
                taken == good && (taken || said == "error 33 at 1:1"),
                "{radius} {end}: {said}"
            );
        }
    }
}
