//! The player of a host's stream: it receives frames, and moves three motors.
#![no_std]
#![no_main]

use stepwright::SharedEngine;
use stepwright_controller::{AXES, RUNS, run_stream};
use stepwright_nrf51::board::{BOARD, STREAM};
use stepwright_nrf51::pins::{BoardPins, StepPins};
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::{self, Uart};

static ENGINE: SharedEngine<Timer, StepPins, StepInterrupt, AXES, RUNS> = SharedEngine::empty();

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
    run_stream(&ENGINE, timer, pins, &BOARD, STREAM, panel, &mut line)
}
