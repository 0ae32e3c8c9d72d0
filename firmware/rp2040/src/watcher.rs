//! The program of a state machine that reports when a pin rises.
//!
//! ```text
//! .program watcher
//! .wrap_target
//! low:
//!     jmp x-- ask          ; X counts two cycles
//! ask:
//!     jmp pin rises
//! .wrap
//! rises:
//!     mov isr, x
//!     push noblock
//!     jmp x-- more         ; both at once: `mov` and `push`, and these two
//! more:
//!     jmp x-- high
//! high:
//!     jmp pin still
//!     jmp x-- low
//! still:
//!     jmp x-- high
//! ```
//!
//! X counts down by one every two cycles on all paths, from all ones: for 68 s at 125 MHz. A rise
//! is reported by the X at the moment when it was seen: to two cycles, and always with the same
//! delay after the edge.

/// The instructions.
pub const CODE: [u16; 9] = [0x0041, 0x00C2, 0xA0C1, 0x8000, 0x0045, 0x0046, 0x00C8, 0x0040, 0x0046];

/// The last line before the program wraps to its first.
pub const WRAP: u32 = 1;

/// The cycles per count of X.
pub const CYCLES: u32 = 2;

/// Sets X to all ones: `mov x, ~null`.
pub const REWIND: u16 = 0xA02B;

#[cfg(test)]
mod tests {
    /// Compares with the same program from an independent assembler.
    #[test]
    fn it_is_what_an_assembler_makes_of_its_text() {
        let text = pio::pio_asm!(
            ".wrap_target",
            "low:",
            "jmp x-- ask",
            "ask:",
            "jmp pin rises",
            ".wrap",
            "rises:",
            "mov isr, x",
            "push noblock",
            "jmp x-- more",
            "more:",
            "jmp x-- high",
            "high:",
            "jmp pin still",
            "jmp x-- low",
            "still:",
            "jmp x-- high",
        );
        assert!(super::CODE.iter().eq(text.program.code.iter()));
        assert_eq!((super::WRAP, 0), (text.program.wrap.source.into(), text.program.wrap.target));
        let rewind = pio::pio_asm!("mov x, !null");
        assert_eq!([super::REWIND], rewind.program.code[..]);
    }
}
