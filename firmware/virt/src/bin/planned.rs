//! Planned motors in your own program: lines and moves. It is linked like the controller: it can't
//! panic.
#![no_std]
#![no_main]

use riscv::interrupt::Interrupt;
use stepwright::{Control, MoveError, SharedEngine, Steppers};
use stepwright_device::main_loop::SerialPort;
use stepwright_virt::board::BOARD;
use stepwright_virt::pins::StepPins;
use stepwright_virt::timer::{self, StepInterrupt, Timer};
use stepwright_virt::uart::Uart;

#[path = "../../../qemu/chip/planned.rs"]
mod planned;

static ENGINE: SharedEngine<Timer, StepPins, StepInterrupt, 3> = SharedEngine::empty();

#[riscv_rt::core_interrupt(Interrupt::MachineTimer)]
fn on_compare() {
    // SAFETY: this is the step interrupt.
    unsafe { timer::visit(|| ENGINE.on_compare()) };
}

#[riscv_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, mut line) = unsafe { (Timer::start(), StepPins::new(), Uart::start()) };
    let mut reached = false;
    if let Some((engine, feeds)) = ENGINE.fill(timer, pins, &BOARD) {
        let mut motors = Steppers::new(engine, feeds, BOARD);
        reached = moves(&mut motors) == Ok(()) && motors.late() == 0;
    }
    let verdict: &[u8] = if reached { b"reached\r" } else { b"not reached\r" };
    for byte in verdict {
        while !line.has_room() {}
        line.send(*byte);
    }
    loop {
        core::hint::spin_loop();
    }
}

fn moves(motors: &mut Steppers<'_, impl Control, 3>) -> Result<(), MoveError> {
    for number in 0..planned::ORDERS {
        planned::order(motors, number)?;
        while motors.any_moving() {
            motors.poll();
        }
    }
    Ok(())
}
