//! The firmwares that this command carries, as `cargo xtask image` has built them.

use std::fmt::Write;

use sha2::{Digest, Sha256};

use super::Board;

/// A Nano is an Uno.
static UNO: &[u8] = include_bytes!("../../images/uno.bin");
static MEGA: &[u8] = include_bytes!("../../images/mega.bin");

/// What a boot loader leaves of a Nano's flash.
const NANO: usize = 30_720;

const _: () = assert!(UNO.len() <= NANO, "it fits on a Nano");

/// A firmware, from address 0 of the flash.
pub struct Image(&'static [u8]);

impl Image {
    /// The controller of a board.
    pub fn of(board: Board) -> Image {
        match board {
            Board::Uno | Board::Nano => Image(UNO),
            Board::Mega => Image(MEGA),
        }
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
