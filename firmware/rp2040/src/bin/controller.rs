//! The controller: it takes lines, and moves three motors.
#![no_std]
#![no_main]

use stepwright::{Board, OrderedMotors};
use stepwright_controller::{AXES, RUNS};
use stepwright_rp2040::board::{BOUND, RATE, board};
use stepwright_rp2040::lines::Lines;
use stepwright_rp2040::pins::BoardPins;
use stepwright_rp2040::pio::{self, PioInterrupt, PioPlayer};
use stepwright_rp2040::usb::Usb;
use stepwright_rp2040::{chip, uart};
use stepwright_sink::SharedSink;

/// A constant, so that the compiler computes the values derived from it.
const BOARD: Board<AXES> = board();

static SINK: SharedSink<PioPlayer, PioInterrupt, AXES, RUNS> = SharedSink::empty();

// In RAM, like all functions that it calls.
#[unsafe(link_section = ".data.stepwright")]
#[unsafe(no_mangle)]
extern "C" fn PIO0_IRQ_0() {
    // SAFETY: this is the player's interrupt.
    unsafe { SINK.serve(pio::begun()) };
}

#[unsafe(no_mangle)]
extern "C" fn UART0_IRQ() {
    // SAFETY: this is the line's interrupt.
    unsafe { uart::on_receive() };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: first, and each of them once.
    let (player, panel, mut line) = unsafe {
        chip::start();
        let line = Lines { uart: uart::Uart::start(), usb: Usb::start() };
        (PioPlayer::new(), BoardPins::new(RATE), line)
    };
    if let Some((engine, feeds)) = SINK.fill(player, &BOARD, BOUND) {
        let motors = OrderedMotors::new(engine, feeds, BOARD);
        stepwright_controller::run_motors(motors, RATE, panel, &mut line);
    }
    // The engine was filled elsewhere, which no program does.
    loop {
        core::hint::spin_loop();
    }
}
