//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use riscv::interrupt::Interrupt;
use stepwright_controller::ControllerEngine;
use stepwright_virt::board::BOARD;
use stepwright_virt::pins::{BoardPins, StepPins};
use stepwright_virt::timer::{self, StepInterrupt, Timer};
use stepwright_virt::uart::Uart;

static ENGINE: ControllerEngine<Timer, StepPins, StepInterrupt> = ControllerEngine::empty();

#[riscv_rt::core_interrupt(Interrupt::MachineTimer)]
fn on_compare() {
    // SAFETY: this is the step interrupt.
    unsafe { timer::visit(|| ENGINE.on_compare()) };
}

#[riscv_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, panel, mut line) =
        unsafe { (Timer::start(), StepPins::new(), BoardPins::new(), Uart::start()) };
    stepwright_controller::run(&ENGINE, timer, pins, BOARD, panel, &mut line)
}
