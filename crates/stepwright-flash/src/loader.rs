//! What the boot loaders of the boards have in common: they are met after a reset, and flash
//! is written and read back page by page.

use std::fmt;
use std::io;
use std::time::Duration;

use stepwright_host::link::Link;

/// Why nothing was written, or not all.
#[derive(Debug)]
pub enum LoaderError {
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

impl fmt::Display for LoaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LoaderError::Silent => f.write_str("no boot loader answers"),
            LoaderError::Chip([a, b, c]) => write!(f, "another chip: {a:02X} {b:02X} {c:02X}"),
            LoaderError::Odd => f.write_str("the boot loader lost its step"),
            LoaderError::Refused => f.write_str("the boot loader refused to go on"),
            LoaderError::Differs(at) => {
                write!(f, "what was written differs from byte {at} on")
            }
            LoaderError::Line(error) => write!(f, "the line is gone ({error})"),
        }
    }
}

impl std::error::Error for LoaderError {}

/// An answer to a command: a page takes 5 ms to write, and at 57600 bits/s 23 ms to send.
pub(crate) const PATIENCE: Duration = Duration::from_millis(1000);
/// How long an answer to the first command may take, and how often it is sent.
pub(crate) const KNOCK: Duration = Duration::from_millis(150);
const KNOCKS: usize = 10;

/// A conversation with a boot loader.
pub trait Loader {
    /// The line.
    type Link: Link;
    /// Bytes of flash that are written at once.
    const PAGE: usize;

    /// The line.
    fn link(&mut self) -> &mut Self::Link;

    /// Sends the first command once.
    ///
    /// # Errors
    /// Anything but its answer.
    fn knock(&mut self) -> Result<(), LoaderError>;

    /// Begins to program the chip, if it is the right one.
    ///
    /// # Errors
    /// [`LoaderError::Chip`]: it is another one; or the boot loader does not answer.
    fn enter(&mut self) -> Result<(), LoaderError>;

    /// Writes a page of [`PAGE`](Loader::PAGE) bytes to this address, a multiple of it.
    ///
    /// # Errors
    /// No answer, or a refusal.
    fn write_page(&mut self, address: usize, page: &[u8]) -> Result<(), LoaderError>;

    /// Reads as many bytes from this address, a multiple of [`PAGE`](Loader::PAGE).
    ///
    /// # Errors
    /// No answer, or a refusal.
    fn read_page(&mut self, address: usize, into: &mut [u8]) -> Result<(), LoaderError>;

    /// Has the program begin.
    ///
    /// # Errors
    /// No answer, or a refusal.
    fn leave(&mut self) -> Result<(), LoaderError>;

    /// Gets in step with a boot loader that was just reset, and begins to program.
    ///
    /// # Errors
    /// [`LoaderError::Silent`]: ten commands had no answer; and those of [`enter`](Loader::enter).
    fn meet(&mut self) -> Result<(), LoaderError> {
        let mut met = false;
        for _ in 0..KNOCKS {
            self.drain()?;
            met = match self.knock() {
                Err(LoaderError::Line(error)) => return Err(LoaderError::Line(error)),
                answer => answer.is_ok(),
            };
            if met {
                break;
            }
        }
        if !met {
            return Err(LoaderError::Silent);
        }
        // Answers to earlier knocks may be on their way.
        self.drain()?;
        self.enter()
    }

    /// Writes flash from address 0 on; the rest of the last page is erased. `done` gets the bytes
    /// written.
    ///
    /// # Errors
    /// Those of [`write_page`](Loader::write_page).
    fn write(&mut self, bytes: &[u8], done: &mut impl FnMut(usize)) -> Result<(), LoaderError> {
        for (n, chunk) in bytes.chunks(Self::PAGE).enumerate() {
            let mut page = chunk.to_vec();
            page.resize(Self::PAGE, 0xFF);
            self.write_page(n * Self::PAGE, &page)?;
            done(n * Self::PAGE + chunk.len());
        }
        Ok(())
    }

    /// Reads flash back, and compares it. `done` gets the bytes compared.
    ///
    /// # Errors
    /// [`LoaderError::Differs`]; those of [`read_page`](Loader::read_page).
    fn compare(&mut self, bytes: &[u8], done: &mut impl FnMut(usize)) -> Result<(), LoaderError> {
        for (n, chunk) in bytes.chunks(Self::PAGE).enumerate() {
            let mut page = vec![0; Self::PAGE];
            self.read_page(n * Self::PAGE, &mut page)?;
            if let Some(at) = chunk.iter().zip(&page).position(|(right, is)| right != is) {
                return Err(LoaderError::Differs(n * Self::PAGE + at));
            }
            done(n * Self::PAGE + chunk.len());
        }
        Ok(())
    }

    /// Throws away what comes until nothing does.
    ///
    /// # Errors
    /// [`LoaderError::Line`]
    fn drain(&mut self) -> Result<(), LoaderError> {
        let mut rubbish = [0; 256];
        let pause = Duration::from_millis(20);
        while self.link().read(&mut rubbish, pause).map_err(LoaderError::Line)? > 0 {}
        Ok(())
    }
}

/// Reads until `into` is full, until this time of the link's clock.
pub(crate) fn fill(
    link: &mut impl Link,
    into: &mut [u8],
    end: Duration,
) -> Result<(), LoaderError> {
    let mut count = 0;
    while count < into.len() {
        let left = end.saturating_sub(link.now());
        if left.is_zero() {
            return Err(LoaderError::Silent);
        }
        let rest = into.get_mut(count..).unwrap_or_default();
        count += link.read(rest, left).map_err(LoaderError::Line)?;
    }
    Ok(())
}
