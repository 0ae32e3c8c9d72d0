//! Places functions near those that call them.
//!
//! A short call reaches 4 KB either way, an eighth of an ATmega328P, and takes 2 bytes less than a
//! long one. Simulated annealing searches for the order with the most short calls: it moves
//! functions at random, and accepts a worse order often at first and hardly ever at the end. The
//! generator always starts with the same seed, and the functions start in the order of their names,
//! so that the result is the same wherever the program is built.
//!
//! The linker keeps the order of an object's sections, and shortens the calls that reach
//! (`--relax`).

use std::collections::HashMap;

use super::asm::{instruction, key, label};

/// The reach of a short call, in bytes.
const REACH: i32 = 4_090;
/// The moves tried, for each section.
const MOVES: u32 = 8_000;

/// Code that stays together: a section.
#[derive(Debug, Default)]
struct Unit<'a> {
    name: &'a str,
    /// The lines, without the directives that open the section.
    lines: Vec<&'a str>,
    bytes: i32,
    /// The calls and jumps: the position, the label, and whether it must be in reach.
    calls: Vec<(i32, String, bool)>,
}

/// A call of another unit, from a position in one to a position in the other.
struct Call {
    from: usize,
    at: i32,
    to: usize,
    there: i32,
    /// The source has a short call.
    must: bool,
}

/// Orders the code of a program.
pub(crate) fn order(text: &str) -> String {
    let (rest, units, labels) = units(text);
    // libgcc's functions come after everything else.
    let last = units.len();
    let mut calls = Vec::new();
    for (from, unit) in units.iter().enumerate() {
        for (at, label, must) in &unit.calls {
            let known = labels.get(&**label).copied();
            let (to, there) = known.unwrap_or((last, 0));
            // Distances within a unit, as in `.-4`, do not change.
            if to != from && (known.is_some() || !must) {
                calls.push(Call { from, at: *at, to, there, must: *must });
            }
        }
    }
    let mut order: Vec<usize> = (0..last).collect();
    order.sort_by_cached_key(|&unit| key(units[unit].name));
    let sizes: Vec<i32> = units.iter().map(|unit| unit.bytes).collect();
    search(&mut order, &sizes, &calls);
    let mut ordered: String = rest.iter().map(|line| format!("{line}\n")).collect();
    for (place, &unit) in order.iter().enumerate() {
        // A linker script that sorts by other names keeps the order of these.
        ordered += &format!("\t.section\t.text.ordered.{place:04},\"ax\",@progbits\n");
        units[unit].lines.iter().for_each(|line| ordered += &format!("{line}\n"));
    }
    ordered
}

/// The unit of each label, and its position there.
type Labels<'a> = HashMap<&'a str, (usize, i32)>;

/// The lines of a text outside code, the units, and the labels.
fn units(text: &str) -> (Vec<&str>, Vec<Unit<'_>>, Labels<'_>) {
    let (mut rest, mut units, mut labels) = (Vec::new(), Vec::new(), HashMap::new());
    let mut names: HashMap<&str, usize> = HashMap::new();
    // The unit of the present section.
    let mut open: Option<usize> = None;
    for line in text.lines() {
        let words = line.split(|c: char| c.is_whitespace() || c == ',');
        let mut words = words.filter(|word| !word.is_empty());
        if let Some(".section" | ".text" | ".data" | ".bss") = words.next() {
            let name = words.next().filter(|name| name.starts_with(".text."));
            open = name.map(|name| {
                *names.entry(name).or_insert_with(|| {
                    units.push(Unit { name, ..Unit::default() });
                    units.len() - 1
                })
            });
            if open.is_some() {
                continue;
            }
        }
        let Some(index) = open else {
            rest.push(line);
            continue;
        };
        let unit = &mut units[index];
        unit.lines.push(line);
        if let Some(label) = label(line) {
            labels.insert(label, (index, unit.bytes));
        } else if let Some(code) = instruction(line) {
            let must = line.trim_start().starts_with('r');
            if ["call", "jmp", "rjmp"].contains(&&*code.name) {
                unit.calls.push((unit.bytes, code.a, must));
                // Most become short.
                unit.bytes += 2;
            } else {
                unit.bytes += 2 * code.words();
            }
        }
    }
    (rest, units, labels)
}

