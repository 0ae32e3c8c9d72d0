//! The functions that a page calls. There is one planner, and a page has one thread.
//!
//! | function | what |
//! | --- | --- |
//! | `stepwright_numbers` | the address to which the [`FIELDS`] numbers of the travel are written |
//! | `stepwright_fields`, `_laws`, `_most_points` | the numbers of fields, laws and points |
//! | `stepwright_low`, `_high` | the range of a number |
//! | `stepwright_plan` | plans by a law: 0, or 1 if the travel is refused |
//! | `stepwright_what`, `_remedy` | the reason: the address of a UTF-8 text that ends with a 0 |
//! | `stepwright_columns`, `_figures` | the addresses of the curves and the figures |
//! | `stepwright_hash` | a hash of all delays |
//!
//! Addresses stay valid as long as the module lives: it never allocates.

use core::cell::UnsafeCell;

use crate::order::{FIELDS, PlanLaw, PlanOrder, PlanRefusal};
use crate::planner::{MOST_POINTS, Planner};

/// The most bytes of a text, with its 0.
const TEXT: usize = 256;

struct Desk {
    planner: Planner,
    what: [u8; TEXT],
    remedy: [u8; TEXT],
}

struct OneThread<T>(UnsafeCell<T>);

// SAFETY: WebAssembly without shared memory has one thread; elsewhere no two threads call these functions.
unsafe impl<T> Sync for OneThread<T> {}

static NUMBERS: OneThread<[f64; FIELDS]> = OneThread(UnsafeCell::new(PlanOrder::EXAMPLE));

/// All zeros, which take no space in a module.
static DESK: OneThread<Desk> = OneThread(UnsafeCell::new(Desk {
    planner: Planner::new(),
    what: [0; TEXT],
    remedy: [0; TEXT],
}));

/// Copies a text, and adds a 0.
fn put(place: &mut [u8; TEXT], text: &str) {
    let bytes = text.bytes().take(TEXT - 1).chain(core::iter::repeat(0));
    for (to, from) in place.iter_mut().zip(bytes) {
        *to = from;
    }
}

/// The address to which the numbers of the travel are written, in the order of [`PlanOrder::check`].
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_numbers() -> *mut f64 {
    NUMBERS.0.get().cast()
}

/// The number of fields of a travel.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_fields() -> u32 {
    FIELDS as u32
}

/// The number of laws.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_laws() -> u32 {
    PlanLaw::ALL.len() as u32
}

/// The most points of a curve, which is the distance between two columns.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_most_points() -> u32 {
    MOST_POINTS as u32
}

/// The smallest valid value of a field; NaN if there is no such field.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_low(field: u32) -> f64 {
    PlanOrder::field(field as usize).map_or(f64::NAN, |field| field.low)
}

/// The largest valid value of a field; NaN if there is no such field.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_high(field: u32) -> f64 {
    PlanOrder::field(field as usize).map_or(f64::NAN, |field| field.high)
}

/// Plans by the law of this number, with the numbers that were written. Returns 0, or 1 if the travel is
/// refused.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_plan(law: u32) -> u32 {
    // SAFETY: there is one thread, and no reference outlives a call.
    let (desk, numbers) = unsafe { (&mut *DESK.0.get(), &*NUMBERS.0.get()) };
    let law = PlanLaw::ALL.get(law as usize).copied().ok_or(PlanRefusal::NO_LAW);
    let order = PlanOrder::check(numbers);
    match law.and_then(|law| desk.planner.plan(law, &order?)) {
        Ok(()) => 0,
        Err(PlanRefusal { what, remedy }) => {
            put(&mut desk.what, what);
            put(&mut desk.remedy, remedy);
            1
        }
    }
}

/// The reason of the last refusal.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_what() -> *const u8 {
    // SAFETY: the address of a field; nothing is read.
    unsafe { (&raw const (*DESK.0.get()).what).cast() }
}

/// The remedy: what is allowed, or what to do.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_remedy() -> *const u8 {
    // SAFETY: the address of a field; nothing is read.
    unsafe { (&raw const (*DESK.0.get()).remedy).cast() }
}

/// The curves, one column after the other.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_columns() -> *const f64 {
    // SAFETY: there is one thread, and no reference outlives a call.
    unsafe { &*DESK.0.get() }.planner.columns()
}

/// The figures, one number after the other.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_figures() -> *const f64 {
    // SAFETY: there is one thread, and no reference outlives a call.
    core::ptr::from_ref(unsafe { &*DESK.0.get() }.planner.figures()).cast()
}

/// A hash of all delays of the last plan.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_hash() -> u64 {
    // SAFETY: there is one thread, and no reference outlives a call.
    unsafe { &*DESK.0.get() }.planner.hash()
}

#[cfg(all(target_family = "wasm", not(test)))]
mod panic {
    unsafe extern "C" {
        /// Exists nowhere: code that could panic would have to import it.
        fn stepwright_panicked() -> !;
    }

    #[panic_handler]
    fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: it takes nothing and does not return.
        unsafe { stepwright_panicked() }
    }
}
