//! Top speeds in thousandths of a step per second, on the chip.

use crate::common::{LATENCY, chip, rest, say, steps};

/// 2.5 steps/s, and 0.05: 20 s from step to step.
#[test]
fn a_slow_axis_steps_on_time() {
    for (millis, count, cycles) in [(2_500, 4, 6_400_000), (50, 2, 320_000_000)] {
        let mut chip = chip();
        say(&mut chip, &format!("PO S5 m{millis} R1 G+{count} E"));
        rest(&mut chip);
        let steps = steps(&chip, 0);
        assert_eq!(steps.len(), count);
        for pair in steps.windows(2) {
            let gap = pair[1].time as i64 - pair[0].time as i64;
            assert!((gap - cycles).abs() <= LATENCY, "{gap}, not {cycles}");
        }
    }
}
