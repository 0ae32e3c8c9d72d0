//! The boot loader of a Mega: the part of STK500 version 2 that writes flash.
//!
//! Atmel's application note AVR068 has the protocol. A command is a message, and so is its
//! answer, with the same number:
//!
//! ```text
//!   1B  number  size high  size low  0E  body …  checksum        the checksum: XOR of all before
//!
//!   01                             → 01 00, 08, "AVRISP_2" or another name   who is there?
//!   1B 04 30 00 n 00               → 1B 00, byte n of the signature, 00      which chip?
//!   10 …                           → 10 00       programming begins
//!   06, an address in words        → 06 00       four bytes, the highest first
//!   13, size, …, a page            → 13 00       writes it
//!   14, size, 20                   → 14 00, a page, 00
//!   11 01 01                       → 11 00       programming ends, and the program begins
//! ```
//!
//! The second byte of an answer is 00 if the command was carried out. Parameters for the chip's
//! serial interface (delays, opcodes) are for programmers; a boot loader ignores them.

use std::time::Duration;

use crate::loader::{KNOCK, Loader, LoaderError, PATIENCE, fill};
use stepwright_host::link::Link;

/// Begins a message.
const START: u8 = 0x1B;
/// Separates the head of a message from its body.
const TOKEN: u8 = 0x0E;
/// The status of a command that was carried out.
const OK: u8 = 0;
/// The signature of an ATmega2560.
const CHIP: [u8; 3] = [0x1E, 0x98, 0x01];
/// The longest body.
const LONGEST: usize = 275;

const SIGN_ON: u8 = 0x01;
const LOAD_ADDRESS: u8 = 0x06;
const ENTER: u8 = 0x10;
const LEAVE: u8 = 0x11;
const WRITE_FLASH: u8 = 0x13;
const READ_FLASH: u8 = 0x14;
const READ_SIGNATURE: u8 = 0x1B;

/// The bit of an address for memory larger than 64 KiB.
const LARGE: u32 = 1 << 31;

/// A conversation with the boot loader of a Mega.
pub struct Stk500v2<L> {
    link: L,
    /// The number of the last message.
    number: u8,
}

impl<L: Link> Stk500v2<L> {
    /// A conversation with a board on this line.
    pub fn new(link: L) -> Stk500v2<L> {
        Stk500v2 { link, number: 0 }
    }

    /// Sets the address.
    fn seek(&mut self, address: usize) -> Result<(), LoaderError> {
        let words = (address / 2) as u32 | LARGE;
        let body = [&[LOAD_ADDRESS][..], &words.to_be_bytes()].concat();
        self.ask(&body, PATIENCE).map(|_| ())
    }

    /// Sends a command. Returns the answer's data after command and status.
    fn ask(&mut self, body: &[u8], limit: Duration) -> Result<Vec<u8>, LoaderError> {
        self.number = self.number.wrapping_add(1);
        let message = message(self.number, body);
        self.link.write(&message).map_err(LoaderError::Line)?;
        let end = self.link.now() + limit;
        let mut head = [0; 5];
        fill(&mut self.link, &mut head, end)?;
        let [START, number, high, low, TOKEN] = head else { return Err(LoaderError::Odd) };
        let size = usize::from(u16::from_be_bytes([high, low]));
        if number != self.number || size > LONGEST {
            return Err(LoaderError::Odd);
        }
        let mut rest = vec![0; size + 1];
        fill(&mut self.link, &mut rest, end)?;
        let sum = head.iter().chain(&rest).fold(0, |sum, byte| sum ^ byte);
        rest.pop();
        match (rest.split_first_chunk(), body.first()) {
            (Some(([command, status], data)), Some(asked)) if sum == 0 && command == asked => {
                if *status == OK {
                    Ok(data.to_vec())
                } else {
                    Err(LoaderError::Refused)
                }
            }
            _ => Err(LoaderError::Odd),
        }
    }
}

/// A body with its head and its checksum.
fn message(number: u8, body: &[u8]) -> Vec<u8> {
    let [high, low] = (body.len() as u16).to_be_bytes();
    let mut message = [&[START, number, high, low, TOKEN], body].concat();
    message.push(message.iter().fold(0, |sum, byte| sum ^ byte));
    message
}

impl<L: Link> Loader for Stk500v2<L> {
    type Link = L;
    const PAGE: usize = 256;

    fn link(&mut self) -> &mut L {
        &mut self.link
    }

