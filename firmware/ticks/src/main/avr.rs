//! An AVR with an Uno's core, and 128 KB of flash: an ATmega1284P. No Uno holds the 64-bit
//! arithmetic of all laws.

use avr_device::atmega328p::Peripherals;
use stepwright_avr as _; // // for its numbers and its panic handler
use stepwright_ticks::{self as all, Law};

/// The exact S-curve fills most of the flash: it has a program of its own.
const LAWS: &[Law] = if cfg!(feature = "s-curve") {
    &[all::S_CURVE]
} else {
    &[
        all::TRAPEZOID,
        all::RAMP,
        all::AUSTIN,
        all::AUSTIN_FIXED,
        all::LINEAR_FACTOR,
        all::POWER,
        all::PIECEWISE,
        all::BOARD,
        all::BOARD_JERK,
    ]
};

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: they are taken only here.
    let usart = unsafe { Peripherals::steal() }.USART0;
    // 2 Mbaud: 16 MHz / 8 / 1.
    usart.ucsr0a().write(|w| w.u2x0().set_bit());
    usart.ubrr0().write(|w| w.set(0));
    usart.ucsr0c().write(|w| w.ucsz0().chr8());
    usart.ucsr0b().write(|w| w.txen0().set_bit());
    let mut number = 0u32;
    loop {
        for law in LAWS {
            law.tell(number, |byte| {
                while usart.ucsr0a().read().udre0().bit_is_clear() {}
                // SAFETY: sending a byte affects no memory.
                usart.udr0().write(|w| unsafe { w.bits(byte) });
            });
        }
        number = number.wrapping_add(1);
    }
}
