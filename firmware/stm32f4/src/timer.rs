//! TIM2, free-running at 96 MHz with 32 bits: compare 1 steps.

use cortex_m::peripheral::NVIC;
use stepwright::HoldOff;
use stepwright_controller::{CompareRegister, CompareTimer};
use stm32f4xx_hal::pac::{Interrupt, TIM2};

use crate::chip;

/// The step timer.
pub type Timer = CompareTimer<Tim2>;

/// Its registers.
pub struct Tim2(TIM2);

/// Starts TIM2 at 0, its interrupt held off.
pub fn start(timer: TIM2) -> Timer {
    chip::hold();
    // SAFETY: all values of the register.
    timer.arr().write(|w| unsafe { w.bits(u32::MAX) });
    timer.dier().write(|w| w.cc1ie().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
    // SAFETY: it is held off by its priority.
    unsafe { NVIC::unmask(Interrupt::TIM2) };
    CompareTimer::new(Tim2(timer))
}

/// The counter, for the main loop, while the step interrupt may come.
#[inline(always)]
pub fn count() -> u32 {
    // SAFETY: a look at one register.
    unsafe { &*TIM2::ptr() }.cnt().read().bits()
}

impl CompareRegister for Tim2 {
    /// Leaving and entering takes 24 cycles, and what the handler saves.
    const LINGER: u32 = 60;
    /// 12 cycles, and some 35 instructions to the edge of a step that is due alone; twice as many where
    /// several are.
    const REACTION: u32 = 150;

    #[inline(always)]
    fn count(&mut self) -> u32 {
        self.0.cnt().read().bits()
    }

    #[inline(always)]
    fn compare(&mut self, at: u32) {
        // SAFETY: all values of the register.
        self.0.ccr1().write(|w| unsafe { w.bits(at) });
    }

    #[inline(always)]
    fn clear(&mut self) {
        // What is written as 1 stays.
        // SAFETY: the other flags are nobody's.
        self.0.sr().write(|w| unsafe { w.bits(!(1 << 1)) });
    }

    #[inline(always)]
    fn pend(&mut self) {
        NVIC::pend(Interrupt::TIM2);
    }
}

/// TIM2's interrupt, and what is less urgent.
pub struct StepInterrupt;

// SAFETY: by priority, of TIM2's and of those that are less urgent; a barrier for the processor is
// behind it, and the write is one for the compiler. What is pending stays so.
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
