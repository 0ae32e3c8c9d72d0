//! Tests the compiled arithmetic of wide numbers on the chip: the same results as on the host, bit
//! for bit, for random operands of every length. (Arguments on the stack, which the compiler gets
//! wrong on a Mega, are refused when a firmware is built: `cargo xtask check`.)

use std::cell::RefCell;

use crate::common::board;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use stepwright_rig::{Chip, firmware};

include!("../../avr/examples/arithmetic/operations.rs");

/// A name, and the function of two operands.
type Operation = (&'static str, fn(u64, u64) -> (u64, u64));

macro_rules! table {
    ($($name:ident($a:ident, $b:ident): $results:expr;)*) => {
        const OPERATIONS: &[Operation] = &[$((stringify!($name), |$a, $b| $results)),*];
    };
}
operations!(table);

/// The pairs of operands for each operation.
const PAIRS: u32 = 300;
/// An upper bound for the cycles of the slowest, a division.
const LIMIT: u64 = 100_000;

/// Numbers of every length, of either sign, and neighbours of powers of two.
fn operand() -> impl Strategy<Value = u64> {
    prop_oneof![
        any::<u64>(),
        (any::<u64>(), 0..64u32).prop_map(|(number, by)| number >> by),
        (any::<i64>(), 0..64u32).prop_map(|(number, by)| (number >> by) as u64),
        (0..64u32, 0..3u64).prop_map(|(bit, less)| (1u64 << bit).wrapping_sub(less)),
        (0..64u32, 0..3u64).prop_map(|(bit, more)| (u64::MAX << bit).wrapping_add(more)),
    ]
}

#[test]
fn wide_numbers_are_on_the_chip_what_they_are_here() {
    let image = firmware::load(&format!("{}-arithmetic", board())).expect("no firmware");
    let mut chip = Chip::new(board(), &image);
    let (main, _) = image.function("main");
    assert!(chip.run_to(100_000, |chip| chip.pc() == main), "it does not start");
    let (place, _) = image.variable("OPERANDS");
    let read = |chip: &Chip, from: u16| {
        (0..8).rev().fold(0, |all, n| all << 8 | u64::from(chip.byte(from + n)))
    };
    for (name, operation) in OPERATIONS {
        let (address, _) = image.function(name);
        let mut runner = TestRunner::new(Config::with_cases(PAIRS));
        let shared = RefCell::new(&mut chip);
        let tried = runner.run(&(operand(), operand()), |(a, b)| {
            let chip = &mut **shared.borrow_mut();
            let bytes = a.to_le_bytes().into_iter().chain(b.to_le_bytes());
            (place..).zip(bytes).for_each(|(at, byte)| chip.set_byte(at, byte));
            prop_assert!(chip.call(address, LIMIT), "it does not come back");
            prop_assert_eq!((read(chip, place), read(chip, place + 8)), operation(a, b));
            Ok(())
        });
        tried.unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}
