//! The registers of the three step channels.

#[cfg(feature = "mega")]
pub use mega::*;
#[cfg(feature = "uno")]
pub use uno::*;

/// Timer 1, and timer 2 for the third axis.
#[cfg(feature = "uno")]
mod uno {
    /// The counter's low byte; the compare register of the first axis.
    pub const TCNT: u16 = 0x84;
    pub const OCR: u16 = 0x88;
    /// Mode and prescaler.
    pub const TCCRA: u16 = 0x80;
    /// The interrupt mask of the channels, from bit 1 on, and their flags (an I/O address).
    pub const TIMSK: u16 = 0x6F;
    pub const TIFR: u8 = 0x16;
    /// Mask and bit of the third axis.
    pub const MASK2: u16 = 0x70;
    pub const BIT2: u8 = 1;
    /// The interrupt vectors of the axes.
    pub const VECTORS: [u8; 3] = [11, 12, 7];
}

/// One 16-bit timer: 1, or the one selected by a feature.
#[cfg(feature = "mega")]
mod mega {
    macro_rules! timer {
        ($number:literal, $tccra:literal, $timsk:literal, $tifr:literal, $vector:literal) => {
            pub const TCCRA: u16 = $tccra;
            pub const TCNT: u16 = $tccra + 4;
            pub const OCR: u16 = $tccra + 8;
            pub const TIMSK: u16 = $timsk;
            pub const TIFR: u8 = $tifr;
            pub const VECTORS: [u8; 3] = [$vector, $vector + 1, $vector + 2];
        };
    }
    #[cfg(not(any(feature = "timer3", feature = "timer4", feature = "timer5")))]
    timer!(1, 0x80, 0x6F, 0x16, 17);
    #[cfg(feature = "timer3")]
    timer!(3, 0x90, 0x71, 0x18, 32);
    #[cfg(feature = "timer4")]
    timer!(4, 0xA0, 0x72, 0x19, 42);
    #[cfg(feature = "timer5")]
    timer!(5, 0x120, 0x73, 0x1A, 47);
    pub const MASK2: u16 = TIMSK;
    pub const BIT2: u8 = 3;
}

/// The STEP bits of all axes in the pins of entries.
pub const STEPS: u8 = {
    let mut all = 0;
    let mut axis = 0;
    while axis < crate::board::AXES {
        all |= crate::board::wiring(axis as u8).step;
        axis += 1;
    }
    all
};
