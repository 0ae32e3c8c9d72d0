//! The first channel of timer 0, free-running at 42 MHz with 32 bits: compare C steps.

use stepwright::HoldOff;
use stepwright_controller::{CompareRegister, CompareTimer, Register};

use crate::chip::{self, register};
use crate::vectors::TC0_NUMBER;

/// A register of the channel.
const fn channel(offset: usize) -> Register {
    register(0x4008_0000 + offset)
}

const CONTROL: Register = channel(0x00);
const MODE: Register = channel(0x04);
const COUNTER: Register = channel(0x10);
const COMPARE_C: Register = channel(0x1C);
const STATE: Register = channel(0x20);
const INTERRUPT_ON: Register = channel(0x24);

/// A match of compare C.
const MATCH: u32 = 1 << 4;

/// The step timer.
pub type Timer = CompareTimer<Channel>;

/// The channel's registers.
pub struct Channel(());

/// Starts the channel at 0, its interrupt held off.
///
/// # Safety
/// Called once.
pub unsafe fn start() -> Timer {
    chip::hold();
    // "Waveform" mode, counting to the end, at half the processor's clock.
    MODE.write(1 << 15);
    INTERRUPT_ON.write(MATCH);
    // Clock on, and start from 0.
    CONTROL.write(1 << 2 | 1);
    chip::let_in(TC0_NUMBER);
    CompareTimer::new(Channel(()))
}

/// The counter. Called in the main loop, with the step interrupt enabled.
#[inline(always)]
pub fn count() -> u32 {
    COUNTER.read()
}

impl CompareRegister for Channel {
    /// Leaving and entering the interrupt takes 24 cycles, plus the registers that the handler
    /// saves.
    const LINGER: u32 = 30;
    /// 12 cycles, and some 35 instructions up to the edge of a single due step; twice as many for
    /// several steps.
    const REACTION: u32 = 80;

    #[inline(always)]
    fn count(&mut self) -> u32 {
        COUNTER.read()
    }

    #[inline(always)]
    fn compare(&mut self, at: u32) {
        COMPARE_C.write(at);
    }

    #[inline(always)]
    fn clear(&mut self) {
        // Reading the register clears the flag.
        STATE.read();
    }

    #[inline(always)]
    fn pend(&mut self) {
        chip::pend(TC0_NUMBER);
    }
}

/// The channel's interrupt, and the less urgent ones.
pub struct StepInterrupt;

// SAFETY: the priority mask holds off the channel's interrupt and the less urgent ones. A barrier
// for the processor follows, and the write is one for the compiler. Pending interrupts stay
// pending.
unsafe impl HoldOff for StepInterrupt {
    #[inline(always)]
    fn hold() {
        chip::hold();
    }

    #[inline(always)]
    fn release() {
        chip::release();
    }
}
