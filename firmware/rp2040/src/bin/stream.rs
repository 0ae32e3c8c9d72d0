//! The player of a host's stream: it receives frames, and moves three motors.
#![no_std]
#![no_main]

use stepwright::Control;
use stepwright_controller::{AXES, RUNS, play_stream};
use stepwright_rp2040::board::{STREAM, STREAM_BOARD, STREAM_RATE};
use stepwright_rp2040::divided::Divided;
use stepwright_rp2040::lines::Lines;
use stepwright_rp2040::pins::BoardPins;
use stepwright_rp2040::pio::{self, PioInterrupt, PioPlayer};
use stepwright_rp2040::usb::Usb;
use stepwright_rp2040::{chip, uart};
use stepwright_sink::SharedSink;

static SINK: SharedSink<Divided<PioPlayer, 3>, PioInterrupt, AXES, RUNS> = SharedSink::empty();

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
        chip::start_laser();
        let line = Lines { uart: uart::Uart::start(), usb: Usb::start() };
        (Divided(PioPlayer::new()), BoardPins::new(STREAM_RATE), line)
    };
    // A step may be up to 1 µs from its time.
    if let Some(filled) = SINK.fill(player, &STREAM_BOARD, STREAM_RATE.micros(1)) {
        // An axis that rests in the middle of a run, or turns, continues only after such a call.
        let round = |engine: &mut _| _ = Control::playing(engine, 0);
        play_stream(filled, STREAM, panel, &mut line, round);
    }
    // The engine was filled elsewhere, which no program does.
    loop {
        core::hint::spin_loop();
    }
}