    fn knock(&mut self) -> Result<(), LoaderError> {
        self.ask(&[SIGN_ON], KNOCK).map(|_| ())
    }

    fn enter(&mut self) -> Result<(), LoaderError> {
        let mut chip = [0; 3];
        for (n, byte) in (0..).zip(&mut chip) {
            let answer = self.ask(&[READ_SIGNATURE, 4, 0x30, 0, n, 0], PATIENCE)?;
            let [is, OK] = answer.as_slice() else { return Err(LoaderError::Odd) };
            *byte = *is;
        }
        if chip != CHIP {
            return Err(LoaderError::Chip(chip));
        }
        // Delays in ms, and the opcode that enables programming.
        let body = [ENTER, 200, 100, 25, 32, 0, 0x53, 3, 0xAC, 0x53, 0, 0];
        self.ask(&body, PATIENCE).map(|_| ())
    }

    fn write_page(&mut self, address: usize, page: &[u8]) -> Result<(), LoaderError> {
        self.seek(address)?;
        let [high, low] = (page.len() as u16).to_be_bytes();
        // Page mode, polled until the chip is ready; three opcodes.
        let head = [WRITE_FLASH, high, low, 0xC1, 10, 0x40, 0x4C, 0x20, 0, 0];
        self.ask(&[&head, page].concat(), PATIENCE).map(|_| ())
    }

    fn read_page(&mut self, address: usize, into: &mut [u8]) -> Result<(), LoaderError> {
        self.seek(address)?;
        let [high, low] = (into.len() as u16).to_be_bytes();
        let answer = self.ask(&[READ_FLASH, high, low, 0x20], PATIENCE)?;
        match answer.split_last() {
            Some((&OK, page)) if page.len() == into.len() => {
                into.copy_from_slice(page);
                Ok(())
            }
            _ => Err(LoaderError::Odd),
        }
    }

    fn leave(&mut self) -> Result<(), LoaderError> {
        self.ask(&[LEAVE, 1, 1], PATIENCE).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    const PAGE: usize = Stk500v2::<Board>::PAGE;
    /// The boot loader has the last 8 KiB.
    const ROOM: usize = 0x3_E000;

    /// A boot loader by the application note.
    struct Board {
        flash: Vec<u8>,
        at: usize,
        open: bool,
        said: Vec<u8>,
        chip: [u8; 3],
        /// Ignores this many messages.
        deaf: usize,
        /// A byte of flash that can't be written.
        worn: Option<usize>,
        /// Changes the next answer.
        spoil: Option<fn(&mut Vec<u8>)>,
        now: Duration,
    }

    impl Board {
        fn new() -> Board {
            Board {
                flash: vec![0xFF; ROOM],
                at: 0,
                open: false,
                said: Vec::new(),
                chip: CHIP,
                deaf: 0,
                worn: None,
                spoil: None,
                now: Duration::ZERO,
            }
        }

        /// The body of the answer to a body.
        fn answer(&mut self, body: &[u8]) -> Vec<u8> {
            let data = match *body {
                [0x01] => b"\x08AVRISP_2".to_vec(),
                [0x1B, 4, 0x30, 0, n @ 0..3, 0] => vec![self.chip[usize::from(n)], 0],
                [0x10, _, _, _, _, _, 0x53, 3, 0xAC, 0x53, 0, 0] => {
                    self.open = true;
                    vec![]
                }
                // Addresses are in words, and advance with each write or read.
                [0x06, 0x80, a, b, c] => {
                    self.at = 2 * u32::from_be_bytes([0, a, b, c]) as usize;
                    vec![]
                }
                [0x13, high, low, mode, _, _, _, _, _, _, ref page @ ..] if self.open => {
                    assert_eq!(usize::from(u16::from_be_bytes([high, low])), page.len());
                    assert!(mode & 0x81 == 0x81, "a whole page, and then it is written");
                    assert!(self.at.is_multiple_of(PAGE) && page.len() == PAGE);
                    self.flash[self.at..][..PAGE].copy_from_slice(page);
                    self.at += PAGE;
                    if let Some(worn) = self.worn {
                        self.flash[worn] = 0;
                    }
                    vec![]
                }
                [0x14, high, low, _] if self.open => {
                    let count = usize::from(u16::from_be_bytes([high, low]));
                    let page = self.flash[self.at..][..count].to_vec();
                    self.at += count;
                    [page, vec![0]].concat()
                }
                [0x11, _, _] => {
                    self.open = false;
                    vec![]
                }
                // STATUS_CMD_FAILED
                _ => return vec![body[0], 0xC0],
            };
            [vec![body[0], 0], data].concat()
        }
    }

    impl Link for Board {
        fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
            if self.deaf > 0 {
                self.deaf -= 1;
                return Ok(());
            }
            let [0x1B, number, high, low, 0x0E, body @ .., sum] = bytes else {
                panic!("{bytes:?}")
            };
            assert_eq!(usize::from(u16::from_be_bytes([*high, *low])), body.len());
            assert_eq!(bytes[..bytes.len() - 1].iter().fold(0, |a, b| a ^ b), *sum);
            let body = self.answer(body);
            let size = (body.len() as u16).to_be_bytes();
            let mut answer = vec![0x1B, *number, size[0], size[1], 0x0E];
            answer.extend(body);
            answer.push(answer.iter().fold(0, |a, b| a ^ b));
            if let Some(spoil) = self.spoil.take() {
                spoil(&mut answer);
            }
            self.said.extend(answer);
            Ok(())
        }

        fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
            if self.said.is_empty() {
                self.now += limit;
            }
            // Not all at once, as on a serial line.
            let count = self.said.len().min(buffer.len()).min(61);
            buffer[..count].copy_from_slice(&self.said[..count]);
            self.said.drain(..count);
            Ok(count)
        }

