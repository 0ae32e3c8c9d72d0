//! Functions stand near those that call them.
//!
//! A short call reaches 4 KB either way, an eighth of the chip, and takes 2 bytes less than a long
//! one. Which order has the most short calls is looked for by moving functions at random: a move
//! that is worse is taken at first and hardly ever at the end. The generator starts with the same
//! seed each time, and the functions start in the order of their names, so that a program is the
//! same wherever it is built.
//!
//! The order is told by the names of the sections, which the linker sorts (`build.rs` of the
//! firmware).

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;

use super::asm::key;
use super::branches::words;

/// How far a short call goes.
const REACH: i32 = 4_090;
/// Moves that are tried.
const MOVES: u32 = 60_000;
/// Calls that an island is worth.
const WORTH: usize = 3;

/// Code that stays together.
#[derive(Debug, Default)]
struct Unit {
    /// Its section, as it stands in the text.
    line: usize,
    bytes: i32,
    calls: Vec<Jump>,
}

/// A call as it is written: its line, its place, where it goes, and whether it must reach.
#[derive(Debug)]
struct Jump {
    line: usize,
    at: i32,
    label: String,
    must: bool,
}

/// Orders the code of a program.
pub fn order(text: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(Into::into).collect();
    let (mut units, labels) = units(text);
    // The last stands for libgcc, behind all else.
    let last = units.len();
    let mut calls = Vec::new();
    for (from, unit) in units.iter().enumerate() {
        for Jump { line, at, label, must } in &unit.calls {
            let known = labels.get(label.as_str()).copied();
            let (to, there) = known.unwrap_or((last, 0));
            // Distances in a unit, as in `.-4`, are its own.
            if to != from && (known.is_some() || !must) {
                calls.push(Call { line: *line, from, at: *at, to, there, must: *must });
            }
        }
    }
    let mut order: Vec<usize> = (0..last).collect();
    order.sort_by_cached_key(|&unit| key(&lines[units[unit].line]));
    units.push(Unit::default());
    search(&mut order, last, &units, &calls);
    let islands = islands(&mut units, &mut calls, &mut order, last, &lines);
    search(&mut order, last, &units, &calls);

    let mut more = String::new();
    for (place, &unit) in order.iter().enumerate() {
        let section = format!("\t.section\t.text.ordered.{place:04},\"ax\",@progbits");
        match unit.checked_sub(last + 1).and_then(|n| islands.get(n)) {
            Some(label) => {
                let _ = writeln!(more, "{section}\nstepwright_island_{unit}:\n\tjmp\t{label}");
            }
            None if units[unit].bytes > 0 => lines[units[unit].line] = section,
            None => {}
        }
    }
    for call in calls.iter().filter(|call| call.to > last) {
        let name = if lines[call.line].contains("jmp") { "jmp" } else { "call" };
        lines[call.line] = format!("\t{name}\tstepwright_island_{}", call.to);
    }
    lines.join("\n") + "\n" + &more
}

/// Puts an island, a long jump to it, where several calls do not reach what they call. The labels
/// of what they lead to.
fn islands(
    units: &mut Vec<Unit>,
    calls: &mut [Call],
    order: &mut Vec<usize>,
    last: usize,
    lines: &[String],
) -> Vec<String> {
    let mut labels = Vec::new();
    let mut at = vec![0; units.len()];
    put(order, last, units, &mut at);
    let mut far: BTreeMap<(String, &str), Vec<usize>> = BTreeMap::new();
    for (n, call) in calls.iter().enumerate() {
        if !call.must && call.misses(&at) > 0 {
            let label = lines[call.line].split_whitespace().nth(1).unwrap_or("");
            far.entry((key(label), label)).or_default().push(n);
        }
    }
    for ((_, label), ways) in far.into_iter().filter(|(_, ways)| ways.len() >= WORTH) {
        labels.push(label.to_string());
        let island = units.len();
        units.push(Unit { bytes: 4, ..Unit::default() });
        order.insert(order.len() / 2, island);
        for n in ways {
            (calls[n].to, calls[n].there) = (island, 0);
        }
    }
    labels
}

/// A call of another unit.
struct Call {
    line: usize,
    from: usize,
    at: i32,
    to: usize,
    there: i32,
    /// It was written as a short one.
    must: bool,
}

impl Call {
    /// By how many bytes it does not reach.
    fn misses(&self, at: &[i32]) -> i32 {
        (at[self.from] + self.at - at[self.to] - self.there).abs() - REACH
    }
}

