//! A model of the TMC2209 from its data sheet (revision 1.09): registers and datagrams on one wire,
//! and its pin DIAG.
//!
//! It shares nothing with the code under test: register numbers and bits are written out here.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::digital::Wait;
use embedded_io_async::{Error, ErrorKind, ErrorType, Read, Write};

use super::bench::Around;

pub const GCONF: usize = 0x00;
pub const GSTAT: usize = 0x01;
pub const IFCNT: usize = 0x02;
pub const SLAVECONF: usize = 0x03;
pub const IOIN: usize = 0x06;
pub const IHOLD_IRUN: usize = 0x10;
pub const TCOOLTHRS: usize = 0x14;
pub const SGTHRS: usize = 0x40;
pub const SG_RESULT: usize = 0x41;
pub const CHOPCONF: usize = 0x6C;
pub const DRV_STATUS: usize = 0x6F;

/// The CRC of polynomial x⁸ + x² + x + 1, by long division of the bits, the lowest of each byte
/// first.
pub fn crc(bytes: &[u8]) -> u8 {
    let mut bits: Vec<bool> =
        bytes.iter().flat_map(|byte| (0..8).map(move |n| byte >> n & 1 != 0)).collect();
    let length = bits.len();
    bits.extend([false; 8]);
    for at in 0..length {
        if bits[at] {
            for power in [8, 2, 1, 0] {
                bits[at + 8 - power] ^= true;
            }
        }
    }
    bits[length..].iter().fold(0, |crc, bit| crc << 1 | u8::from(*bit))
}

/// An error of the computer's end of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing;

impl std::fmt::Display for Framing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("framing")
    }
}

impl std::error::Error for Framing {}

impl Error for Framing {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

pub struct Chip {
    pub registers: [u32; 128],
    address: u8,
    outgoing: VecDeque<Result<u8, Framing>>,
    readers: Vec<Waker>,
    /// Bytes that have passed the wire in either direction, and the number of the byte to corrupt.
    pub passed: usize,
    pub spoiled: Option<usize>,
    /// Whether the computer's end notices that as an error.
    pub framing: bool,
    /// Whether each look at the line is an error, or says that it has ended.
    pub broken: bool,
    pub ended: bool,
    /// The number of writes before one in which the chip is reset.
    pub reset_in: Option<usize>,
    /// The number of writes before the chip is absent.
    pub silent_in: Option<usize>,
    /// Whether the chip is absent, and whether it ignores writes.
    pub silent: bool,
    pub deaf: bool,
    /// The step at which StallGuard reports a false stall.
    pub false_stall: Option<usize>,
    /// The times at which the run current was written, and its values.
    pub currents: Vec<(u64, u32)>,
    now: u64,
}

impl Chip {
    pub fn new(address: u8) -> Chip {
        Chip {
            registers: Chip::at_power_up(),
            address,
            outgoing: VecDeque::new(),
            readers: Vec::new(),
            passed: 0,
            spoiled: None,
            framing: false,
            broken: false,
            ended: false,
            reset_in: None,
            silent_in: None,
            silent: false,
            deaf: false,
            false_stall: None,
            currents: Vec::new(),
            now: 0,
        }
    }

    pub fn at_power_up() -> [u32; 128] {
        let mut registers = [0; 128];
        registers[GSTAT] = 1;
        registers[IOIN] = 0x21 << 24;
        registers[IHOLD_IRUN] = 31 << 8;
        registers[CHOPCONF] = 0x1000_0053;
        registers
    }

    /// Puts a byte on the wire. Returns what the chip hears.
    fn on_wire(&mut self, byte: u8) -> u8 {
        let spoiled = self.spoiled == Some(self.passed);
        self.passed += 1;
        let heard = if spoiled { byte ^ 0x10 } else { byte };
        // One wire: the sender hears itself.
        self.outgoing.push_back(if spoiled && self.framing { Err(Framing) } else { Ok(heard) });
        heard
    }

    /// Sends the value of a register.
    pub fn answer(&mut self, register: usize) {
        let mut answer = vec![0x05, 0xFF, register as u8];
        answer.extend(self.registers[register].to_be_bytes());
        answer.push(crc(&answer));
        for byte in answer {
            self.on_wire(byte);
        }
    }

    /// The current in mA (rms) of a motor that moves, at 0.11 Ω.
    pub fn milliamps(&self) -> u32 {
        let full = if self.registers[CHOPCONF] >> 17 & 1 != 0 { 180.0 } else { 325.0 };
        let steps = f64::from((self.registers[IHOLD_IRUN] >> 8 & 31) + 1);
        (steps / 32.0 * full / 0.13 / 2f64.sqrt()) as u32
    }

    /// Counts down to an event at a write.
    fn due(count: &mut Option<usize>) -> bool {
        let now = *count == Some(0);
        *count = count.and_then(|count| count.checked_sub(1));
        now
    }

