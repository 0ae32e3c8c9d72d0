//! The firmwares in this crate, as built by `cargo xtask image`.

use std::fmt::Write;
use std::time::Duration;

use sha2::{Digest, Sha256};

use crate::drive::{BootDrive, DriveError};
use crate::{NoProgram, uf2};

/// A board that there is a firmware for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum FlashBoard {
    /// Arduino Uno, or a copy of it with an ATmega328P
    Uno,
    /// Arduino Nano, likewise
    Nano,
    /// Arduino Mega 2560
    Mega,
}

impl FlashBoard {
    /// Its name: `uno`.
    pub fn name(self) -> &'static str {
        match self {
            FlashBoard::Uno => "uno",
            FlashBoard::Nano => "nano",
            FlashBoard::Mega => "mega",
        }
    }
}

/// A program that is carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum FlashProgram {
    /// The controller: move, run, line, home, jog, serve
    Slave,
    /// The timed driver: `stepwright timed`
    Timed,
    /// Motor cycles: `stepwright cycle`
    Cycles,
    /// Austin's laws: `stepwright move --law`; the Mega's has them all
    Laws,
    /// Austin's laws whose acceleration changes on the way
    Transitions,
    /// Austin's power term
    PowerTerm,
    /// What a host streams: `stepwright gcode FILE --port`
    Stream,
    /// A Pico's test of itself: `stepwright selftest`
    Selftest,
}

/// The images, with their boards and programs.
const IMAGES: [(&[FlashBoard], FlashProgram, &[u8]); 12] = [
    (
        &[FlashBoard::Uno, FlashBoard::Nano],
        FlashProgram::Slave,
        include_bytes!("../images/uno.bin"),
    ),
    (&[FlashBoard::Mega], FlashProgram::Slave, include_bytes!("../images/mega.bin")),
    (
        &[FlashBoard::Uno, FlashBoard::Nano],
        FlashProgram::Timed,
        include_bytes!("../images/uno-timed.bin"),
    ),
    (&[FlashBoard::Mega], FlashProgram::Timed, include_bytes!("../images/mega-timed.bin")),
    (
        &[FlashBoard::Uno, FlashBoard::Nano],
        FlashProgram::Cycles,
        include_bytes!("../images/uno-cycles.bin"),
    ),
    (&[FlashBoard::Mega], FlashProgram::Cycles, include_bytes!("../images/mega-cycles.bin")),
    (
        &[FlashBoard::Uno, FlashBoard::Nano],
        FlashProgram::Laws,
        include_bytes!("../images/uno-laws.bin"),
    ),
    (&[FlashBoard::Mega], FlashProgram::Laws, include_bytes!("../images/mega-laws.bin")),
    (
        &[FlashBoard::Uno, FlashBoard::Nano],
        FlashProgram::Transitions,
        include_bytes!("../images/uno-transitions.bin"),
    ),
    (
        &[FlashBoard::Uno, FlashBoard::Nano],
        FlashProgram::PowerTerm,
        include_bytes!("../images/uno-power-term.bin"),
    ),
    (
        &[FlashBoard::Uno, FlashBoard::Nano],
        FlashProgram::Stream,
        include_bytes!("../images/uno-stream.bin"),
    ),
    (&[FlashBoard::Mega], FlashProgram::Stream, include_bytes!("../images/mega-stream.bin")),
];

/// The bytes of flash that the boot loader leaves. The boot loader of an Uno, and of a Nano from
/// 2018 on, takes 512, that of a Mega 8,192.
const fn room(board: FlashBoard) -> usize {
    match board {
        FlashBoard::Uno | FlashBoard::Nano => 32_256,
        FlashBoard::Mega => 253_952,
    }
}

/// The bytes of flash that the boot loader of a Nano from before 2018 leaves: it takes 2,048.
pub const OLD_ROOM: usize = 30_720;

const _: () = {
    let mut n = 0;
    while n < IMAGES.len() {
        let (boards, _, image) = IMAGES[n];
        let mut at = 0;
        while at < boards.len() {
            assert!(image.len() <= room(boards[at]), "the boot loader leaves less");
            at += 1;
        }
        n += 1;
    }
};

/// A firmware for a board, from address 0 of the flash.
#[derive(Clone, Copy, Debug)]
pub struct Firmware {
    board: FlashBoard,
    old_boot_loader: bool,
    bytes: &'static [u8],
}

