//! The brake: how an axis comes to rest by itself, from any speed.
//!
//! At a deceleration a the interval c grows from step to step by
//!
//! ```text
//!   dc/dn = c³ · a / f²          f: ticks a second
//! ```
//!
//! The formula holds at every speed, and takes three products of 16 bits. A host sends a/f² as a mantissa and
//! an exponent, and the *slowest* interval f·√(2/a). A motor may rest at once from that interval on, as it
//! is the first interval of a start from rest.
//!
//! A braking entry has 16 groups, over which the interval grows by 1/16 to 1/8. The growth is the formula's
//! for the first interval of the entry. The formula's growth rises with c, so the deceleration is never above
//! a. The braking distance is 12 to 13 % longer than v²/2a, at most a fifth and some steps. From 38,000
//! steps/s to rest at 40,000 steps/s² takes 56 entries. At long intervals each step is an entry. At high speed a
//! gentle deceleration makes the interval grow by less than can be said from group to group: then an entry has one
//! interval, and the next one is longer, by 1/128 at most. An entry has at most 2¹⁵ steps, and the next one is longer
//! by at least 2⁻⁸ ticks: below 82 steps/s² at 16 MHz and 222,000 steps/s the deceleration is above a by that.

use crate::record::{Record, RecordAct, Trail};

/// From this interval on each step is an entry, in 2⁻⁸ ticks.
const LONG: u32 = 28_000 << 8;
/// The longest part of a wait, in 2⁻⁸ ticks …
const PART: u32 = 0x7E00 << 8;
/// … and the shortest part that the remainder of a wait is played as.
const SHORT: u32 = 1_200 << 8;

/// Groups that grow by less than this have one interval, and the next record grows, in 2⁻⁸ ticks.
const FINE: u32 = 32;

/// The bound of the slowest interval, in ticks. An axis with half of this interval still brakes, and a longer
/// interval does not fit into one record.
const SLOWEST: u128 = (2 * 32_000) << 7;

/// A deceleration as a board takes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BrakeLaw {
    /// The interval from which on the axis may rest at once, in 2⁻⁸ ticks.
    slowest: u32,
    /// a/f² is `mantissa` · 2^(exponent − 64); the mantissa is at least 2¹⁵.
    mantissa: u16,
    exponent: i8,
}

impl BrakeLaw {
    /// No brake: the axis rests at once.
    pub const NONE: BrakeLaw = BrakeLaw { slowest: 0, mantissa: 0, exponent: 0 };
    /// The number of bytes of a law on the line.
    pub const LEN: usize = 6;

    /// The law of a deceleration in thousandths of a step/s², on a timer of `hz` ticks per second. Rounding
    /// makes it gentler. `None` if the deceleration is 0, or so small that the timer counts more than 8,192,000
    /// ticks from the last step to rest: below 8 steps/s² at 16 MHz. The longest interval of one record is half
    /// of that.
    ///
    /// ```
    /// use stepwright_stream::brake::BrakeLaw;
    /// let law = BrakeLaw::of(40_000_000, 16_000_000).unwrap();
    /// // f·√(2/a) is 113,137 ticks.
    /// assert_eq!(law.slowest() >> 8, 113_138);
    /// // At 400 ticks a step: 400³ · 40000 / 16000000² = 0.01 ticks, 2.56 of 2⁻⁸.
    /// assert_eq!(law.growth(400 << 8, 0), 2);
    /// assert_eq!(law.growth(400 << 8, 4), 40);
    /// assert_eq!(BrakeLaw::of(7_000, 16_000_000), None);
    /// ```
    pub const fn of(thousandths: u64, hz: u32) -> Option<BrakeLaw> {
        if thousandths == 0 || thousandths >> 48 != 0 || hz == 0 {
            return None;
        }
        let square = hz as u128 * hz as u128;
        let scaled = ((thousandths as u128) << 64) / (1_000 * square);
        if scaled == 0 {
            return None;
        }
        let bits = 128 - scaled.leading_zeros() as i32;
        let exponent = bits - 16;
        if exponent < -40 || exponent > 60 {
            return None;
        }
        let mantissa =
            if exponent < 0 { (scaled << -exponent) as u16 } else { (scaled >> exponent) as u16 };
        // Rounded up to an even number: gentler, and its low byte is never `FILL`.
        let slowest = (2_000 * square / thousandths as u128).isqrt() + 1;
        if slowest >= SLOWEST {
            return None;
        }
        let slowest = (slowest as u32 + 1) & !1;
        Some(BrakeLaw { slowest: slowest << 8, mantissa: mantissa & !1, exponent: exponent as i8 })
    }

    /// The bytes on the line. At most two bytes in a row are 0xFF, and the last byte never is.
    pub const fn bytes(self) -> [u8; Self::LEN] {
        let [_, a, b, c] = self.slowest.to_le_bytes();
        let [low, high] = self.mantissa.to_le_bytes();
        [a, b, c, low, high, (self.exponent as u8).wrapping_add(64)]
    }

    /// The law of these bytes.
    pub const fn from_bytes(bytes: [u8; Self::LEN]) -> BrakeLaw {
        let [a, b, c, low, high, exponent] = bytes;
        BrakeLaw {
            slowest: u32::from_le_bytes([0, a, b, c]),
            mantissa: u16::from_le_bytes([low, high]),
            exponent: exponent.wrapping_sub(64) as i8,
        }
    }

    /// The interval from which on an axis may rest at once, in 2⁻⁸ ticks.
    pub const fn slowest(self) -> u32 {
        self.slowest
    }

