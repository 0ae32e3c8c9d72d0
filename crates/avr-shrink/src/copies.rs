//! Removes copies of values that a register already holds, and computations whose results are not
//! read.
//!
//! ```text
//!   movw r18, r6                            movw r30, r6
//!   movw r30, r18             →             ldd  r24, Z+1
//!   ldd  r24, Z+1
//! ```
//!
//! Each register has a value at each line: a constant, the result of an instruction, or a merge of
//! values where paths join. A copy has the value of its source. Then
//!
//! 1. a copy or a constant is removed if the register has that value already;
//! 2. an instruction reads the register that first held the value, if that still holds it, so that
//!    the copy is not read;
//! 3. an instruction is removed if its results are not read.
//!
//! No instruction that accesses memory, a port or the stack is moved or removed.

use std::collections::HashMap;

use super::asm::{Code, Function, Line, Program};
use super::calls::Calls;
use super::effects::{Effect, FLAGS, Kind, operands, register};
use super::flow::Flow;

/// Processes all functions.
pub(crate) fn leave_out(program: &mut Program) {
    let calls = Calls::of(program);
    for function in program.functions_mut() {
        while pass(function, &calls) {}
    }
}

/// Processes a function once. Returns whether it has changed.
fn pass(function: &mut Function, calls: &Calls) -> bool {
    let Some(flow) = Flow::of(function, calls) else { return false };
    let states = meet(function, &flow).unwrap_or_default();
    let live = flow.live();
    let mut gone = vec![false; function.lines.len()];
    let mut new: Vec<(usize, Code)> = Vec::new();
    for (block, state) in flow.blocks.iter().zip(states) {
        let Some(mut state) = state else { continue };
        for n in block.lines.clone() {
            if let Some(code) = function.lines[n].code().filter(|_| !flow.pinned[n]) {
                let silent = |effect: Effect| effect.writes & FLAGS & live[n] == 0;
                if is_there(code, &state)
                    || keeps(code, &state) && flow.effects[n].is_some_and(silent)
                {
                    gone[n] = true;
                } else if let Some(better) = first(code, &state) {
                    new.push((n, better));
                }
            }
            step(&mut state, function, &flow, n);
        }
    }
    let changed = !new.is_empty();
    for (n, code) in new {
        function.lines[n] = Line::Code(code);
    }
    remove(function, &gone) | unread(function, calls) | changed
}

/// Removes lines.
fn remove(function: &mut Function, gone: &[bool]) -> bool {
    let mut n = 0;
    function.lines.retain(|_| {
        n += 1;
        !gone[n - 1]
    });
    gone.contains(&true)
}

/// Removes instructions whose results are not read.
fn unread(function: &mut Function, calls: &Calls) -> bool {
    let mut any = false;
    loop {
        let Some(flow) = Flow::of(function, calls) else { return any };
        let live = flow.live();
        let gone: Vec<bool> = (0..function.lines.len())
            .map(|n| {
                let idle =
                    |effect: Effect| effect.kind == Kind::Plain && effect.writes & live[n] == 0;
                !flow.pinned[n] && flow.effects[n].is_some_and(idle)
            })
            .collect();
        if !remove(function, &gone) {
            return any;
        }
        any = true;
    }
}

/// The value of a register. Values below 256 are constants.
type Value = u64;
/// Set in a value that is not a constant but known to be 0 or 1.
const BIT: Value = 1 << 62;

/// Whether a value is 0 or 1.
fn is_bit(value: Value) -> bool {
    value < 2 || value & BIT != 0
}

/// The values of all registers, and of the flags.
type State = [Value; 33];

/// The value that a line leaves in a register: different for each.
fn result(n: usize, register: usize) -> Value {
    256 + 128 * (n as Value + 1) + register as Value
}

/// The merged value of a register at the beginning of a line.
fn met(n: usize, register: usize) -> Value {
    result(n, register) + 64
}

/// The state at the beginning of a function.
fn begin() -> State {
    let mut state = [0; 33];
    for (register, value) in state.iter_mut().enumerate() {
        *value = 256 + register as Value;
    }
    state[1] = 0;
    state
}

