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

use super::asm::{instruction, label};

/// The reach of a short call, in bytes.
const REACH: i32 = 4_090;
/// The moves tried, for each section.
const MOVES: u32 = 20_000;

/// Code that stays together: a section.
#[derive(Debug, Default)]
struct Unit<'a> {
    name: &'a str,
    /// The lines, without the directive that opens the section.
    lines: Vec<&'a str>,
    bytes: i32,
}

/// A unit, and the bytes before a place in it.
type Place = (usize, i32);

/// Orders the code of a program.
pub(crate) fn order(text: &str) -> String {
    let (mut ordered, mut units) = (String::new(), Vec::<Unit>::new());
    let (mut labels, mut calls) = (HashMap::new(), Vec::new());
    let mut in_code = false;
    for line in text.lines() {
        let words = line.split(|c: char| c.is_whitespace() || c == ',');
        let mut words = words.filter(|word| !word.is_empty());
        if let Some(".section" | ".text" | ".data" | ".bss") = words.next() {
            let name = words.next().filter(|name| name.starts_with(".text."));
            in_code = name.is_some();
            units.extend(name.map(|name| Unit { name, ..Unit::default() }));
            if in_code {
                continue;
            }
        }
        let Some((index, unit)) = units.iter_mut().enumerate().last().filter(|_| in_code) else {
            ordered += &format!("{line}\n");
            continue;
        };
        unit.lines.push(line);
        if let Some(label) = label(line) {
            labels.insert(label.to_string(), (index, unit.bytes));
        } else if let Some(code) = instruction(line) {
            // Most of those that the linker can shorten become short.
            let is_long = ["call", "jmp"].iter().any(|name| line.trim_start().starts_with(name));
            let words = if is_long { 1 } else { code.words() };
            if is_long {
                calls.push(((index, unit.bytes), code.a));
            }
            unit.bytes += 2 * words;
        }
    }
    // libgcc's functions come after everything else.
    let place = |label: &String| labels.get(label).copied().unwrap_or((units.len(), 0));
    let calls: Vec<_> = calls.iter().map(|(from, label)| (*from, place(label))).collect();
    let mut order: Vec<usize> = (0..units.len()).collect();
    order.sort_by_cached_key(|&unit| key(units[unit].name));
    search(&mut order, &units, &calls);
    for (place, &unit) in order.iter().enumerate() {
        // A linker script that sorts by other names keeps the order of these.
        ordered += &format!("\t.section\t.text.ordered.{place:04},\"ax\",@progbits\n");
        units[unit].lines.iter().for_each(|line| ordered += &format!("{line}\n"));
    }
    ordered
}

/// The parts of a symbol that are the same in each build folder: without the hashes of crates, and
/// back-references.
fn key(symbol: &str) -> Vec<String> {
    let cut = |part: &str, mark: &str| part.split(mark).next().unwrap_or_default().to_string();
    symbol.split('_').map(|part| cut(&cut(part, "Cs"), "B")).collect()
}

/// Searches for a better order.
fn search(order: &mut [usize], units: &[Unit], calls: &[(Place, Place)]) {
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move |below: usize| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 33) as usize % below
    };
    let mut now = cost(order, units, calls);
    let moves = MOVES * units.len() as u32;
    for step in 0..moves {
        // Up to four units change places with those between here and there.
        let (here, there) = (random(order.len()), random(order.len()));
        let between = &mut order[here.min(there)..=here.max(there)];
        let many = (1 + random(4)).min(between.len());
        let many = if here < there { many } else { between.len() - many };
        between.rotate_left(many);
        let then = cost(order, units, calls);
        // Accepts a worse order with a probability that falls with time.
        let heat = 2_000.0 * (1.0 - f64::from(step) / f64::from(moves)).powi(3);
        let chance = (f64::from(now - then) / heat).exp();
        if chance * f64::from(1 << 20) > random(1 << 20) as f64 {
            now = then;
        } else {
            order[here.min(there)..=here.max(there)].rotate_right(many);
        }
    }
}

/// The cost of an order: each call out of reach counts, plus a little for its distance.
fn cost(order: &[usize], units: &[Unit], calls: &[(Place, Place)]) -> i32 {
    let (mut begins, mut here) = (vec![0; units.len() + 1], 0);
    for &unit in order {
        begins[unit] = here;
        here += units[unit].bytes;
    }
    begins[units.len()] = here;
    let at = |place: &Place| begins[place.0] + place.1;
    let misses = calls.iter().map(|(from, to)| (at(from) - at(to)).abs() - REACH);
    misses.filter(|&miss| miss > 0).map(|miss| 1_000 + miss / 64).sum()
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

    #[test]
    fn a_key_is_the_same_in_every_folder() {
        let here = "_RNvMNtCsaB1_10stepwright5groupNtB4_5Group4haltCs9x_5slave";
        let there = "_RNvMNtCsaB1cD_10stepwright5groupNtB6z_5Group4haltCs1_5slave";
        assert_eq!(key(here), key(there));
        assert_ne!(key(here), key(&here.replace("halt", "stop")));
        assert_eq!(key("memcpy"), ["memcpy"]);
    }
}
