//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use stepwright_controller::ControllerEngine;
use stepwright_mps2::board::BOARD;
use stepwright_mps2::pins::{BoardPins, StepPins};
use stepwright_mps2::timer::{StepInterrupt, Timer};
use stepwright_mps2::uart::Uart;

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[unsafe(no_mangle)]
extern "C" fn DUALTIMER() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, panel, mut line) =
        unsafe { (Timer::start(), StepPins::new(), BoardPins::new(), Uart::start()) };
    stepwright_controller::run(&ENGINE, timer, pins, BOARD, panel, &mut line)
}
