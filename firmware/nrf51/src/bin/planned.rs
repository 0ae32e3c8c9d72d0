//! Planned motors in your own program: lines and moves. It is linked like the controller: it can't
//! panic.
#![no_std]
#![no_main]

use core::fmt::Write;

use cortex_m::asm;
use stepwright::{Control, MoveError, SharedEngine, Steppers};
use stepwright_nrf51::board::BOARD;
use stepwright_nrf51::pins::StepPins;
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::Uart;

#[path = "../../../qemu/chip/planned.rs"]
mod planned;

static ENGINE: SharedEngine<Timer, StepPins, StepInterrupt, 3> = SharedEngine::empty();

#[unsafe(no_mangle)]
extern "C" fn TIMER0() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: each of them once.
    let (timer, pins, mut line) = unsafe { (Timer::start(), StepPins::new(), Uart::to_talk()) };
    let mut reached = false;
    if let Some((engine, feeds)) = ENGINE.fill(timer, pins, &BOARD) {
        let mut motors = Steppers::new(engine, feeds, BOARD);
        reached = moves(&mut motors) == Ok(()) && motors.late() == 0;
    }
    let _ = line.write_str(if reached { "reached\r" } else { "not reached\r" });
    loop {
        asm::wfe();
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
