//! A main loop that sleeps, without an executor.
#![no_std]
#![no_main]

use cortex_m::asm;
use nrf51_pac::interrupt;
use stepwright::{Axis, Steppers};
use stepwright_microbit::{BOARD, Engine, say, start};

static ENGINE: Engine = Engine::empty();

#[interrupt]
fn TIMER0() {
    // SAFETY: this is the step interrupt.
    unsafe { ENGINE.on_compare() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: once.
    let (timer, pins) = unsafe { start() };
    let (engine, feeds) = ENGINE.fill(timer, pins, &BOARD).unwrap();
    let mut motors = Steppers::new(engine, feeds, BOARD);
    for target in [400, 100] {
        motors.move_line_to([(Axis::X, target), (Axis::Y, -target / 2)]).unwrap();
        while motors.any_moving() {
            motors.poll();
            asm::wfe(); // sleeps until an interrupt comes, if none has come since the last time
        }
    }
    let [x, y] = [Axis::X, Axis::Y].map(|axis| motors.position(axis));
    say!("{x:?} {y:?} late {}", motors.late());
    loop {
        asm::wfe();
    }
}