    /// Receives a datagram, after a pause.
    fn receive(&mut self, bytes: &[u8]) {
        if self.silent {
            return;
        }
        let Some((&check, rest)) = bytes.split_last() else { return };
        if rest[0] & 0xF != 5 || rest[1] != self.address || crc(rest) != check {
            return;
        }
        let register = usize::from(rest[2] & 0x7F);
        match (rest[2] >> 7, bytes.len()) {
            (0, 4) => self.answer(register),
            (1, 8) if Chip::due(&mut self.reset_in) => self.registers = Chip::at_power_up(),
            (1, 8) if Chip::due(&mut self.silent_in) => self.silent = true,
            (1, 8) if !self.deaf => {
                let value = u32::from_be_bytes([rest[3], rest[4], rest[5], rest[6]]);
                match register {
                    // Writing a 1 clears a bit.
                    GSTAT => self.registers[GSTAT] &= !value,
                    _ => self.registers[register] = value,
                }
                if register == IHOLD_IRUN {
                    self.currents.push((self.now, value >> 8 & 31));
                }
                self.registers[IFCNT] = (self.registers[IFCNT] + 1) & 0xFF;
            }
            _ => {}
        }
    }
}

/// The wire.
#[derive(Clone)]
pub struct Wire(pub Rc<RefCell<Chip>>, pub Rc<Around>);

impl ErrorType for Wire {
    type Error = Framing;
}

impl Read for Wire {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Framing> {
        poll_fn(|context| {
            let mut chip = self.0.borrow_mut();
            if chip.broken {
                return Poll::Ready(Err(Framing));
            }
            if chip.ended {
                return Poll::Ready(Ok(0));
            }
            let Some(first) = chip.outgoing.front().copied() else {
                chip.readers.push(context.waker().clone());
                return Poll::Pending;
            };
            if let Err(error) = first {
                chip.outgoing.pop_front();
                return Poll::Ready(Err(error));
            }
            let mut count = 0;
            while count < buffer.len()
                && let Some(&Ok(byte)) = chip.outgoing.front()
            {
                buffer[count] = byte;
                chip.outgoing.pop_front();
                count += 1;
            }
            Poll::Ready(Ok(count))
        })
        .await
    }
}

impl Write for Wire {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Framing> {
        let mut chip = self.0.borrow_mut();
        chip.now = self.1.time.now();
        let bytes: Vec<u8> = bytes.iter().map(|byte| chip.on_wire(*byte)).collect();
        chip.receive(&bytes);
        chip.readers.drain(..).for_each(Waker::wake);
        Ok(bytes.len())
    }
    async fn flush(&mut self) -> Result<(), Framing> {
        Ok(())
    }
}

pub struct Delay(pub Rc<Around>);

impl DelayNs for Delay {
    async fn delay_ns(&mut self, ns: u32) {
        self.0.after_us(u64::from(ns).div_ceil(1_000)).await;
    }
}

/// The pin DIAG of the driver of X.
pub struct Diag(pub Rc<RefCell<Chip>>, pub Rc<Around>);

impl Diag {
    /// High on a stall at speed, and while the driver is off.
    fn is_high(&self) -> bool {
        let (mut chip, shafts) = (self.0.borrow_mut(), self.1.shafts.borrow());
        if chip.registers[DRV_STATUS] & 0b111110 != 0 {
            return true;
        }
        let [.., before, last] = shafts.steps[0][..] else { return false };
        // TSTEP: clock ticks at 12 MHz in 1/256 of a full step.
        let interval = (last - before).max(self.1.time.now() - last) as u32;
        let microsteps = 256 >> (chip.registers[CHOPCONF] >> 24 & 0xF);
        let ticks = interval.saturating_mul(12) * microsteps / 256;
        let lag = shafts.stops[0].map_or(0, |stop| stop.lag());
        let nervous = chip.false_stall == Some(shafts.steps[0].len());
        let load = if nervous || lag >= i64::from(microsteps) { 20 } else { 300 };
        chip.registers[SG_RESULT] = load;
        ticks <= chip.registers[TCOOLTHRS] && load <= 2 * chip.registers[SGTHRS]
    }

    async fn level(&self, high: bool) -> Result<(), Infallible> {
        poll_fn(|context| {
            if self.is_high() == high {
                return Poll::Ready(Ok(()));
            }
            self.1.watch(context);
            Poll::Pending
        })
        .await
    }
}

impl embedded_hal::digital::ErrorType for Diag {
    type Error = Infallible;
}

impl Wait for Diag {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        self.level(true).await
    }
    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        self.level(false).await
    }
    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        self.level(false).await?;
        self.level(true).await
    }
    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        self.level(true).await?;
        self.level(false).await
    }
    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        self.level(!self.is_high()).await
    }
}
