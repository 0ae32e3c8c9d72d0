//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use stepwright_controller::ControllerEngine;
use stepwright_nrf51::board::BOARD;
use stepwright_nrf51::pins::{BoardPins, StepPins};
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::{self, Uart};

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[unsafe(no_mangle)]
extern "C" fn TIMER0() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[unsafe(no_mangle)]
extern "C" fn UART0() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, panel, mut line) =
        unsafe { (Timer::start(), StepPins::new(), BoardPins::new(), Uart::start()) };
    stepwright_controller::run(&ENGINE, timer, pins, BOARD, panel, &mut line)
}
