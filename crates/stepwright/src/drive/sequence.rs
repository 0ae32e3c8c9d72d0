//! Tables of the levels of a motor's windings in each step.
//!
//! A line is an input of the driver: bit 0 is the first one named. Rows are steps. A motor that
//! turns forward goes through them from top to bottom, then begins again.
//!
//! ```text
//!        B+
//!     3  │  2        full step: two windings on   1 2 3 4 …  (the Arduino driver and Austin)
//!   A− ──┼── A+      wave:      one winding on
//!     0  │  1        half:      both in turn
//!        B−
//! ```
//!
//! Sources: the Arduino driver, sections 1 and 2 (bipolar `--`, `+-`, `++`, `-+`; unipolar 1001,
//! 1100, 0110, 0011, where 1 does not conduct); Austin, the L6219 (two phase inputs
//! in Gray order 00, 01, 11, 10, and currents of 0, 33, 67 and 100 %).

use core::fmt;

/// Rows of the longest table: quarter steps.
pub(super) const ROWS: usize = 16;

/// The levels of up to 8 lines in each of up to 16 steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    rows: [u8; ROWS],
    len: u8,
    lines: u8,
    /// The levels without current.
    off: u8,
    /// Whether the current goes off after the last step.
    rests: bool,
}

const fn rows(some: &[u8]) -> [u8; ROWS] {
    let mut rows = [0; ROWS];
    let (mut rest, mut at) = (some, 0);
    while let [row, more @ ..] = rest {
        if at < ROWS {
            rows[at] = *row;
        }
        (rest, at) = (more, at + 1);
    }
    rows
}

/// The motor shield's bridges: DIR A is line 0, DIR B line 1. Each also drives the bridge's other
/// input, inverted, so that current flows until the enables fall.
pub const SHIELD: Sequence = Sequence::plain(2, &[0b00, 0b01, 0b11, 0b10]);

/// The four inputs of two bridges, each on a line: In1, In2 (winding A), In3, In4 (winding B). A
/// winding is off while both its inputs are low.
pub const BRIDGE_FULL: Sequence = Sequence::plain(4, &[0b1010, 0b1001, 0b0101, 0b0110]);
/// One winding at a time.
pub const BRIDGE_WAVE: Sequence = Sequence::plain(4, &[0b1000, 0b0001, 0b0100, 0b0010]);
/// Half steps.
pub const BRIDGE_HALF: Sequence =
    Sequence::plain(4, &[0b1010, 0b1000, 0b1001, 0b0001, 0b0101, 0b0100, 0b0110, 0b0010]);

/// A Darlington driver (ULN2003, 2004, 2803) of phases A to D, lines 0 to 3; a high line conducts.
/// In the article's 1001, 1100, 0110, 0011 the digits are A to D, and a 1 does not conduct.
pub const UNIPOLAR_FULL: Sequence = Sequence::plain(4, &[0b0110, 0b1100, 0b1001, 0b0011]);
/// One phase at a time.
pub const UNIPOLAR_WAVE: Sequence = Sequence::plain(4, &[0b0100, 0b1000, 0b0001, 0b0010]);
/// Half steps.
pub const UNIPOLAR_HALF: Sequence =
    Sequence::plain(4, &[0b0110, 0b0100, 0b1100, 0b1000, 0b1001, 0b0001, 0b0011, 0b0010]);

/// The L6219's lines: PHASE1, PHASE2, I01, I11, I02, I12. With both I lines of a winding low it
/// gets 100 % of the set current; with I0 high 67 %, with I1 high 33 %, with both high 0.
const fn l6219(phases: u8, one: Current, two: Current) -> u8 {
    phases | (one as u8) << 2 | (two as u8) << 4
}

/// The current of a winding, as I0 (bit 0) and I1 (bit 1).
#[derive(Clone, Copy)]
enum Current {
    Full = 0b00,
    TwoThirds = 0b01,
    Third = 0b10,
    None = 0b11,
}
use Current::{Full, None as Zero, Third, TwoThirds};

const L6219_OFF: u8 = l6219(0, Zero, Zero);

/// The L6219 in full steps: both windings at 100 %.
pub const L6219_FULL: Sequence = Sequence::with_off(
    6,
    &[
        l6219(0b00, Full, Full),
        l6219(0b01, Full, Full),
        l6219(0b11, Full, Full),
        l6219(0b10, Full, Full),
    ],
    L6219_OFF,
);

/// The L6219 in half steps: one winding at 100 %, or both at 67 %, so that the torque is even (94.8
/// % between the full steps).
pub const L6219_HALF: Sequence = Sequence::with_off(
    6,
    &[
        l6219(0b00, TwoThirds, TwoThirds),
        l6219(0b00, Zero, Full),
        l6219(0b01, TwoThirds, TwoThirds),
        l6219(0b01, Full, Zero),
        l6219(0b11, TwoThirds, TwoThirds),
        l6219(0b11, Zero, Full),
        l6219(0b10, TwoThirds, TwoThirds),
        l6219(0b10, Full, Zero),
    ],
    L6219_OFF,
);

