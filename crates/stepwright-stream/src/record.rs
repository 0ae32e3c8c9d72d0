//! Records: entries of all axes, compressed.
//!
//! A data frame has a *gate*, the start of its first record in 2¹⁶ ticks modulo 256, and records of all axes
//! in the order of their starts. A record is an [entry](stepwright::entry): an event on the pins and a wait,
//! repeated many times. A record does not say when it starts: it starts where the last record of its axis
//! ends.
//!
//! ```text
//!   ┌──────┬──────┬─────────┐
//!   │ axis │ form │ small   │  then numbers
//!   │ 7  6 │ 5  4 │ 3 2 1 0 │
//!   └──────┴──────┴─────────┘
//!   form 0  steps      small: their number, 1 … 15; 0: a byte says it; that is 0: two bytes do
//!                      number: interval
//!   form 1  groups     small: b, of 2^b steps each, 0 … 8; a byte: how many, 2 … 255
//!                      numbers: interval of the first group, growth from group to group
//!   form 2  a step     small: 2^(small & 7) waits, and 8 if the next event is a step as well
//!                      number: the wait
//!   form 3  no step    small: 2^(small & 7) waits, and 8 if DIR turns before them
//!                      number: the wait
//!   0xC0    nothing    one byte, at the end of a frame
//!   0xD…    power      of a laser: see [`crate::power`]
//! ```
//!
//! Waits are in 2⁻⁸ ticks. Waits of records with less than 64 steps, and of forms 2 and 3, are multiples of
//! 2⁻⁴ ticks, and sent in that unit. A number is the difference from the value that the axis' last record
//! leads to. It is signed, and has a prefix: `0b00` and 6 bits, `0b01` and 14, `0b10` and 22, the highest
//! bits first.

use stepwright::Ticks;
use stepwright::entry::{Entry, EntryParts, NEAR, Wiring};

/// The most axes of a stream. The fourth number of the two bits is of [`NOTHING`] and of a laser's
/// [power](crate::power).
pub const AXES: usize = 3;
/// A byte that ends a frame which would otherwise have four bytes of 0xFF in a row.
pub const NOTHING: u8 = 0xC0;
/// The most bytes of a record.
pub const MOST: usize = 8;

/// The first wait that is too long for one event, in 2⁻⁸ ticks.
pub const FAR: u32 = NEAR << 8;

/// The events of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordAct {
    /// Steps at one interval: 1 … 65535 of them.
    Steps(u16),
    /// Groups of 2^bits steps. The interval grows from group to group.
    Groups {
        /// 0 … 8.
        bits: u8,
        /// 2 … 255.
        count: u8,
    },
    /// One step, and 2^halvings waits.
    Step {
        /// 0 … 7.
        halvings: u8,
        /// The next event is a step the same way: the wait is an interval.
        goes_on: bool,
    },
    /// No step, and 2^halvings waits.
    Wait {
        /// 0 … 7.
        halvings: u8,
        /// DIR turns first.
        turn: bool,
    },
}

/// One entry of an axis, as it is streamed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// The events.
    pub act: RecordAct,
    /// The wait after each event of the first group, in 2⁻⁸ ticks.
    pub interval: u32,
    /// The growth of the interval from group to group, in 2⁻⁸ ticks.
    pub growth: i32,
}

impl RecordAct {
    /// The number of steps.
    pub const fn steps(self) -> u32 {
        match self {
            RecordAct::Steps(count) => count as u32,
            RecordAct::Groups { bits, count } => (count as u32) << (bits & 15),
            RecordAct::Step { .. } => 1,
            RecordAct::Wait { .. } => 0,
        }
    }

    /// The number of low bits that are not sent, as they are 0.
    const fn coarse(self) -> u32 {
        match self {
            RecordAct::Steps(64..) => 0,
            RecordAct::Groups { bits, count } if (count as u32) << (bits & 15) >= 64 => 0,
            _ => 4,
        }
    }
}

impl Record {
    /// The duration of the record, in 2⁻⁸ ticks.
    pub const fn time(&self) -> u64 {
        match self.act {
            RecordAct::Steps(count) => self.interval as u64 * count as u64,
            RecordAct::Groups { bits, count } => {
                let (groups, first) = (count as i64, self.interval as i64);
                let grown = self.growth as i64 * (groups * (groups - 1) / 2);
                ((first * groups + grown) << (bits & 15)) as u64
            }
            RecordAct::Step { halvings, .. } | RecordAct::Wait { halvings, .. } => {
                (self.interval as u64) << (halvings & 7)
            }
        }
    }