/// Searches for a better order.
fn search(order: &mut Vec<usize>, sizes: &[i32], calls: &[Call]) {
    let count = order.len();
    if count < 2 {
        return;
    }
    let mut now = cost(order, sizes, calls);
    let mut best = (now, order.clone());
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move |below: usize| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 33) as usize % below.max(1)
    };
    let moves = MOVES * count as u32;
    for step in 0..moves {
        let length = 1 + random(4).min(count - 1);
        let from = random(count - length + 1);
        let moved: Vec<usize> = order.drain(from..from + length).collect();
        let to = random(order.len() + 1);
        order.splice(to..to, moved);
        let then = cost(order, sizes, calls);
        // Accepts a worse order with a probability that falls with time.
        let heat = 2_000.0 * (1.0 - f64::from(step) / f64::from(moves)).powi(3);
        let chance = (-((then - now) as f64) / heat.max(1e-9)).exp();
        if then <= now || (random(1 << 20) as f64) < chance * f64::from(1 << 20) {
            now = then;
            if now < best.0 {
                best = (now, order.clone());
            }
        } else {
            let moved: Vec<usize> = order.drain(to..to + length).collect();
            order.splice(from..from, moved);
        }
    }
    *order = best.1;
}

/// The cost of an order: each call out of reach counts, plus a little for its distance.
fn cost(order: &[usize], sizes: &[i32], calls: &[Call]) -> i64 {
    let (mut at, mut here) = (vec![0; sizes.len() + 1], 0);
    for &unit in order {
        at[unit] = here;
        here += sizes[unit];
    }
    at[sizes.len()] = here;
    let mut cost = 0;
    for call in calls {
        let misses = (at[call.from] + call.at - at[call.to] - call.there).abs() - REACH;
        if misses > 0 {
            cost += if call.must { 1_000_000 } else { 1_000 } + i64::from(misses / 64);
        }
    }
    cost
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function with these calls, and `more` other instructions.
    fn function(name: &str, calls: &[&str], more: usize) -> String {
        let calls: String = calls.iter().map(|label| format!("\tcall\t{label}\n")).collect();
        let more = "\tnop\n".repeat(more);
        format!("\t.section\t.text.{name},\"ax\",@progbits\n{name}:\n{calls}{more}\tret\n")
    }

    /// The functions in the order of their sections.
    fn names(text: &str) -> Vec<&str> {
        let mut all: Vec<(&str, &str)> = Vec::new();
        let lines: Vec<&str> = text.lines().collect();
        for pair in lines.windows(2).filter(|pair| pair[0].contains(".section")) {
            all.push((pair[0], pair[1].trim_end_matches(':')));
        }
        all.sort_unstable();
        all.into_iter().map(|(_, name)| name).collect()
    }

    #[test]
    fn a_function_stands_near_its_callers() {
        let far = function("large", &[], 3000) + &function("other", &[], 3000);
        let text = function("caller", &["called"], 10) + &far + &function("called", &[], 10);
        let ordered = order(&text);
        let names = names(&ordered);
        let place = |name| names.iter().position(|other| *other == name).unwrap();
        assert_eq!(place("caller").abs_diff(place("called")), 1, "{names:?}");
        // Nothing else has changed.
        let code = |text: &str| {
            let mut lines: Vec<_> =
                text.lines().filter(|line| !line.contains(".section")).collect();
            lines.sort_unstable();
            lines.join("\n")
        };
        assert_eq!(code(&ordered), code(&text));
    }

    #[test]
    fn it_is_always_the_same() {
        let text = (0..9).fold(String::new(), |text, n| {
            text + &function(&format!("f{n}"), &[&format!("f{}", (n * 4 + 1) % 9)], 700)
        });
        assert_eq!(order(&text), order(&text));
    }
}
