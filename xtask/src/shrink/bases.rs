//! Bytes at addresses near each other are reached from a pointer.
//!
//! ```text
//!   lds r24, DEVICE+240            ldi r30, lo8(DEVICE+240)
//!   lds r25, DEVICE+241      →     ldi r31, hi8(DEVICE+240)
//!   sts DEVICE+247, r24            ldd r24, Z+0
//!                                  ldd r25, Z+1
//!                                  std Z+7, r24
//! ```
//!
//! An address in an instruction takes 2 bytes more than a distance from Z, and two instructions
//! set Z. So three are worth it, where Z is free.
//!
//! **Gain**: 2 bytes from the third on. **Cost**: 2 cycles.

use super::asm::{Code, Function, Line, Program};
use super::flow::{Flow, code};
use super::machine::{Kind, Set, Taken, operands, pair};

/// Furthest byte from Z.
const REACH: i32 = 63;
/// Accesses that are worth it.
const LEAST: usize = 3;

/// Goes through all functions.
pub fn reach(program: &mut Program, taken: &Taken) {
    for function in program.functions_mut() {
        while group(function, taken) {}
    }
}

/// The symbol of an access, and how far behind it.
fn place(code: &Code) -> Option<(&str, i32)> {
    let (a, b) = operands(code);
    let address = match &*code.name {
        "lds" => b,
        "sts" => a,
        _ => return None,
    };
    let (symbol, far) = address.split_once('+').unwrap_or((address, "0"));
    // Ports have numbers.
    let named = symbol.starts_with(|c: char| c.is_alphabetic() || c == '_');
    named.then_some((symbol, far.parse().ok()?))
}

/// Has one group go by a pointer. Whether there was one.
fn group(function: &mut Function, taken: &Taken) -> bool {
    let Some(flow) = Flow::of(function, taken) else { return false };
    let live = flow.live();
    for block in &flow.blocks {
        for n in block.lines.clone() {
            let found = found(function, &flow, &live, block.lines.end, n);
            if found.len() >= LEAST {
                replace(function, &found);
                return true;
            }
        }
    }
    false
}

/// Accesses from a line on that one pointer can reach; none if Z is not free.
fn found(function: &Function, flow: &Flow, live: &[Set], end: usize, from: usize) -> Vec<usize> {
    let z = pair(30);
    let at = |n: usize| code(&function.lines[n]).filter(|_| !flow.pinned[n]).and_then(place);
    let Some((symbol, first)) = at(from) else { return Vec::new() };
    let (mut least, mut most) = (first, first);
    let mut found = Vec::new();
    let mut free = 0;
    for (n, (effect, live)) in flow.effects.iter().zip(live).enumerate().take(end).skip(from) {
        let Some(effect) = effect else { break };
        let plain = matches!(effect.kind, Kind::Plain | Kind::Outward | Kind::Branch);
        if !plain || (effect.reads | effect.writes) & z != 0 {
            break;
        }
        if let Some((_, far)) = at(n).filter(|(other, _)| *other == symbol)
            && far.max(most) - far.min(least) <= REACH
        {
            (least, most) = (far.min(least), far.max(most));
            found.push(n);
            if live & z == 0 {
                free = found.len();
            }
        }
    }
    found.truncate(free);
    found
}

/// Sets the pointer, and goes by it.
fn replace(function: &mut Function, found: &[usize]) {
    let lines = &mut function.lines;
    let all = found.iter().filter_map(|&n| code(&lines[n]).and_then(place));
    let all: Vec<(String, i32)> = all.map(|(symbol, far)| (symbol.into(), far)).collect();
    let Some(base) = all.iter().map(|(_, far)| *far).min() else { return };
    for (&n, (_, far)) in found.iter().zip(&all) {
        let Some(code) = code(&lines[n]) else { continue };
        let (a, b) = operands(code);
        let place = format!("Z+{}", far - base);
        let new = match &*code.name {
            "lds" => Code { name: "ldd".into(), operands: format!("{a}, {place}") },
            _ => Code { name: "std".into(), operands: format!("{place}, {b}") },
        };
        lines[n] = Line::Code(new);
    }
    let symbol = &all[0].0;
    let set = |register: &str, half: &str| {
        let operands = format!("{register}, {half}({symbol}+{base})");
        Line::Code(Code { name: "ldi".into(), operands })
    };
    lines.splice(found[0]..found[0], [set("r30", "lo8"), set("r31", "hi8")]);
}

#[cfg(test)]
mod tests {
    use super::super::tests;
    use super::*;

    fn left(body: &str) -> String {
        tests::left(body, reach)
    }

    #[test]
    fn bytes_near_each_other_are_reached_from_a_pointer() {
        assert_eq!(
            left("lds r24, D+240; lds r25, D+241; sts D+247, r24"),
            "ldi r30, lo8(D+240); ldi r31, hi8(D+240); ldd r24, Z+0; ldd r25, Z+1; std Z+7, r24"
        );
        // Others may be between; the lowest is the base.
        assert_eq!(
            left("sts D+63, r24; lds r20, E; lds r25, D; cli; sts D+9, r25"),
            "ldi r30, lo8(D+0); ldi r31, hi8(D+0); std Z+63, r24; lds r20, E; ldd r25, Z+0; cli; \
             std Z+9, r25"
        );
    }

    #[test]
    fn a_pointer_in_use_is_not_taken() {
        for stays in [
            // It is read later, or between.
            "lds r24, D; lds r25, D+1; lds r20, D+2; ldd r21, Z+0",
            "lds r24, D; lds r25, D+1; ldd r21, Z+0; lds r20, D+2",
            "lds r24, D; lds r25, D+1; lds r20, D+2; breq .L7; out 10, r31",
            // It is what is loaded, or stored.
            "lds r24, D; lds r25, D+1; lds r30, D+2; out 10, r30",
            "ldi r30, 1; lds r24, D; lds r25, D+1; sts D+2, r30",
        ] {
            assert_eq!(left(stays), stays);
        }
    }

    #[test]
    fn what_is_not_worth_it_stays() {
        for stays in [
            "lds r24, D; lds r25, D+1",
            // Too far, of another symbol, or a port.
            "lds r24, D; lds r25, D+1; lds r20, D+64",
            "lds r24, D; lds r25, D+1; lds r20, E+2",
            "lds r24, 128; sts 128, r25; lds r20, 128",
            // A call loses the pointer, and so does another way that leads here.
            "lds r24, D; lds r25, D+1; call g; lds r20, D+2",
            "lds r24, D; lds r25, D+1\n.L1:; lds r20, D+2; brne .L1",
        ] {
            assert_eq!(left(stays), stays.replace("\n.L1:", ""));
        }
    }
}