/// The L6219 in quarter steps: 100 and 33 % in between, 105.4 % of the torque.
pub const L6219_QUARTER: Sequence = Sequence::with_off(
    6,
    &[
        l6219(0b00, TwoThirds, TwoThirds),
        l6219(0b00, Third, Full),
        l6219(0b00, Zero, Full),
        l6219(0b01, Third, Full),
        l6219(0b01, TwoThirds, TwoThirds),
        l6219(0b01, Full, Third),
        l6219(0b01, Full, Zero),
        l6219(0b11, Full, Third),
        l6219(0b11, TwoThirds, TwoThirds),
        l6219(0b11, Third, Full),
        l6219(0b11, Zero, Full),
        l6219(0b10, Third, Full),
        l6219(0b10, TwoThirds, TwoThirds),
        l6219(0b10, Full, Third),
        l6219(0b10, Full, Zero),
        l6219(0b00, Full, Third),
    ],
    L6219_OFF,
);

impl Sequence {
    const fn plain(lines: u8, levels: &[u8]) -> Sequence {
        Sequence::with_off(lines, levels, 0)
    }

    const fn with_off(lines: u8, levels: &[u8], off: u8) -> Sequence {
        Sequence { rows: rows(levels), len: levels.len() as u8, lines, off, rests: off != 0 }
    }

    /// A custom table, such as the Arduino driver's `MOTOR_PATTERN0` … 3 on port bits, with its
    /// `MOTOR_OUTPUTS` as `mask`.
    ///
    /// ```
    /// use stepwright::drive::Sequence;
    /// let four = [0b0011_0000, 0b0110_0000, 0b1100_0000, 0b1001_0000];
    /// assert!(Sequence::new(&four, 0b1111_0000).is_ok());
    /// assert!(Sequence::new(&four, 0b0111_0000).is_err()); // a pattern beyond the outputs
    /// ```
    ///
    /// # Errors
    /// [`BadSequence`] unless the table has 2, 4, 8 or 16 rows within `mask`.
    pub const fn new(levels: &[u8], mask: u8) -> Result<Sequence, BadSequence> {
        let len = levels.len();
        if len < 2 || len > ROWS || !len.is_power_of_two() {
            return Err(BadSequence::Length);
        }
        let mut rest = levels;
        while let [row, more @ ..] = rest {
            if *row & !mask != 0 {
                return Err(BadSequence::Outside);
            }
            rest = more;
        }
        let lines = 8 - mask.leading_zeros() as u8;
        Ok(Sequence { rows: rows(levels), len: len as u8, lines, off: 0, rests: false })
    }

    /// This table with the levels without current, and whether they follow the last step.
    pub const fn with_rest(self, off: u8, rests: bool) -> Sequence {
        Sequence { off, rests, ..self }
    }

    /// This table with every level inverted: for a driver that conducts while low.
    pub const fn inverted(self) -> Sequence {
        let all = self.all();
        let mut rows = self.rows;
        let mut at = 0;
        while at < ROWS {
            rows[at] ^= all;
            at += 1;
        }
        Sequence { rows, off: self.off ^ all, ..self }
    }

    /// This table on other bits: line i moves to bit `bits[i]`; a line without a bit is dropped.
    pub fn on_bits(&self, bits: &[u8]) -> Sequence {
        let moved = |levels: u8| {
            let lines = bits.iter().enumerate().take(self.lines.into());
            let high = lines.filter(|(line, _)| levels >> line & 1 != 0);
            high.fold(0, |all, (_, bit)| all | 1u8.checked_shl((*bit).into()).unwrap_or(0))
        };
        let (rows, off) = (self.rows.map(moved), moved(self.off));
        Sequence { rows, off, lines: 8, ..*self }
    }

    /// The number of steps until the table repeats.
    #[allow(clippy::len_without_is_empty, reason = "it never is")]
    pub const fn len(&self) -> u8 {
        self.len
    }

    /// The number of lines.
    pub const fn lines(&self) -> u8 {
        self.lines
    }

    /// The mask of all lines.
    const fn all(&self) -> u8 {
        if self.lines >= 8 { 0xFF } else { (1 << self.lines) - 1 }
    }

    /// The levels in step `phase`, modulo the length.
    #[inline(always)]
    pub const fn levels(&self, phase: u8) -> u8 {
        // The mask keeps the index within the table.
        self.rows[(phase & (self.len - 1) & (ROWS as u8 - 1)) as usize]
    }

    /// The levels without current.
    pub const fn off(&self) -> u8 {
        self.off
    }

    /// This table with the current off one interval after the last step: for a unipolar motor or
    /// bridges that need not hold. The motor shield's lines can't switch the current off; its
    /// enables do.
    pub const fn resting(self) -> Sequence {
        Sequence { rests: true, ..self }
    }

    /// This table with the current on after the last step, where an L6219 has to hold.
    pub const fn holding(self) -> Sequence {
        Sequence { rests: false, ..self }
    }

    /// Whether the current must go off one interval after the last step, as Austin has it for the
    /// L6219. Other drivers hold the motor until they are switched off, unless the table is
    /// [`resting`](Sequence::resting).
    pub const fn rests(&self) -> bool {
        self.rests
    }

    /// The step after this one, or before it if not `forward`.
    #[inline(always)]
    pub const fn after(&self, phase: u8, forward: bool) -> u8 {
        let step = if forward { 1 } else { u8::MAX };
        phase.wrapping_add(step) & (self.len - 1)
    }
}

/// Why a table is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadSequence {
    /// It does not have 2, 4, 8 or 16 rows.
    Length,
    /// A row has a bit outside the mask.
    Outside,
}

impl fmt::Display for BadSequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            BadSequence::Length => "a sequence has 2, 4, 8 or 16 steps; give as many patterns",
            BadSequence::Outside => {
                "a pattern has a bit that is no output; add the bit to the outputs, or clear it"
            }
        })
    }
}

impl core::error::Error for BadSequence {}

#[cfg(test)]
mod tests;
