//! A condition that is made a byte, and asked again, is a branch.
//!
//! ```text
//!   ldi  r24, 1              cp   r18, r20
//!   cp   r18, r20            cpc  r19, r21
//!   cpc  r19, r21            movw r30, r6
//!   brlo .L1                 brlo .L5
//!   mov  r24, r1       →
//! .L1:
//!   movw r30, r6
//!   cpi  r24, 0
//!   brne .L5
//! ```
//!
//! and a comparison with 0 goes where the flags say already what it would.

use super::asm::{Code, Function, Line, Program};
use super::branches::opposite;
use super::effects::{ARITHMETIC, CARRY, FLAGS, Kind, SIGN, Set, operands, register};
use super::flow::Flow;

/// Goes through all functions.
pub(crate) fn branch(program: &mut Program) {
    for function in program.functions_mut() {
        while asked(function) || compared(function) {}
    }
}

/// Takes out one byte of a condition. Whether there was one.
fn asked(function: &mut Function) -> bool {
    let Some(flow) = Flow::of(function) else { return false };
    let live = flow.live();
    for n in 0..function.lines.len() {
        if let Some(found) = Asked::at(function, &flow, &live, n) {
            found.replace(function, n);
            return true;
        }
    }
    false
}

/// A byte of a condition, whose branch has been found.
struct Asked {
    /// The line of the label, behind the other number.
    label: usize,
    /// Lines that ask for it.
    tests: Vec<usize>,
    /// The branch.
    branch: usize,
    /// The branch by the condition itself.
    new: Code,
}

impl Asked {
    /// At a line with the first branch.
    fn at(function: &Function, flow: &Flow, live: &[Set], n: usize) -> Option<Asked> {
        let lines = &function.lines;
        let first = lines[n].code()?;
        let other = opposite(&first.name)?;
        let byte = lines.get(n + 1)?.code()?;
        let Line::Label(label) = lines.get(n + 2)? else { return None };
        let at = register(operands(byte).0)?;
        let not_taken = constant(byte)?;
        if *label != first.operands || flow.pinned[n] || !flow.has_zero(function, n + 1) {
            return None;
        }
        // Nobody else comes there.
        let comes = |line: &Line| line.code().is_some_and(|code| code.operands == *label);
        if lines.iter().filter(|line| comes(line)).count() != 1 {
            return None;
        }
        let mask: Set = 1 << at;
        let mut back = n;
        let taken = loop {
            back = back.checked_sub(1)?;
            let effect = flow.effects[back]?;
            if !matches!(effect.kind, Kind::Plain | Kind::Outward) {
                return None;
            }
            if effect.writes & mask != 0 {
                let code = lines[back].code().filter(|_| flow.has_zero(function, back))?;
                break constant(code)?;
            }
            if effect.reads & mask != 0 {
                return None;
            }
        };
        if taken + not_taken != 1 {
            return None;
        }
        let mut tests = Vec::new();
        let mut ahead = n + 3;
        loop {
            let effect = flow.effects[ahead]?;
            let code = lines[ahead].code()?;
            let (a, b) = operands(code);
            if register(a) == Some(at)
                && (code.is(&format!("cpi r{at}, 0"))
                    || code.name == "tst"
                    || code.name == "andi" && b == "1")
            {
                tests.push(ahead);
            } else if effect.kind == Kind::Branch {
                break;
            } else if !matches!(effect.kind, Kind::Plain | Kind::Outward)
                || effect.writes & (mask | FLAGS) != 0
                || effect.reads & (mask | FLAGS) != 0
            {
                return None;
            }
            ahead += 1;
        }
        let last = lines[ahead].code()?;
        let unread = live[ahead] & (mask | ARITHMETIC) == 0;
        if tests.is_empty() || !unread {
            return None;
        }
        let name = match (&*last.name, taken) {
            ("brne", 1) | ("breq", 0) => first.name.clone(),
            ("brne", 0) | ("breq", 1) => other.to_string(),
            _ => return None,
        };
        let new = Code { name, operands: last.operands.clone() };
        Some(Asked { label: n + 2, tests, branch: ahead, new })
    }

    /// Makes it a branch.
    fn replace(self, function: &mut Function, n: usize) {
        function.lines[self.branch] = Line::Code(self.new);
        let mut line = 0;
        function.lines.retain(|_| {
            let gone = (n..=self.label).contains(&line) || self.tests.contains(&line);
            line += 1;
            !gone
        });
    }
}

