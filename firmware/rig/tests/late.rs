//! Steps that planning is too slow for.
//!
//! What is refused is a peak speed; how fast a ramp's runs follow one another
//! is not looked at. A short and steep ramp therefore asks for more than the
//! chip can plan, although no speed in it is too high. What happens then has to
//! be said, and nothing may be lost.

mod common;

use common::{board, chip, path_of_accel, rest, say, steps};
use stepwright_rig::Board;
use stepwright_rig::edges::intervals_of;

/// A dry queue costs more cycles than that, and latency fewer: what is queued late is played
/// at once.
const DRY: u64 = 200;

#[test]
fn a_ramp_too_steep_to_plan_is_late_says_so_and_loses_no_step() {
    let mut sum = 0;
    for (accel, count) in [(1_000_000, 30), (2_000_000, 30), (2_000_000, 60)] {
        let mut chip = chip();
        say(&mut chip, &format!("PO s0 t30000 a{accel} d{accel} G-{count} E"));
        // The drivers' needs, too.
        rest(&mut chip);
        let made = steps(&chip, 0);
        assert_eq!((made.len(), made[count - 1].position), (count, -(count as i64)));
        chip.expect("V1", &format!("-{count}"));
        let health = chip.ask("?").unwrap();
        let late = health.split(" late=").nth(1).unwrap().split(' ').next().unwrap();
        let late: usize = late.parse().unwrap();
        // Each late step is a queue that ran dry: an interval longer than the
        // law's, and the ramp goes on behind it.
        let path = path_of_accel(0, 30_000, accel, count as u32);
        let law = (1..count as u32).map(|n| path.time_of(n) - path.time_of(n - 1));
        let intervals = intervals_of(chip.edges(), 0);
        let longer = intervals.iter().zip(law).filter(|(real, law)| **real > law + DRY).count();
        assert_eq!(late, longer, "a{accel} G{count}: {intervals:?}");
        sum += late;
    }
    assert!(sum > 0, "all of it is on time: this test needs a steeper ramp");
}

#[test]
fn half_as_steep_a_ramp_is_on_time() {
    let mut chip = chip();
    for count in [10, 30, 60, 100] {
        say(&mut chip, &format!("PO s0 t30000 a500000 d500000 G+{count} E"));
        rest(&mut chip);
    }
    chip.expect("V1", "200");
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}

/// At 123,733 steps/s runs of 1, 2, 4 … steps would be over before the next are planned: such a
/// travel begins with a longer one. Whatever the host asks in the beginning.
#[test]
fn a_travel_that_starts_fast_is_on_time() {
    if board() == Board::Mega {
        // Its step interrupt is slower.
        return;
    }
    for phase in 0..20 {
        let mut chip = chip();
        say(&mut chip, "PO m123733722 s123733 G-1883 E");
        chip.run_for(11_000 + 100 * phase);
        chip.send("V1\r".repeat(20).as_bytes());
        chip.run_for(16_000 * 60);
        // More than the board keeps: the rest of them ends here.
        chip.poll(&[]);
        chip.ask("");
        rest(&mut chip);
        assert!(chip.ask("?").unwrap().contains(" late=0 "), "phase {phase}");
    }
}

/// A stop in the first bend of an S-curve, of which a bend takes 6 ms.
#[test]
fn an_s_curve_that_is_stopped_in_a_bend_is_on_time() {
    if board() == Board::Mega {
        return;
    }
    for phase in 0..10 {
        let mut chip = chip();
        say(&mut chip, "PO T929 s3810 a97855 d39784 j16085928 G-35 E A0");
        chip.run_for(1_000 * phase);
        chip.expect("Z", "Y");
        rest(&mut chip);
        assert!(chip.ask("?").unwrap().contains(" late=0 "), "phase {phase}");
    }
}
