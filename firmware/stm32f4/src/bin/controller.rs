//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use stepwright_controller::ControllerEngine;
use stepwright_stm32f4::board::BOARD;
use stepwright_stm32f4::chip::Chip;
use stepwright_stm32f4::pins::{self, StepPins};
use stepwright_stm32f4::timer::{self, StepInterrupt, Timer};
use stepwright_stm32f4::uart::{self, Uart};
use stm32f4xx_hal::interrupt;

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[interrupt]
fn TIM2() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[interrupt]
fn USART2() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some(chip) = Chip::take() {
        let (drive, panel) = pins::start(chip.port, chip.watchdog, chip.reasons);
        let (timer, mut line) = (timer::start(chip.timer), Uart::start(chip.line));
        stepwright_controller::run(&ENGINE, timer, drive, BOARD, panel, &mut line)
    }
    // No program takes the chip twice.
    loop {
        cortex_m::asm::wfe();
    }
}