/// The units of a text, and where labels are: in which one, and where there.
fn units(text: &str) -> (Vec<Unit>, HashMap<&str, (usize, i32)>) {
    let mut units: Vec<Unit> = Vec::new();
    let mut labels = HashMap::new();
    let mut code = false;
    for (n, line) in text.lines().enumerate() {
        let plain = line.split(';').next().unwrap_or("").trim();
        let mut parts = plain.splitn(2, char::is_whitespace);
        let (name, rest) = (parts.next().unwrap_or(""), parts.next().unwrap_or("").trim());
        if name == ".section" || name == ".text" {
            code = rest.starts_with(".text.");
            if code {
                units.push(Unit { line: n, ..Unit::default() });
            }
        } else if !code || plain.is_empty() {
        } else if let Some(label) = plain.strip_suffix(':') {
            labels.insert(label, (units.len() - 1, units[units.len() - 1].bytes));
        } else if !name.starts_with('.') {
            let last = units.len() - 1;
            let unit = &mut units[last];
            if ["call", "jmp", "rcall", "rjmp"].contains(&name) {
                let must = name.starts_with('r');
                unit.calls.push(Jump { line: n, at: unit.bytes, label: rest.into(), must });
                // Most become short.
                unit.bytes += 2;
            } else {
                unit.bytes += 2 * words(name);
            }
        }
    }
    (units, labels)
}

/// Looks for a better order.
fn search(order: &mut Vec<usize>, last: usize, units: &[Unit], calls: &[Call]) {
    let count = order.len();
    if count < 2 {
        return;
    }
    let mut at = vec![0; units.len()];
    let mut now = cost(order, last, units, calls, &mut at);
    let mut best = (now, order.clone());
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move |below: usize| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 33) as usize % below.max(1)
    };
    for step in 0..MOVES {
        let length = 1 + random(4).min(count - 1);
        let from = random(count - length + 1);
        let moved: Vec<usize> = order.drain(from..from + length).collect();
        let to = random(order.len() + 1);
        order.splice(to..to, moved);
        let then = cost(order, last, units, calls, &mut at);
        // Worse by as much, now and then.
        let heat = 2_000.0 * (1.0 - f64::from(step) / f64::from(MOVES)).powi(3);
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

/// Says where the units are.
fn put(order: &[usize], last: usize, units: &[Unit], at: &mut [i32]) {
    let mut here = 0;
    for &unit in order {
        at[unit] = here;
        here += units[unit].bytes;
    }
    at[last] = here;
}

/// What an order costs: calls that do not reach count, and by how far they miss a little.
fn cost(order: &[usize], last: usize, units: &[Unit], calls: &[Call], at: &mut [i32]) -> i64 {
    put(order, last, units, at);
    let mut cost = 0;
    for call in calls {
        let misses = call.misses(at);
        if misses > 0 {
            cost += if call.must { 1_000_000 } else { 1_000 } + i64::from(misses / 64);
        }
    }
    cost
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function of these calls, and of this many instructions more.
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
            let plain = text.lines().filter(|line| !line.contains(".section"));
            plain.map(|line| format!("{line}\n")).collect::<String>()
        };
        assert_eq!(code(&ordered), code(&text));
    }

    #[test]
    fn an_island_leads_where_its_calls_went() {
        // What libgcc has is at the end, and each by its name.
        let calls = ["__mulsi3", "__mulsi3", "__mulsi3", "__divsi3", "__divsi3", "__divsi3"];
        let text = function("large", &calls, 5000) + &function("end", &[], 5000);
        let ordered = order(&text);
        let mut reached = Vec::new();
        for line in ordered.lines().filter(|line| line.contains("call\t")) {
            let label = line.split_whitespace().nth(1).unwrap();
            let island = format!("{label}:\n\tjmp\t");
            reached.push(match ordered.split_once(&island) {
                Some((_, behind)) => behind.lines().next().unwrap(),
                None => label,
            });
        }
        assert_eq!(reached, calls);
        assert_eq!(ordered.matches("stepwright_island").count(), 6 + 2);
    }

    #[test]
    fn it_is_always_the_same() {
        let text = (0..9).fold(String::new(), |text, n| {
            text + &function(&format!("f{n}"), &[&format!("f{}", (n * 4 + 1) % 9)], 700)
        });
        assert_eq!(order(&text), order(&text));
    }
}
