//! Fixed texts, kept where they cost no RAM.
//!
//! An AVR has two memories: a constant that is read in the ordinary way is
//! copied to RAM at power-up. [`text!`] leaves it in flash, and
//! [`Text::byte`] reads it there, a byte at a time (about 10 cycles). On every
//! other chip a text is a constant like any other.

use core::fmt;

/// A fixed text of ASCII characters.
///
/// The slice names the place and the length. On an AVR the place is one in
/// flash, so that only [`Text::byte`] may look at it.
#[derive(Clone, Copy)]
pub struct Text(&'static [u8]);

/// A [`Text`] of a literal.
macro_rules! text {
    ($literal:expr) => {{
        const LENGTH: usize = $literal.len();
        // SAFETY: a section that the linker knows, and nothing else in it but
        // constants.
        #[cfg_attr(target_arch = "avr", allow(unsafe_code))]
        #[cfg_attr(target_arch = "avr", unsafe(link_section = ".progmem.data"))]
        static BYTES: [u8; LENGTH] = crate::flash::bytes($literal);
        crate::flash::Text::at(&BYTES)
    }};
}
pub(crate) use text;

/// The bytes of a literal, for [`text!`].
pub(crate) const fn bytes<const LENGTH: usize>(literal: &str) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let mut at = 0;
    while at < LENGTH {
        bytes[at] = literal.as_bytes()[at];
        at += 1;
    }
    bytes
}

impl Text {
    /// The text that [`text!`] has put there.
    pub(crate) const fn at(place: &'static [u8]) -> Text {
        Text(place)
    }

    /// Byte `at`, counted from 0; `None` behind the last.
    #[cfg(not(target_arch = "avr"))]
    pub(crate) fn byte(self, at: u8) -> Option<u8> {
        self.0.get(usize::from(at)).copied()
    }

    /// Byte `at`, counted from 0; `None` behind the last.
    #[cfg(target_arch = "avr")]
    #[allow(unsafe_code)]
    pub(crate) fn byte(self, at: u8) -> Option<u8> {
        if usize::from(at) >= self.0.len() {
            return None;
        }
        let place = self.0.as_ptr().wrapping_add(at.into());
        let byte: u8;
        // SAFETY: `text!` has put `len` bytes there, in the first 64 KB of
        // flash, which `lpm` reaches: the linker puts `.progmem.data` right
        // behind the vectors. It changes no memory and no flags.
        unsafe {
            core::arch::asm!("lpm {byte}, Z", byte = out(reg) byte, in("Z") place,
                options(pure, readonly, nostack, preserves_flags));
        }
        Some(byte)
    }

    /// Whether these are its bytes.
    pub(crate) fn is(self, bytes: &[u8]) -> bool {
        self.0.len() == bytes.len()
            && bytes.iter().zip(0..).all(|(byte, at)| self.byte(at) == Some(*byte))
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (0..)
            .map_while(|at| self.byte(at))
            .try_for_each(|byte| fmt::Write::write_char(f, byte.into()))
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    #[test]
    fn a_text_is_its_own_bytes_and_no_others() {
        let text = text!("max-speed");
        assert_eq!(text.to_string(), "max-speed");
        assert!(text.is(b"max-speed") && text!("").is(b""));
        for other in [&b""[..], b"max-spee", b"max-speedy", b"max_speed"] {
            assert!(!text.is(other), "{other:?}");
        }
        assert_eq!((text.byte(8), text.byte(9), text.byte(255)), (Some(b'd'), None, None));
    }
}
