//! Proves at link time that the firmware contains no panic.

/// Defines the panic handler of a firmware that can't panic. It calls a function that does not
/// exist, so a firmware that can reach a panic does not link.
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
