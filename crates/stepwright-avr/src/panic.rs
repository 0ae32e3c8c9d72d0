//! Proves at link time that the firmware contains no panic.

use core::panic::PanicInfo;

unsafe extern "C" {
    /// Does not exist: a firmware that can reach a panic does not link.
    safe fn a_panic_can_be_reached() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    a_panic_can_be_reached()
}
