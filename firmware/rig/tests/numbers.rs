//! The planner's numbers on the chip, which are assembly, compared bit for bit with the Rust that
//! they implement.
//!
//! The routines are called one by one in the firmware's own flash, without its program. The Rust is
//! compiled from its own file, with its tests: it is private to the core.

use std::cell::RefCell;

use crate::common::{board, image};
use crate::num::Num;
use proptest::prelude::*;
use stepwright_rig::{Chip, Image};

/// Addresses in RAM for a result and for two operands. The firmware does not run: all RAM is free
/// except the number in hand, which is below.
const OUT: u16 = 0x700;
const A: u16 = 0x710;
const B: u16 = 0x720;

/// The registers that a function preserves by C's convention, besides r1, which is 0.
const KEPT: [u8; 18] = [2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29];

/// The routines in a chip's flash.
struct Routines {
    chip: RefCell<Chip>,
    image: Image,
}

impl Routines {
    fn new() -> Routines {
        let image = image();
        Routines { chip: RefCell::new(Chip::new(board(), &image)), image }
    }

    /// Calls one with 16-bit arguments, in r25–r24, r23–r22 and so on. Returns r25–r18.
    fn call(&self, name: &str, arguments: &[u16]) -> u64 {
        let chip = &mut *self.chip.borrow_mut();
        for &register in &KEPT {
            chip.set_byte(register.into(), 0x5A ^ register);
        }
        for register in [0, 18, 19, 20, 21, 26, 27, 30, 31] {
            chip.set_byte(register, 0xC3);
        }
        chip.set_byte(1, 0);
        for (argument, register) in arguments.iter().zip([24, 22, 20, 18]) {
            let [low, high] = argument.to_le_bytes();
            chip.set_byte(register, low);
            chip.set_byte(register + 1, high);
        }
        let (address, _) = self.image.function(&format!("stepwright_{name}"));
        assert!(chip.call(address, 2_000), "{name} does not come back");
        for &register in &KEPT {
            assert_eq!(chip.byte(register.into()), 0x5A ^ register, "{name} changes r{register}");
        }
        assert_eq!(chip.byte(1), 0, "{name} changes r1");
        (18..=25).rev().fold(0, |all, register| all << 8 | u64::from(chip.byte(register)))
    }

    fn put(&self, place: u16, number: Num) {
        for (n, byte) in (0..).zip(bytes(number)) {
            self.chip.borrow_mut().set_byte(place + n, byte);
        }
    }

    fn get(&self, place: u16) -> [u8; 6] {
        [0, 1, 2, 3, 4, 5].map(|n| self.chip.borrow().byte(place + n))
    }

    /// Runs a routine on the number in hand and a second operand.
    fn in_hand(&self, name: &str, a: Num, b: Num) -> [u8; 6] {
        self.take_in_hand(a);
        self.put(B, b);
        self.call(&format!("hand_{name}"), &[B]);
        self.hand()
    }

    fn take_in_hand(&self, a: Num) {
        self.put(A, a);
        self.call("hand_load", &[A]);
        assert_eq!(self.get(A), bytes(a));
    }

    fn hand(&self) -> [u8; 6] {
        self.call("hand_store", &[OUT]);
        self.get(OUT)
    }

    /// A copy.
    fn copy(&self, a: Num) -> [u8; 6] {
        self.put(A, a);
        self.call("copy", &[A, OUT]);
        self.get(OUT)
    }

    fn split(&self, a: Num) -> (u32, u32) {
        self.put(A, a);
        let both = self.call("split", &[A]);
        ((both >> 32) as u32, both as u32)
    }

    /// Runs a routine that returns a byte of two operands.
    fn byte_of(&self, name: &str, a: Num, b: Num) -> u8 {
        self.put(A, a);
        self.put(B, b);
        (self.call(name, &[A, B]) >> 48) as u8
    }
}

/// A number in the chip's layout.
fn bytes(number: Num) -> [u8; 6] {
    // SAFETY: six bytes without a gap, in an order that `repr(C)` fixes; on a little-endian host
    // they are the chip's.
    unsafe { std::mem::transmute(number) }
}

