//! A driver on its UART: reads registers, and writes them with confirmation.

use core::future::pending;
use core::task::Poll;

use embassy_futures::poll_once;
use embassy_futures::select::{Either, select};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};
use tmc2209::reg::{self, ReadableRegister, WritableRegister};
use tmc2209::{ReadRequest, ReadResponse, Reader, WriteRequest};

use crate::current::Scale;
use crate::error::DriverError;

/// The number of attempts of an access.
const ATTEMPTS: u8 = 3;

/// The time-out of an answer in ms. At 9600 baud an answer takes 13 ms, with the echo of the
/// request.
const ANSWER_MS: u32 = 30;

/// The address of a driver on a shared wire: the levels of its pins MS2 and MS1, MS2 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverAddress {
    /// Both low or open: the only driver.
    A0 = 0,
    /// MS1 high.
    A1 = 1,
    /// MS2 high.
    A2 = 2,
    /// Both high.
    A3 = 3,
}

/// A TMC2209 on a UART.
///
/// One wire carries both directions, so each request is read back before the answer: the echo is
/// skipped. Two to four drivers on one wire have [addresses](DriverAddress) of their own. The
/// chip's counter of writes confirms each write; a lost one is repeated.
pub struct Tmc2209<U, D> {
    line: U,
    pub(crate) delay: D,
    address: u8,
    pub(crate) scale: Option<Scale>,
    pub(crate) currents: reg::IHOLD_IRUN,
}

impl<U: Read + Write, D: DelayNs> Tmc2209<U, D> {
    /// The driver with this address, on a line of 9,600 to 500,000 baud.
    pub fn new(line: U, delay: D, address: DriverAddress) -> Tmc2209<U, D> {
        let currents = reg::IHOLD_IRUN::default();
        Tmc2209 { line, delay, address: address as u8, scale: None, currents }
    }

    /// Reads a register.
    ///
    /// # Errors
    /// [`DriverError::Line`], [`DriverError::Silent`]
    pub async fn read<R: ReadableRegister>(&mut self) -> Result<R, DriverError<U::Error>> {
        let request = ReadRequest::new::<R>(self.address);
        let mut failed = DriverError::Silent;
        for _ in 0..ATTEMPTS {
            self.drop_old();
            self.send(request.bytes()).await?;
            match select(answer::<R, U>(&mut self.line), self.delay.delay_ms(ANSWER_MS)).await {
                Either::First(Ok(answer)) => return Ok(answer),
                Either::First(Err(error)) => {
                    failed = DriverError::Line(error);
                    // The answer may still come.
                    self.delay.delay_ms(ANSWER_MS).await;
                }
                Either::Second(()) => failed = DriverError::Silent,
            }
        }
        Err(failed)
    }

    /// Writes a register, and checks that the driver took it.
    ///
    /// # Errors
    /// [`DriverError::Line`], [`DriverError::Silent`], [`DriverError::NotTaken`]
    pub async fn write<R: WritableRegister>(
        &mut self,
        register: R,
    ) -> Result<(), DriverError<U::Error>> {
        let request = WriteRequest::new(self.address, register);
        let before = self.read::<reg::IFCNT>().await?.get();
        for _ in 0..ATTEMPTS {
            self.send(request.bytes()).await?;
            // Writing the same value twice does no harm, so it need not be known which write was
            // taken.
            if self.read::<reg::IFCNT>().await?.get() != before {
                return Ok(());
            }
        }
        Err(DriverError::NotTaken)
    }

    /// Drops what came too late, or for a request whose future was dropped.
    fn drop_old(&mut self) {
        let mut buffer = [0; ReadResponse::LEN_BYTES];
        while let Poll::Ready(Ok(1..)) = poll_once(self.line.read(&mut buffer)) {}
    }

    async fn send(&mut self, bytes: &[u8]) -> Result<(), DriverError<U::Error>> {
        self.line.write_all(bytes).await.map_err(DriverError::Line)?;
        self.line.flush().await.map_err(DriverError::Line)
    }
}

/// Returns the next intact answer for a register.
async fn answer<R: ReadableRegister, U: Read>(line: &mut U) -> Result<R, U::Error> {
    let (mut reader, mut buffer) = (Reader::default(), [0; ReadResponse::LEN_BYTES]);
    loop {
        let count = line.read(&mut buffer).await?;
        if count == 0 {
            // The line has ended.
            return pending().await;
        }
        let mut bytes = buffer.get(..count).unwrap_or_default();
        while !bytes.is_empty() {
            let (used, answer) = reader.read_response(bytes);
            bytes = bytes.get(used.max(1)..).unwrap_or_default();
            if let Some(answer) = answer.filter(ReadResponse::crc_is_valid)
                && let Ok(register) = answer.register::<R>()
            {
                return Ok(register);
            }
        }
    }
}
