//! Motor cycles over the serial line: three motors, each with a program of its own.
#![no_std]
#![no_main]

use riscv::interrupt::Interrupt;
use stepwright_controller::ControllerCycle;
use stepwright_protocol::flash_text;
use stepwright_virt::board::{BOARD, CYCLE_PINS};
use stepwright_virt::pins::{BoardPins, StepPins};
use stepwright_virt::timer::{self, StepInterrupt, Timer};
use stepwright_virt::uart::Uart;

static CYCLE: ControllerCycle<Timer, StepPins, StepInterrupt, BoardPins> = ControllerCycle::empty();

#[riscv_rt::core_interrupt(Interrupt::MachineTimer)]
fn on_compare() {
    // SAFETY: this is the step interrupt.
    unsafe { timer::visit(|| CYCLE.on_compare()) };
}

#[riscv_rt::entry]
fn main() -> ! {
    let about = flash_text!("stepwright-cycle virt hz=10000000 axes=3 legs=64");
    // SAFETY: each of them once; the interrupt is off at power-up.
    unsafe {
        let board = (Timer::start(), StepPins::new(), BoardPins::new());
        let mut line = Uart::start();
        CYCLE.run(board, BOARD, CYCLE_PINS, about, &mut line)
    }
}
