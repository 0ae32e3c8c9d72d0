//! The serial line: over USB while a program on the host has that port open, otherwise over the
//! UART.

use stepwright_device::main_loop::{Received, SerialPort};

use crate::uart::Uart;
use crate::usb::Usb;

/// Both lines, for the main loop.
pub struct Lines {
    /// GPIO 0 and 1.
    pub uart: Uart,
    /// The USB port.
    pub usb: Usb,
}

impl SerialPort for Lines {
    fn receive(&mut self) -> Option<Received> {
        self.usb.poll();
        if self.usb.is_open() {
            self.usb.receive().map(Received::Byte)
        } else {
            self.uart.receive()
        }
    }

    fn has_room(&self) -> bool {
        self.usb.poll();
        if self.usb.is_open() { self.usb.has_room() } else { self.uart.has_room() }
    }

    fn send(&mut self, byte: u8) {
        if self.usb.is_open() { self.usb.send(byte) } else { self.uart.send(byte) }
    }
}
