//! The firmwares that this command carries, as `cargo xtask image` has built them.

use std::fmt::Write;

use clap::ValueEnum;
use sha2::{Digest, Sha256};

use super::Board;
use crate::failure::Failure;

/// A program that is carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Program {
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
}

/// For which boards, which program, the image. A Nano with its old boot loader is an Uno with
/// less room.
const IMAGES: [(&[Board], Program, &[u8]); 11] = [
    (&[Board::Uno], Program::Slave, include_bytes!("../../images/uno.bin")),
    (&[Board::Nano], Program::Slave, include_bytes!("../../images/nano.bin")),
    (&[Board::Mega], Program::Slave, include_bytes!("../../images/mega.bin")),
    (&[Board::Uno, Board::Nano], Program::Timed, include_bytes!("../../images/uno-timed.bin")),
    (&[Board::Mega], Program::Timed, include_bytes!("../../images/mega-timed.bin")),
    (&[Board::Uno, Board::Nano], Program::Cycles, include_bytes!("../../images/uno-cycles.bin")),
    (&[Board::Mega], Program::Cycles, include_bytes!("../../images/mega-cycles.bin")),
    (&[Board::Uno, Board::Nano], Program::Laws, include_bytes!("../../images/uno-laws.bin")),
    (&[Board::Mega], Program::Laws, include_bytes!("../../images/mega-laws.bin")),
    (
        &[Board::Uno, Board::Nano],
        Program::Transitions,
        include_bytes!("../../images/uno-transitions.bin"),
    ),
    (
        &[Board::Uno, Board::Nano],
        Program::PowerTerm,
        include_bytes!("../../images/uno-power-term.bin"),
    ),
];

/// Bytes of flash that the boot loader leaves: an Uno's takes 512, an old Nano's 2,048, a Mega's
/// 8,192.
const fn room(board: Board) -> usize {
    match board {
        Board::Uno => 32_256,
        Board::Nano => 30_720,
        Board::Mega => 253_952,
    }
}

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

/// A firmware, from address 0 of the flash.
pub struct Image(&'static [u8]);

impl Image {
    /// The program for a board. A Nano with the new boot loader has an Uno's room.
    ///
    /// # Errors
    /// There is none; which there are.
    pub fn of(board: Board, old_boot_loader: bool, program: Program) -> Result<Image, Failure> {
        let board = if board == Board::Nano && !old_boot_loader { Board::Uno } else { board };
        let fits = |row: &&(&[Board], Program, &[u8])| row.0.contains(&board);
        let found = IMAGES.iter().filter(fits).find(|row| row.1 == program);
        found.map(|row| Image(row.2)).ok_or_else(|| {
            let names = IMAGES.iter().filter(fits).map(|row| row.1.name());
            let names = names.collect::<Vec<_>>().join(", ");
            let board = board.name();
            Failure::usage(format!("there is no program {} for a {board}", program.name()))
                .hint(format!("--program is one of {names}"))
        })
    }

    /// Its bytes.
    pub fn bytes(&self) -> &'static [u8] {
        self.0
    }

    /// Its SHA-256, in hexadecimal digits.
    pub fn hash(&self) -> String {
        Sha256::digest(self.0).iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
    }
}

impl Program {
    /// Its name, as `--program` takes it.
    pub fn name(self) -> &'static str {
        match self {
            Program::Slave => "slave",
            Program::Timed => "timed",
            Program::Cycles => "cycles",
            Program::Laws => "laws",
            Program::Transitions => "transitions",
            Program::PowerTerm => "power-term",
        }
    }

    /// How to see it at work on a port.
    pub fn seen_with(self, port: &str) -> String {
        match self {
            Program::Slave => format!("stepwright status --port {port}"),
            Program::Timed => format!("stepwright timed --case 1 --port {port}"),
            Program::Cycles => format!("stepwright cycle FILE --port {port}"),
            Program::Laws => format!("stepwright move 400 --law austin --port {port}"),
            Program::Transitions => {
                format!("stepwright move 400 --law linear-factor --port {port}")
            }
            Program::PowerTerm => format!("stepwright move 400 --law power --port {port}"),
        }
    }
}
