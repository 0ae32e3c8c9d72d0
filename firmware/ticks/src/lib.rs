//! Seeded travels for every law, and a checksum of the delays of each: the same on every chip.
//!
//! ```text
//!   number ─► Luck ─► Travel ─► law of the product ─► delays in ticks ─► CRC-32 ─► a line
//!             32 bits, below     as the chip runs it    u32, the first 0
//! ```
//!
//! A line is the law, the travel's number, its pulses and the checksum in hexadecimal digits:
//! `austin 17 205 1a2b3c4d`. For a travel that the law refuses it has `refused` in place of the
//! last two. `python/tests/seeded.py` makes the same travels with its own program, and the same
//! lines from the plans of the Python package.
//!
//! # The travels
//!
//! [`Luck`] is Marsaglia's xorshift of 32 bits (13, 17, 5). For law `l` (its index in [`LAWS`]) and
//! travel `n` it begins at (n + 1)·2654435769 + l·2246822519 modulo 2³², or at 1 if that is 0, and
//! the first eight numbers are discarded. `below(k)` is the next number modulo k, and `about(a, b)`
//! is 2^e + below(2^e) for e = a + below(b − a). Every law draws all of these, in this order:
//!
//! | drawn | value |
//! | --- | --- |
//! | timer | 1, 2, 16 or 84 MHz: below(4) |
//! | pulses | about(0, 8) |
//! | top speed | about(15, 25) thousandths of a step/s |
//! | acceleration | about(16, 28) thousandths of a step/s² |
//! | deceleration | below(2) = 0: the same; else about(16, 28) thousandths of a step/s² |
//! | start speed | below(2) = 0: 0; else a twentieth of the top speed, rounded down |
//! | jerk | about(10, 24) steps/s³ |
//! | ramp | about(0, 9) steps |
//! | first delay | Eq 7; 0.676 of it; c₁: below(3) |
//! | divisor | 4n + 1 or 2n: below(2) |
//! | knee | below(901) thousandths of the top speed |
//! | power | 2 + below(8) |
//! | breaks | below(17) |
//! | c₀, c_min | about(11, 17) ticks, about(6, 12) ticks |
//!
//! `board` and `board-jerk` are the trapezoid and the S-curve as a board plans them, with small
//! numbers and a timer of 16 MHz: their checksums are over the entries that a step interrupt plays.

#![no_std]

mod laws;
#[cfg(target_family = "wasm")]
mod module;
mod planned;

use stepwright::{Accel, Jerk, Rate, Speed};
use stepwright_austin::{C0, Divisor};
use stepwright_selftest::{Crc32, Luck};

pub use laws::{
    AUSTIN, AUSTIN_FIXED, LAWS, LINEAR_FACTOR, PIECEWISE, POWER, RAMP, S_CURVE, TRAPEZOID,
};
pub use planned::{BOARD, BOARD_JERK};

/// A travel. Each law uses the fields that it needs.
#[derive(Clone, Copy, Debug)]
pub struct Travel {
    rate: Rate,
    pulses: u32,
    top: Speed,
    accel: Accel,
    decel: Accel,
    start: Speed,
    jerk: Jerk,
    ramp: u16,
    c0: C0,
    divisor: Divisor,
    knee: u16,
    power: u8,
    breaks: u8,
    /// c₀ and c_min of the published listing.
    listed: (u32, u32),
}

impl Travel {
    /// The travel with this number.
    fn of(law: u32, number: u32) -> Travel {
        let mut luck = Luck::of(law, number);
        let accel =
            |thousandths: u32| Accel::from_millisteps(thousandths.into()).unwrap_or(Accel::MAX);
        let speed = |thousandths| Speed::from_millisteps(thousandths).unwrap_or(Speed::MAX);
        let rate = match luck.below(4) {
            0 => Rate::MHZ,
            1 => Rate::of::<2_000_000>(),
            2 => Rate::of::<16_000_000>(),
            _ => Rate::of::<84_000_000>(),
        };
        let pulses = luck.about(0, 8);
        let top = luck.about(15, 25);
        let up = luck.about(16, 28);
        let down = if luck.below(2) == 0 { up } else { luck.about(16, 28) };
        let start = if luck.below(2) == 0 { 0 } else { top / 20 };
        Travel {
            rate,
            pulses,
            top: speed(top),
            accel: accel(up),
            decel: accel(down),
            start: speed(start),
            jerk: Jerk::clamped(luck.about(10, 24)),
            ramp: luck.about(0, 9) as u16,
            c0: match luck.below(3) {
                0 => C0::Exact,
                1 => C0::Reduced,
                _ => C0::FirstStep,
            },
            divisor: if luck.below(2) == 0 { Divisor::FourN } else { Divisor::TwoN },
            knee: luck.below(901) as u16,
            power: 2 + luck.below(8) as u8,
            breaks: luck.below(17) as u8,
            listed: (luck.about(11, 17), luck.about(6, 12)),
        }
    }
}

/// The result of a travel's delays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sum {
    /// The number of pulses.
    pub pulses: u32,
    /// CRC-32 of the delays, four bytes each, the lowest first.
    pub crc: u32,
}

impl Sum {
    /// The sum of a law's delays, if it accepts the travel.
    fn of<E>(delays: Result<impl Iterator<Item = u32>, E>) -> Option<Sum> {
        Some(Sum::over(delays.ok()?))
    }

    fn over(delays: impl Iterator<Item = u32>) -> Sum {
        let (mut crc, mut pulses) = (Crc32::new(), 0u32);
        delays.for_each(|delay| {
            crc.add(delay);
            pulses = pulses.wrapping_add(1);
        });
        Sum { pulses, crc: crc.end() }
    }
}

/// A law. Each is a function of its own, so that a small chip holds only those that its program
/// names.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// The name in `stepwright plan`.
    pub name: &'static str,
    /// The index in [`LAWS`].
    place: u32,
    sum: fn(&Travel) -> Option<Sum>,
}

impl Law {
    /// The result of a travel; `None` if the law refuses it.
    pub fn sum(&self, number: u32) -> Option<Sum> {
        (self.sum)(&Travel::of(self.place, number))
    }

    /// Writes the line of a travel, byte by byte, including its end.
    pub fn tell(&self, number: u32, mut byte: impl FnMut(u8)) {
        self.name.bytes().for_each(&mut byte);
        byte(b' ');
        decimal(number, &mut byte);
        match self.sum(number) {
            Some(Sum { pulses, crc }) => {
                byte(b' ');
                decimal(pulses, &mut byte);
                byte(b' ');
                crc.to_be_bytes().into_iter().flat_map(|two| [two >> 4, two & 15]).for_each(
                    |digit| byte(if digit < 10 { b'0' + digit } else { b'a' - 10 + digit }),
                );
            }
            None => b" refused".iter().for_each(|letter| byte(*letter)),
        }
        byte(b'\n');
    }
}

/// Writes a number in decimal digits.
fn decimal(number: u32, byte: &mut impl FnMut(u8)) {
    let mut unit = 1_000_000_000;
    while unit > 1 && unit > number {
        unit /= 10;
    }
    let mut rest = number;
    while unit > 0 {
        let mut digit = b'0';
        while rest >= unit {
            rest = rest.wrapping_sub(unit);
            digit = digit.wrapping_add(1);
        }
        byte(digit);
        unit /= 10;
    }
}
