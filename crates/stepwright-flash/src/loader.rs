//! The common parts of the boot loaders: the connection after a reset, and writing and reading
//! flash page by page.

use std::fmt;
use std::io;
use std::time::Duration;

use stepwright_host::link::Link;

/// The error of a firmware that was not written, or not completely.
#[derive(Debug)]
pub enum LoaderError {
    /// No boot loader answers.
    Silent,
    /// The board has another chip.
    Chip([u8; 3]),
    /// An invalid answer.
    Odd,
    /// The boot loader has refused a command.
    Refused,
    /// The flash that was read back differs, from this byte on.
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

/// The longest wait for an answer to a command. Writing a page takes 5 ms, and sending it 23 ms at
/// 57600 bits/s.
pub(crate) const PATIENCE: Duration = Duration::from_millis(1000);
/// The longest wait for an answer to the first command, and how often it is sent.
pub(crate) const KNOCK: Duration = Duration::from_millis(150);
const KNOCKS: usize = 10;

/// A conversation with a boot loader.
pub trait Loader {
    /// The line.
    type Link: Link;
    /// The bytes of a page of flash, which is written at once.
    const PAGE: usize;

    /// The line.
    fn link(&mut self) -> &mut Self::Link;

    /// Sends the first command once.
    ///
    /// # Errors
    /// No valid answer.
    fn knock(&mut self) -> Result<(), LoaderError>;

    /// Enters programming mode, if it is the right chip.
    ///
    /// # Errors
    /// [`LoaderError::Chip`]: it is another chip; or the boot loader does not answer.
    fn enter(&mut self) -> Result<(), LoaderError>;

    /// Writes a page of [`PAGE`](Loader::PAGE) bytes to this address, a multiple of `PAGE`.
    ///
    /// # Errors
    /// No answer, or a refusal.
    fn write_page(&mut self, address: usize, page: &[u8]) -> Result<(), LoaderError>;

    /// Fills `into` from this address, a multiple of [`PAGE`](Loader::PAGE).
    ///
    /// # Errors
    /// No answer, or a refusal.
    fn read_page(&mut self, address: usize, into: &mut [u8]) -> Result<(), LoaderError>;

    /// Starts the program.
    ///
    /// # Errors
    /// No answer, or a refusal.
    fn leave(&mut self) -> Result<(), LoaderError>;

    /// Synchronizes with a boot loader after a reset, and enters programming mode.
    ///
    /// # Errors
    /// [`LoaderError::Silent`]: ten commands got no answer; the errors of [`enter`](Loader::enter).
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
        // Answers to earlier knocks may still come.
        self.drain()?;
        self.enter()
    }

    /// Writes flash from address 0 on. The rest of the last page is erased. Calls `done` with the
    /// number of bytes written.
    ///
    /// # Errors
    /// The errors of [`write_page`](Loader::write_page).
    fn write(&mut self, bytes: &[u8], done: &mut impl FnMut(usize)) -> Result<(), LoaderError> {
        for (n, chunk) in bytes.chunks(Self::PAGE).enumerate() {
            let mut page = chunk.to_vec();
            page.resize(Self::PAGE, 0xFF);
            self.write_page(n * Self::PAGE, &page)?;
            done(n * Self::PAGE + chunk.len());
        }
        Ok(())
    }

    /// Reads flash back, and compares it. Calls `done` with the number of bytes compared.
    ///
    /// # Errors
    /// [`LoaderError::Differs`]; the errors of [`read_page`](Loader::read_page).
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

    /// Discards input until none comes.
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

/// Reads until `into` is full, at most until this time of the link's clock.
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
