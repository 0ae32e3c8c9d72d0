//! The functions that a page calls. There is one planner, and a page has one thread.
//!
//! | function | what |
//! | --- | --- |
//! | `stepwright_numbers` | where the [`FIELDS`] numbers of the travel are written to |
//! | `stepwright_fields`, `_laws`, `_most_points` | how many numbers, laws and points there are |
//! | `stepwright_low`, `_high` | what is allowed of a number |
//! | `stepwright_plan` | plans by a law: 0, or 1 if it is refused |
//! | `stepwright_what`, `_remedy` | why: the address of a text of UTF-8 that ends with a 0 |
//! | `stepwright_columns`, `_figures` | where the curves and the figures lie |
//! | `stepwright_hash` | a hash of all delays |
//!
//! Addresses hold as long as the module does: nothing is ever allocated.

use core::cell::UnsafeCell;

use crate::order::{FIELDS, PlanLaw, PlanOrder, PlanRefusal};
use crate::planner::{MOST_POINTS, Planner};

/// The longest text, with its end.
const TEXT: usize = 256;

struct Desk {
    planner: Planner,
    what: [u8; TEXT],
    remedy: [u8; TEXT],
}

struct OneThread<T>(UnsafeCell<T>);

// SAFETY: WebAssembly without shared memory has one thread; elsewhere nothing calls these
// functions from two.
unsafe impl<T> Sync for OneThread<T> {}

static NUMBERS: OneThread<[f64; FIELDS]> = OneThread(UnsafeCell::new(PlanOrder::EXAMPLE));

/// All of it zeros, which a module need not carry.
static DESK: OneThread<Desk> = OneThread(UnsafeCell::new(Desk {
    planner: Planner::new(),
    what: [0; TEXT],
    remedy: [0; TEXT],
}));

/// Copies a text, and a 0 behind it.
fn put(place: &mut [u8; TEXT], text: &str) {
    let bytes = text.bytes().take(TEXT - 1).chain(core::iter::repeat(0));
    for (to, from) in place.iter_mut().zip(bytes) {
        *to = from;
    }
}

/// Where the numbers of the travel are written to, in the order of [`PlanOrder::check`].
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_numbers() -> *mut f64 {
    NUMBERS.0.get().cast()
}

/// How many numbers a travel has.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_fields() -> u32 {
    FIELDS as u32
}

/// How many laws there are.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_laws() -> u32 {
    PlanLaw::ALL.len() as u32
}

/// How many points a curve has room for: the distance of two columns.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_most_points() -> u32 {
    MOST_POINTS as u32
}

/// The smallest that is allowed of a number; NaN if there is no such number.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_low(field: u32) -> f64 {
    PlanOrder::field(field as usize).map_or(f64::NAN, |field| field.low)
}

/// The largest that is allowed of a number; NaN if there is no such number.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_high(field: u32) -> f64 {
    PlanOrder::field(field as usize).map_or(f64::NAN, |field| field.high)
}

/// Plans by the law of this number, with the numbers that were written. 0: planned. 1: refused.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_plan(law: u32) -> u32 {
    // SAFETY: one thread, and no reference outlives a call.
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

/// What was wrong with the travel that was refused last.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_what() -> *const u8 {
    // SAFETY: the address of a field; nothing is read.
    unsafe { (&raw const (*DESK.0.get()).what).cast() }
}

/// What is allowed, or what to do.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_remedy() -> *const u8 {
    // SAFETY: the address of a field; nothing is read.
    unsafe { (&raw const (*DESK.0.get()).remedy).cast() }
}

/// The curves, one column behind the other.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_columns() -> *const f64 {
    // SAFETY: one thread, and no reference outlives a call.
    unsafe { &*DESK.0.get() }.planner.columns()
}

/// The figures, one number behind the other.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_figures() -> *const f64 {
    // SAFETY: one thread, and no reference outlives a call.
    core::ptr::from_ref(unsafe { &*DESK.0.get() }.planner.figures()).cast()
}

/// A hash of all delays that were planned last.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_hash() -> u64 {
    // SAFETY: one thread, and no reference outlives a call.
    unsafe { &*DESK.0.get() }.planner.hash()
}

#[cfg(all(target_family = "wasm", not(test)))]
mod panic {
    unsafe extern "C" {
        /// Stands nowhere: code that could panic would have to import it.
        fn stepwright_panicked() -> !;
    }

    #[panic_handler]
    fn panicked(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: it takes nothing and does not return.
        unsafe { stepwright_panicked() }
    }
}
