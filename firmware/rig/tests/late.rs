//! Ramps that planning is fast enough for, and those that it is not, which are refused.

mod common;

use common::{board, chip, rest, say, steps};
use stepwright_rig::Board;

#[test]
fn a_ramp_too_steep_to_plan_is_refused() {
    for (accel, count) in [(1_000_000, 30), (2_000_000, 60), (3_000_000, 60)] {
        let mut chip = chip();
        say(&mut chip, &format!("PO s0 t30000 a{accel} d{accel} G-{count}"));
        chip.expect("E", "E");
        assert!(chip.ask("?").unwrap().contains(" last=too-steep "));
        assert!(steps(&chip, 0).is_empty());
        // On the way too: it goes on as it was.
        say(&mut chip, "PO s0 t30000 a20000 d20000 G-9000 E");
        chip.run_for(2_000_000);
        chip.expect(&format!("a{accel}"), "E");
        assert!(chip.ask("?").unwrap().contains(" last=too-steep "));
        rest(&mut chip);
        assert_eq!(steps(&chip, 0).last().unwrap().position, -9_000);
        assert!(chip.ask("?").unwrap().contains(" late=0 "));
    }
}

/// The queue holds it as a whole.
#[test]
fn a_steep_ramp_of_a_few_steps_is_on_time() {
    for count in [1, 2, 4, 6] {
        let mut chip = chip();
        say(&mut chip, &format!("PO s0 t30000 a2000000 d2000000 G+{count} E"));
        rest(&mut chip);
        chip.expect("V1", &count.to_string());
        assert!(chip.ask("?").unwrap().contains(" late=0 "), "{count} steps");
    }
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
