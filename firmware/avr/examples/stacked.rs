//! A function with arguments on its stack. `cargo xtask test` checks that it is refused for a Mega,
//! where the compiler reads them from the wrong place.
#![no_std]
#![no_main]

use core::hint::black_box;

use stepwright_avr as _;

/// 26 bytes, of which 18 are passed in registers.
#[inline(never)]
fn stacked(a: u64, b: u64, c: u64, d: u16) -> u64 {
    a ^ b ^ c ^ u64::from(d)
}

#[avr_device::entry]
fn main() -> ! {
    loop {
        black_box(stacked(black_box(1), black_box(2), black_box(4), black_box(8)));
    }
}
