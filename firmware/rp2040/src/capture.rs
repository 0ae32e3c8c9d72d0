//! Captures STEP with a state machine of the second PIO: see [`watcher`](crate::watcher). No wire
//! is needed: an input has the level of its pin, whatever drives it. DMA copies the times to RAM.

use core::cell::UnsafeCell;

use stepwright_controller::Register;
use stepwright_selftest::{Capture, MOST_PULSES, ORDERS};

use crate::board::STEP;
use crate::chip;
use crate::watcher::{CODE, CYCLES, REWIND, WRAP};

/// A register of the second PIO, whose first state machine captures.
const fn pio(offset: usize) -> Register {
    // SAFETY: the datasheet's table of PIO.
    unsafe { Register::at(0x5030_0000 + offset) }
}

const CTRL: Register = pio(0x000);
const RECEIVED: usize = 0x5030_0020;
const MEMORY: usize = 0x048;
const EXECCTRL: Register = pio(0x0CC);
const SHIFTCTRL: Register = pio(0x0D0);
const INSTR: Register = pio(0x0D8);

/// A register of the first DMA channel.
const fn dma(offset: usize) -> Register {
    // SAFETY: the datasheet's table of DMA.
    unsafe { Register::at(0x5000_0000 + offset) }
}

const LEFT: Register = dma(0x008);

/// Room for all edges of a test.
const ROOM: usize = (ORDERS * (MOST_PULSES + 1)) as usize;

struct Times(UnsafeCell<[u32; ROOM]>);

// SAFETY: the DMA writes, and one `PioCapture` reads the finished part.
unsafe impl Sync for Times {}

static TIMES: Times = Times(UnsafeCell::new([0; ROOM]));

/// The capture of one axis at a time.
pub struct PioCapture {
    /// The number of times that belong to earlier orders.
    before: u32,
}

impl PioCapture {
    /// Loads the program, and starts the DMA.
    ///
    /// # Safety
    /// Called once, after [`chip::start`].
    pub unsafe fn new() -> PioCapture {
        // SAFETY: the caller's promise.
        unsafe { chip::start_capture() };
        for (line, instruction) in CODE.into_iter().enumerate() {
            pio(MEMORY + 4 * line).write(instruction.into());
        }
        // Both FIFOs are joined for receiving.
        SHIFTCTRL.write(1 << 31 | 1 << 18 | 1 << 19);
        dma(0x000).write(RECEIVED as u32);
        dma(0x004).write(TIMES.0.get() as u32);
        LEFT.write(ROOM as u32);
        // Words, to consecutive addresses, paced by the first machine of the second PIO; no channel
        // is chained.
        dma(0x00C).write(12 << 15 | 1 << 5 | 2 << 2 | 1);
        PioCapture { before: 0 }
    }

    /// The number of times that the DMA has copied.
    fn taken() -> u32 {
        (ROOM as u32).saturating_sub(LEFT.read())
    }
}

impl Capture for PioCapture {
    fn begin(&mut self, axis: u8) {
        CTRL.write(0);
        self.before = Self::taken();
        EXECCTRL.write((STEP + u32::from(axis)) << 24 | WRAP << 12);
        INSTR.write(REWIND.into());
        INSTR.write(0); // jmp 0
        CTRL.write(1);
    }

    fn count(&self) -> u32 {
        Self::taken().saturating_sub(self.before)
    }

    fn rise(&self, number: u32) -> Option<u32> {
        let at = self.before.saturating_add(number) as usize;
        if number >= self.count() || at >= ROOM {
            return None;
        }
        // SAFETY: within the array, and the DMA has finished this place.
        let left = unsafe { TIMES.0.get().cast::<u32>().add(at).read_volatile() };
        Some((!left).wrapping_mul(CYCLES))
    }
}
