//! There is no panic, and the linker proves it.

use core::panic::PanicInfo;

unsafe extern "C" {
    /// Stands nowhere: a firmware in which a panic could be reached does not
    /// link.
    safe fn a_panic_can_be_reached() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    a_panic_can_be_reached()
}
