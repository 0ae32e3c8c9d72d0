//! The dual timer of ARM's CMSDK, whose counters count down: the first one, free-running at 25 MHz with 32
//! bits, tells the time; the second counts what is left to the next step, once.

use stepwright::HoldOff;
use stepwright::timer::StepTimer;
use stepwright_controller::Register;

use crate::vectors::DUALTIMER_NUMBER;

/// A register.
const fn register(address: usize) -> Register {
    // SAFETY: every address here is of one, in ARM's manuals of the CMSDK and of the core.
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
/// Of a less urgent interrupt the number is higher.
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
        // On, of 32 bits; the second once, to 0, with an interrupt.
        TIME_CONTROL.write(1 << 7 | 1 << 1);
        CONTROL.write(1 << 7 | 1 << 6 | 1 << 5 | 1 << 1 | 1);
        CLEAR.write(1);
        // SAFETY: NVIC_IPR, a byte for each interrupt.
        unsafe { ((0xE000_E400 + DUALTIMER_NUMBER) as *mut u8).write_volatile(STEP_PRIORITY) };
        register(0xE000_E100).write(1 << DUALTIMER_NUMBER);
        Timer(())
    }
}

/// The counter, for the main loop, while the step interrupt may come.
#[inline(always)]
pub fn count() -> u32 {
    !LEFT.read()
}

impl StepTimer for Timer {
    type Count = u32;
    /// Leaving and entering takes 24 cycles, and what the handler saves.
    const LINGER: u32 = 60;
    /// 12 cycles, and some 35 instructions to the edge of a step that is due alone; twice as many where
    /// several are.
    const REACTION: u32 = 150;

    #[inline(always)]
    fn now(&mut self) -> u32 {
        count()
    }

    #[inline(always)]
    fn wake_at(&mut self, at: u32) {
        // The request of the value before.
        CLEAR.write(1);
        let left = at.wrapping_sub(self.now());
        if left as i32 <= 0 {
            PENDS.write(1 << DUALTIMER_NUMBER);
        } else {
            LOAD.write(left);
        }
    }
}

/// The dual timer's interrupt, and what is less urgent.
pub struct StepInterrupt;

// SAFETY: by priority, of this one and of those that are less urgent; a barrier for the processor is
// behind it, and the write is one for the compiler. What is pending stays so.
unsafe impl HoldOff for StepInterrupt {
    #[inline(always)]
    fn hold() {
        // SAFETY: it raises what is masked: `release` lets the same come.
        unsafe { cortex_m::register::basepri::write(STEP_PRIORITY) };
        cortex_m::asm::isb();
    }

    #[inline(always)]
    fn release() {
        // SAFETY: nothing else masks by priority.
        unsafe { cortex_m::register::basepri::write(0) };
        cortex_m::asm::isb();
    }
}
