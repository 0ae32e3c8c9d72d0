//! Turns a condition that is made a byte and tested again into a branch.
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
//! It also removes a comparison of a byte with 0 if the flags already have its result. A comparison
//! of a pair of registers with 0 becomes one instruction: `sbiw r24, 0`, or `or r18, r19` if one of
//! them is not read later.

use super::asm::{Code, Function, Line, Program};
use super::branches::opposite;
use super::calls::Calls;
use super::effects::{ARITHMETIC, CARRY, FLAGS, Kind, SIGN, Set, ZERO, operands, register};
use super::flow::Flow;

/// Processes all functions.
pub(crate) fn branch(program: &mut Program) {
    let calls = Calls::of(program);
    for function in program.functions_mut() {
        while asked(function, &calls) || compared(function, &calls) {}
    }
}

/// Removes one byte of a condition. Returns whether there was one.
fn asked(function: &mut Function, calls: &Calls) -> bool {
    let Some(flow) = Flow::of(function, calls) else { return false };
    let live = flow.live();
    for n in 0..function.lines.len() {
        if let Some(found) = Asked::at(function, &flow, &live, n) {
            found.replace(function, n);
            return true;
        }
    }
    false
}

/// A byte of a condition, with the branches that replace it.
struct Asked {
    /// The line of the label after the other constant.
    label: usize,
    /// The lines that test the byte.
    tests: Vec<usize>,
    /// The branches on the condition itself, each with its line.
    new: Vec<(usize, Code)>,
}

impl Asked {
    /// Finds one at a line with its first branch.
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
        // Nothing else jumps to the label.
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
        if tests.is_empty() || live[ahead] & mask != 0 {
            return None;
        }
        let mut new = Vec::new();
        for at in users(flow, live, ahead)? {
            let code = lines[at].code()?;
            let name = match (&*code.name, taken) {
                ("brne", 1) | ("breq", 0) => first.name.clone(),
                ("brne", 0) | ("breq", 1) => other.to_string(),
                _ => return None,
            };
            new.push((at, Code { name, operands: code.operands.clone() }));
        }
        Some(Asked { label: n + 2, tests, new })
    }

    /// Replaces the byte by a branch.
    fn replace(self, function: &mut Function, n: usize) {
        for (at, code) in self.new {
            function.lines[at] = Line::Code(code);
        }
        let mut line = 0;
        function.lines.retain(|_| {
            let gone = (n..=self.label).contains(&line) || self.tests.contains(&line);
            line += 1;
            !gone
        });
    }
}

/// The lines from a branch on that read the same flags. `None` if flags of other instructions may
/// reach them, or if something other than a branch reads them.
fn users(flow: &Flow, live: &[Set], branch: usize) -> Option<Vec<usize>> {
    let place = |n: usize| flow.blocks.iter().position(|block| block.lines.contains(&n));
    let (mut users, mut left, mut ended) = (Vec::new(), vec![(place(branch)?, branch)], Vec::new());
    let mut begun: Vec<usize> = Vec::new();
    while let Some((index, from)) = left.pop() {
        let block = &flow.blocks[index];
        let mut is_left = true;
        for (n, live) in (from..block.lines.end).zip(&live[from..]) {
            let Some(effect) = flow.effects[n] else { continue };
            match effect.kind {
                Kind::Branch if effect.reads == ZERO => users.push(n),
                Kind::Plain | Kind::Outward | Kind::Jump | Kind::Leave => {}
                _ => return None,
            }
            if effect.kind != Kind::Branch && effect.reads & ARITHMETIC != 0 {
                return None;
            }
            // Other flags from here on, or flags that are not read.
            if live & ARITHMETIC & !effect.sure == 0 {
                is_left = false;
                break;
            }
            if effect.writes & ARITHMETIC != 0 {
                return None;
            }
        }
        if is_left {
            ended.push(index);
            for &next in &block.next {
                let start = flow.blocks[next].lines.start;
                // For a label: the flags that are read from there on.
                let unread = flow.effects[start].is_none() && live[start] & ARITHMETIC == 0;
                if !unread && !begun.contains(&next) {
                    begun.push(next);
                    left.push((next, start));
                }
            }
        }
    }
    let alone = |&block: &usize| flow.blocks[block].before.iter().all(|one| ended.contains(one));
    begun.iter().all(alone).then_some(users)
}

/// The 0 or 1 that an instruction puts into its register, while r1 is 0.
fn constant(code: &Code) -> Option<u8> {
    let (_, b) = operands(code);
    match (&*code.name, b) {
        ("mov", "r1") | ("ldi", "0") | ("clr", _) => Some(0),
        ("ldi", "1") => Some(1),
        _ => None,
    }
}