/// The values at the beginning of each block; `None` for an unreachable block.
fn meet(function: &Function, flow: &Flow) -> Option<Vec<Option<State>>> {
    let count = flow.blocks.len();
    let mut ins: Vec<Option<State>> = vec![None; count];
    let mut outs: Vec<Option<State>> = vec![None; count];
    for _ in 0..200 {
        let mut changed = false;
        for (index, block) in flow.blocks.iter().enumerate() {
            let mut ways: Vec<State> =
                block.before.iter().filter_map(|&before| outs[before]).collect();
            if index == 0 {
                ways.push(begin());
            }
            if ways.is_empty() {
                continue;
            }
            let mut state = [0; 33];
            let mut classes: HashMap<Vec<Value>, Value> = HashMap::new();
            for (register, value) in state.iter_mut().enumerate() {
                let tuple: Vec<Value> = ways.iter().map(|way| way[register]).collect();
                let same = tuple.iter().all(|value| *value == tuple[0]);
                let bit = if tuple.iter().all(|&value| is_bit(value)) { BIT } else { 0 };
                let fresh = if same { tuple[0] } else { met(block.lines.start, register) | bit };
                *value = *classes.entry(tuple).or_insert(fresh);
            }
            if ins[index] != Some(state) {
                ins[index] = Some(state);
                changed = true;
            }
            for n in block.lines.clone() {
                step(&mut state, function, flow, n);
            }
            if outs[index] != Some(state) {
                outs[index] = Some(state);
                changed = true;
            }
        }
        if !changed {
            return Some(ins);
        }
    }
    None
}

/// Updates the state for a line.
fn step(state: &mut State, function: &Function, flow: &Flow, n: usize) {
    let Some(effect) = flow.effects[n] else { return };
    let before = *state;
    for (register, value) in state.iter_mut().enumerate() {
        if register < 32 && effect.writes >> register & 1 != 0 {
            *value = result(n, register);
        }
    }
    if effect.writes & FLAGS != 0 {
        state[32] = result(n, 32);
    }
    let Some(code) = function.lines[n].code() else { return };
    let (a, b) = operands(code);
    match (&*code.name, register(a), register(b)) {
        ("mov", Some(a), Some(b)) => state[usize::from(a)] = before[usize::from(b)],
        ("movw", Some(a), Some(b)) => {
            let (a, b) = (usize::from(a), usize::from(b));
            (state[a], state[a + 1]) = (before[b], before[b + 1]);
        }
        ("ldi", Some(a), _) => {
            if let Some(constant) = constant(b) {
                state[usize::from(a)] = constant;
            }
        }
        ("clr", Some(a), _) => state[usize::from(a)] = 0,
        // Repeating a comparison gives the same flags.
        ("cpi", Some(a), _) => {
            let number = constant(b).unwrap_or(256);
            state[32] = compared(before[usize::from(a)], number);
        }
        ("tst", Some(a), _) => state[32] = compared(before[usize::from(a)], SIGN_ALONE),
        ("eor", Some(a), Some(b)) if a == b => state[usize::from(a)] = 0,
        _ => {}
    }
}

/// In place of a number: `tst` leaves the carry unchanged.
const SIGN_ALONE: Value = 257;

/// The value of the flags after a comparison.
fn compared(value: Value, number: Value) -> Value {
    1 << 63 | value << 9 | number
}

/// A number of 8 bits.
fn constant(text: &str) -> Option<Value> {
    let number: i32 = match text.strip_prefix("0x") {
        Some(digits) => i32::from_str_radix(digits, 16).ok()?,
        None => text.parse().ok()?,
    };
    (-128..256).contains(&number).then_some((number & 255) as Value)
}

/// Whether the register already has the value that the instruction would put there.
fn is_there(code: &Code, state: &State) -> bool {
    let (a, b) = operands(code);
    let Some(to) = register(a).map(usize::from) else { return false };
    let from = register(b).map(usize::from);
    match (&*code.name, from) {
        ("mov", Some(from)) => state[to] == state[from],
        ("movw", Some(from)) => state[to] == state[from] && state[to + 1] == state[from + 1],
        ("ldi", _) => constant(b) == Some(state[to]),
        ("cpi", _) => constant(b).is_some_and(|number| compared(state[to], number) == state[32]),
        ("tst", _) => compared(state[to], SIGN_ALONE) == state[32],
        _ => false,
    }
}

