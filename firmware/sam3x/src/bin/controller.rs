//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use stepwright_controller::ControllerEngine;
use stepwright_sam3x::board::BOARD;
use stepwright_sam3x::chip;
use stepwright_sam3x::pins::{BoardPins, StepPins};
use stepwright_sam3x::timer::{self, StepInterrupt, Timer};
use stepwright_sam3x::uart::{self, Uart};

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[unsafe(no_mangle)]
extern "C" fn TC0() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[unsafe(no_mangle)]
extern "C" fn UART() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: first, and each of them once.
    let (timer, pins, panel, mut line) = unsafe {
        chip::start();
        (timer::start(), StepPins::new(), BoardPins::new(), Uart::start())
    };
    stepwright_controller::run(&ENGINE, timer, pins, BOARD, panel, &mut line)
}
