//! Tests the contract of `StepTimer` for the step timers: `stepwright-port-test` in QEMU.

use stepwright_qemu::boards::{CONTROLLERS, Simulated};
use stepwright_qemu::{Machine, Pace};

fn keeps_the_contract(board: &Simulated) {
    for pace in [Pace::Quick, Pace::Chip] {
        let mut chip = Machine::start(board, "port-test", pace).unwrap();
        let verdict = chip.hear().unwrap();
        let words: Vec<_> = verdict.split(' ').collect();
        let [kept, deadlines, ..] = words[..] else { panic!("{verdict}") };
        // A counter of 32 bits wraps only after minutes.
        assert_eq!(kept, "kept", "{}: {verdict}", board.name);
        assert!(deadlines.parse::<u32>().unwrap() > 230, "{}: {verdict}", board.name);
    }
}

#[test]
fn every_step_timer_keeps_the_contract() {
    CONTROLLERS.iter().for_each(|board| keeps_the_contract(board));
}
