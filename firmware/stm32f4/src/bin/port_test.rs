//! Tests whether the step timer keeps the contract of `StepTimer`, and sends the result on the
//! line.
#![no_std]
#![no_main]

use stepwright_controller::TimerTrial;
use stepwright_stm32f4::chip::Chip;
use stepwright_stm32f4::timer::{self, StepInterrupt, Timer};
use stepwright_stm32f4::uart::{self, Uart};
use stm32f4xx_hal::interrupt;

static TRIAL: TimerTrial<Timer, StepInterrupt> = TimerTrial::empty();

#[interrupt]
fn TIM2() {
    // SAFETY: this is the step interrupt.
    unsafe { TRIAL.on_compare() };
}

#[interrupt]
fn USART2() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(chip) = Chip::take() {
        let (timer, mut line) = (timer::start(chip.timer), Uart::start(chip.line));
        // 2,000 ticks: the interrupt with its work.
        // SAFETY: once; the interrupt has been held off since the timer's start.
        unsafe { TRIAL.run(timer, 2_000, &mut line) }
    }
    // No program takes the chip twice.
    loop {
        cortex_m::asm::wfe();
    }
}
