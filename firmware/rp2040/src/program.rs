//! The program of a state machine: "wait, then step", n times.
//!
//! ```text
//! .program step
//! .side_set 1                      ; STEP; the OUT pin is DIR
//! .wrap_target
//!     out isr, 32      side 0      ; D; rests here
//!     out pins, 1      side 0      ; DIR
//!     out y, 31        side 0      ; steps - 1
//!     irq nowait 0 rel side 0      ; a group has begun: there is room for another
//! pause:
//!     mov x, isr       side 0
//! low:
//!     jmp x-- low      side 0      ; D + 1 cycles
//!     set x, P         side 1      ; STEP rises
//! high:
//!     jmp x-- high     side 1 [d]  ; (P + 1)(d + 1) cycles; both lines again for longer pulses
//!     jmp y-- again    side 0
//! .wrap
//! again:
//!     jmp pause        side 0 [3]  ; as long as the four lines of a group's head
//! ```
//!
//! From edge to edge it takes D + H + 7 cycles, also from group to group; H = k(1 + (P + 1)(d + 1))
//! is the pulse, with k such loops. Autopull at 32 bits, OUT shifts right, the FIFOs joined: 8
//! words are four groups of two words, `D`, and `steps - 1` above `DIR`.

/// Cycles from edge to edge in addition to D and the pulse.
pub const FIXED: u32 = 7;

/// Cycles from a start to the first edge in addition to D: one to fill the output register, the
/// four lines of the head, and two of the wait.
pub const FIRST: u32 = 7;

/// The longest pulse of one loop: (31 + 1)(15 + 1) + 1.
const LOOP: u32 = 513;

/// The most loops: enough for the largest `pulse-us`, 20 µs.
const LOOPS: u32 = 5;

/// The instructions and their layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    code: [u16; 18],
    loops: u8,
    /// Cycles for which STEP is high.
    pub high: u32,
}

/// The side-set bit for a high STEP.
const SIDE: u16 = 1 << 12;

impl Program {
    /// The program for pulses of at least this many cycles, 2 to 2,565. They are longer by one in
    /// eight at most.
    pub const fn of_pulse(pulse: u32) -> Program {
        let mut loops = 1;
        while loops < LOOPS && pulse > loops * LOOP {
            loops += 1;
        }
        // Cycles of a loop's jumps: a count times a number of cycles.
        let mut each = 1;
        while each < LOOP - 1 && loops * (each + 1) < pulse {
            each += 1;
        }
        let delay = (each - 1) / 32;
        let mut count = 1;
        while count * (delay + 1) < each {
            count += 1;
        }
        let mut code =
            [0x60C0, 0x6001, 0x605F, 0xC010, 0xA026, 0x0045, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let mut at = 6;
        while at < code.len() {
            let line = at as u16;
            code[at] = if at as u32 == 6 + 2 * loops {
                0x0080 | (line + 1)
            } else if at as u32 > 6 + 2 * loops {
                0x0304
            } else if at % 2 == 0 {
                0xE020 | (count - 1) as u16 | SIDE
            } else {
                0x0040 | line | (delay as u16) << 8 | SIDE
            };
            at += 1;
        }
        Program { code, loops: loops as u8, high: loops * (1 + count * (delay + 1)) }
    }

    /// The instructions.
    pub fn code(&self) -> impl Iterator<Item = u16> + '_ {
        self.code.iter().copied().take(usize::from(self.again()) + 1)
    }

    /// The last line before the program wraps to its first.
    pub const fn wrap(&self) -> u8 {
        6 + 2 * self.loops
    }

    const fn again(&self) -> u8 {
        7 + 2 * self.loops
    }

    /// Whether STEP is high before this line is carried out.
    pub const fn is_high(&self, line: u8) -> bool {
        line > 6 && line <= self.wrap()
    }

    /// The steps of the present group that are left before this line is carried out, if the
    /// machine's Y is `y`; `u32::MAX` for all of them.
    pub const fn left(&self, line: u8, y: u32) -> u32 {
        match line {
            0 => 0,
            1 | 2 => u32::MAX,
            _ if self.is_high(line) => y,
            _ => y.wrapping_add(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the same program from an independent assembler.
    #[test]
    fn it_is_what_an_assembler_makes_of_its_text() {
        let text = pio::pio_asm!(
            ".side_set 1",
            ".wrap_target",
            "out isr, 32 side 0",
            "out pins, 1 side 0",
            "out y, 31 side 0",
            "irq nowait 0 rel side 0",
            "pause:",
            "mov x, isr side 0",
            "low:",
            "jmp x-- low side 0",
            "set x, 30 side 1",
            "high:",
            "jmp x-- high side 1 [3]",
            "jmp y-- again side 0",
            ".wrap",
            "again:",
            "jmp pause side 0 [3]",
        );
        let own = Program::of_pulse(125);
        assert!(own.code().eq(text.program.code.iter().copied()));
        assert_eq!((own.wrap(), own.high), (text.program.wrap.source, 125));
    }

    #[test]
    fn a_pulse_is_as_long_as_asked_for_or_a_little_longer() {
        for pulse in 2..=2_565 {
            let own = Program::of_pulse(pulse);
            assert!(own.high >= pulse, "{pulse}: {}", own.high);
            assert!(own.high - pulse <= pulse / 8 + 1, "{pulse}: {}", own.high);
            assert!(own.code().count() <= 18);
        }
        assert_eq!(Program::of_pulse(2_565).high, 2_565);
    }

    #[test]
    fn what_is_left_is_known_at_each_line() {
        let own = Program::of_pulse(125);
        let at = |line| own.left(line, 5);
        assert_eq!([0, 1, 2].map(at), [0, u32::MAX, u32::MAX]);
        assert_eq!([3, 4, 5, 6, 7, 8, 9].map(at), [6, 6, 6, 6, 5, 5, 6]);
        assert!(!own.is_high(6) && own.is_high(7) && own.is_high(8) && !own.is_high(9));
    }
}
