//! Austin's power term over the serial line, on an Uno. See `stepwright_avr::laws`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

stepwright_avr::ordered_laws!();
