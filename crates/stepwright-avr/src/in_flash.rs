//! Values that stay in flash.

use core::cell::UnsafeCell;

/// A value in flash: for a static in the section `.progmem.data`.
///
/// An ordinary constant takes RAM as well as flash.
#[repr(transparent)]
pub struct InFlash<T>(UnsafeCell<T>);

// SAFETY: nobody can write it.
unsafe impl<T> Sync for InFlash<T> {}

impl<T: Copy> InFlash<T> {
    const AT_MOST_255_BYTES: () = assert!(size_of::<T>() > 0 && size_of::<T>() <= 255);

    /// A value for flash.
    pub const fn new(value: T) -> InFlash<T> {
        let () = Self::AT_MOST_255_BYTES;
        InFlash(UnsafeCell::new(value))
    }

    /// Copies the value: about 8 cycles a byte.
    ///
    /// # Safety
    /// This is a static in the section `.progmem.data`: in the first 64 KB of flash, which
    /// `lpm` reaches.
    #[inline(always)]
    pub unsafe fn load(&self, to: &mut T) {
        // SAFETY: reads this many bytes of flash, by the caller's promise those of a `T`, and
        // writes as many to a `T`.
        unsafe {
            core::arch::asm!(
                "1: lpm {byte}, Z+",
                "st X+, {byte}",
                "dec {left}",
                "brne 1b",
                byte = out(reg) _,
                left = inout(reg) size_of::<T>() as u8 => _,
                inout("Z") self.0.get() => _,
                inout("X") core::ptr::from_mut(to) => _,
                options(nostack),
            );
        }
    }
}
