//! Turns a condition that is made a byte and tested again into a branch.
//!
//! ```text
//!   ldi  r24, 1              ldi  r24, 1
//!   cp   r18, r20            cp   r18, r20
//!   cpc  r19, r21            cpc  r19, r21
//!   brlo .L1                 brlo .L1
//!   mov  r24, r1       →     mov  r24, r1
//! .L1:                     .L1:
//!   movw r30, r6             movw r30, r6
//!   cpi  r24, 0              brlo .L5
//!   brne .L5
//! ```
//!
//! If the byte is not read then, `copies` removes it, and its branch.
//!
//! A comparison of a pair of registers with 0 becomes one instruction: `sbiw r24, 0`, or
//! `or r18, r19` if one of them is not read later.

use super::asm::{Code, Function, Line, Program};
use super::branches::opposite;
use super::calls::Calls;
use super::effects::{ARITHMETIC, CARRY, Kind, SIGN, ZERO, register};
use super::flow::Flow;
use super::values::{Value, Values, slots};

/// Removes one test of a condition's byte. Returns whether there was one.
pub(crate) fn branch(function: &mut Function, calls: &Calls) -> bool {
    let Some(values) = Values::of(function, calls) else { return false };
    for n in 0..function.lines.len() {
        let Some(truth) = asked(function, &values, n) else { continue };
        let Some(users) = users(&values.flow, n) else { continue };
        for at in users {
            if let Line::Code(code) = &mut function.lines[at] {
                let same = code.name == "brne";
                code.name = if same { truth } else { opposite(truth).unwrap_or_default() }.into();
            }
        }
        function.lines.remove(n);
        return true;
    }
    false
}

/// The branch that is taken if the byte which a line compares with 0 is 1. Its flags are still
/// there.
fn asked(function: &Function, values: &Values, n: usize) -> Option<&'static str> {
    let (code, flow) = (function.lines[n].code()?, &values.flow);
    let before = values.before[n]?;
    let byte = before[register(&code.a)?].origin().filter(|origin| origin.merged)?;
    // The branch, and one instruction that it jumps over.
    let &[branch, over] = &*flow.before[byte.line] else { return None };
    let constant = |line: usize| values.after[line].map(|after| after[byte.slot]);
    let taken = match (constant(branch)?, constant(over)?) {
        (Value::Constant(1), Value::Constant(0)) => true,
        (Value::Constant(0), Value::Constant(1)) => false,
        _ => return None,
    };
    let asks = code.name == "cpi" && code.b == "0";
    let is_short = over == branch + 1 && flow.before[over] == [branch];
    let flags = values.before[branch]?;
    let are_there = slots(flow.effects[branch].reads).all(|flag| flags[flag] == before[flag]);
    let other = opposite(&function.lines[branch].code()?.name)?;
    let truth = if taken { opposite(other)? } else { other };
    (asks && is_short && are_there).then_some(truth)
}