    /// The interval of the last group, in 2⁻⁸ ticks.
    pub const fn last(&self) -> u32 {
        match self.act {
            RecordAct::Groups { count, .. } => self
                .interval
                .wrapping_add((self.growth as u32).wrapping_mul(count.wrapping_sub(1) as u32)),
            _ => self.interval,
        }
    }

    /// Whether step interrupts can play the record: its count is within its range, and each wait is at least
    /// `least` ticks and shorter than [`NEAR`].
    #[inline(always)]
    pub const fn is_playable(&self, least: Ticks) -> bool {
        let (least, span) = (least << 8, FAR.wrapping_sub(least << 8));
        let counted =
            !matches!(self.act, RecordAct::Steps(0) | RecordAct::Groups { count: ..2, .. });
        counted
            && self.interval.wrapping_sub(least) < span
            && self.last().wrapping_sub(least) < span
    }

    /// The entry for the queue of an axis with this wiring.
    #[inline(always)]
    pub const fn entry(&self, wiring: Wiring) -> Entry {
        let (mut events, mut groups, mut pins, mut then) = (1, 1, wiring.step, wiring.step);
        match self.act {
            RecordAct::Steps(count) => events = count as u32,
            RecordAct::Groups { bits, count } => {
                (events, groups) = (1 << (bits & 15), count as u32)
            }
            RecordAct::Step { halvings, .. } => (groups, then) = (1 << (halvings & 7), 0),
            RecordAct::Wait { halvings, turn } => {
                (groups, then) = (1 << (halvings & 7), 0);
                pins = if turn { wiring.turn } else { 0 };
            }
        }
        let (interval, growth) = (self.interval << 8, self.growth << 8);
        EntryParts { pins, then, events, groups, interval, growth }.entry()
    }
}

/// The state that the last record of an axis leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trail {
    /// The interval of the last group, in 2⁻⁸ ticks; of a wait in parts the length of one part.
    pub last: u32,
    /// The growth of that interval from group to group.
    pub growth: i32,
    /// The wait has 2^halvings equal parts.
    pub halvings: u8,
    /// The next event is a step the same way: the wait is a step interval.
    pub moves: bool,
}

impl Trail {
    /// Before the first record.
    pub const NONE: Trail = Trail { last: 0, growth: 0, halvings: 0, moves: false };

    /// The interval that would come next if the record went on.
    #[inline(always)]
    pub const fn next(&self) -> u32 {
        self.last.wrapping_add(self.growth as u32)
    }

    /// The value that a record's first number is relative to, without the bits that are not sent.
    const fn from(&self, coarse: u32) -> u32 {
        (self.next() & 0xFF_FFFF) >> coarse
    }

    /// Moves on over a record.
    #[inline(always)]
    pub const fn pass(&mut self, record: &Record) {
        self.last = record.last();
        (self.growth, self.halvings, self.moves) = (0, 0, true);
        match record.act {
            RecordAct::Steps(_) => {}
            RecordAct::Groups { .. } => self.growth = record.growth,
            RecordAct::Step { halvings, goes_on } => {
                (self.halvings, self.moves) = (halvings, goes_on)
            }
            RecordAct::Wait { halvings, .. } => (self.halvings, self.moves) = (halvings, false),
        }
    }
}

/// The bytes of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordBytes {
    bytes: [u8; MOST],
    len: u8,
}

