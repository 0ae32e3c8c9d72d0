//! The player of a host's stream: entries of three axes in frames, played and braked by the board
//! itself; no planner. See `stepwright_avr::stream`, and `docs/stream.md` for the format.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

stepwright_avr::step_interrupts!();
stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let desk = unsafe { stepwright_avr::stream::StreamDesk::start() };
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { avr_device::interrupt::enable() };
    desk.serve()
}
