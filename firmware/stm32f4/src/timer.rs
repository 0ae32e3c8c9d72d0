//! TIM2, free-running at 96 MHz with 32 bits: compare 1 steps.

use cortex_m::peripheral::NVIC;
use stepwright::HoldOff;
use stepwright_controller::{CompareRegister, CompareTimer};
use stm32f4xx_hal::pac::{Interrupt, TIM2};

use crate::chip;

/// The step timer.
pub type Timer = CompareTimer<Tim2>;

/// TIM2's registers.
pub struct Tim2(TIM2);

/// Starts TIM2 at 0, its interrupt held off.
pub fn start(timer: TIM2) -> Timer {
    chip::hold();
    // SAFETY: the register may have any value.
    timer.arr().write(|w| unsafe { w.bits(u32::MAX) });
    timer.dier().write(|w| w.cc1ie().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
    // SAFETY: the priority mask holds it off.
    unsafe { NVIC::unmask(Interrupt::TIM2) };
    CompareTimer::new(Tim2(timer))
}

/// The counter. Called in the main loop, with the step interrupt enabled.
#[inline(always)]
pub fn count() -> u32 {
    // SAFETY: a read of one register.
    unsafe { &*TIM2::ptr() }.cnt().read().bits()
}

impl CompareRegister for Tim2 {
    /// Leaving and entering the interrupt takes 24 cycles, plus the registers that the handler
    /// saves.
    const LINGER: u32 = 60;
    /// 12 cycles, and some 35 instructions up to the edge of a single due step; twice as many for
    /// several steps.
    const REACTION: u32 = 150;

    #[inline(always)]
    fn count(&mut self) -> u32 {
        self.0.cnt().read().bits()
    }

    #[inline(always)]
    fn compare(&mut self, at: u32) {
        // SAFETY: the register may have any value.
        self.0.ccr1().write(|w| unsafe { w.bits(at) });
    }

    #[inline(always)]
    fn clear(&mut self) {
        // Writing a 1 leaves a flag unchanged.
        // SAFETY: nothing uses the other flags.
        self.0.sr().write(|w| unsafe { w.bits(!(1 << 1)) });
    }

    #[inline(always)]
    fn pend(&mut self) {
        NVIC::pend(Interrupt::TIM2);
    }
}

/// TIM2's interrupt, and the less urgent ones.
pub struct StepInterrupt;

// SAFETY: the priority mask holds off TIM2's interrupt and the less urgent ones. A barrier for the
// processor follows, and the write is one for the compiler. Pending interrupts stay pending.
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
