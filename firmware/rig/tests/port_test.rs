//! Tests the contract of `StepTimer` for the AVR's step timer: `stepwright-port-test` on the chip.

use crate::common::board;
use stepwright_rig::board::HZ;
use stepwright_rig::{Chip, firmware};

#[test]
fn the_step_timer_keeps_the_contract() {
    let image = firmware::load(&format!("{}-port-test", board())).expect("no firmware");
    let mut chip = Chip::new(board(), &image);
    let (place, _) = image.variable("RESULT");
    let word = |chip: &Chip, n: u16| {
        i16::from_le_bytes([chip.byte(place + 2 * n), chip.byte(place + 2 * n + 1)])
    };
    // Before the program begins RAM holds anything.
    let ended = |chip: &Chip| (1..=5).contains(&word(chip, 0));
    assert!(chip.run_to(60 * HZ, ended), "it does not end");
    chip.run_for(100); // // until the other two are written
    // Kept, the number of values, and whether the counter wrapped; otherwise the fault and its
    // numbers.
    let [kept, values, wrapped] = [0, 1, 2].map(|n| word(&chip, n));
    assert!(kept == 1 && values > 200 && wrapped == 1, "{kept} {values} {wrapped}");
}
