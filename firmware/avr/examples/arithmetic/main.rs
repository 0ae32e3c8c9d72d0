//! Each operation of `operations.rs` as a function, which the rig calls: the compiled arithmetic of
//! wide numbers must have the same results as on a host.
#![no_std]
#![no_main]

use core::hint::black_box;

use stepwright_avr::slot::Slot;

include!("operations.rs");

/// The two operands, overwritten by the two results.
#[unsafe(no_mangle)]
static OPERANDS: Slot<[u64; 2]> = Slot::new([0; 2]);

macro_rules! functions {
    ($($name:ident($a:ident, $b:ident): $results:expr;)*) => {
        $(
            #[unsafe(no_mangle)]
            extern "C" fn $name() {
                // SAFETY: nothing else runs.
                let operands = unsafe { OPERANDS.get() };
                let [$a, $b] = black_box(*operands);
                let results: (u64, u64) = $results;
                *operands = black_box([results.0, results.1]);
            }
        )*
        /// They are called only from outside, and are kept because `main` has their addresses.
        static ALL: &[extern "C" fn()] = &[$($name),*];
    };
}
operations!(functions);

#[avr_device::entry]
fn main() -> ! {
    loop {
        black_box(ALL);
    }
}
