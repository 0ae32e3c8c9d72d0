//! The registers and flags that an instruction reads and writes.
//!
//! The sets are on the safe side. `reads` has all registers that may be read. `writes` has all that
//! may be written, `sure` those that certainly are.
//!
//! A function compiled by LLVM gets its arguments in r8 to r25 and returns its result in r18 to
//! r25. It preserves r2 to r17 and Y; r1 is 0 at its beginning and end. libgcc's helpers also read
//! X and Z.

use super::asm::Code;

/// Registers as bits 0 to 31, and the flags.
pub(crate) type Set = u64;

/// The carry flag, and the half carry.
pub(crate) const CARRY: Set = 1 << 32;
/// The zero flag.
pub(crate) const ZERO: Set = 1 << 33;
/// The flags N, V and S.
pub(crate) const SIGN: Set = 1 << 34;
/// The flag T.
const BIT: Set = 1 << 35;
/// The flags that arithmetic sets.
pub(crate) const ARITHMETIC: Set = CARRY | ZERO | SIGN;
/// The flags that logic sets.
const LOGIC: Set = ZERO | SIGN;
/// All flags.
pub(crate) const FLAGS: Set = ARITHMETIC | BIT;
/// Every register and flag.
const EVERYTHING: Set = (1 << 36) - 1;

/// The registers from one to another.
const fn span(from: u8, to: u8) -> Set {
    ((1 << (to - from + 1)) - 1) << from
}

/// The registers that may hold arguments.
pub(crate) const TAKEN: Set = span(8, 25);
/// The registers that may hold a result.
pub(crate) const GIVEN: Set = span(18, 25);
/// The registers that a function preserves.
const KEPT: Set = span(2, 17) | span(28, 29);
/// The registers and flags that a called function may overwrite.
const LOST: Set = EVERYTHING & !KEPT & !(1 << 1);

/// A kind of instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// It computes: it can be removed if its result is not read.
    Plain,
    /// It accesses memory, a port or the stack, or calls.
    Outward,
    /// It continues at a label, or after it.
    Branch,
    /// It continues at a label.
    Jump,
    /// It may skip the next instruction.
    Skip,
    /// It leaves the function.
    Leave,
}

/// The effect of an instruction on registers and flags.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effect {
    pub kind: Kind,
    pub reads: Set,
    pub writes: Set,
    /// Those of `writes` that are certain.
    pub sure: Set,
}

/// The number of a register.
pub(crate) fn register(text: &str) -> Option<usize> {
    let number = text.strip_prefix('r')?.parse().ok()?;
    (number < 32).then_some(number)
}

/// Both registers of a pair.
const fn pair(low: usize) -> Set {
    3 << low
}

/// The registers of the pointer in `X`, `-Z`, `Y+` or `Z+3`, and those of them that change.
fn pointer(text: &str) -> Option<(Set, Set)> {
    let low = match text.trim_start_matches('-').chars().next()? {
        'X' => 26,
        'Y' => 28,
        'Z' => 30,
        _ => return None,
    };
    let changes = text.starts_with('-') || text.ends_with('+');
    Some((pair(low), if changes { pair(low) } else { 0 }))
}

/// The effect of a label or a comment.
pub(crate) const NOTHING: Effect = Effect { kind: Kind::Outward, reads: 0, writes: 0, sure: 0 };
/// The effect of hand-written assembly, which leaves r1 0.
pub(crate) const UNKNOWN: Effect =
    Effect { kind: Kind::Outward, reads: EVERYTHING, writes: EVERYTHING & !2, sure: 0 };

