//! The functions that a host of WebAssembly calls.

use core::cell::UnsafeCell;

use crate::LAWS;

/// Room for a line.
const ROOM: usize = 64;

struct Line(UnsafeCell<[u8; ROOM]>);
// SAFETY: a module has one thread.
unsafe impl Sync for Line {}

static LINE: Line = Line(UnsafeCell::new([0; ROOM]));

/// The address of the line.
#[unsafe(no_mangle)]
extern "C" fn line() -> *const u8 {
    LINE.0.get().cast()
}

/// Writes the line of a travel, and returns its length; 0 if there is no such law.
#[unsafe(no_mangle)]
extern "C" fn tell(law: u32, number: u32) -> usize {
    let Some(law) = LAWS.get(law as usize) else { return 0 };
    // SAFETY: nothing else uses it meanwhile.
    let line = unsafe { &mut *LINE.0.get() };
    let mut length = 0;
    law.tell(number, |byte| {
        if let Some(place) = line.get_mut(length) {
            *place = byte;
            length += 1;
        }
    });
    length
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    core::arch::wasm32::unreachable()
}
