//! Registers, by address.

/// A register of 32 bits.
///
/// A chip's manual names the registers. A crate of all of them would take longer to build than a
/// controller is worth.
#[derive(Clone, Copy)]
pub struct Register(usize);

impl Register {
    /// The register at an address.
    ///
    /// # Safety
    /// There is a register of 32 bits, and the program may read and write it at any time.
    pub const unsafe fn at(address: usize) -> Register {
        Register(address)
    }

    /// Reads the register.
    #[inline(always)]
    pub fn read(self) -> u32 {
        // SAFETY: the promise of the caller of `at`.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    /// Writes the register.
    #[inline(always)]
    pub fn write(self, value: u32) {
        // SAFETY: as above.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}
