//! The boot loader of an Uno and a Nano: the part of STK500 version 1 that writes flash.
//!
//! Atmel's application note AVR061 has the protocol. A command is a letter, its parameters and
//! a blank; the answer is 0x14, the data, and 0x10:
//!
//! ```text
//!   0 ' '                        → in step?
//!   u ' '                        → three bytes: which chip
//!   P ' '                          programming begins
//!   U low high ' '                 an address, in words of two bytes
//!   d high low F … ' '             a page of flash
//!   t high low F ' '             → the same, read back
//!   Q ' '                          programming ends, and the program begins
//! ```

use std::time::Duration;

use crate::loader::{KNOCK, Loader, LoaderError, PATIENCE, fill};
use stepwright_host::link::Link;

/// Ends a command.
const END: u8 = b' ';
/// Begins an answer.
const IN_STEP: u8 = 0x14;
/// Ends an answer.
const OK: u8 = 0x10;
/// The signatures of an ATmega328P and an ATmega328.
const CHIPS: [[u8; 3]; 2] = [[0x1E, 0x95, 0x0F], [0x1E, 0x95, 0x14]];

/// A conversation with the boot loader of an Uno or a Nano.
pub struct Stk500<L> {
    link: L,
}

impl<L: Link> Stk500<L> {
    /// A conversation with a board on this line.
    pub fn new(link: L) -> Stk500<L> {
        Stk500 { link }
    }

    /// Sets the address.
    fn seek(&mut self, address: usize) -> Result<(), LoaderError> {
        let [low, high, ..] = (address / 2).to_le_bytes();
        self.ask(&[b'U', low, high], &mut [], PATIENCE)
    }

    /// Sends a command, and waits for its answer.
    fn ask(&mut self, command: &[u8], into: &mut [u8], limit: Duration) -> Result<(), LoaderError> {
        self.link.write(&[command, &[END]].concat()).map_err(LoaderError::Line)?;
        let end = self.link.now() + limit;
        let mut answer = vec![0; into.len() + 2];
        fill(&mut self.link, &mut answer, end)?;
        match answer.as_slice() {
            [IN_STEP, middle @ .., OK] => {
                into.copy_from_slice(middle);
                Ok(())
            }
            _ => Err(LoaderError::Odd),
        }
    }
}

impl<L: Link> Loader for Stk500<L> {
    type Link = L;
    const PAGE: usize = 128;

    fn link(&mut self) -> &mut L {
        &mut self.link
    }

    fn knock(&mut self) -> Result<(), LoaderError> {
        self.ask(b"0", &mut [], KNOCK)
    }

    fn enter(&mut self) -> Result<(), LoaderError> {
        let mut chip = [0; 3];
        self.ask(b"u", &mut chip, PATIENCE)?;
        if !CHIPS.contains(&chip) {
            return Err(LoaderError::Chip(chip));
        }
        self.ask(b"P", &mut [], PATIENCE)
    }

    fn write_page(&mut self, address: usize, page: &[u8]) -> Result<(), LoaderError> {
        self.seek(address)?;
        let [high, low] = (page.len() as u16).to_be_bytes();
        self.ask(&[&[b'd', high, low, b'F'], page].concat(), &mut [], PATIENCE)
    }

    fn read_page(&mut self, address: usize, into: &mut [u8]) -> Result<(), LoaderError> {
        self.seek(address)?;
        let [high, low] = (into.len() as u16).to_be_bytes();
        self.ask(&[b't', high, low, b'F'], into, PATIENCE)
    }

    fn leave(&mut self) -> Result<(), LoaderError> {
        self.ask(b"Q", &mut [], PATIENCE)
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    const PAGE: usize = Stk500::<Board>::PAGE;

    /// A boot loader by the application note: 32 KiB of flash, 512 bytes of which are its own.
    struct Board {
        flash: Vec<u8>,
        at: usize,
        open: bool,
        said: Vec<u8>,
        chip: [u8; 3],
        /// Ignores this many commands.
        deaf: usize,
        /// A byte of flash that can't be written.
        worn: Option<usize>,
        now: Duration,
    }

    impl Board {
        fn new() -> Board {
            Board {
                flash: vec![0xFF; 32_256],
                at: 0,
                open: false,
                said: Vec::new(),
                chip: CHIPS[0],
                deaf: 0,
                worn: None,
                now: Duration::ZERO,
            }
        }
    }

    impl Link for Board {
        fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
            if self.deaf > 0 {
                self.deaf -= 1;
                return Ok(());
            }
            let (end, command) = bytes.split_last().unwrap();
            assert_eq!(*end, END);
            let answer = match command {
                b"0" => vec![],
                b"u" => self.chip.to_vec(),
                b"P" => {
                    self.open = true;
                    vec![]
                }
                [b'U', low, high] => {
                    self.at = 2 * usize::from(u16::from_le_bytes([*low, *high]));
                    vec![]
                }
                [b'd', high, low, b'F', page @ ..] if self.open => {
                    assert_eq!(usize::from(u16::from_be_bytes([*high, *low])), page.len());
                    assert!(self.at.is_multiple_of(PAGE) && page.len() == PAGE);
                    self.flash[self.at..][..PAGE].copy_from_slice(page);
                    if let Some(worn) = self.worn {
                        self.flash[worn] = 0;
                    }
                    vec![]
                }
                [b't', high, low, b'F'] if self.open => {
                    let count = usize::from(u16::from_be_bytes([*high, *low]));
                    self.flash[self.at..][..count].to_vec()
                }
                b"Q" => {
                    self.open = false;
                    vec![]
                }
                other => panic!("{other:?}"),
            };
            self.said.extend([&[IN_STEP], &answer[..], &[OK]].concat());
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

    fn program() -> Vec<u8> {
        (0..30_001u32).map(|n| ((n * n) >> 3) as u8).collect()
    }

    #[test]
    fn a_program_is_written_and_compared() {
        let mut loader = Stk500::new(Board::new());
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
        let mut silent = Stk500::new(Board { deaf: usize::MAX, ..Board::new() });
        assert!(matches!(silent.meet(), Err(LoaderError::Silent)));
        let mut mega = Stk500::new(Board { chip: [0x1E, 0x98, 0x01], ..Board::new() });
        assert!(matches!(mega.meet(), Err(LoaderError::Chip([0x1E, 0x98, 0x01]))));
        let mut worn = Stk500::new(Board { worn: Some(4711), ..Board::new() });
        worn.meet().unwrap();
        worn.write(&program(), &mut |_| ()).unwrap();
        assert!(matches!(worn.compare(&program(), &mut |_| ()), Err(LoaderError::Differs(4711))));
        let mut odd = Stk500::new(Board::new());
        odd.link().said = vec![IN_STEP, 0x11];
        assert!(matches!(odd.ask(b"P", &mut [], PATIENCE), Err(LoaderError::Odd)));
    }
}
