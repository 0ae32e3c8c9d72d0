//! What an instruction reads and writes.
//!
//! The sets are on the safe side. For what is read: all that may be. For what is written: `sure`
//! has what is certainly overwritten, `writes` all that may be.
//!
//! A function of LLVM's gets its arguments in r8 to r25 and gives its result in r18 to r25. It
//! keeps r2 to r17 and Y; r1 is 0 at its beginning and end. What libgcc's helpers take besides
//! is in X and Z.

use std::collections::HashMap;

use super::asm::Code;

/// Registers as bits 0 to 31, and the flags.
pub type Set = u64;

/// The carry flag, and the half carry.
pub const CARRY: Set = 1 << 32;
/// The zero flag.
pub const ZERO: Set = 1 << 33;
/// The flags of the sign.
pub const SIGN: Set = 1 << 34;
/// The flag of a bit that is copied.
pub const BIT: Set = 1 << 35;
/// What arithmetic sets.
const ALL: Set = CARRY | ZERO | SIGN;
/// What logic sets.
const LOGIC: Set = ZERO | SIGN;
/// All flags.
pub const FLAGS: Set = CARRY | ZERO | SIGN | BIT;
/// Every register and flag.
pub const EVERYTHING: Set = (1 << 36) - 1;

/// The registers from one to another.
const fn span(from: u8, to: u8) -> Set {
    ((1 << (to - from + 1)) - 1) << from
}

/// What a caller finds as it was.
const KEPT: Set = span(2, 17) | span(28, 29);
/// What a called function may overwrite.
const LOST: Set = EVERYTHING & !KEPT & !(1 << 1);

/// What an instruction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It computes: if nobody reads what it writes, it can go.
    Plain,
    /// It touches memory, a port or the stack.
    Outward,
    /// It goes on at a label, or behind it.
    Branch,
    /// It goes on at a label.
    Jump,
    /// It may skip the next instruction.
    Skip,
    /// It calls.
    Call,
    /// It leaves the function.
    Leave,
}

/// What an instruction does with registers and flags.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    pub kind: Kind,
    pub reads: Set,
    pub writes: Set,
    /// What it certainly overwrites.
    pub sure: Set,
}

/// The number of a register.
pub fn register(text: &str) -> Option<u8> {
    let number = text.trim().strip_prefix('r')?.parse().ok()?;
    (number < 32).then_some(number)
}

/// Both registers of a pair.
pub const fn pair(low: u8) -> Set {
    3 << low
}

/// The operands.
pub fn operands(code: &Code) -> (&str, &str) {
    let (a, b) = code.operands.split_once(',').unwrap_or((&code.operands, ""));
    (a.trim(), b.trim())
}

/// The pointer of `X`, `-Z`, `Y+` or `Z+3`, and whether it is changed.
fn pointer(text: &str) -> Option<(u8, bool)> {
    let name = text.trim_start_matches('-');
    let low = match name.chars().next()? {
        'X' => 26,
        'Y' => 28,
        'Z' => 30,
        _ => return None,
    };
    Some((low, text.starts_with('-') || text.ends_with('+')))
}

/// The registers of the pointer that an instruction has.
pub fn pointed(code: &Code) -> Set {
    let (a, b) = operands(code);
    [a, b].iter().filter_map(|text| pointer(text)).fold(0, |all, (low, _)| all | pair(low))
}

/// Whether an instruction may skip the next one.
pub fn skips(code: &Code) -> bool {
    ["sbrs", "sbrc", "sbis", "sbic", "cpse"].contains(&&*code.name)
}

