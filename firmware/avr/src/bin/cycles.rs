//! Motor cycles over the serial line: orders by `stepwright cycle FILE --port`, or by any sender of
//! the lines of `stepwright_cycle::line`.
//!
//! An Uno has three motors, a Mega four, each on any pins except the serial line's.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

stepwright_avr::cycles_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    unsafe { stepwright_avr::cycles::serve() }
}
