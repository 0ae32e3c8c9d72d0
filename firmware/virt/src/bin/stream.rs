//! The player of a host's stream: it receives frames, and moves three motors.
#![no_std]
#![no_main]

use riscv::interrupt::Interrupt;
use stepwright::SharedEngine;
use stepwright_controller::{AXES, RUNS, run_stream};
use stepwright_virt::board::{BOARD, STREAM};
use stepwright_virt::pins::{BoardPins, StepPins};
use stepwright_virt::timer::{self, StepInterrupt, Timer};
use stepwright_virt::uart::Uart;

static ENGINE: SharedEngine<Timer, StepPins, StepInterrupt, AXES, RUNS> = SharedEngine::empty();

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
    run_stream(&ENGINE, timer, pins, &BOARD, STREAM, panel, &mut line)
}
