//! Removes copies of values that a register already holds, and computations whose results are not
//! read.
//!
//! ```text
//!   movw r18, r6                            movw r30, r6
//!   movw r30, r18             →             ldd  r24, Z+1
//!   ldd  r24, Z+1
//! ```
//!
//! 1. An instruction is removed if it changes nothing that is read later: its registers and flags
//!    are not read, or have these values already.
//! 2. An instruction reads the register that first held the value, if that still holds it, so that
//!    the copy is not read.
//!
//! No instruction that accesses memory, a port or the stack is moved or removed.

use super::asm::{Code, Function, Line};
use super::calls::Calls;
use super::effects::{Effect, register};
use super::values::{State, Value, Values};

/// Processes a function once. Returns whether it has changed.
pub(crate) fn leave_out(function: &mut Function, calls: &Calls) -> bool {
    let Some(values) = Values::of(function, calls) else { return false };
    let mut lines = Vec::new();
    for (n, line) in function.lines.iter().enumerate() {
        // A branch to the next line does nothing either.
        if values.idle[n] || values.flow.next[n] == [n + 1, n + 1] && !function.is_skipped(n) {
            continue;
        }
        let better = line.code().zip(values.before[n].as_ref());
        let better = better.and_then(|(code, state)| first(code, values.flow.effects[n], state));
        lines.push(better.map_or_else(|| line.clone(), Line::Code));
    }
    let changed = lines != function.lines;
    function.lines = lines;
    changed
}

/// The same instruction reading the registers that first held its operands, if others.
fn first(code: &Code, effect: Effect, state: &State) -> Option<Code> {
    let home = |text: &str| {
        let register = register(text)?;
        let home = match state[register] {
            // r1 will do.
            Value::Constant(0) => 1,
            value => value.origin()?.slot,
        };
        let is_read = (effect.reads & !effect.writes) >> register & 1 != 0;
        let fits = match &*code.name {
            "movw" => home % 2 == 0 && state[home + 1] == state[register + 1],
            "cpi" => home >= 16,
            name => !name.starts_with("muls"),
        };
        (is_read && fits && state[home] == state[register]).then(|| format!("r{home}"))
    };
    let (a, b) = (home(&code.a), home(&code.b));
    let (a, b) = (a.unwrap_or(code.a.clone()), b.unwrap_or(code.b.clone()));
    Some(Code { name: code.name.clone(), a, b })
}

#[cfg(test)]
mod tests {
    use crate::simplify;
    use crate::tests;

    fn left(body: &str) -> String {
        tests::left(body, simplify)
    }

    #[test]
    fn what_is_there_is_not_put_there_again() {
        assert_eq!(left("ldi r24, 7; out 10, r24; ldi r24, 7"), "ldi r24, 7; out 10, r24");
        assert_eq!(left("movw r26, r6; out 10, r26; movw r26, r6"), "out 10, r6");
        let twice = "cpi r24, 3; breq .L7; cpi r24, 3; brlo .L7";
        assert_eq!(left(twice), "cpi r24, 3; breq .L7; brlo .L7");
    }

    #[test]
    fn what_may_differ_is_put_there() {
        // On the third path to the label.
        let third = "ldi r24, 7; cp r18, r20; brlo .L1; breq .L1; ldi r24, 9\n.L1:; \
                     out 10, r24; ldi r24, 7";
        assert!(left(third).ends_with("out 10, r24; ldi r24, 7"));
    }

    #[test]
    fn a_branch_to_the_next_line_goes() {
        let branch = "cp r18, r20; breq .L1\n.L1:; out 10, r24";
        assert_eq!(left(branch), "out 10, r24");
        // Otherwise another instruction would be skipped.
        let skipped = branch.replace("breq", "sbrc r20, 0; breq");
        assert!(left(&skipped).contains("breq"));
    }

    #[test]
    fn what_nobody_reads_is_not_computed() {
        assert_eq!(left("ldi r26, 7; add r26, r20; in r27, 10"), "in r27, 10");
        let read = "ldi r26, 7; add r26, r20; out 10, r26";
        assert_eq!(left(read), read);
    }

    #[test]
    fn what_keeps_a_value_goes() {
        for nothing in ["or r24, r1", "ldi r26, 0; add r24, r26"] {
            let left = left(&format!("in r24, 10; {nothing}; out 10, r24"));
            assert!(!left.contains("r24, r"), "{left}");
        }
        // A bit stays a bit where paths join.
        let bit = "ldi r24, 1; cp r18, r20; brlo .L1; mov r24, r1\n.L1:";
        assert!(!left(&format!("{bit}; andi r24, 1; out 10, r24")).contains("andi"));
        // A value that is not a bit on one path; and flags that are read.
        for needed in [
            format!("{}; andi r24, 1; out 10, r24", bit.replace("r24, 1", "r24, 3")),
            format!("{bit}; andi r24, 1; out 10, r24; breq .L7"),
            "in r24, 10; add r24, r1; out 10, r24; brlo .L7".into(),
        ] {
            assert_eq!(left(&needed), needed.replace("\n.L1:", ""));
        }
    }
}
