//! The self-test of the micro:bit: its line passes the command's check, and agrees with its edges.

use stepwright_qemu::boards::NRF51;
use stepwright_qemu::{Machine, Pace, machine};
use stepwright_selftest::{Line, ORDERS, judge};

#[test]
fn the_line_of_a_micro_bit_passes() {
    for pace in [Pace::Quick, Pace::Chip] {
        let mut chip = Machine::start(&NRF51, "selftest", pace).unwrap();
        let said = chip.hear().unwrap();
        let line = Line::read(&said).unwrap_or_else(|error| panic!("{said}: {error}"));
        let judgement = judge(&line).unwrap();
        println!("{said}: {} ns at {pace:?}", judgement.off[0]);
        assert!(judgement.is_kept(), "{said}: {:?}", judgement.faults().collect::<Vec<_>>());
        // Its report agrees with the observed edges.
        let edges = chip.end().unwrap();
        let seen: Vec<_> = (0..3).map(|axis| machine::steps(&edges, axis).len()).collect();
        assert_eq!(seen.iter().sum::<usize>(), line.found.edges as usize);
        assert!(seen.iter().all(|axis| *axis > 0) && line.found.orders == ORDERS, "{seen:?}");
    }
}
