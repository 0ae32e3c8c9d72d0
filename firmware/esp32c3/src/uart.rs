//! The serial line: UART 0 at 115200 baud. Its queue of 128 bytes holds the bytes that arrive
//! during a round of the main loop.

use esp_hal::Blocking;
use esp_hal::uart::Uart as Driver;
use stepwright_device::main_loop::{Received, SerialPort};

/// The line, for the main loop.
pub struct Uart(Driver<'static, Blocking>);

impl Uart {
    /// Uses an open line.
    pub fn new(line: Driver<'static, Blocking>) -> Uart {
        Uart(line)
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        let mut byte = [0];
        match self.0.read_buffered(&mut byte) {
            Ok(0) => None,
            Ok(_) => Some(Received::Byte(byte[0])),
            Err(_) => Some(Received::Garbled),
        }
    }

    fn has_room(&self) -> bool {
        self.0.write_ready()
    }

    fn send(&mut self, byte: u8) {
        // There is room for the byte.
        let _ = self.0.write(&[byte]);
    }
}
