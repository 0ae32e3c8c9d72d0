//! A static that the main program sets up and an interrupt uses.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

/// Memory at a fixed address. Its users agree who owns it at what time.
///
/// A fixed address saves the interrupt a pointer. No flag says whether the value is set, because it
/// would cost cycles in each interrupt.
#[repr(transparent)] // assembly finds the value at its address
pub struct Slot<T>(UnsafeCell<T>);

// SAFETY: the chip has one core, so only an interrupt can interfere; each `get` says why none does.
unsafe impl<T> Sync for Slot<T> {}

impl<T> Slot<T> {
    /// Memory with an initial value.
    pub const fn new(value: T) -> Slot<T> {
        Slot(UnsafeCell::new(value))
    }

    /// The address of the value.
    pub const fn address(&self) -> *const T {
        self.0.get()
    }

    /// A shared reference to the value.
    ///
    /// # Safety
    /// Nothing may call [`get`](Slot::get) on it.
    pub const unsafe fn share(&self) -> &T {
        // SAFETY: the caller's promise.
        unsafe { &*self.0.get() }
    }

    /// An exclusive reference to the value.
    ///
    /// # Safety
    /// While the reference lives, nothing else may get another: the caller is the interrupt that
    /// owns the value, or that interrupt can't come.
    #[inline(always)]
    #[allow(clippy::mut_from_ref, reason = "that is what the caller promises")]
    pub unsafe fn get(&self) -> &mut T {
        // SAFETY: the caller's promise.
        unsafe { &mut *self.0.get() }
    }
}

/// A value without bytes that stands for access to registers.
///
/// # Safety
/// The caller has the access, or the value is not used before somebody has.
pub(crate) const unsafe fn token<T>() -> T {
    const { assert!(size_of::<T>() == 0) };
    // SAFETY: a value without bytes is always initialised; the caller's promise.
    unsafe { MaybeUninit::uninit().assume_init() }
}
