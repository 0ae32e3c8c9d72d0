//! Writes a firmware to an Uno, a Nano, a Mega or a Pico through its boot loader, without a
//! compiler.
//!
//! ```no_run
//! # use std::time::Duration;
//! # use stepwright_flash::{Firmware, FlashBoard, FlashProgram};
//! # use stepwright_host::link::serial::{LeaseWait, SerialLink, Share};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let firmware = Firmware::of(FlashBoard::Uno, false, FlashProgram::Slave)?;
//! let port = "/dev/ttyACM0".as_ref();
//! let link = SerialLink::open(port, firmware.baud(), Share::Alone, |_| LeaseWait::Over)?;
//! firmware.write(link, |stage, done| println!("{stage} {done} bytes"))?;
//! # Ok(())
//! # }
//! ```
//!
//! A Pico's boot loader is a drive:
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use stepwright_flash::{FlashProgram, PicoFirmware, drive::BootDrive};
//! if let Some(firmware) = PicoFirmware::of(FlashProgram::Stream) {
//!     firmware.write(&BootDrive::find()?, |_| ())?;
//! }
//! # Ok(())
//! # }
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | `image` | the firmwares in this crate |
//! | [`loader`] | the common parts of the boot loaders |
//! | [`stk500`] | the boot loader of an Uno and a Nano |
//! | [`stk500v2`] | the boot loader of a Mega |
//! | [`drive`], [`uf2`] | the boot loader of a Pico, and the file that it takes |

#![warn(missing_docs)]
#![forbid(unsafe_code)]

pub mod drive;
mod image;
pub mod loader;
pub mod stk500;
pub mod stk500v2;
pub mod uf2;

use std::fmt;
use std::thread;
use std::time::Duration;

use stepwright_host::link::serial::SerialLink;

pub use image::{Firmware, FlashBoard, FlashProgram, OLD_ROOM, PicoFirmware};
use loader::{Loader, LoaderError};
use stk500::Stk500;
use stk500v2::Stk500v2;

/// How often to reset the board to find the boot loader, which listens for about a second after a
/// reset.
const RESETS: usize = 3;

/// The stages of flashing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashStage {
    /// The flash is written.
    Writing,
    /// The flash is read back and compared.
    Comparing,
}

impl fmt::Display for FlashStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FlashStage::Writing => "writing",
            FlashStage::Comparing => "comparing",
        })
    }
}

/// The error of a program that the board can't have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoProgram {
    /// There is no such program for this board.
    Board {
        /// The board.
        board: FlashBoard,
        /// The missing program.
        program: FlashProgram,
        /// The available programs.
        there: Vec<FlashProgram>,
    },
    /// The program is larger than the [`OLD_ROOM`] that a Nano's old boot loader leaves. It fits
    /// with the boot loader of later Nanos.
    OldBootLoader {
        /// The program.
        program: FlashProgram,
        /// Its size in bytes.
        size: usize,
    },
}

impl fmt::Display for NoProgram {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoProgram::Board { board, program, .. } => {
                write!(f, "there is no program {} for a {}", program.name(), board.name())
            }
            NoProgram::OldBootLoader { program, size } => {
                let program = program.name();
                write!(f, "{program} has {size} bytes, and the old boot loader leaves {OLD_ROOM}")
            }
        }
    }
}

impl std::error::Error for NoProgram {}

impl Firmware {
    /// Resets the board on this line, writes the firmware, compares all of it, and starts it. Calls
    /// `done` with the number of bytes written, then with those compared. It blocks for some
    /// seconds.
    ///
    /// # Errors
    /// [`LoaderError`]. Except for [`Silent`](LoaderError::Silent) and [`Chip`](LoaderError::Chip),
    /// the program that was on the board may be lost.
    pub fn write(
        &self,
        link: SerialLink,
        done: impl FnMut(FlashStage, usize),
    ) -> Result<(), LoaderError> {
        match self.board() {
            FlashBoard::Uno | FlashBoard::Nano => self.through(Stk500::new(link), done),
            FlashBoard::Mega => self.through(Stk500v2::new(link), done),
        }
    }

    fn through(
        &self,
        mut loader: impl Loader<Link = SerialLink>,
        mut done: impl FnMut(FlashStage, usize),
    ) -> Result<(), LoaderError> {
        let mut met = Err(LoaderError::Silent);
        for _ in 0..RESETS {
            loader.link().reset();
            met = loader.meet();
            if met.is_ok() {
                break;
            }
        }
        met?;
        loader.write(self.bytes(), &mut |bytes| done(FlashStage::Writing, bytes))?;
        loader.compare(self.bytes(), &mut |bytes| done(FlashStage::Comparing, bytes))?;
        loader.leave()?;
        // Lets the program start.
        thread::sleep(Duration::from_millis(200));
        Ok(())
    }
}
