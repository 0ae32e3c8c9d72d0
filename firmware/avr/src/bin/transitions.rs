//! Austin's smooth transitions over the serial line, on an Uno: linear factor and piecewise.
//! See `stepwright_avr::laws`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

stepwright_avr::ordered_laws!();
