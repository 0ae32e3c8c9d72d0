//! Austin's laws over the serial line: the motor on axis 1 moves by any of them.
#![no_std]
#![no_main]

use riscv::interrupt::Interrupt;
use stepwright_controller::{LawEngine, run_laws};
use stepwright_protocol::flash_text;
use stepwright_virt::board::BOARD;
use stepwright_virt::pins::{BoardPins, StepPins};
use stepwright_virt::timer::{self, StepInterrupt, Timer};
use stepwright_virt::uart::Uart;

static ENGINE: LawEngine<Timer, StepPins, StepInterrupt> = LawEngine::empty();

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
    run_laws(&ENGINE, timer, pins, &BOARD, panel, flash_text!("virt"), &mut line)
}
