//! The boot loader of an Uno and a Nano: the part of STK500 version 1 that writes flash.
//!
//! Atmel's application note AVR061 has the protocol. A command is a letter, its parameters and
//! [`END`]; the answer is [`IN_STEP`], what was asked for, and [`OK`]:
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

use std::io;
use std::time::Duration;

use crate::link::Link;

/// Ends a command.
const END: u8 = b' ';
/// Begins an answer.
const IN_STEP: u8 = 0x14;
/// Ends an answer.
const OK: u8 = 0x10;
/// Of an ATmega328P, and of its sister without the P.
const CHIPS: [[u8; 3]; 2] = [[0x1E, 0x95, 0x0F], [0x1E, 0x95, 0x14]];
/// Bytes of flash that are written at once.
pub const PAGE: usize = 128;
/// A page takes 5 ms to write, and 12 to send; at 57600 bits/s 23.
const PATIENCE: Duration = Duration::from_millis(1000);
/// How long an answer to the first word may take, and how often it is said.
const KNOCK: Duration = Duration::from_millis(150);
const KNOCKS: usize = 10;

/// Why nothing was written, or not all.
#[derive(Debug)]
pub enum LinkError {
    /// Nothing answers as a boot loader does.
    Silent,
    /// Another chip.
    Chip([u8; 3]),
    /// An answer that is none.
    Odd,
    /// What was read back differs, from this byte on.
    Differs(usize),
    /// The line is gone.
    Line(io::Error),
}

/// A conversation with a boot loader.
pub struct Loader<L> {
    link: L,
}

impl<L: Link> Loader<L> {
    /// Of a board on this line.
    pub fn new(link: L) -> Loader<L> {
        Loader { link }
    }

    /// The line.
    pub fn link(&mut self) -> &mut L {
        &mut self.link
    }

    /// Gets in step with a boot loader that was just reset, and begins to program.
    pub fn meet(&mut self) -> Result<(), LinkError> {
        let mut met = false;
        for _ in 0..KNOCKS {
            self.quiet()?;
            met = self.ask(b"0", &mut [], KNOCK).is_ok();
            if met {
                break;
            }
        }
        if !met {
            return Err(LinkError::Silent);
        }
        // Answers to earlier knocks may be on their way.
        self.quiet()?;
        let mut chip = [0; 3];
        self.ask(b"u", &mut chip, PATIENCE)?;
        if !CHIPS.contains(&chip) {
            return Err(LinkError::Chip(chip));
        }
        self.ask(b"P", &mut [], PATIENCE)
    }

    /// Writes flash from address 0 on.
    pub fn write(&mut self, bytes: &[u8], done: &mut impl FnMut(usize)) -> Result<(), LinkError> {
        for (n, page) in bytes.chunks(PAGE).enumerate() {
            self.seek(n)?;
            let mut command = vec![b'd', 0, PAGE as u8, b'F'];
            command.extend(page);
            command.resize(4 + PAGE, 0xFF);
            self.ask(&command, &mut [], PATIENCE)?;
            done(n * PAGE + page.len());
        }
        Ok(())
    }

    /// Reads flash back, and compares it.
    pub fn compare(&mut self, bytes: &[u8], done: &mut impl FnMut(usize)) -> Result<(), LinkError> {
        for (n, page) in bytes.chunks(PAGE).enumerate() {
            self.seek(n)?;
            let mut read = [0; PAGE];
            self.ask(&[b't', 0, PAGE as u8, b'F'], &mut read, PATIENCE)?;
            if let Some(at) = page.iter().zip(&read).position(|(right, is)| right != is) {
                return Err(LinkError::Differs(n * PAGE + at));
            }
            done(n * PAGE + page.len());
        }
        Ok(())
    }

    /// Has the program begin.
    pub fn leave(&mut self) -> Result<(), LinkError> {
        self.ask(b"Q", &mut [], PATIENCE)
    }

    /// Goes to the beginning of a page.
    fn seek(&mut self, page: usize) -> Result<(), LinkError> {
        let [low, high, ..] = (page * PAGE / 2).to_le_bytes();
        self.ask(&[b'U', low, high], &mut [], PATIENCE)
    }

    /// Says a command, and waits for its answer.
    fn ask(&mut self, command: &[u8], into: &mut [u8], limit: Duration) -> Result<(), LinkError> {
        self.link.write(&[command, &[END]].concat()).map_err(LinkError::Line)?;
        let end = self.link.now() + limit;
        let mut answer = vec![0; into.len() + 2];
        let mut count = 0;
        while count < answer.len() {
            let left = end.saturating_sub(self.link.now());
            if left.is_zero() {
                return Err(LinkError::Silent);
            }
            let rest = answer.get_mut(count..).unwrap_or_default();
            count += self.link.read(rest, left).map_err(LinkError::Line)?;
        }
        match answer.as_slice() {
            [IN_STEP, middle @ .., OK] => {
                into.copy_from_slice(middle);
                Ok(())
            }
            _ => Err(LinkError::Odd),
        }
    }

    /// Throws away what comes until nothing does.
    fn quiet(&mut self) -> Result<(), LinkError> {
        let mut rubbish = [0; 256];
        while self.link.read(&mut rubbish, Duration::from_millis(20)).map_err(LinkError::Line)? > 0
        {
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A boot loader by the application note: flash of 32 KiB, 512 bytes of it its own.
    struct Board {
        flash: Vec<u8>,
        at: usize,
        open: bool,
        said: Vec<u8>,
        chip: [u8; 3],
        /// Deaf for this many commands.
        deaf: usize,
        /// A byte that does not take what is written.
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
            // Not all at once, as lines have it.
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
        let mut loader = Loader::new(Board::new());
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
        let mut silent = Loader::new(Board { deaf: usize::MAX, ..Board::new() });
        assert!(matches!(silent.meet(), Err(LinkError::Silent)));
        let mut mega = Loader::new(Board { chip: [0x1E, 0x98, 0x01], ..Board::new() });
        assert!(matches!(mega.meet(), Err(LinkError::Chip([0x1E, 0x98, 0x01]))));
        let mut worn = Loader::new(Board { worn: Some(4711), ..Board::new() });
        worn.meet().unwrap();
        worn.write(&program(), &mut |_| ()).unwrap();
        assert!(matches!(worn.compare(&program(), &mut |_| ()), Err(LinkError::Differs(4711))));
        let mut odd = Loader::new(Board::new());
        odd.link().said = vec![IN_STEP, 0x11];
        assert!(matches!(odd.ask(b"P", &mut [], PATIENCE), Err(LinkError::Odd)));
    }
}
