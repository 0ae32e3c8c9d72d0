//! A number is computed where it is wanted, and not copied there.
//!
//! ```text
//!   ldd  r24, Z+1            ldd  r12, Z+1
//!   ldd  r25, Z+2       →    ldd  r13, Z+2
//!   movw r12, r24            …
//! ```
//!
//! The other way round, a copy whose original nobody reads any more is not made: what works on
//! the copy works on the original.

use super::asm::{Code, Function, Line, Program};
use super::flow::{Block, Flow, code};
use super::machine::{self, Effect, Kind, Set, Taken, operands, register};

/// Goes through all functions.
pub fn leave_out(program: &mut Program, taken: &Taken) {
    for function in program.functions_mut() {
        while renamed(function, taken) {}
    }
}

/// Takes out one copy. Whether there was one.
fn renamed(function: &mut Function, taken: &Taken) -> bool {
    let Some(flow) = Flow::of(function, taken) else { return false };
    let live = flow.live();
    for block in &flow.blocks {
        for n in block.lines.clone() {
            let Some(copy) = Copy::at(function, &flow, n) else { continue };
            // What is copied is of no use behind the copy.
            if live[n] & copy.original() != 0 {
                continue;
            }
            let new = copy
                .back(function, &flow, block, n)
                .or_else(|| copy.ahead(function, &flow, &live, block, n));
            if let Some(new) = new {
                for (at, code) in new {
                    function.lines[at] = Line::Code(code);
                }
                function.lines.remove(n);
                return true;
            }
        }
    }
    false
}

/// `mov to, from`, or both registers of a pair.
#[derive(Clone, Copy)]
struct Copy {
    to: u8,
    from: u8,
    /// 1 or 2 registers.
    width: u8,
}

impl Copy {
    fn at(function: &Function, flow: &Flow, n: usize) -> Option<Copy> {
        let code = code(&function.lines[n]).filter(|_| !flow.pinned[n])?;
        let (to, from) = operands(code);
        let (to, from) = (register(to)?, register(from)?);
        let width = match &*code.name {
            "mov" => 1,
            "movw" => 2,
            _ => return None,
        };
        let ours = |low: u8| low <= 1 || low == 28 || low == 29;
        (!ours(to) && !ours(from) && to != from).then_some(Copy { to, from, width })
    }

    fn set(self, low: u8) -> Set {
        ((1 << self.width) - 1) << low
    }

    fn original(self) -> Set {
        self.set(self.from)
    }

    fn target(self) -> Set {
        self.set(self.to)
    }

    /// The other way round.
    fn turned(self) -> Copy {
        Copy { to: self.from, from: self.to, width: self.width }
    }

    /// The lines before a copy, on the target instead.
    fn back(
        self,
        function: &Function,
        flow: &Flow,
        block: &Block,
        n: usize,
    ) -> Option<Vec<(usize, Code)>> {
        let mut new = Vec::new();
        let mut missing = self.original();
        let mut at = n;
        while missing != 0 {
            at = at.checked_sub(1).filter(|&at| at >= block.lines.start)?;
            let effect = flow.effects[at]?;
            if let Some(code) = self.replaced(function, flow, effect, at)? {
                new.push((at, code));
            }
            // Before its definition a register has another value.
            if missing != 0 && effect.reads & self.original() & !missing != 0 {
                return None;
            }
            missing &= !(effect.writes & !effect.reads);
        }
        Some(new)
    }

    /// The lines behind a copy, on the original.
    fn ahead(
        self,
        function: &Function,
        flow: &Flow,
        live: &[Set],
        block: &Block,
        n: usize,
    ) -> Option<Vec<(usize, Code)>> {
        let turned = self.turned();
        let mut new = Vec::new();
        let mut at = n;
        while live[at] & self.target() != 0 {
            at += 1;
            if at >= block.lines.end {
                return None;
            }
            let effect = flow.effects[at]?;
            if let Some(code) = turned.replaced(function, flow, effect, at)? {
                new.push((at, code));
            }
        }
        Some(new)
    }