/// The 0 or 1 that an instruction puts into its register, where r1 is 0.
fn constant(code: &Code) -> Option<u8> {
    let (_, b) = operands(code);
    match (&*code.name, b) {
        ("mov", "r1") | ("ldi", "0") | ("clr", _) => Some(0),
        ("ldi", "1") => Some(1),
        _ => None,
    }
}

/// Takes out one comparison with 0. Whether there was one.
fn compared(function: &mut Function) -> bool {
    let Some(flow) = Flow::of(function) else { return false };
    let live = flow.live();
    for block in &flow.blocks {
        // The last instruction that set flags.
        let mut last: Option<(usize, u8)> = None;
        for n in block.lines.clone() {
            let (Some(effect), Some(code)) = (flow.effects[n], function.lines[n].code()) else {
                last = None;
                continue;
            };
            let (a, _) = operands(code);
            let asks = code.name == "tst" || code.name == "cpi" && code.operands.ends_with(", 0");
            if let (true, Some((m, register))) = (asks, last)
                && self::register(a) == Some(register)
                && !flow.pinned[n]
                && live[n] & lost(function, m) == 0
            {
                function.lines.remove(n);
                return true;
            }
            if effect.writes & FLAGS != 0 {
                last = says(code).map(|register| (n, register));
            } else if last.is_some_and(|(_, register)| effect.writes >> register & 1 != 0) {
                last = None;
            }
        }
    }
    false
}

/// The register of which the flags say whether it is 0.
fn says(code: &Code) -> Option<u8> {
    let sets = [
        "and", "andi", "or", "ori", "eor", "add", "sub", "subi", "inc", "dec", "lsr", "lsl", "tst",
        "cpi",
    ];
    let (a, b) = operands(code);
    (sets.contains(&&*code.name) && (code.name != "cpi" || b == "0")).then(|| register(a))?
}

/// The flags that are others than a comparison with 0 would leave.
fn lost(function: &Function, n: usize) -> Set {
    let logic = ["and", "andi", "or", "ori", "eor", "tst"];
    match function.lines[n].code() {
        Some(code) if code.name == "cpi" => 0,
        Some(code) if logic.contains(&&*code.name) => CARRY,
        _ => CARRY | SIGN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests;

    fn left(body: &str) -> String {
        tests::left(body, branch)
    }

    #[test]
    fn a_condition_is_a_branch() {
        let asked = "ldi r26, 1; cp r18, r20; brlo .L1; mov r26, r1\n.L1:; movw r30, r6; \
                     cpi r26, 0; brne .L7; ldi r24, 1";
        let branches = "ldi r26, 1; cp r18, r20; movw r30, r6; brlo .L7; ldi r24, 1";
        assert_eq!(left(asked), branches);
        assert_eq!(left(&asked.replace("brne", "breq")), branches.replace("brlo", "brsh"));
        // The byte is read later.
        let read = asked.replace("ldi r24, 1", "mov r24, r26");
        assert_eq!(left(&read), read.replace("\n.L1:", ""));
    }

    #[test]
    fn what_the_flags_say_is_not_asked_again() {
        assert_eq!(left("and r24, r19; cpi r24, 0; breq .L7"), "and r24, r19; breq .L7");
        let dec = "dec r20; cpi r20, 0; brne .L7; ldi r24, 1";
        assert_eq!(left(dec), "dec r20; brne .L7; ldi r24, 1");
    }

    #[test]
    fn what_is_needed_stays() {
        for needed in [
            // Another register, another number, another question.
            "and r24, r19; cpi r25, 0; breq .L7",
            "and r24, r19; cpi r24, 1; breq .L7",
            "and r24, r19; cpi r24, 0; brlo .L7",
            // The zero flag of all bytes so far.
            "sbc r24, r19; cpi r24, 0; breq .L7",
            // The carry is read, here or there.
            "and r24, r19; cpi r24, 0; breq .L7; brlo .L7",
            "add r24, r19; cpi r24, 0; breq .L7; mov r20, r21; adc r20, r20",
        ] {
            assert_eq!(left(needed), needed);
        }
        let there = "add r24, r19; cpi r24, 0; breq .L8; ret\n.L8:; rol r24";
        assert!(left(there).contains("cpi"));
    }

    #[test]
    fn a_product_in_r1_is_no_zero() {
        let byte = "ldi r26, 1; cp r18, r20; brlo .L1; mov r26, r1\n.L1:; cpi r26, 0; brne .L7";
        let dirty = format!("mul r18, r20; {byte}; clr r1");
        assert_eq!(left(&dirty), dirty.replace("\n.L1:", ""));
        let clean = format!("mul r18, r20; clr r1; {byte}");
        assert!(!left(&clean).contains("cpi"));
    }
}
