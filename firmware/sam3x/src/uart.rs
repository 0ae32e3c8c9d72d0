//! The serial line: UART, 115200 baud. An interrupt receives the bytes; the step interrupt can
//! preempt it.

use stepwright_controller::{Register, Ring};
use stepwright_device::main_loop::{Received, SerialPort};

use crate::chip::{self, register};
use crate::vectors::UART_NUMBER;

/// A register of the line.
const fn uart(offset: usize) -> Register {
    register(0x400E_0800 + offset)
}

const CONTROL: Register = uart(0x00);
const STATE: Register = uart(0x14);
const RECEIVED: Register = uart(0x18);
const TO_SEND: Register = uart(0x1C);

/// Bits of the state: a byte was received; there is room; an overrun, a framing or a parity error.
const READY: u32 = 1 << 0;
const ROOM: u32 = 1 << 1;
const BAD: u32 = 7 << 5;

/// The bytes that the interrupt has received.
static RING: Ring = Ring::new();

/// The line's interrupt.
///
/// # Safety
/// Called by that interrupt only.
#[inline(always)]
pub unsafe fn on_receive() {
    let state = STATE.read();
    // SAFETY: the caller's promise.
    unsafe {
        if state & BAD != 0 {
            // Resets the errors only: receiver and sender stay on.
            CONTROL.write(1 << 8);
            RING.put_garbled();
        }
        if state & READY != 0 {
            RING.put(RECEIVED.read() as u8);
        }
    }
}

/// The line, for the main loop.
pub struct Uart(());

impl Uart {
    /// Starts the line. Its interrupt is less urgent than the step timer's.
    ///
    /// # Safety
    /// Nothing else has started the line.
    pub unsafe fn start() -> Uart {
        // PA8 and PA9 to peripheral A; RX with a pull-up.
        register(0x400E_0E64).write(1 << 8);
        register(0x400E_0E04).write(3 << 8);
        CONTROL.write(1 << 2 | 1 << 3 | 1 << 5 | 1 << 7);
        // No parity; 84 MHz / 16 / 46.
        uart(0x04).write(4 << 9);
        uart(0x20).write(46);
        uart(0x08).write(READY | BAD);
        CONTROL.write(1 << 8 | 1 << 6 | 1 << 4);
        chip::let_in(UART_NUMBER);
        Uart(())
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        // SAFETY: there is one `Uart`, which the main loop owns.
        unsafe { RING.take() }
    }

    fn has_room(&self) -> bool {
        STATE.read() & ROOM != 0
    }

    fn send(&mut self, byte: u8) {
        TO_SEND.write(byte.into());
    }
}