/// Whether the register keeps its value, so that only flags are computed.
fn keeps(code: &Code, state: &State) -> bool {
    let (a, b) = operands(code);
    let value = |text: &str| register(text).map(|register| state[usize::from(register)]);
    match (&*code.name, value(a), value(b)) {
        ("andi", Some(value), _) => masked(value, constant(b)) == Some(value),
        ("or" | "eor" | "add" | "sub", _, Some(0)) => true,
        _ => false,
    }
}

/// A value under a mask, if it is known.
fn masked(value: Value, mask: Option<Value>) -> Option<Value> {
    match (value, mask?) {
        (_, 0) => Some(0),
        (value, 255) => Some(value),
        (0..256, mask) => Some(value & mask),
        (value, mask) if is_bit(value) && mask & 1 != 0 => Some(value),
        _ => None,
    }
}

/// The same instruction reading the registers that first held its operands.
fn first(code: &Code, state: &State) -> Option<Code> {
    let (a, b) = operands(code);
    let root = |text: &str, least: u8| {
        let value = state[usize::from(register(text)?)];
        let home = match value {
            // r1 will do.
            0 => 1,
            1..256 => return None,
            value => (value % 64) as u8,
        };
        let better = home >= least && home != register(text)? && state[usize::from(home)] == value;
        better.then(|| format!("r{home}"))
    };
    let both = |text: &str| {
        let low = register(text)?;
        let home = root(text, 0)?;
        let number = register(&home)?;
        let high = state[usize::from(low) + 1] == state[usize::from(number) + 1];
        (number % 2 == 0 && high).then_some(home)
    };
    let make = |a: &str, b: &str| {
        let operands = if b.is_empty() { a.into() } else { format!("{a}, {b}") };
        Some(Code { name: code.name.clone(), operands })
    };
    match &*code.name {
        "mov" | "add" | "adc" | "sub" | "sbc" | "and" | "or" | "eor" if a != b => {
            make(a, &root(b, 0)?)
        }
        "movw" => make(a, &both(b)?),
        "cp" | "cpc" | "mul" => {
            let (c, d) = (root(a, 0), root(b, 0));
            if c.is_none() && d.is_none() {
                return None;
            }
            make(c.as_deref().unwrap_or(a), d.as_deref().unwrap_or(b))
        }
        "cpi" => make(&root(a, 16)?, b),
        "tst" => make(&root(a, 0)?, ""),
        "st" | "std" | "sts" | "out" => make(a, &root(b, 0)?),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests;

    fn left(body: &str) -> String {
        tests::left(body, leave_out)
    }

    #[test]
    fn what_is_there_is_not_put_there_again() {
        assert_eq!(left("ldi r24, 7; out 10, r24; ldi r24, 7"), "ldi r24, 7; out 10, r24");
        assert_eq!(left("movw r26, r6; out 10, r26; movw r26, r6"), "out 10, r6");
        let twice = "cpi r24, 3; breq .L7; cpi r24, 3; brlo .L7";
        assert_eq!(left(twice), "cpi r24, 3; breq .L7; brlo .L7");
    }

    #[test]
    fn what_nobody_reads_is_not_computed() {
        assert_eq!(left("ldi r26, 7; add r26, r20; in r27, 10"), "in r27, 10");
        let read = "ldi r26, 7; add r26, r20; out 10, r26";
        assert_eq!(left(read), read);
    }

    #[test]
    fn what_keeps_a_value_goes() {
        for nothing in ["or r24, r1", "andi r24, 255", "ldi r26, 0; add r24, r26"] {
            let left = left(&format!("in r24, 10; {nothing}; out 10, r24"));
            assert!(!left.contains("r24, r") && !left.contains("andi"), "{left}");
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

    #[test]
    fn values_of_lines_far_apart_are_others() {
        let flags = |n| compared(result(n, 5), 0);
        for n in [1 << 15, 1 << 20] {
            assert_ne!(flags(0), flags(n), "{n}");
        }
        assert_ne!(flags(0), compared(result(0, 5), SIGN_ALONE));
    }
}
