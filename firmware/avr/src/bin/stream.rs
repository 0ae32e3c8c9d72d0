//! What a host streams: entries of three axes in frames, played and braked by the board itself; no
//! planner. See `stepwright_avr::stream`, and `docs/stream.md` for the format.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

stepwright_avr::step_interrupts!();
stepwright_avr::serial_interrupts!();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let desk = unsafe { stepwright_avr::stream::StreamDesk::start() };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    desk.serve()
}
