//! The inputs that stop all axes.

use crate::common::{board, chip, rest, say, steps, talk};

/// The inputs are sampled every millisecond, and the queues are cleared: cycles from the level to
/// the last step.
const AT_ONCE: u64 = 2 * 16_000;

#[test]
fn an_emergency_stop_and_a_drivers_fault_kill() {
    let pins = board().stoppers();
    for (setting, letter, pin) in [("estop", "E", pins[0]), ("driver-fault", "D", pins[1])] {
        // A low level stops, and so does a contact to ground that opens.
        for level in [1, 2] {
            let mut chip = chip();
            chip.pull(pin, level == 2);
            chip.run_for(160_000);
            say(&mut chip, &format!("${setting}={level} A0 T200 g+"));
            chip.run_for(16_000_000);
            let before = steps(&chip, 0).len();
            chip.run_for(1_600_000);
            assert!(steps(&chip, 0).len() > before + 100, "{setting}={level}: it does not move");
            chip.pull(pin, level == 1);
            let pulled = chip.now();
            chip.run_for(8_000_000);
            for axis in 0..3 {
                let last = steps(&chip, axis).last().unwrap().time;
                assert!(last <= pulled + AT_ONCE, "{setting}={level}: {} late", last - pulled);
            }
            let stops = letter.repeat(3);
            talk(
                &mut chip,
                &format!("F R\nA1 Y\nPO Y\nG+5 Y\nE E\n? * last=fault uncertain=7 stop={stops} *"),
            );
            chip.pull(pin, level == 2);
            chip.run_for(160_000);
            talk(&mut chip, "I1 Y\nPO Y\nG+5 Y\nE Y\n*rest\nV1 5");
            rest(&mut chip);
        }
    }
}
