//! The dual timer of ARM's CMSDK, whose counters count down: the first one, free-running at 25 MHz
//! with 32 bits, is the clock; the second one counts down once to the next step.

use stepwright::HoldOff;
use stepwright::timer::StepTimer;
use stepwright_controller::Register;

use crate::vectors::DUALTIMER_NUMBER;

/// A register.
const fn register(address: usize) -> Register {
    // SAFETY: every address here is that of a register, in ARM's manuals of the CMSDK and of the
    // core.
    unsafe { Register::at(address) }
}

/// A register of the dual timer.
const fn timer(offset: usize) -> Register {
    register(0x4000_2000 + offset)
}

const LEFT: Register = timer(0x04);
const TIME_CONTROL: Register = timer(0x08);
const LOAD: Register = timer(0x20);
const CONTROL: Register = timer(0x28);
const CLEAR: Register = timer(0x2C);

/// Requests an interrupt of the NVIC.
const PENDS: Register = register(0xE000_E200);
/// A higher number is less urgent.
const STEP_PRIORITY: u8 = 0x80;

/// The step timer.
pub struct Timer(());

impl Timer {
    /// Starts the dual timer, its interrupt held off.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn start() -> Timer {
        StepInterrupt::hold();
        // On, with 32 bits; the second one counts once, to 0, with an interrupt.
        TIME_CONTROL.write(1 << 7 | 1 << 1);
        CONTROL.write(1 << 7 | 1 << 6 | 1 << 5 | 1 << 1 | 1);
        CLEAR.write(1);
        // SAFETY: NVIC_IPR, a byte for each interrupt.
        unsafe { ((0xE000_E400 + DUALTIMER_NUMBER) as *mut u8).write_volatile(STEP_PRIORITY) };
        register(0xE000_E100).write(1 << DUALTIMER_NUMBER);
        Timer(())
    }
}

/// The counter. Called in the main loop, with the step interrupt enabled.
#[inline(always)]
pub fn count() -> u32 {
    !LEFT.read()
}

impl StepTimer for Timer {
    type Count = u32;
    /// Leaving and entering the interrupt takes 24 cycles, plus the registers that the handler
    /// saves.
    const LINGER: u32 = 60;
    /// 12 cycles, and some 35 instructions up to the edge of a single due step; twice as many for
    /// several steps.
    const REACTION: u32 = 150;

    #[inline(always)]
    fn now(&mut self) -> u32 {
        count()
    }

    #[inline(always)]
    fn wake_at(&mut self, at: u32) {
        // Clears the request of the previous value.
        CLEAR.write(1);
        let left = at.wrapping_sub(self.now());
        if left as i32 <= 0 {
            PENDS.write(1 << DUALTIMER_NUMBER);
        } else {
            LOAD.write(left);
        }
    }
}

/// The dual timer's interrupt, and the less urgent ones.
pub struct StepInterrupt;

// SAFETY: the priority mask holds off this interrupt and the less urgent ones. A barrier for the
// processor follows, and the write is one for the compiler. Pending interrupts stay pending.
unsafe impl HoldOff for StepInterrupt {
    #[inline(always)]
    fn hold() {
        // SAFETY: it only masks more; `release` unmasks the same interrupts.
        unsafe { cortex_m::register::basepri::write(STEP_PRIORITY) };
        cortex_m::asm::isb();
    }

    #[inline(always)]
    fn release() {
        // SAFETY: nothing else uses the priority mask.
        unsafe { cortex_m::register::basepri::write(0) };
        cortex_m::asm::isb();
    }
}
