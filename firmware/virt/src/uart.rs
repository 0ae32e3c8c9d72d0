//! The serial line: a 16550, without its queue. QEMU holds a byte back until the previous one is
//! read; and it begins to send before the program starts, so switching the queue on would lose
//! received bytes. A real line needs the queue.

use core::cell::Cell;

use stepwright_device::main_loop::{Received, SerialPort};

/// The address of a register of 8 bits.
fn uart(offset: usize) -> *mut u8 {
    (0x1000_0000 + offset) as *mut u8
}

const DATA: usize = 0;
const FORMAT: usize = 3;
const STATE: usize = 5;

/// Bits of the state: a byte was received; a byte was lost or damaged; there is room.
const READY: u8 = 1 << 0;
const BAD: u8 = 0xF << 1;
const ROOM: u8 = 1 << 5;

/// The line, for the main loop.
pub struct Uart {
    /// A byte was lost or damaged. Reading the state clears its error bits.
    bad: Cell<bool>,
}

impl Uart {
    /// Starts the line: 8 bits, no parity. QEMU's has no speed.
    ///
    /// # Safety
    /// Nothing else has started the line.
    pub unsafe fn start() -> Uart {
        // SAFETY: the memory map of `virt`: the 16550 at 0x1000_0000, bytes.
        unsafe { uart(FORMAT).write_volatile(3) };
        Uart { bad: Cell::new(false) }
    }

    fn state(&self) -> u8 {
        // SAFETY: as above.
        let state = unsafe { uart(STATE).read_volatile() };
        self.bad.set(self.bad.get() || state & BAD != 0);
        state
    }
}

impl SerialPort for Uart {
    fn receive(&mut self) -> Option<Received> {
        let ready = self.state() & READY != 0;
        if self.bad.take() {
            return Some(Received::Garbled);
        }
        // SAFETY: as above.
        ready.then(|| Received::Byte(unsafe { uart(DATA).read_volatile() }))
    }

    fn has_room(&self) -> bool {
        self.state() & ROOM != 0
    }

    fn send(&mut self, byte: u8) {
        // SAFETY: as above.
        unsafe { uart(DATA).write_volatile(byte) };
    }
}