/// Typical numbers, and the critical ones.
fn number() -> impl Strategy<Value = Num> {
    let mantissa = prop_oneof![
        4 => any::<u32>(),
        1 => any::<u8>().prop_map(u32::from),
        1 => (0u32..32).prop_map(|bits| u32::MAX << bits),
        1 => (0u32..32).prop_map(|bit| 1 << bit),
    ];
    let exponent = prop_oneof![4 => -70i16..40, 1 => -300i16..300];
    prop_oneof![
        30 => (mantissa, exponent).prop_map(|(m, e)| Num::new(m, e)),
        1 => Just(Num::ZERO),
        1 => Just(Num::UNSET),
        // Divided by 0: the largest number.
        1 => Just(Num::ONE.over(&Num::ZERO)),
    ]
}

/// Two of them, mostly near each other, where sums and differences have the most work.
fn pair() -> impl Strategy<Value = (Num, Num)> {
    prop_oneof![
        (number(), number()),
        (number(), any::<u32>(), -34i16..34)
            .prop_map(|(a, m, by)| (a, a.scaled(by).times(&Num::new(m | 1 << 31, -32)))),
        (number(), -2i16..2).prop_map(|(a, by)| (a, a.scaled(by))),
    ]
}

fn cases() -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(3_000) }
}

#[test]
fn what_compares_two_is_the_rusts() {
    let chip = Routines::new();
    proptest!(cases(), |((a, b) in pair())| {
        prop_assert_eq!(chip.byte_of("at_least", a, b), u8::from(a.at_least(&b)), "at_least");
        prop_assert_eq!(chip.byte_of("doublings", a, b) as i8, a.doublings_of(&b), "doublings");
    });
}

#[test]
fn what_is_done_in_hand_is_the_rusts() {
    let chip = Routines::new();
    proptest!(cases(), |((a, b) in pair(), by: i8, n: u32)| {
        prop_assert_eq!(chip.in_hand("times", a, b), bytes(a.times(&b)), "times");
        prop_assert_eq!(chip.in_hand("roughly", a, b), bytes(a.roughly(&b)), "roughly");
        prop_assert_eq!(chip.in_hand("over", a, b), bytes(a.over(&b)), "over");
        prop_assert_eq!(chip.in_hand("under", a, b), bytes(b.over(&a)), "under");
        prop_assert_eq!(chip.in_hand("plus", a, b), bytes(a.plus(&b)), "plus");
        prop_assert_eq!(chip.in_hand("minus", a, b), bytes(a.minus(&b)), "minus");
        prop_assert_eq!(chip.in_hand("off", a, b), bytes(b.minus(&a)), "off");
        prop_assert_eq!(chip.in_hand("square", a, b), bytes(a.times(&a)), "square");
        prop_assert_eq!(chip.in_hand("root", a, b), bytes(a.root()), "root");
        chip.take_in_hand(a);
        prop_assert_eq!((chip.call("hand_at_least", &[B]) >> 48) as u8, u8::from(a.at_least(&b)));
        prop_assert_eq!((chip.call("hand_bits", &[]) >> 48) as i16, a.bits(), "bits");
        let both = chip.call("hand_split", &[]);
        prop_assert_eq!(((both >> 32) as u32, both as u32), a.split(), "split");
        chip.call("hand_scale", &[u16::from(by as u8)]);
        prop_assert_eq!(chip.hand(), bytes(a.scaled(by.into())), "scale");
        chip.call("hand_whole", &[(n >> 16) as u16, n as u16]);
        prop_assert_eq!(chip.hand(), bytes(Num::from(n)), "whole");
    });
}

#[test]
fn each_of_one_operand_is_the_rusts() {
    let chip = Routines::new();
    proptest!(cases(), |(a in number())| {
        prop_assert_eq!(chip.copy(a), bytes(a), "copy");
        prop_assert_eq!(chip.split(a), a.split(), "split");
    });
    // Whole parts of one bit to 32, and beyond.
    proptest!(cases(), |(m: u32, e in -40i16..4)| {
        let a = Num::new(m, e);
        prop_assert_eq!(chip.split(a), a.split(), "split");
    });
}

#[test]
fn an_integer_in_hand_is_the_rusts() {
    let chip = Routines::new();
    proptest!(cases(), |(n: u32, down in 0u32..33)| {
        let n = n.checked_shr(down).unwrap_or(0);
        chip.call("hand_whole", &[(n >> 16) as u16, n as u16]);
        prop_assert_eq!(chip.hand(), bytes(Num::from(n)));
    });
}