/// What an instruction does; none for those that are not known.
pub fn effect(code: &Code, inside: impl Fn(&str) -> bool, taken: &Taken) -> Option<Effect> {
    let taken = |name: &str| taken.by(name);
    let (a, b) = operands(code);
    let one = |text: &str| register(text).map(|r| 1 << r);
    let of = |kind, reads, writes| Effect { kind, reads, writes, sure: writes };
    Some(match &*code.name {
        "mov" => of(Kind::Plain, one(b)?, one(a)?),
        "movw" => of(Kind::Plain, pair(register(b)?), pair(register(a)?)),
        "ldi" | "ser" => of(Kind::Plain, 0, one(a)?),
        "clr" => of(Kind::Plain, 0, one(a)? | LOGIC),
        "eor" if a == b => of(Kind::Plain, 0, one(a)? | LOGIC),
        "and" | "or" | "eor" => of(Kind::Plain, one(a)? | one(b)?, one(a)? | LOGIC),
        "andi" | "ori" | "inc" | "dec" => of(Kind::Plain, one(a)?, one(a)? | LOGIC),
        "tst" => of(Kind::Plain, one(a)?, LOGIC),
        "swap" => of(Kind::Plain, one(a)?, one(a)?),
        "add" | "sub" => of(Kind::Plain, one(a)? | one(b)?, one(a)? | ALL),
        "adc" => of(Kind::Plain, one(a)? | one(b)? | CARRY, one(a)? | ALL),
        "sbc" => of(Kind::Plain, one(a)? | one(b)? | CARRY | ZERO, one(a)? | ALL),
        "subi" | "neg" | "com" | "lsl" | "lsr" | "asr" => of(Kind::Plain, one(a)?, one(a)? | ALL),
        "rol" | "ror" => of(Kind::Plain, one(a)? | CARRY, one(a)? | ALL),
        "sbci" => of(Kind::Plain, one(a)? | CARRY | ZERO, one(a)? | ALL),
        "adiw" | "sbiw" => of(Kind::Plain, pair(register(a)?), pair(register(a)?) | ALL),
        "cp" => of(Kind::Plain, one(a)? | one(b)?, ALL),
        "cpc" => of(Kind::Plain, one(a)? | one(b)? | CARRY | ZERO, ALL),
        "cpi" => of(Kind::Plain, one(a)?, ALL),
        "mul" | "muls" | "mulsu" => of(Kind::Plain, one(a)? | one(b)?, 3 | CARRY | ZERO),
        "bst" => of(Kind::Plain, one(a)?, BIT),
        "bld" => of(Kind::Plain, one(a)? | BIT, one(a)?),
        "set" | "clt" => of(Kind::Plain, 0, BIT),
        "sec" | "clc" => of(Kind::Plain, 0, CARRY),
        "ld" | "ldd" | "lpm" => {
            let (low, changed) = pointer(b)?;
            let writes = one(a)? | if changed { pair(low) } else { 0 };
            of(Kind::Outward, pair(low), writes)
        }
        "st" | "std" => {
            let (low, changed) = pointer(a)?;
            of(Kind::Outward, pair(low) | one(b)?, if changed { pair(low) } else { 0 })
        }
        "lds" | "pop" => of(Kind::Outward, 0, one(a)?),
        "in" => of(Kind::Outward, if b == "63" { FLAGS } else { 0 }, one(a)?),
        "out" => {
            let flags = if a == "63" { FLAGS } else { 0 };
            of(Kind::Outward, one(b)?, flags)
        }
        "sts" => of(Kind::Outward, one(b)?, 0),
        "push" => of(Kind::Outward, one(a)?, 0),
        "cli" | "sei" | "sbi" | "cbi" | "wdr" | "nop" | "sleep" => of(Kind::Outward, 0, 0),
        "breq" | "brne" => of(Kind::Branch, ZERO, 0),
        "brcs" | "brcc" | "brlo" | "brsh" => of(Kind::Branch, CARRY, 0),
        "brmi" | "brpl" | "brlt" | "brge" => of(Kind::Branch, SIGN, 0),
        "brts" | "brtc" => of(Kind::Branch, BIT, 0),
        "sbrs" | "sbrc" => of(Kind::Skip, one(a)?, 0),
        "sbis" | "sbic" => of(Kind::Skip, 0, 0),
        "cpse" => of(Kind::Skip, one(a)? | one(b)?, 0),
        "rjmp" | "jmp" if inside(a) => of(Kind::Jump, 0, 0),
        "rjmp" | "jmp" => of(Kind::Leave, KEPT | taken(a), 0),
        // What comes back in these is the function's.
        "call" => {
            let sure = if a.starts_with("__") { 0 } else { LOST };
            Effect { kind: Kind::Call, reads: taken(a), writes: LOST, sure }
        }
        "ret" => of(Kind::Leave, KEPT | span(18, 25) | 2, 0),
        _ => return None,
    })
}

/// What functions read of their callers' registers.
#[derive(Debug, Default)]
pub struct Taken(HashMap<String, Set>);

impl Taken {
    /// What a function may read.
    fn by(&self, name: &str) -> Set {
        let all = if name.starts_with("__") {
            span(8, 27) | span(30, 31) | BIT
        } else {
            self.0.get(name).copied().unwrap_or(span(8, 25))
        };
        all | span(28, 29) | 2
    }

    /// It reads no more than these at its beginning.
    pub fn no_more(&mut self, name: &str, live: Set) {
        self.0.insert(name.into(), live & span(8, 25));
    }
}
