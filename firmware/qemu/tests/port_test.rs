//! The step timer keeps the contract of `StepTimer`: `stepwright-port-test` in QEMU.

use stepwright_qemu::{Machine, Pace};

#[test]
fn the_step_timer_keeps_the_contract() {
    for pace in [Pace::Quick, Pace::Chip] {
        let mut chip = Machine::start("nrf51", "port-test", pace).unwrap();
        let verdict = chip.hear().unwrap();
        let words: Vec<_> = verdict.split(' ').collect();
        let [kept, deadlines, ..] = words[..] else { panic!("{verdict}") };
        // A counter of 32 bits wraps after 268 s: nobody waits for that.
        assert_eq!(kept, "kept", "{verdict}");
        assert!(deadlines.parse::<u32>().unwrap() > 230, "{verdict}");
    }
}
