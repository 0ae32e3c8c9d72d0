//! The serial line: the UART of ARM's CMSDK, without an interrupt. QEMU holds a byte back until the
//! previous one is read; a real line needs an interrupt.

use stepwright_controller::Register;
use stepwright_device::main_loop::{Received, SerialPort};

/// A register of UART0.
const fn uart(offset: usize) -> Register {
    // SAFETY: ARM's manual of the CMSDK, and of AN385: words.
    unsafe { Register::at(0x4000_4000 + offset) }
}

const DATA: Register = uart(0x00);
const STATE: Register = uart(0x04);
const CONTROL: Register = uart(0x08);
const DIVISOR: Register = uart(0x10);

/// Bits of the state: no room; a byte was received; a byte was lost.
const FULL: u32 = 1 << 0;
const READY: u32 = 1 << 1;
const LOST: u32 = 1 << 3;

/// The line, for the main loop.
pub struct Uart(());

impl Uart {
    /// Starts the line: 115200 baud from 25 MHz.
    ///
    /// # Safety
    /// Nothing else has started the line.
    pub unsafe fn start() -> Uart {
        DIVISOR.write(217);
        CONTROL.write(3);
        Uart(())
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        let state = STATE.read();
        if state & LOST != 0 {
            // Writing a 1 clears the bit.
            STATE.write(LOST);
            return Some(Received::Garbled);
        }
        (state & READY != 0).then(|| Received::Byte(DATA.read() as u8))
    }

    fn has_room(&self) -> bool {
        STATE.read() & FULL == 0
    }

    fn send(&mut self, byte: u8) {
        DATA.write(byte.into());
    }
}