/// The effect of an instruction; `None` if it is not known.
pub(crate) fn effect(code: &Code) -> Option<Effect> {
    use Kind::{Branch, Jump, Leave, Outward, Plain, Skip};
    let (a, b) = (&*code.a, &*code.b);
    let one = |text: &str| register(text).map(|r| 1 << r);
    let two = |text: &str| register(text).map(pair);
    let of = |kind, reads, writes| Effect { kind, reads, writes, sure: writes };
    let inside = a.starts_with('.');
    Some(match &*code.name {
        "mov" => of(Plain, one(b)?, one(a)?),
        "movw" => of(Plain, two(b)?, two(a)?),
        "ldi" | "ser" => of(Plain, 0, one(a)?),
        "clr" => of(Plain, 0, one(a)? | LOGIC),
        "eor" if a == b => of(Plain, 0, one(a)? | LOGIC),
        "and" | "or" | "eor" => of(Plain, one(a)? | one(b)?, one(a)? | LOGIC),
        "andi" | "ori" | "inc" | "dec" => of(Plain, one(a)?, one(a)? | LOGIC),
        "tst" => of(Plain, one(a)?, LOGIC),
        "swap" => of(Plain, one(a)?, one(a)?),
        "add" | "sub" => of(Plain, one(a)? | one(b)?, one(a)? | ARITHMETIC),
        "adc" => of(Plain, one(a)? | one(b)? | CARRY, one(a)? | ARITHMETIC),
        "sbc" => of(Plain, one(a)? | one(b)? | CARRY | ZERO, one(a)? | ARITHMETIC),
        "subi" | "neg" | "com" | "lsl" | "lsr" | "asr" => of(Plain, one(a)?, one(a)? | ARITHMETIC),
        "rol" | "ror" => of(Plain, one(a)? | CARRY, one(a)? | ARITHMETIC),
        "sbci" => of(Plain, one(a)? | CARRY | ZERO, one(a)? | ARITHMETIC),
        "adiw" | "sbiw" => of(Plain, two(a)?, two(a)? | ARITHMETIC),
        "cp" => of(Plain, one(a)? | one(b)?, ARITHMETIC),
        "cpc" => of(Plain, one(a)? | one(b)? | CARRY | ZERO, ARITHMETIC),
        "cpi" => of(Plain, one(a)?, ARITHMETIC),
        "mul" | "muls" | "mulsu" => of(Plain, one(a)? | one(b)?, 3 | CARRY | ZERO),
        "bst" => of(Plain, one(a)?, BIT),
        "bld" => of(Plain, one(a)? | BIT, one(a)?),
        "set" | "clt" => of(Plain, 0, BIT),
        "sec" | "clc" => of(Plain, 0, CARRY),
        "ld" | "ldd" | "lpm" => {
            let (reads, changed) = pointer(b)?;
            of(Outward, reads, one(a)? | changed)
        }
        "st" | "std" => {
            let (reads, changed) = pointer(a)?;
            of(Outward, reads | one(b)?, changed)
        }
        "lds" | "pop" => of(Outward, 0, one(a)?),
        "in" => of(Outward, if b == "63" { FLAGS } else { 0 }, one(a)?),
        "out" => of(Outward, one(b)?, if a == "63" { FLAGS } else { 0 }),
        "sts" => of(Outward, one(b)?, 0),
        "push" => of(Outward, one(a)?, 0),
        "cli" | "sei" | "sbi" | "cbi" | "wdr" | "nop" | "sleep" => of(Outward, 0, 0),
        "breq" | "brne" => of(Branch, ZERO, 0),
        "brcs" | "brcc" | "brlo" | "brsh" => of(Branch, CARRY, 0),
        "brmi" | "brpl" | "brlt" | "brge" => of(Branch, SIGN, 0),
        "brts" | "brtc" => of(Branch, BIT, 0),
        "sbrs" | "sbrc" => of(Skip, one(a)?, 0),
        "sbis" | "sbic" => of(Skip, 0, 0),
        "cpse" => of(Skip, one(a)? | one(b)?, 0),
        "rjmp" | "jmp" if inside => of(Jump, 0, 0),
        "rjmp" | "jmp" => of(Leave, EVERYTHING, 0),
        "call" if a.starts_with("__") => {
            let reads = match a {
                "__mulsi3" => span(18, 25),
                "__udivmodhi4" => span(22, 25),
                _ => span(8, 31) | BIT | 2,
            };
            Effect { kind: Outward, reads, writes: LOST, sure: 0 }
        }
        // The result registers count as written by the call.
        "call" => of(Outward, TAKEN | span(28, 29) | 2, LOST),
        "ret" => of(Leave, KEPT | GIVEN | 2, 0),
        _ => return None,
    })
}
