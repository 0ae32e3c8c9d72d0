//! Plays seeded orders, captures its own STEP with the other PIO, and sends a line that `stepwright
//! selftest` checks: over USB, or over the UART while no program has the USB port open.
#![no_std]
#![no_main]

use stepwright::{Board, OrderedMotors};
use stepwright_controller::RUNS;
use stepwright_rp2040::board::{BOUND, MACHINES};
use stepwright_rp2040::capture::PioCapture;
use stepwright_rp2040::lines::Lines;
use stepwright_rp2040::pio::{self, PioInterrupt, PioPlayer};
use stepwright_rp2040::usb::Usb;
use stepwright_rp2040::{chip, uart};
use stepwright_selftest::RP2040;
use stepwright_sink::SharedSink;

const BOARD: Board<MACHINES> = RP2040.board();

static SINK: SharedSink<PioPlayer, PioInterrupt, MACHINES, RUNS> = SharedSink::empty();

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
    let (player, mut capture, mut line) = unsafe {
        chip::start();
        let line = Lines { uart: uart::Uart::start(), usb: Usb::start() };
        (PioPlayer::new(), PioCapture::new(), line)
    };
    if let Some((engine, feeds)) = SINK.fill(player, &BOARD, BOUND) {
        let mut motors = OrderedMotors::new(engine, feeds, BOARD);
        let found = stepwright_selftest::run(&mut motors, &RP2040, &mut capture);
        stepwright_controller::tell(&RP2040, found, Some(chip::khz()), &mut line)
    }
    // The engine was filled elsewhere, which no program does.
    loop {
        core::hint::spin_loop();
    }
}
