//! Austin's laws over the serial line: on a Mega all of them, on an Uno the general form and
//! the published listing. See `stepwright_avr::laws`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

stepwright_avr::ordered_laws!();
