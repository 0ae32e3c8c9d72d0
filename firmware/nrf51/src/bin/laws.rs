//! Austin's laws over the serial line: the motor on axis 1 moves by any of them.
#![no_std]
#![no_main]

use stepwright_controller::{LawEngine, run_laws};
use stepwright_nrf51::board::BOARD;
use stepwright_nrf51::pins::{BoardPins, StepPins};
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::{self, Uart};
use stepwright_protocol::flash_text;

static ENGINE: LawEngine<Timer, StepPins, StepInterrupt> = LawEngine::empty();

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
    run_laws(&ENGINE, timer, pins, &BOARD, panel, flash_text!("nrf51"), &mut line)
}