/// Removes one comparison with 0. Returns whether there was one.
fn compared(function: &mut Function, calls: &Calls) -> bool {
    let Some(flow) = Flow::of(function, calls) else { return false };
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

/// Compares pairs of registers with 0 by one instruction, in all functions. It comes after all
/// stages that track values, because these instructions write what they compare.
pub(crate) fn shorten(program: &mut Program) {
    let calls = Calls::of(program);
    for function in program.functions_mut() {
        while shorter(function, &calls) {}
    }
}

/// Shortens one comparison of a pair with 0. Returns whether there was one.
fn shorter(function: &mut Function, calls: &Calls) -> bool {
    let Some(flow) = Flow::of(function, calls) else { return false };
    let live = flow.live();
    let is = |n: usize, text: String| function.lines[n].code().is_some_and(|code| code.is(&text));
    let found = (1..function.lines.len() - 1).find_map(|n| {
        let low = register(operands(function.lines[n].code()?).0)?;
        let high = low + 1;
        let compares = is(n, format!("cp r{low}, r1")) && is(n + 1, format!("cpc r{high}, r1"));
        if !compares || flow.pinned[n] || !flow.has_zero(function, n) {
            return None;
        }
        let unread = |register: u8| live[n + 1] & (1 << register | CARRY | SIGN) == 0;
        let new = match low {
            // All flags are the same.
            24 | 26 | 28 | 30 => format!("sbiw r{low}, 0"),
            _ if unread(low) => format!("or r{low}, r{high}"),
            _ if unread(high) => format!("or r{high}, r{low}"),
            _ => return None,
        };
        Some((n, Code::parse(&new)))
    });
    let Some((n, code)) = found else { return false };
    function.lines.splice(n..n + 2, [Line::Code(code)]);
    true
}

/// The register whose comparison with 0 the flags show.
fn says(code: &Code) -> Option<u8> {
    let sets = [
        "and", "andi", "or", "ori", "eor", "add", "sub", "subi", "inc", "dec", "lsr", "lsl", "tst",
        "cpi",
    ];
    let (a, b) = operands(code);
    (sets.contains(&&*code.name) && (code.name != "cpi" || b == "0")).then(|| register(a))?
}

/// The flags that differ from those of a comparison with 0.
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
    fn a_condition_is_asked_by_several_branches() {
        let made = "cp r18, r20; ldi r26, 1; brlo .L1; mov r26, r1\n.L1:; cpi r26, 0";
        let asked = "brne .L2; movw r22, r6\n.L2:; std Y+1, r22; breq .L3; movw r24, r8\n.L3:";
        let left = |asked: &str| left(&format!("{made}; {asked}; std Y+2, r24"));
        let branches = "brlo .L2; movw r22, r6; std Y+1, r22; brsh .L3; movw r24, r8; std Y+2, r24";
        assert_eq!(left(asked), format!("cp r18, r20; ldi r26, 1; {branches}"));
        for other in [
            // The flags are read by something other than a branch, or by another branch.
            asked.replace("std Y+1", "adc r25, r1; std Y+1"),
            asked.replace("breq", "brlo"),
            // The flags are those of another instruction, here, on one path, or in part.
            asked.replace("std Y+1", "inc r26; std Y+1"),
            asked.replace("movw r22, r6", "inc r22"),
            asked.replace("std Y+1", "clc; std Y+1"),
            // Another jump goes there.
            format!("{asked}; cp r24, r25; brmi .L2"),
            // The byte is read later.
            asked.replace("movw r24, r8", "mov r24, r26"),
        ] {
            assert!(left(&other).contains("cpi r26, 0"), "{other}");
        }
    }

    #[test]
    fn what_the_flags_say_is_not_asked_again() {
        assert_eq!(left("and r24, r19; cpi r24, 0; breq .L7"), "and r24, r19; breq .L7");
        let dec = "dec r20; cpi r20, 0; brne .L7; ldi r24, 1";
        assert_eq!(left(dec), "dec r20; brne .L7; ldi r24, 1");
    }

    #[test]
    fn a_pair_is_compared_with_0_by_one_instruction() {
        let short = |body: &str| tests::left(body, shorten);
        let word = "cp r26, r1; cpc r27, r1; breq .L7; ldi r24, 1";
        assert_eq!(short(word), "sbiw r26, 0; breq .L7; ldi r24, 1");
        // The carry and the zero flag of the bytes so far are the same.
        let wide = word.replace("breq", "cpc r20, r1; breq");
        assert_eq!(short(&wide), "sbiw r26, 0; cpc r20, r1; breq .L7; ldi r24, 1");
        for (unread, one) in [("r18", "or r18, r19"), ("r19", "or r19, r18")] {
            let pair = format!("cp r18, r1; cpc r19, r1; ldi {unread}, 2; breq .L7");
            assert_eq!(short(&pair), format!("{one}; ldi {unread}, 2; breq .L7"));
            for needed in [
                pair.replace("breq", "brlt"),
                pair.replace("breq", "cpc r20, r1; breq"),
                pair.replace("cpc r19", "cpc r20"),
                pair.replace("cpc r19, r1", "cpc r19, r2"),
                // Both are read later; the other byte is skipped, or r1 is not 0.
                pair.replace(&format!("ldi {unread}, 2; "), ""),
                format!("sbrc r24, 0; {pair}"),
                format!("mul r20, r21; {pair}; clr r1"),
            ] {
                assert_eq!(short(&needed), needed);
            }
        }
    }

    #[test]
    fn what_is_needed_stays() {
        for needed in [
            // Another register, another number, another condition.
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