/// The branches that read the flags of a line. `None` if flags of other instructions may reach
/// them, as behind one that may be skipped, or if something other than a branch on the zero flag
/// reads them.
fn users(flow: &Flow, line: usize) -> Option<Vec<usize>> {
    let (mut users, mut passed) = (Vec::new(), vec![line]);
    let mut reached = flow.next[line].clone();
    let mut at = 0;
    while let Some(&n) = reached.get(at) {
        at += 1;
        let effect = flow.effects[n];
        if effect.reads & ARITHMETIC != 0 {
            if effect.kind != Kind::Branch || effect.reads != ZERO {
                return None;
            }
            users.push(n);
        }
        // Other flags from here on, or flags that are not read.
        if flow.live[n] & ARITHMETIC & !effect.sure == 0 {
            continue;
        }
        if effect.writes & ARITHMETIC != 0 {
            return None;
        }
        passed.push(n);
        for &next in &flow.next[n] {
            if flow.needs(next) & ARITHMETIC != 0 && !reached.contains(&next) {
                reached.push(next);
            }
        }
    }
    let alone = |&n: &usize| flow.before[n].iter().all(|before| passed.contains(before));
    reached.iter().all(alone).then_some(users)
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
    let Some(values) = Values::of(function, calls) else { return false };
    let found = (1..function.lines.len() - 1).find_map(|n| {
        let is_zero = |text: &str| Some(values.before[n]?[register(text)?] == Value::Constant(0));
        let (first, second) = (function.lines[n].code()?, function.lines[n + 1].code()?);
        let (low, high) = (register(&first.a)?, register(&second.a)?);
        let compare = first.name == "cp" && second.name == "cpc" && high == low + 1;
        let with_zero = is_zero(&first.b)? && is_zero(&second.b)?;
        if !compare || !with_zero || function.is_skipped(n) {
            return None;
        }
        let unread =
            |register: usize| values.flow.live[n + 1] & (1 << register | CARRY | SIGN) == 0;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplify;
    use crate::tests;

    fn left(body: &str) -> String {
        tests::left(body, simplify)
    }

    #[test]
    fn a_condition_is_a_branch() {
        let asked = "ldi r26, 1; cp r18, r20; brlo .L1; mov r26, r1\n.L1:; std Y+1, r6; \
                     cpi r26, 0; brne .L7; ldi r24, 1";
        let branches = "cp r18, r20; std Y+1, r6; brlo .L7; ldi r24, 1";
        assert_eq!(left(asked), branches);
        assert_eq!(left(&asked.replace("brne", "breq")), branches.replace("brlo", "brsh"));
        // The byte is read later: only its test goes.
        let read = asked.replace("ldi r24, 1", "mov r24, r26");
        let without = read.replace("\n.L1:", "").replace("cpi r26, 0; brne", "brlo");
        assert_eq!(left(&read), without);
        for other in [
            // The condition is not there any more, or was not tested on each path.
            asked.replace("std", "add r22, r20; std"),
            asked.replace("brlo", "sbrc r20, 0; brlo"),
            format!("cpi r20, 9; breq .L1; {asked}"),
            // No byte of a condition, or another test.
            asked.replace("r26, r1", "r26, r21"),
            asked.replace("r26, 0", "r26, 1"),
            asked.replace("cpi r26, 0", "sbrc r20, 0; cpi r26, 0; cp r18, r19"),
        ] {
            assert!(left(&other).contains("cpi r26"), "{other}");
        }
    }

    #[test]
    fn a_condition_is_asked_by_several_branches() {
        let made = "cp r18, r20; ldi r26, 1; brlo .L1; mov r26, r1\n.L1:; cpi r26, 0";
        let asked = "brne .L2; movw r22, r6\n.L2:; std Y+1, r22; breq .L3; movw r24, r8\n.L3:";
        let left = |asked: &str| left(&format!("{made}; {asked}; std Y+2, r24"));
        let branches = "brlo .L2; movw r22, r6; std Y+1, r22; brsh .L3; movw r24, r8; std Y+2, r24";
        assert_eq!(left(asked), format!("cp r18, r20; {branches}"));
        for other in [
            // The flags are read by something other than a branch, or by another branch.
            asked.replace("std Y+1", "adc r25, r1; std Y+1"),
            asked.replace("breq", "brlo"),
            // The flags are those of another instruction, on one path, or in part.
            asked.replace("movw r22, r6", "inc r22"),
            asked.replace("std Y+1", "clc; std Y+1") + "; rol r24",
            asked.replace("std Y+1", "sbrc r20, 0; clc; std Y+1"),
            // Another jump goes there.
            format!("{asked}; cp r24, r25; brmi .L2"),
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
            // The zero flag of several bytes.
            "sbc r24, r19; cpi r24, 0; breq .L7",
            "sbiw r24, 3; cpi r24, 0; breq .L7",
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
