//! The serial line: UART 0, 115200 baud, on GPIO 0 and 1. An interrupt receives the bytes; the
//! PIO's interrupt can preempt it.

use stepwright_controller::{Register, Ring};
use stepwright_device::main_loop::{Received, SerialPort};

use crate::board::LINE;
use crate::chip::{self, Function};

/// A register of UART 0.
const fn uart(offset: usize) -> Register {
    // SAFETY: the datasheet's table of UART.
    unsafe { Register::at(0x4003_4000 + offset) }
}

const DATA: Register = uart(0x00);
const FLAGS: Register = uart(0x18);
/// Nothing to read; no room to write.
const EMPTY: u32 = 1 << 4;
const FULL: u32 = 1 << 5;
/// Errors of a byte that was read: frame, parity, break, overrun.
const ERRORS: u32 = 0xF00;

/// The bytes that the interrupt has received.
static RING: Ring = Ring::new();

/// The interrupt of UART 0.
///
/// # Safety
/// Called by that interrupt only.
#[inline(always)]
pub unsafe fn on_receive() {
    // Clears received, timeout and errors, before checking for received bytes, so that a later byte
    // requests the interrupt again.
    uart(0x44).write(0x7D0);
    while FLAGS.read() & EMPTY == 0 {
        let byte = DATA.read();
        if byte & ERRORS != 0 {
            // SAFETY: the caller's promise.
            unsafe { RING.put_garbled() };
        } else {
            // SAFETY: as above.
            unsafe { RING.put(byte as u8) };
        }
    }
}

/// The line, for the main loop.
pub struct Uart(());

impl Uart {
    /// Starts the line. Its interrupt is less urgent than the PIO's, and enabled together with it.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn start() -> Uart {
        // 125 MHz / 16 / 115200 = 67 + 52/64.
        uart(0x24).write(67);
        uart(0x28).write(52);
        // 8 bits, FIFOs.
        uart(0x2C).write(3 << 5 | 1 << 4);
        // An interrupt at 4 bytes, or when bytes have waited for a while.
        uart(0x34).write(0);
        uart(0x38).write(1 << 4 | 1 << 6);
        uart(0x30).write(1 << 0 | 1 << 8 | 1 << 9);
        for pin in LINE {
            chip::give(pin, Function::Uart, false);
        }
        // SAFETY: the NVIC's IPR5, whose first byte is UART 0's priority: the lowest.
        unsafe { Register::at(0xE000_E414) }.write(0xC0);
        Uart(())
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        // SAFETY: there is one `Uart`, which the main loop owns.
        unsafe { RING.take() }
    }

    fn has_room(&self) -> bool {
        FLAGS.read() & FULL == 0
    }

    fn send(&mut self, byte: u8) {
        DATA.write(byte.into());
    }
}
