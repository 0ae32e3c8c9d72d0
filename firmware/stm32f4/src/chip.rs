//! Clocks, functions of pins and priorities, by `stm32f4xx-hal`.

use stm32f4xx_hal::pac::{self, Interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Enable, Reset};
use stm32f4xx_hal::serial::Serial;

/// The step timer's interrupt is the more urgent one; a higher number is less urgent.
const STEP_PRIORITY: u8 = 0x80;
const LINE_PRIORITY: u8 = 0xC0;

/// The parts of the chip that the program uses.
pub struct Chip {
    /// The step timer.
    pub timer: pac::TIM2,
    /// The port of all pins except the line's.
    pub port: pac::GPIOC,
    /// The serial line, at 115200 baud.
    pub line: pac::USART2,
    /// The watchdog.
    pub watchdog: pac::IWDG,
    /// The reasons of the last reset: bits 24 to 31 of RCC_CSR.
    pub reasons: u32,
}

impl Chip {
    /// Runs the processor at 96 MHz, from the debugger's 8 MHz, and sets both interrupts'
    /// priorities. `None` if the chip was taken already, or if the clocks can't be set.
    pub fn take() -> Option<Chip> {
        let chip = pac::Peripherals::take()?;
        let mut core = cortex_m::Peripherals::take()?;
        let reasons = chip.RCC.csr().read().bits();
        chip.RCC.csr().modify(|_, w| w.rmvf().set_bit());
        let clocks = Config::hse(8.MHz()).bypass_hse_oscillator();
        let mut rcc = chip.RCC.freeze(clocks.sysclk(96.MHz()).pclk1(48.MHz()));
        pac::TIM2::enable(&mut rcc);
        pac::TIM2::reset(&mut rcc);
        pac::GPIOC::enable(&mut rcc);
        let pins = chip.GPIOA.split(&mut rcc);
        let line: Serial<_> =
            chip.USART2.serial((pins.pa2, pins.pa3), 115_200.bps(), &mut rcc).ok()?;
        let (line, _) = line.release();
        // SAFETY: neither is enabled yet.
        unsafe {
            core.NVIC.set_priority(Interrupt::TIM2, STEP_PRIORITY);
            core.NVIC.set_priority(Interrupt::USART2, LINE_PRIORITY);
        }
        let (timer, port, watchdog) = (chip.TIM2, chip.GPIOC, chip.IWDG);
        Some(Chip { timer, port, line, watchdog, reasons })
    }
}

/// Holds off the step interrupt, and the line's, which is less urgent.
#[inline(always)]
pub fn hold() {
    // SAFETY: it only masks more; `release` unmasks the same interrupts.
    unsafe { cortex_m::register::basepri::write(STEP_PRIORITY) };
    cortex_m::asm::isb();
}

/// Releases the interrupts.
#[inline(always)]
pub fn release() {
    // SAFETY: nothing else uses the priority mask.
    unsafe { cortex_m::register::basepri::write(0) };
    cortex_m::asm::isb();
}
