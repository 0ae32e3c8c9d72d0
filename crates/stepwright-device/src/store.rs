//! The settings where they outlast a loss of power.
//!
//! Two copies take turns:
//!
//! ```text
//!   address   0       1         2 …       then                     then
//!             mark    sequence  settings  CRC-16 of the last two   end mark
//! ```
//!
//! The older copy is written over: first its end mark is taken away, then its mark,
//! then the bytes are written, then the end mark is set again, and then the mark. It
//! counts only with both. So at every moment, also in the middle of a byte, the newer
//! copy is whole, and the older one does not count before it is whole too. The
//! sequence number, which wraps, says which is newer. The CRC finds what decays later.
//!
//! A byte whose writing is cut off may hold anything afterwards, a mark too. One mark
//! would not do: if the power goes while it is set, the copy may be lost though all
//! else is whole; and if it goes again while that mark is taken away for the next
//! settings, it may be set after all, and what was lost is back. Of two, one at least
//! is surely not set while the other is in doubt over bytes that don't count.

use stepwright_protocol::Settings;

use crate::panel::Memory;

/// A copy that is whole begins with this byte.
const MARK: u8 = 0x50 | Settings::LAYOUT;
/// A copy that does not count begins with this one, as an empty EEPROM does.
const NO_MARK: u8 = 0xFF;

/// From the mark of one copy to that of the other.
const APART: u8 = 128;

/// Where in a copy the parts are.
const SEQUENCE: u8 = 1;
const VALUES: u8 = 2;
const CRC: u8 = VALUES + Settings::SIZE as u8;
const END: u8 = CRC + 2;
/// Behind them all comes the mark.
const LAST: u8 = END + 1;

/// No step of the writing: all is written.
const DONE: u8 = 0;
/// The first, which takes the end mark away, and the second, which takes the mark. The
/// next write one byte each, the end mark among them; the last sets the mark.
const FIRST: u8 = 1;
const SECOND: u8 = 2;

/// Writes settings in the background, a byte at a time.
#[derive(Clone, Debug)]
pub struct Store {
    /// The sequence number that the next copy gets. Even ones are the first copy.
    sequence: u8,
    /// The next step of the writing.
    step: u8,
    /// Of what is written so far.
    crc: u16,
}

impl Store {
    /// Bytes of memory that it takes, from address 0.
    pub const SIZE: u16 = 2 * APART as u16;

    /// A store that has found nothing yet.
    pub(crate) const NEW: Store = Store { sequence: 0, step: DONE, crc: 0 };

    /// Finds the newest settings; the defaults where there are none.
    pub fn load(memory: &mut impl Memory) -> (Store, Settings) {
        let (mut store, mut settings) = (Store::NEW, Settings::blank());
        store.find(memory, &mut settings);
        (store, settings)
    }

    /// [`load`](Store::load), in place.
    pub(crate) fn find(&mut self, memory: &mut impl Memory, settings: &mut Settings) {
        let mut newest = check(memory, 0);
        if let Some(second) = check(memory, 1)
            && newest.is_none_or(|first| is_newer(second, first))
        {
            newest = Some(second);
        }
        let Some(sequence) = newest else {
            settings.reset();
            return;
        };
        let mut address = place(sequence, VALUES);
        settings.load(|| {
            let byte = memory.read(address);
            address = address.wrapping_add(1);
            byte
        });
        self.sequence = sequence.wrapping_add(1);
    }

    /// The settings have changed: they are to be written, from the beginning
    /// if that is going on already.
    pub fn save(&mut self) {
        self.step = FIRST;
        self.crc = u16::MAX;
    }

    /// Whether something is still to be written.
    pub fn is_saving(&self) -> bool {
        self.step != DONE
    }

    /// Does a step of the writing, if the memory has time: at most one byte,
    /// and only one that differs. Call it again and again.
    pub fn poll(&mut self, memory: &mut impl Memory, settings: &Settings) {
        if self.step == DONE || memory.is_writing() {
            return;
        }
        let step = self.step;
        self.step = step.wrapping_add(1);
        let sequence = self.sequence;
        let [low, high] = self.crc.to_le_bytes();
        let mut at = step.wrapping_sub(SECOND);
        let byte = match at {
            u8::MAX => {
                at = END;
                NO_MARK
            }
            0 => NO_MARK,
            SEQUENCE => sequence,
            VALUES..CRC => {
                let value = settings.bytes().get(usize::from(at.wrapping_sub(VALUES)));
                value.copied().unwrap_or(0)
            }
            CRC => high,
            END => MARK,
            LAST => {
                at = 0;
                self.sequence = sequence.wrapping_add(1);
                self.step = DONE;
                MARK
            }
            _ => low,
        };
        if (SEQUENCE..CRC).contains(&at) {
            self.crc = crc(self.crc, byte);
        }
        let address = place(sequence, at);
        if memory.read(address) != byte {
            memory.start_write(address, byte);
        }
    }
}

/// The address of a byte of the copy with this sequence number.
fn place(sequence: u8, at: u8) -> u16 {
    u16::from((sequence & 1).wrapping_mul(APART).wrapping_add(at))
}

/// The sequence number of a copy, if it is whole.
#[inline(never)]
fn check(memory: &mut impl Memory, copy: u8) -> Option<u8> {
    // The sum of bytes and their sum, its high byte first, is 0.
    let sum = (SEQUENCE..END).fold(u16::MAX, |sum, at| crc(sum, memory.read(place(copy, at))));
    let whole =
        sum == 0 && memory.read(place(copy, 0)) == MARK && memory.read(place(copy, END)) == MARK;
    whole.then(|| memory.read(place(copy, SEQUENCE)))
}

/// Whether a sequence number that wraps comes after another.
fn is_newer(sequence: u8, than: u8) -> bool {
    (sequence.wrapping_sub(than) as i8) > 0
}

/// CRC-16/IBM-3740: polynomial 0x1021, begun with 0xFFFF. Bit by bit it would
/// be eight loops; this takes the same sum in a few shifts, about 40 cycles on
/// an AVR.
#[inline(never)]
fn crc(crc: u16, byte: u8) -> u16 {
    let [low, high] = crc.to_le_bytes();
    let mut top = high ^ byte;
    top ^= top >> 4;
    let top = u16::from(top);
    u16::from_be_bytes([low, 0]) ^ top << 12 ^ top << 5 ^ top
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_the_known_one() {
        // The check value of CRC-16/IBM-3740.
        assert_eq!(b"123456789".iter().fold(u16::MAX, |sum, byte| crc(sum, *byte)), 0x29B1);
    }

    #[test]
    fn sequence_numbers_wrap() {
        assert!(is_newer(0, 255) && is_newer(1, 0) && !is_newer(255, 0) && !is_newer(7, 7));
    }

    #[test]
    fn a_copy_fits_its_place() {
        const { assert!(END < APART) };
    }
}
