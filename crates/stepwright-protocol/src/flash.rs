//! Fixed texts, kept where they cost no RAM.
//!
//! An AVR has two memories: a constant that is read in the ordinary way is copied to RAM at
//! power-up. [`text!`] leaves it in flash, and [`Text::byte`] reads it there, a byte at a time
//! (about 10 cycles). On every other chip a text is an ordinary constant.

use core::fmt;

/// A fixed text of ASCII characters, or a table of bytes.
///
/// The slice holds the address and the length. On an AVR the address is one in flash, so only
/// `Text::byte` may read it.
#[derive(Clone, Copy)]
pub struct Text(&'static [u8]);

/// A [`Text`] of this many bytes. The compiler computes the array.
macro_rules! flash {
    ($length:expr, $bytes:expr) => {{
        // SAFETY: the linker knows this section, and it holds nothing but constants.
        #[cfg_attr(target_arch = "avr", allow(unsafe_code))]
        #[cfg_attr(target_arch = "avr", unsafe(link_section = ".progmem.data"))]
        static BYTES: [u8; $length] = $bytes;
        crate::flash::Text::at(&BYTES)
    }};
}
pub(crate) use flash;

/// A [`Text`] of a literal.
macro_rules! text {
    ($literal:expr) => {
        crate::flash::flash!($literal.len(), crate::flash::bytes($literal))
    };
}
pub(crate) use text;

/// The bytes of a literal, for [`text!`].
#[doc(hidden)] // `flash_text!` uses it
pub const fn bytes<const LENGTH: usize>(literal: &str) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let mut at = 0;
    while at < LENGTH {
        bytes[at] = literal.as_bytes()[at];
        at += 1;
    }
    bytes
}

/// A [`Text`] of a literal, in flash: for the words of a program's line.
///
/// ```
/// use stepwright_protocol::flash_text;
/// assert_eq!(flash_text!("pin").to_string(), "pin");
/// ```
#[macro_export]
macro_rules! flash_text {
    ($literal:expr) => {{
        // SAFETY: the linker knows this section, and it holds nothing but constants.
        #[cfg_attr(target_arch = "avr", unsafe(link_section = ".progmem.data"))]
        static BYTES: [u8; $literal.len()] = $crate::flash_bytes($literal);
        $crate::Text::at(&BYTES)
    }};
}

impl Text {
    /// The text that [`flash!`] or [`flash_text!`](crate::flash_text) has put at this place. On an
    /// AVR its bytes are read from flash.
    #[doc(hidden)] // the macros use it
    pub const fn at(place: &'static [u8]) -> Text {
        Text(place)
    }

    /// Byte `at`, counted from 0; `None` past the end.
    #[cfg(not(target_arch = "avr"))]
    pub(crate) fn byte(self, at: u16) -> Option<u8> {
        self.0.get(usize::from(at)).copied()
    }

    /// Byte `at`, counted from 0; `None` past the end.
    #[cfg(target_arch = "avr")]
    #[allow(unsafe_code)]
    pub(crate) fn byte(self, at: u16) -> Option<u8> {
        if usize::from(at) >= self.0.len() {
            return None;
        }
        let place = self.0.as_ptr().wrapping_add(usize::from(at));
        let byte: u8;
        // SAFETY: `flash!` has put `len` bytes there, in the first 64 KB of flash, which `lpm`
        // reaches: the linker puts `.progmem.data` right after the vectors. The instruction changes
        // no memory and no flags.
        unsafe {
            core::arch::asm!("lpm {byte}, Z", byte = out(reg) byte, in("Z") place,
                options(pure, readonly, nostack, preserves_flags));
        }
        Some(byte)
    }

    /// The text without its first byte.
    pub(crate) fn rest(self) -> Text {
        Text(self.0.get(1..).unwrap_or_default())
    }

    /// Word `n` of a text of words, each terminated by a NUL; past the last word an empty text. One
    /// such text takes less flash than many separate ones.
    #[inline(never)]
    pub(crate) fn word(self, n: u8) -> Text {
        let (mut left, mut from, mut at) = (n, 0, 0u16);
        while let Some(byte) = self.byte(at) {
            if byte == 0 {
                match left.checked_sub(1) {
                    None => return Text(self.0.get(from..at.into()).unwrap_or_default()),
                    Some(less) => left = less,
                }
                from = usize::from(at).wrapping_add(1);
            }
            at = at.wrapping_add(1);
        }
        Text(&[])
    }

    /// Whether the text consists of these bytes.
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
    fn a_text_of_words_has_each_of_them() {
        let words = text!("one\0\0three\0");
        let found = [0, 1, 2, 3, 255].map(|n| words.word(n).to_string());
        assert_eq!(found, ["one", "", "three", "", ""]);
        assert_eq!(text!("").word(0).to_string(), "");
    }

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
