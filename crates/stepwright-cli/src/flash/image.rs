//! The firmwares that this command carries, as `cargo xtask image` has built them.

use std::fmt::Write;

use sha2::{Digest, Sha256};

use super::Board;

static UNO: &[u8] = include_bytes!("../../images/uno.bin");
/// A Nano is an Uno whose boot loader leaves less.
static NANO: &[u8] = include_bytes!("../../images/nano.bin");
static MEGA: &[u8] = include_bytes!("../../images/mega.bin");

const _: () = assert!(UNO.len() <= 32_256, "the boot loader of an Uno takes 512 bytes");
const _: () = assert!(NANO.len() <= 30_720, "that of an old Nano takes 2,048");

/// A firmware, from address 0 of the flash.
pub struct Image(&'static [u8]);

impl Image {
    /// The controller of a board.
    pub fn of(board: Board) -> Image {
        match board {
            Board::Uno => Image(UNO),
            Board::Nano => Image(NANO),
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