    /// The growth of an interval over 2^bits steps, both in 2⁻⁸ ticks: rounded down, and at most `u32::MAX`.
    pub const fn growth(self, interval: u32, bits: u8) -> u32 {
        let (cube, shift) = self.cube(interval);
        grown(cube, shift, bits)
    }

    /// The growth over one step, as `cube` · 2^shift.
    #[inline(always)]
    const fn cube(self, interval: u32) -> (u32, i8) {
        if interval == 0 {
            return (0, 0);
        }
        // interval = m · 2^(16 − zeros), m of 16 bits; K·c³/2¹⁶ = m³·mantissa·2^(…).
        let (mut m, mut zeros) = (interval, 0i8);
        while m & 0x8000_0000 == 0 {
            m <<= 1;
            zeros = zeros.wrapping_add(1);
        }
        let m = (m >> 16) as u16;
        let cube = upper(upper(m, m), m) as u32 * self.mantissa as u32;
        (cube, self.exponent.saturating_sub(zeros).saturating_sub(zeros).saturating_sub(zeros))
    }
}

/// The upper half of a product.
#[inline(always)]
const fn upper(a: u16, b: u16) -> u16 {
    ((a as u32 * b as u32) >> 16) as u16
}

/// `cube` · 2^(shift + bits), rounded down, and at most `u32::MAX`.
const fn grown(cube: u32, shift: i8, bits: u8) -> u32 {
    let by = shift.saturating_add(bits as i8);
    if by <= -32 {
        0
    } else if by < 0 {
        cube >> by.unsigned_abs()
    } else if cube == 0 {
        0
    } else if cube.leading_zeros() >= by as u32 {
        cube << by
    } else {
        u32::MAX
    }
}

/// A braking axis: an iterator of records that lead from any speed to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Braking {
    /// The interval before the next step.
    last: u32,
    /// The interval after the next step.
    next: u32,
    /// The remainder of that interval after the step, in 2⁻⁸ ticks.
    rest: u32,
}

impl Braking {
    /// At rest.
    pub const NONE: Braking = Braking { last: u32::MAX, next: 0, rest: 0 };

    /// Begins where a trail leads.
    pub const fn from(trail: &Trail) -> Braking {
        if !trail.moves {
            return Braking::NONE;
        }
        let last = shifted(trail.last, trail.halvings);
        let next = if trail.growth < 0 { last } else { shifted(trail.next(), trail.halvings) };
        Braking { last, next, rest: 0 }
    }

    /// The next record; `None` once the axis rests with the end of the record before.
    #[inline(never)]
    pub fn next(&mut self, law: BrakeLaw) -> Option<Record> {
        if self.rest != 0 {
            let (interval, halvings) = self.part();
            let act = RecordAct::Wait { halvings, turn: false };
            return Some(Record { act, interval, growth: 0 });
        }
        if self.last >= law.slowest {
            return None;
        }
        let c = self.next;
        let (cube, shift) = law.cube(c);
        if c >= LONG {
            (self.last, self.rest) = (c, c);
            self.next = c.saturating_add(grown(cube, shift, 0).min(c));
            let (interval, halvings) = self.part();
            let act = RecordAct::Step { halvings, goes_on: true };
            return Some(Record { act, interval, growth: 0 });
        }
        let most = c >> 3;
        let mut bits = 11;
        while bits > 0 && grown(cube, shift, bits) > most {
            bits = bits.wrapping_sub(1);
        }
        if bits == 0 {
            self.last = c;
            self.next = c.saturating_add(grown(cube, shift, 0).min(c));
            return Some(Record { act: RecordAct::Steps(1), interval: c, growth: 0 });
        }
        // 16 groups of 2^(bits − 4) steps, or 2^bits of one.
        let (bits, count) = if bits >= 4 { (bits.wrapping_sub(4), 16) } else { (0, 1 << bits) };
        let growth = grown(cube, shift, bits);
        if growth < FINE {
            // Rounded down it would be too little, or nothing.
            let mut bits = 15u8;
            while bits > 0 && grown(cube, shift, bits) > c >> 7 {
                bits = bits.wrapping_sub(1);
            }
            let growth = grown(cube, shift, bits).max(1);
            (self.last, self.next) = (c.wrapping_add(growth >> 1), c.wrapping_add(growth));
            let act = RecordAct::Steps(1 << bits);
            return Some(Record { act, interval: self.last, growth: 0 });
        }
        // A group has the interval of its middle, so that groups of different lengths join without a jump.
        let half = growth >> 1;
        self.next = c.wrapping_add(growth.wrapping_mul(u32::from(count)));
        self.last = self.next.wrapping_sub(growth.wrapping_sub(half));
        let act = RecordAct::Groups { bits, count };
        Some(Record { act, interval: c.wrapping_add(half), growth: growth as i32 })
    }

    /// The next piece of the remaining wait: the length of a part and `halvings`, for 2^halvings parts.
    fn part(&mut self) -> (u32, u8) {
        let (mut part, mut halvings) = (self.rest, 0u8);
        while part >= PART && halvings < 7 {
            part >>= 1;
            halvings = halvings.wrapping_add(1);
        }
        part = part.min(PART);
        // The loss by rounding is less than half a tick.
        self.rest = self.rest.wrapping_sub(part << halvings);
        if self.rest < 128 {
            self.rest = 0;
        } else if self.rest < SHORT {
            self.rest = SHORT;
        }
        (part, halvings)
    }
}

/// The interval of 2^halvings parts, at most `u32::MAX`.
const fn shifted(part: u32, halvings: u8) -> u32 {
    if part.leading_zeros() >= halvings as u32 { part << (halvings & 31) } else { u32::MAX }
}
