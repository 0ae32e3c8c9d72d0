//! Axes of different speeds under any traffic: what is admitted is on time.

use crate::common::{chip, rest, say, steps};

/// The queries that a host sends without a pause.
const TRAFFIC: [&[&str]; 5] = [&[], &["?"], &["$"], &["V1", "F"], &["?", "V3", "$", "F"]];

/// Top speeds in steps/s, and an acceleration in steps/s². A fast axis beside two slow ones near
/// rest, axes of one speed (a gantry), and cases in between.
const ORDERS: [([u32; 3], u32); 9] = [
    ([28_500, 2_300, 2_300], 40_000),
    ([28_500, 17_000, 17_000], 40_000),
    ([28_500, 6_800, 900], 40_000),
    ([57_000, 2_300, 0], 100_000),
    ([21_200, 21_200, 21_200], 40_000),
    ([12_000, 12_000, 12_000], 40_000),
    ([43_000, 43_000, 0], 40_000),
    ([20_000, 20_000, 0], 100_000),
    ([100_000, 0, 0], 500_000),
];

#[test]
fn what_is_admitted_is_on_time_under_any_traffic() {
    for (tops, accel) in ORDERS {
        for traffic in TRAFFIC {
            let mut chip = chip();
            say(&mut chip, "PO");
            let mut ways = [0; 3];
            for (axis, top) in (1..).zip(tops).filter(|(_, top)| *top != 0) {
                // A second at the top speed, or half of one.
                let way = (u64::from(top).pow(2) / u64::from(accel)) as u32 + top / 2;
                ways[axis - 1] = way;
                say(&mut chip, &format!("A{axis} s0 t{top} a{accel} d{accel} G+{way}"));
            }
            say(&mut chip, "E");
            chip.poll(traffic);
            chip.run_for(16_000_000);
            chip.poll(&[]);
            chip.run_for(1_600_000);
            say(&mut chip, "A0");
            rest(&mut chip);
            let said = chip.ask("?").unwrap();
            assert!(said.contains(" late=0 "), "{tops:?} at {accel}, {traffic:?}: {said}");
            for (axis, way) in (0..3).zip(ways).filter(|(_, way)| *way != 0) {
                let last = steps(&chip, axis).last().unwrap().position;
                assert_eq!(last, i64::from(way), "{tops:?} at {accel}, {traffic:?}");
            }
        }
    }
}

/// Two slow axes begin while a fast one cruises.
#[test]
fn axes_that_begin_beside_a_fast_one_are_on_time() {
    for (fast, slow, accel) in [(28_500, 2_300, 40_000), (28_500, 10_000, 40_000)] {
        for traffic in TRAFFIC {
            for phase in 0..2 {
                let mut chip = chip();
                say(&mut chip, &format!("PO A3 s0 t{fast} a40000 d40000 g+ E A1"));
                chip.run_for(30_000_000 + 7_000 * phase);
                let slow = format!("s0 t{slow} a{accel} d{accel} G+5000");
                say(&mut chip, &format!("PO {slow} A2 {slow} E"));
                chip.poll(traffic);
                chip.run_for(3 * 16_000_000);
                chip.poll(&[]);
                chip.run_for(1_600_000);
                say(&mut chip, "A3 Z A0");
                rest(&mut chip);
                let said = chip.ask("?").unwrap();
                assert!(said.contains(" late=0 "), "{fast}, {slow}, {traffic:?}: {said}");
            }
        }
    }
}