    /// A line with `to` in the place of `from`: none if it can't be, or none is needed.
    #[expect(clippy::option_option)] // it can't be; it needs no change
    fn replaced(
        self,
        function: &Function,
        flow: &Flow,
        effect: Effect,
        at: usize,
    ) -> Option<Option<Code>> {
        let touched = effect.reads | effect.writes;
        if touched & self.target() != 0 || !matches!(effect.kind, Kind::Plain | Kind::Outward) {
            return None;
        }
        if touched & self.original() == 0 {
            return Some(None);
        }
        if flow.pinned[at] {
            return None;
        }
        Some(Some(self.rename(code(&function.lines[at])?, touched)?))
    }

    /// An instruction that touches these registers, with others.
    fn rename(self, code: &Code, touched: Set) -> Option<Code> {
        let (a, b) = operands(code);
        let wide = ["movw", "adiw", "sbiw"].contains(&&*code.name);
        let mut named = 0;
        let mut other = |text: &str, first: bool| -> Option<String> {
            let Some(low) = register(text) else { return Some(text.into()) };
            let mask: Set = if wide { 3 << low } else { 1 << low };
            if mask & self.original() == 0 {
                return Some(text.into());
            }
            named |= mask;
            if wide && (self.width != 2 || low != self.from) {
                return None;
            }
            let new = low - self.from + self.to;
            fits(&code.name, new, first).then(|| format!("r{new}"))
        };
        let a = other(a, true)?;
        let b = other(b, false)?;
        // Not those that it touches without a name, or by another.
        let hidden = touched & !named | machine::pointed(code);
        if hidden & self.original() != 0 {
            return None;
        }
        let operands = if b.is_empty() { a } else { format!("{a}, {b}") };
        Some(Code { name: code.name.clone(), operands })
    }
}

/// Whether an instruction can have a register as its first or second operand.
fn fits(name: &str, register: u8, first: bool) -> bool {
    match name {
        "ldi" | "subi" | "sbci" | "andi" | "ori" | "cpi" | "ser" => !first || register >= 16,
        "adiw" | "sbiw" => register >= 24 && register.is_multiple_of(2),
        "movw" => register.is_multiple_of(2),
        "muls" => register >= 16,
        "mulsu" => (16..24).contains(&register),
        // X changed while it is stored, and the like.
        "ld" | "st" | "lpm" => register < 26,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests;
    use super::*;

    fn left(body: &str) -> String {
        tests::left(body, leave_out)
    }

    #[test]
    fn a_number_is_computed_where_it_is_wanted() {
        let copied = "ldd r26, Y+1; ldd r27, Y+2; movw r12, r26";
        assert_eq!(left(copied), "ldd r12, Y+1; ldd r13, Y+2");
        assert_eq!(left("ldi r26, 1; add r26, r20; mov r24, r26"), "ldi r24, 1; add r24, r20");
    }

    #[test]
    fn what_works_on_a_copy_works_on_the_original() {
        // It was computed elsewhere, before the label.
        let copied = "in r26, 10\n.L1:; mov r20, r26; inc r20; out 11, r20; ldi r20, 0";
        assert_eq!(left(copied), "in r26, 10; inc r26; out 11, r26; ldi r20, 0");
    }

    #[test]
    fn a_pointer_that_is_overwritten_by_what_it_reads_keeps_its_name() {
        for stays in [
            "mov r30, r1; ldd r30, Z+2; mov r24, r30",
            "mov r26, r1; ld r26, X; mov r24, r26",
            "mov r31, r1; ldd r31, Z+2; mov r24, r31",
        ] {
            assert_eq!(left(stays), stays);
        }
    }

    #[test]
    fn what_is_needed_stays() {
        for stays in [
            // The original is read later.
            "ldd r26, Y+1; mov r24, r26; out 10, r26",
            // The target is read or written between.
            "ldd r26, Y+1; out 10, r24; mov r24, r26",
            "ldd r26, Y+1; ldd r24, Y+2; mov r24, r26",
            // No constant, and no sum of a word, is made in a low register.
            "ldi r26, 1; mov r12, r26",
            "ldd r26, Y+1; ldd r27, Y+2; adiw r26, 1; movw r12, r26",
            // r27 is another number before it is loaded.
            "mov r26, r27; ldd r27, Y+1; movw r12, r26",
            // The product is in r0, whatever it was copied to.
            "mul r20, r21; mov r24, r0; clr r1",
            // It may be skipped.
            "sbrc r20, 0; ldi r26, 1; mov r24, r26",
        ] {
            assert_eq!(left(stays), stays);
        }
    }
}
