//! Motor cycles over the serial line: three motors, each with a program of its own.
#![no_std]
#![no_main]

use stepwright_controller::ControllerCycle;
use stepwright_nrf51::board::{BOARD, CYCLE_PINS};
use stepwright_nrf51::pins::{BoardPins, StepPins};
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::{self, Uart};
use stepwright_protocol::flash_text;

static CYCLE: ControllerCycle<Timer, StepPins, StepInterrupt, BoardPins> = ControllerCycle::empty();

#[unsafe(no_mangle)]
extern "C" fn TIMER0() {
    // SAFETY: this is the step interrupt.
    unsafe { CYCLE.on_compare() };
}

#[unsafe(no_mangle)]
extern "C" fn UART0() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let about = flash_text!("stepwright-cycle nrf51 hz=16000000 axes=3 legs=64");
    // SAFETY: each of them once; the interrupt is off at power-up.
    unsafe {
        let board = (Timer::start(), StepPins::new(), BoardPins::new());
        let mut line = Uart::start();
        CYCLE.run(board, BOARD, CYCLE_PINS, about, &mut line)
    }
}
