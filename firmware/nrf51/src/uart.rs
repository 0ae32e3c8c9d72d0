//! The serial line: 115200 baud on the micro:bit's USB. An interrupt receives the bytes; the step
//! interrupt can preempt it.

use core::fmt::{self, Write};

use stepwright_controller::{Register, Ring};
use stepwright_device::main_loop::{Received, SerialPort};

/// A register of UART0.
const fn uart(offset: usize) -> Register {
    // SAFETY: the manual's table of UART.
    unsafe { Register::at(0x4000_2000 + offset) }
}

const RECEIVED: Register = uart(0x108);
const SENT: Register = uart(0x11C);
const ERROR: Register = uart(0x124);
const ERRORS: Register = uart(0x480);
const RXD: Register = uart(0x518);
const TXD: Register = uart(0x51C);

/// The bytes that the interrupt has received.
static RING: Ring = Ring::new();

/// The interrupt of UART0.
///
/// # Safety
/// Called by that interrupt only.
#[inline(always)]
pub unsafe fn on_receive() {
    if ERROR.read() != 0 {
        ERROR.write(0);
        // Writing a 1 clears an error.
        ERRORS.write(ERRORS.read());
        // SAFETY: the caller's promise.
        unsafe { RING.put_garbled() };
    }
    // The event is set again at once if another byte waits.
    while RECEIVED.read() != 0 {
        RECEIVED.write(0);
        // SAFETY: as above.
        unsafe { RING.put(RXD.read() as u8) };
    }
}

/// The line, for the main loop.
pub struct Uart(());

impl Uart {
    /// Starts the line. Its interrupt is less urgent than the step timer's, and enabled together
    /// with it.
    ///
    /// # Safety
    /// Nothing else has started the line.
    pub unsafe fn start() -> Uart {
        // SAFETY: the caller's promise.
        let line = unsafe { Uart::to_talk() };
        uart(0x304).write(1 << 9 | 1 << 2); // error, received
        // SAFETY: the NVIC's IPR0, whose third byte is UART0's priority: the lowest.
        unsafe { Register::at(0xE000_E400) }.write(0xC0 << 16);
        uart(0x000).write(1);
        line
    }

    /// Starts the line for a program that only sends.
    ///
    /// # Safety
    /// Nothing else has started the line.
    pub unsafe fn to_talk() -> Uart {
        uart(0x50C).write(24); // TX on P0.24
        uart(0x514).write(25); // RX on P0.25
        uart(0x524).write(0x01D7_E000); // 115200
        uart(0x500).write(4);
        uart(0x008).write(1);
        // Initially there is room.
        SENT.write(1);
        Uart(())
    }
}

/// Waits until everything is sent.
impl Write for Uart {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            while !self.has_room() {}
            self.send(byte);
        }
        Ok(())
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        // SAFETY: there is one `Uart`, which the main loop owns.
        unsafe { RING.take() }
    }

    fn has_room(&self) -> bool {
        SENT.read() != 0
    }

    fn send(&mut self, byte: u8) {
        SENT.write(0);
        TXD.write(byte.into());
    }
}
