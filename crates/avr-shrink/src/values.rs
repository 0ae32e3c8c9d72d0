//! The values of registers and flags at each line of a function.
//!
//! A value is a constant, the result of an instruction, or a merge of values where paths join. A
//! copy has the value of its source, and a flag that is set by a comparison is known by what was
//! compared. An instruction is *idle* if it changes nothing that is read later: the values are those
//! of the function without its idle instructions.

use super::asm::{Code, Function};
use super::calls::Calls;
use super::effects::{ARITHMETIC, Effect, Kind, Set, ZERO, register};
use super::flow::Flow;

/// Where a value comes from: a register or a flag, at a point of the function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Origin {
    pub line: usize,
    pub slot: usize,
    /// Merged where paths join at the line, not its result.
    pub merged: bool,
}

/// A value, named by where it comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Value {
    Constant(u8),
    Made(Origin),
    /// It is known to be 0 or 1.
    Bit(Origin),
    /// A flag after the comparison of what was made there with a number.
    Compared(Origin, u8),
}

impl Value {
    /// The value that a line leaves in a register or a flag.
    const fn result(line: usize, slot: usize) -> Value {
        Value::Made(Origin { line, slot, merged: false })
    }

    /// Where the value of a register comes from.
    pub const fn origin(self) -> Option<Origin> {
        match self {
            Value::Made(origin) | Value::Bit(origin) => Some(origin),
            _ => None,
        }
    }

    const fn is_bit(self) -> bool {
        matches!(self, Value::Constant(0 | 1) | Value::Bit(_))
    }
}

/// The values of the registers and the flags, by their bits in a [`Set`].
pub(crate) type State = [Value; 36];

/// The values in a function.
#[derive(Debug)]
pub(crate) struct Values {
    pub flow: Flow,
    /// Before each line; `None` if it is never reached.
    pub before: Vec<Option<State>>,
    /// After each line.
    pub after: Vec<Option<State>>,
    /// The lines that change nothing that is read later.
    pub idle: Vec<bool>,
}

impl Values {
    /// The values in a function; `None` if it has an unknown instruction, or if they are not found
    /// soon.
    pub fn of(function: &Function, calls: &Calls) -> Option<Values> {
        let (flow, count) = (Flow::of(function, calls)?, function.lines.len());
        let (mut before, mut after) = (vec![None; count], vec![None; count]);
        let mut idle = vec![false; count];
        for _ in 0..200 {
            let mut changed = false;
            for (n, effect) in flow.effects.iter().enumerate() {
                let ways = flow.before[n].iter().filter_map(|&way| after[way]);
                let ways: Vec<State> = ways.chain((n == 0).then(begin)).collect();
                let Some(old) = merge(&ways, n) else { continue };
                let mut new = step(&old, n, function.lines[n].code(), effect);
                idle[n] = effect.kind == Kind::Plain
                    && !function.is_skipped(n)
                    && slots(effect.writes & flow.live[n]).all(|slot| old[slot] == new[slot]);
                if idle[n] {
                    new = old;
                }
                changed |= after[n] != Some(new);
                (before[n], after[n]) = (Some(old), Some(new));
            }
            if !changed {
                return Some(Values { flow, before, after, idle });
            }
        }
        None
    }
}

/// The registers and flags of a set.
pub(crate) fn slots(set: Set) -> impl Iterator<Item = usize> {
    (0..36).filter(move |slot| set >> slot & 1 != 0)
}

/// The values at the beginning of a function.
fn begin() -> State {
    let mut state = std::array::from_fn(|slot| Value::result(0, slot));
    state[1] = Value::Constant(0);
    state
}

/// The values where paths join at a line.
fn merge(ways: &[State], line: usize) -> Option<State> {
    let (first, others) = ways.split_first()?;
    let mut state = *first;
    for slot in 0..state.len() {
        if others.iter().any(|way| way[slot] != first[slot]) {
            let bit = ways.iter().all(|way| way[slot].is_bit());
            let origin = Origin { line, slot, merged: true };
            state[slot] = if bit { Value::Bit(origin) } else { Value::Made(origin) };
        }
    }
    Some(state)
}

/// The values after a line.
fn step(before: &State, line: usize, code: Option<&Code>, effect: &Effect) -> State {
    let mut after = *before;
    slots(effect.writes).for_each(|slot| after[slot] = Value::result(line, slot));
    let Some(code) = code else { return after };
    let Some(a) = register(&code.a) else { return after };
    let number = number(&code.b);
    match (&*code.name, register(&code.b)) {
        ("mov", Some(b)) => after[a] = before[b],
        ("movw", Some(b)) => (after[a], after[a + 1]) = (before[b], before[b + 1]),
        ("ldi", _) => after[a] = number.map_or(after[a], Value::Constant),
        ("clr", _) => after[a] = Value::Constant(0),
        ("eor", Some(b)) if a == b => after[a] = Value::Constant(0),
        ("or" | "eor" | "add" | "sub", Some(b)) if before[b] == Value::Constant(0) => {
            after[a] = before[a];
        }
        ("andi", _) if before[a].is_bit() && number.is_some_and(|mask| mask % 2 == 1) => {
            after[a] = before[a];
        }
        _ => {}
    }
    // The flags that are those of a comparison with this number.
    let (flags, number) = match &*code.name {
        "cpi" => (ARITHMETIC, number),
        "tst" => (ARITHMETIC, Some(0)),
        // The zero flag of some instructions is that of several bytes.
        _ if effect.writes & !ARITHMETIC == 1 << a && effect.reads & ZERO == 0 => (ZERO, Some(0)),
        _ => (0, None),
    };
    if let Some((origin, number)) = after[a].origin().zip(number) {
        let compared = Value::Compared(origin, number);
        slots(flags & effect.writes).for_each(|flag| after[flag] = compared);
    }
    after
}

/// A number of 8 bits.
fn number(text: &str) -> Option<u8> {
    let number: i32 = match text.strip_prefix("0x") {
        Some(digits) => i32::from_str_radix(digits, 16).ok()?,
        None => text.parse().ok()?,
    };
    (-128..256).contains(&number).then_some(number as u8)
}
