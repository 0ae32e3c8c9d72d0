//! Registers by their addresses.

/// A register of 32 bits.
///
/// A chip's manual names them; a crate of all its registers would be more to build than a
/// controller uses.
#[derive(Clone, Copy)]
pub struct Register(usize);

impl Register {
    /// The register at an address.
    ///
    /// # Safety
    /// There is one, of 32 bits, and the program may read and write it at any time.
    pub const unsafe fn at(address: usize) -> Register {
        Register(address)
    }

    /// What it holds.
    #[inline(always)]
    pub fn read(self) -> u32 {
        // SAFETY: the promise of who made it.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    /// Writes it.
    #[inline(always)]
    pub fn write(self, value: u32) {
        // SAFETY: likewise.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}
