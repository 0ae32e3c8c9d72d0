//! There is no panic, and the linker proves it.

/// The panic handler of a firmware that can't panic: what it calls stands nowhere, so that a firmware in
/// which a panic could be reached does not link.
#[macro_export]
macro_rules! never_panics {
    () => {
        #[panic_handler]
        fn panic(_: &core::panic::PanicInfo) -> ! {
            unsafe extern "C" {
                safe fn a_panic_can_be_reached() -> !;
            }
            a_panic_can_be_reached()
        }
    };
}