impl Firmware {
    /// The program for a board. `old_boot_loader` is for a Nano from before 2018, whose boot loader
    /// uses 57,600 bits/s and leaves 1.5 KB less. Later Nanos have the boot loader of an Uno.
    ///
    /// # Errors
    /// [`NoProgram`]: there is no such program for the board, or it is larger than [`OLD_ROOM`]
    /// with the old boot loader.
    pub fn of(
        board: FlashBoard,
        old_boot_loader: bool,
        program: FlashProgram,
    ) -> Result<Firmware, NoProgram> {
        let fits = || IMAGES.iter().filter(|row| row.0.contains(&board));
        match fits().find(|row| row.1 == program) {
            Some(&(_, _, bytes)) if old_boot_loader && bytes.len() > OLD_ROOM => {
                Err(NoProgram::OldBootLoader { program, size: bytes.len() })
            }
            Some(&(_, _, bytes)) => Ok(Firmware { board, old_boot_loader, bytes }),
            None => {
                let there = fits().map(|row| row.1).collect();
                Err(NoProgram::Board { board, program, there })
            }
        }
    }

    /// The board of this firmware.
    pub fn board(&self) -> FlashBoard {
        self.board
    }

    /// The baud rate of the board's boot loader.
    pub fn baud(&self) -> u32 {
        if self.old_boot_loader { 57_600 } else { 115_200 }
    }

    /// Its bytes.
    pub fn bytes(&self) -> &'static [u8] {
        self.bytes
    }

    /// Its SHA-256, in hexadecimal digits.
    pub fn hash(&self) -> String {
        hash(self.bytes)
    }
}

/// The SHA-256 of these bytes, in hexadecimal digits.
fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// A firmware for a Raspberry Pi Pico, whose boot loader is a drive.
#[derive(Clone, Copy, Debug)]
pub struct PicoFirmware {
    /// The content of the flash from [`PicoFirmware::ADDRESS`] on.
    bytes: &'static [u8],
}

/// The images of a Pico, with their programs.
const PICO: [(FlashProgram, &[u8]); 3] = [
    (FlashProgram::Slave, include_bytes!("../images/pico.bin")),
    (FlashProgram::Stream, include_bytes!("../images/pico-stream.bin")),
    (FlashProgram::Selftest, include_bytes!("../images/pico-selftest.bin")),
];

/// The size of a Pico's flash in bytes.
const PICO_ROOM: usize = 2 << 20;

const _: () = {
    let mut n = 0;
    while n < PICO.len() {
        assert!(PICO[n].1.len() <= PICO_ROOM, "a Pico's flash is smaller");
        n += 1;
    }
};

impl PicoFirmware {
    /// The address of the flash of an RP2040.
    pub const ADDRESS: u32 = 0x1000_0000;

    /// The program for a Pico, if there is one.
    pub fn of(program: FlashProgram) -> Option<PicoFirmware> {
        let found = PICO.iter().find(|row| row.0 == program);
        found.map(|row| PicoFirmware { bytes: row.1 })
    }

    /// The available programs for a Pico.
    pub fn programs() -> impl Iterator<Item = FlashProgram> {
        PICO.iter().map(|row| row.0)
    }

    /// Its bytes.
    pub fn bytes(self) -> &'static [u8] {
        self.bytes
    }

    /// Their SHA-256, in hexadecimal digits.
    pub fn hash(self) -> String {
        hash(self.bytes)
    }

    /// The firmware as a UF2 file.
    pub fn uf2(self) -> Vec<u8> {
        uf2::blocks(self.bytes, Self::ADDRESS, uf2::RP2040)
    }

    /// Copies the firmware to a drive, and waits until the board has taken it. Calls `done` with
    /// the number of bytes of the file that were written.
    ///
    /// # Errors
    /// [`DriveError`]: see [`BootDrive::write`].
    pub fn write(self, drive: &BootDrive, done: impl FnMut(usize)) -> Result<(), DriveError> {
        drive.write(&self.uf2(), Duration::from_secs(10), done)
    }
}

impl FlashProgram {
    /// Its name: `power-term`.
    pub fn name(self) -> &'static str {
        match self {
            FlashProgram::Slave => "slave",
            FlashProgram::Timed => "timed",
            FlashProgram::Cycles => "cycles",
            FlashProgram::Laws => "laws",
            FlashProgram::Transitions => "transitions",
            FlashProgram::PowerTerm => "power-term",
            FlashProgram::Stream => "stream",
            FlashProgram::Selftest => "selftest",
        }
    }
}