        fn now(&self) -> Duration {
            self.now
        }

        fn name(&self) -> String {
            "a boot loader".to_owned()
        }
    }

    /// A program beyond the first 64 Ki words of flash, where an address needs its third byte.
    fn program() -> Vec<u8> {
        (0..140_001u32).map(|n| (n.wrapping_mul(n) >> 3) as u8).collect()
    }

    #[test]
    fn a_program_is_written_and_compared() {
        let mut loader = Stk500v2::new(Board::new());
        loader.link().deaf = 3;
        loader.meet().unwrap();
        let (program, mut told) = (program(), 0);
        loader.write(&program, &mut |done| told = done).unwrap();
        assert_eq!(told, program.len());
        loader.compare(&program, &mut |_| ()).unwrap();
        loader.leave().unwrap();
        let board = loader.link();
        assert_eq!(board.flash[..program.len()], program);
        assert!(board.flash[program.len()..].iter().all(|byte| *byte == 0xFF) && !board.open);
    }

    #[test]
    fn what_is_wrong_is_told_apart() {
        let mut silent = Stk500v2::new(Board { deaf: usize::MAX, ..Board::new() });
        assert!(matches!(silent.meet(), Err(LoaderError::Silent)));
        let mut uno = Stk500v2::new(Board { chip: [0x1E, 0x95, 0x0F], ..Board::new() });
        assert!(matches!(uno.meet(), Err(LoaderError::Chip([0x1E, 0x95, 0x0F]))));
        let mut worn = Stk500v2::new(Board { worn: Some(4711), ..Board::new() });
        worn.meet().unwrap();
        worn.write(&program(), &mut |_| ()).unwrap();
        assert!(matches!(worn.compare(&program(), &mut |_| ()), Err(LoaderError::Differs(4711))));
        // Before programming has begun.
        let mut closed = Stk500v2::new(Board::new());
        assert!(matches!(closed.read_page(0, &mut [0; PAGE]), Err(LoaderError::Refused)));
    }

    /// An answer to another message or command, or with a wrong checksum or length, is invalid.
    #[test]
    fn a_spoiled_answer_is_none() {
        let spoils: [fn(&mut Vec<u8>); 6] = [
            |answer| answer[0] = 0x1C,
            |answer| answer[1] ^= 1,
            |answer| answer[2] = 2,
            |answer| answer[4] = 0x0F,
            |answer| {
                // The checksum stays right.
                answer[5] ^= 1;
                answer[6] ^= 1;
            },
            |answer| *answer.last_mut().unwrap() ^= 0x40,
        ];
        for spoil in spoils {
            let mut loader = Stk500v2::new(Board { spoil: Some(spoil), ..Board::new() });
            assert!(matches!(loader.leave(), Err(LoaderError::Odd)));
        }
        // One byte is missing.
        let cut: fn(&mut Vec<u8>) = |answer| answer.truncate(7);
        let mut loader = Stk500v2::new(Board { spoil: Some(cut), ..Board::new() });
        assert!(matches!(loader.leave(), Err(LoaderError::Silent)));
    }
}