impl RecordBytes {
    /// Encodes a record of an axis, 0 … 2, that follows this trail. `None` if a number is too large to be
    /// sent, if the interval has bits that are not sent, or if a count is out of range.
    pub fn new(axis: u8, record: &Record, trail: &Trail) -> Option<RecordBytes> {
        let mut to = RecordBytes { bytes: [0; MOST], len: 0 };
        let (coarse, head) = (record.act.coarse(), axis << 6);
        let mut grows = false;
        match record.act {
            RecordAct::Steps(0) => return None,
            RecordAct::Steps(count @ ..=15) => to.push(head | count as u8),
            RecordAct::Steps(count @ ..=255) => {
                to.push(head);
                to.push(count as u8);
            }
            RecordAct::Steps(count) => {
                let [low, high] = count.to_le_bytes();
                [head, 0, low, high].into_iter().for_each(|byte| to.push(byte));
            }
            RecordAct::Groups { bits: 9.., .. } | RecordAct::Groups { count: 0 | 1, .. } => {
                return None;
            }
            RecordAct::Groups { bits, count } => {
                to.push(head | 0x10 | bits);
                to.push(count);
                grows = true;
            }
            RecordAct::Step { halvings: 8.., .. } | RecordAct::Wait { halvings: 8.., .. } => {
                return None;
            }
            RecordAct::Step { halvings, goes_on } => {
                to.push(head | 0x20 | u8::from(goes_on) << 3 | halvings)
            }
            RecordAct::Wait { halvings, turn } => {
                to.push(head | 0x30 | u8::from(turn) << 3 | halvings)
            }
        }
        let mask = (1 << coarse) - 1;
        if usize::from(axis) >= AXES
            || record.interval & mask != 0
            || record.growth as u32 & mask != 0
            || record.interval >> 24 != 0
        {
            return None;
        }
        to.number((record.interval >> coarse).wrapping_sub(trail.from(coarse)) as i32)?;
        if grows {
            to.number(record.growth >> coarse)?;
        }
        Some(to)
    }

    fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(usize::from(self.len)) {
            *place = byte;
            self.len = self.len.wrapping_add(1);
        }
    }

    /// Appends a number with its prefix.
    fn number(&mut self, number: i32) -> Option<()> {
        let [_, high, middle, low] = number.to_be_bytes();
        match number {
            -32..32 => self.push(low & 0x3F),
            -0x2000..0x2000 => {
                self.push(0x40 | middle & 0x3F);
                self.push(low);
            }
            -0x20_0000..0x20_0000 => {
                self.push(0x80 | high & 0x3F);
                self.push(middle);
                self.push(low);
            }
            _ => return None,
        }
        Some(())
    }

    /// The bytes, in order.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or(&[])
    }
}

/// Reads a number of 6, 14 or 22 bits.
#[inline(never)]
fn number(mut byte: impl FnMut() -> u8) -> i32 {
    let first = byte();
    let top = ((first << 2) as i8) >> 2;
    if first & 0xC0 == 0 {
        return top.into();
    }
    let second = byte();
    if first & 0x80 == 0 {
        return i16::from_be_bytes([top as u8, second]).into();
    }
    let sign = if top < 0 { 0xFF } else { 0 };
    i32::from_be_bytes([sign, top as u8, second, byte()])
}

/// Decodes a record. The caller has read the first byte, `head`, which tells the [axis](axis_of) and so the
/// trail; `byte` returns the following bytes. The trail moves on. Any bytes decode to a record: check it by
/// [`is_playable`](Record::is_playable).
#[inline(always)]
pub fn decode(head: u8, trail: &mut Trail, mut byte: impl FnMut() -> u8) -> Record {
    let small = head & 15;
    let act = match head & 0x30 {
        0 => RecordAct::Steps(if small != 0 {
            small.into()
        } else {
            match byte() {
                0 => {
                    let low = byte();
                    u16::from_le_bytes([low, byte()])
                }
                count => count.into(),
            }
        }),
        0x10 => RecordAct::Groups { bits: if small < 8 { small } else { 8 }, count: byte() },
        0x20 => RecordAct::Step { halvings: small & 7, goes_on: small & 8 != 0 },
        _ => RecordAct::Wait { halvings: small & 7, turn: small & 8 != 0 },
    };
    let coarse = act.coarse() != 0;
    // Shifts by four bits or none: an 8-bit chip is slow at shifts by a variable.
    let mut interval = trail.next() & if coarse { 0xFF_FFF0 } else { 0xFF_FFFF };
    let apart = number(&mut byte);
    interval = interval.wrapping_add((if coarse { apart << 4 } else { apart }) as u32);
    let mut growth = 0;
    if let RecordAct::Groups { .. } = act {
        growth = number(&mut byte);
        if coarse {
            growth <<= 4;
        }
    }
    let record = Record { act, interval: interval & 0xFF_FFFF, growth };
    trail.pass(&record);
    record
}

/// The axis of a record, from its first byte; `None` for [`NOTHING`] and for a change of the
/// [power](crate::power).
#[inline(always)]
pub const fn axis_of(head: u8) -> Option<u8> {
    let axis = head >> 6;
    if axis < AXES as u8 { Some(axis) } else { None }
}
