//! What the boot loaders of the boards have in common: they are met after a reset, and flash
//! is written and read back page by page.

use std::io;
use std::time::Duration;

use stepwright_host::link::Link;

/// Why nothing was written, or not all.
#[derive(Debug)]
pub enum LinkError {
    /// Nothing answers as a boot loader does.
    Silent,
    /// Another chip.
    Chip([u8; 3]),
    /// An answer that is none.
    Odd,
    /// The boot loader has refused a command.
    Refused,
    /// What was read back differs, from this byte on.
    Differs(usize),
    /// The line is gone.
    Line(io::Error),
}

/// An answer to a command: a page takes 5 ms to write, and at 57600 bits/s 23 ms to send.
pub const PATIENCE: Duration = Duration::from_millis(1000);
/// How long an answer to the first command may take, and how often it is sent.
pub const KNOCK: Duration = Duration::from_millis(150);
const KNOCKS: usize = 10;

/// A conversation with a boot loader.
pub trait Loader {
    /// The line.
    type Link: Link;
    /// Bytes of flash that are written at once.
    const PAGE: usize;

    /// The line.
    fn link(&mut self) -> &mut Self::Link;

    /// Sends the first command once. Anything but its answer is an error.
    fn knock(&mut self) -> Result<(), LinkError>;

    /// Begins to program the chip, if it is the right one.
    fn enter(&mut self) -> Result<(), LinkError>;

    /// Writes a page of [`PAGE`](Loader::PAGE) bytes to this address, a multiple of it.
    fn write_page(&mut self, address: usize, page: &[u8]) -> Result<(), LinkError>;

    /// Reads as many bytes from this address, a multiple of [`PAGE`](Loader::PAGE).
    fn read_page(&mut self, address: usize, into: &mut [u8]) -> Result<(), LinkError>;

    /// Has the program begin.
    fn leave(&mut self) -> Result<(), LinkError>;

    /// Gets in step with a boot loader that was just reset, and begins to program.
    fn meet(&mut self) -> Result<(), LinkError> {
        let mut met = false;
        for _ in 0..KNOCKS {
            self.drain()?;
            met = match self.knock() {
                Err(LinkError::Line(error)) => return Err(LinkError::Line(error)),
                answer => answer.is_ok(),
            };
            if met {
                break;
            }
        }
        if !met {
            return Err(LinkError::Silent);
        }
        // Answers to earlier knocks may be on their way.
        self.drain()?;
        self.enter()
    }

    /// Writes flash from address 0 on; the rest of the last page is erased.
    fn write(&mut self, bytes: &[u8], done: &mut impl FnMut(usize)) -> Result<(), LinkError> {
        for (n, chunk) in bytes.chunks(Self::PAGE).enumerate() {
            let mut page = chunk.to_vec();
            page.resize(Self::PAGE, 0xFF);
            self.write_page(n * Self::PAGE, &page)?;
            done(n * Self::PAGE + chunk.len());
        }
        Ok(())
    }

    /// Reads flash back, and compares it.
    fn compare(&mut self, bytes: &[u8], done: &mut impl FnMut(usize)) -> Result<(), LinkError> {
        for (n, chunk) in bytes.chunks(Self::PAGE).enumerate() {
            let mut page = vec![0; Self::PAGE];
            self.read_page(n * Self::PAGE, &mut page)?;
            if let Some(at) = chunk.iter().zip(&page).position(|(right, is)| right != is) {
                return Err(LinkError::Differs(n * Self::PAGE + at));
            }
            done(n * Self::PAGE + chunk.len());
        }
        Ok(())
    }

    /// Throws away what comes until nothing does.
    fn drain(&mut self) -> Result<(), LinkError> {
        let mut rubbish = [0; 256];
        let pause = Duration::from_millis(20);
        while self.link().read(&mut rubbish, pause).map_err(LinkError::Line)? > 0 {}
        Ok(())
    }
}

/// Reads until `into` is full, until this time of the link's clock.
pub fn fill(link: &mut impl Link, into: &mut [u8], end: Duration) -> Result<(), LinkError> {
    let mut count = 0;
    while count < into.len() {
        let left = end.saturating_sub(link.now());
        if left.is_zero() {
            return Err(LinkError::Silent);
        }
        let rest = into.get_mut(count..).unwrap_or_default();
        count += link.read(rest, left).map_err(LinkError::Line)?;
    }
    Ok(())
}
