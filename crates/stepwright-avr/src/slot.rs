//! A static that the main program makes and an interrupt uses.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

/// Memory at a fixed address, whose owners agree who has it when.
///
/// A fixed address saves the interrupt a pointer, and there is no flag that
/// says whether the value is there, as it would cost cycles in each interrupt.
#[repr(transparent)] // assembly finds the value at its address
pub struct Slot<T>(UnsafeCell<T>);

// SAFETY: the chip has one core, so that only an interrupt can come between;
// each `get` says why none does.
unsafe impl<T> Sync for Slot<T> {}

impl<T> Slot<T> {
    /// Memory with a first value.
    pub const fn new(value: T) -> Slot<T> {
        Slot(UnsafeCell::new(value))
    }

    /// Where the value lies.
    pub const fn address(&self) -> *const T {
        self.0.get()
    }

    /// The value, to be read by all.
    ///
    /// # Safety
    /// Nobody may [`get`](Slot::get) it.
    pub const unsafe fn share(&self) -> &T {
        // SAFETY: the caller's promise.
        unsafe { &*self.0.get() }
    }

    /// The value.
    ///
    /// # Safety
    /// While the reference lives, nobody else may get another: the caller is
    /// the interrupt that owns the value, or that interrupt can't come.
    #[inline(always)]
    #[allow(clippy::mut_from_ref, reason = "that is what the caller promises")]
    pub unsafe fn get(&self) -> &mut T {
        // SAFETY: the caller's promise.
        unsafe { &mut *self.0.get() }
    }
}

/// Registers, which are no more than a right.
///
/// # Safety
/// The caller has the right, or nothing is done with them before somebody has.
pub(crate) const unsafe fn token<T>() -> T {
    const { assert!(size_of::<T>() == 0) };
    // SAFETY: of a value without bytes none is missing; the caller's promise.
    unsafe { MaybeUninit::uninit().assume_init() }
}
