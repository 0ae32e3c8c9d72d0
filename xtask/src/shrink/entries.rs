//! An instruction that comes before many calls of a function moves before the function.
//!
//! ```text
//!   movw r24, r16                           stepwright_entry_3_1:
//!   call stepwright_hand_load       →         movw r24, r16
//!                                           stepwright_hand_load:
//!   call stepwright_entry_3_1
//! ```
//!
//! The function has an entry for each instruction that is put before it, and a call takes the one
//! that has all of its own.
//!
//! **Cost**: none. **Gain**: 2 bytes a call, less the instruction's own.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::asm::{Code, Function, Line, Part, Program, key};
use super::branches::words;
use super::machine::skips;
use super::routines::is_plain;

/// Most instructions before a function.
const MOST: usize = 6;

/// A call: in which function, and in which of its lines.
type Site = (usize, usize);

/// Gives functions the entries that are worth it.
pub fn share(program: &mut Program) {
    let closed = closed(program);
    let mut calls: BTreeMap<(String, String), Vec<Site>> = BTreeMap::new();
    let mut functions: Vec<&mut Function> = program.functions_mut().collect();
    for (index, function) in functions.iter().enumerate() {
        for (n, code) in function.code() {
            let called = &code.operands;
            if matches!(&*code.name, "call" | "jmp") && closed.contains(called) {
                calls.entry((key(called), called.clone())).or_default().push((index, n));
            }
        }
    }
    let mut entries: HashMap<String, Vec<String>> = HashMap::new();
    let mut taken: Vec<(Site, usize, String)> = Vec::new();
    for (number, ((_, called), mut sites)) in calls.into_iter().enumerate() {
        let mut before: Vec<Code> = Vec::new();
        let mut ends: Vec<(Site, usize)> = Vec::new();
        while before.len() < MOST {
            let depth = before.len();
            let Some(best) = most_common(&functions, &sites, depth) else { break };
            let (more, left): (Vec<_>, Vec<_>) = sites
                .into_iter()
                .partition(|&site| instruction(functions[site.0], site.1, depth) == Some(&best));
            ends.extend(left.into_iter().map(|site| (site, depth)));
            before.push(best);
            sites = more;
        }
        ends.extend(sites.into_iter().map(|site| (site, before.len())));
        let label = |depth: usize| format!("stepwright_entry_{number}_{depth}");
        taken.extend(
            ends.into_iter()
                .filter(|(_, depth)| *depth > 0)
                .map(|(site, depth)| (site, depth, label(depth))),
        );
        if !before.is_empty() {
            let lines = before.iter().enumerate().rev();
            let lines =
                lines.flat_map(|(n, code)| [format!("{}:", label(n + 1)), code.to_string()]);
            entries.insert(format!("{called}:"), lines.collect());
        }
    }
    // The last first, so that the others stay where they are.
    taken.sort_by_key(|(site, ..)| std::cmp::Reverse(*site));
    for ((index, n), depth, label) in taken {
        let lines = &mut functions[index].lines;
        if let Line::Code(code) = &mut lines[n] {
            code.operands = label;
        }
        lines.drain(n - depth..n);
    }
    for part in &mut program.parts {
        match part {
            Part::Text(lines) => {
                let old = std::mem::take(lines);
                for line in old.iter().flat_map(|text| text.lines()) {
                    lines.extend(entries.remove(line).unwrap_or_default());
                    lines.push(line.into());
                }
            }
            Part::Function(function) => {
                for line in std::mem::take(&mut function.lines) {
                    let before = entries.remove(&line.to_string()).unwrap_or_default();
                    let by_hand = matches!(line, Line::Other(_));
                    function.lines.extend(before.into_iter().map(|text| match by_hand {
                        true => Line::Other(text),
                        false => read(&text),
                    }));
                    function.lines.push(line);
                }
            }
        }
    }
}

/// An entry's line, as the compiler's are.
fn read(text: &str) -> Line {
    match text.strip_suffix(':') {
        Some(label) => Line::Label(label.into()),
        None => Line::Code(Code::parse(text.trim())),
    }
}

/// The instruction that most calls have before them, if it is worth an entry: the one that is
/// `depth` instructions before the last.
fn most_common(functions: &[&mut Function], sites: &[Site], depth: usize) -> Option<Code> {
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for &(index, n) in sites {
        if let Some(code) = instruction(functions[index], n, depth) {
            *times.entry(code.to_string()).or_default() += 1;
        }
    }
    let best = times.into_iter().max_by_key(|(text, times)| {
        let code = Code::parse(text.trim());
        (words(&code.name) * (*times as i32 - 1), std::cmp::Reverse(text.clone()))
    });
    best.filter(|(_, times)| *times >= 2).map(|(text, _)| Code::parse(text.trim()))
}

/// The instruction before line `n`, or `depth` before that, if it may stand before a function.
fn instruction(function: &Function, n: usize, depth: usize) -> Option<&Code> {
    let at = n.checked_sub(depth + 1)?;
    let Line::Code(code) = &function.lines[at] else { return None };
    // What a skip leaves out must stay one instruction.
    let skipped = at > 0 && matches!(&function.lines[at - 1], Line::Code(code) if skips(code));
    (is_plain(code) && !skipped).then_some(code)
}

/// Functions that nothing runs into.
fn closed(program: &Program) -> HashSet<String> {
    let mut closed = HashSet::new();
    let (mut runs_on, mut skipped) = (true, false);
    let text = program.to_string();
    for line in text.lines() {
        let plain = line.split(';').next().unwrap_or("").trim();
        if plain.starts_with(".section") {
            (runs_on, skipped) = (false, false);
        } else if let Some(label) = plain.strip_suffix(':') {
            if !runs_on && ["stepwright_", "_R"].iter().any(|start| label.starts_with(start)) {
                closed.insert(label.to_string());
            }
            runs_on = true;
        } else if !plain.is_empty() && !plain.starts_with('.') {
            let code = Code::parse(plain);
            let leaves = ["ret", "reti", "jmp", "rjmp"].contains(&&*code.name);
            runs_on = !leaves || skipped;
            skipped = skips(&code);
        }
    }
    closed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function of the compiler's in a section of its own.
    fn function(name: &str, body: &str) -> String {
        let lines = body.replace("; ", "\n\t");
        let begin = format!("\t.section\t.text.{name},\"ax\",@progbits\n\t.type\t{name},@function");
        format!("{begin}\n{name}:\n\t{lines}\n.Lfunc_end:\n")
    }

    /// The code that comes of a program, in one line, with `entry` for the names of entries.
    fn shared(text: &str) -> String {
        let mut program = Program::parse(text);
        share(&mut program);
        let text = program.to_string();
        let lines = text.lines().map(|line| line.trim().replace('\t', " "));
        let lines = lines.filter(|line| !line.starts_with('.') && !line.is_empty());
        let plain = lines.map(|line| match line.split_once("stepwright_entry_") {
            Some((before, name)) => {
                let (_, depth) = name.split_once('_').unwrap();
                format!("{before}entry_{depth}")
            }
            None => line,
        });
        plain.collect::<Vec<_>>().join("; ")
    }

    #[test]
    fn what_comes_before_every_call_is_before_the_function() {
        let callers = ["f", "g"].map(|name| function(name, "movw r24, r16; call _Rh; nop"));
        let text = callers.concat() + &function("_Rh", "inc r24; ret");
        let call = "call entry_1; nop";
        let called = "entry_1:; movw r24, r16; _Rh:; inc r24; ret";
        assert_eq!(shared(&text), format!("f:; {call}; g:; {call}; {called}"));
    }

    #[test]
    fn a_call_takes_the_entry_that_has_all_of_its_own() {
        let [f, g, h] = [
            ("f", "ldi r20, 1; movw r24, r16; call _Rh"),
            ("g", "ldi r20, 1; movw r24, r16; jmp _Rh"),
            ("h", "ldi r20, 2; movw r24, r16; call _Rh"),
        ]
        .map(|(name, body)| function(name, body));
        // Another register has nothing of it.
        let other = function("i", "movw r24, r14; call _Rh");
        let text = [f, g, h, other, function("_Rh", "ret")].concat();
        let calls = "f:; call entry_2; g:; jmp entry_2; h:; ldi r20, 2; call entry_1";
        let called = "entry_2:; ldi r20, 1; entry_1:; movw r24, r16; _Rh:; ret";
        assert_eq!(shared(&text), format!("{calls}; i:; movw r24, r14; call _Rh; {called}"));
    }

    #[test]
    fn a_function_of_a_persons_gets_entries_where_nothing_runs_into_it() {
        let by_hand = |before: &str| {
            let code = format!(";APP\n\tclr r1\n\t{before}\nstepwright_h:\n\tret\n\t;NO_APP");
            function("stepwright_all", &code)
        };
        let callers = ["f", "g"].map(|name| function(name, "mov r24, r2; call stepwright_h"));
        let callers = callers.concat();
        let closed = shared(&(callers.clone() + &by_hand("rjmp .Ltmp1")));
        assert!(closed.contains("f:; call entry_1; g:; call entry_1;"), "{closed}");
        assert!(closed.contains("rjmp .Ltmp1; entry_1:; mov r24, r2; stepwright_h:; ret"));
        for open in ["nop", "sbrc r24, 0\n\tret", "ret\n.Ltmp1:"] {
            let text = callers.clone() + &by_hand(open);
            assert!(!shared(&text).contains("entry"), "{open}");
        }
    }

    #[test]
    fn what_is_of_the_stack_of_interrupts_or_may_be_skipped_stays() {
        let called = function("_Rh", "ret");
        for before in ["push r24", "cli", "out 5, r24", "call _Ri", "sbrc r2, 0; mov r24, r2"] {
            let body = format!("{before}; call _Rh");
            let text = ["f", "g"].map(|name| function(name, &body)).concat() + &called;
            assert!(!shared(&text).contains("entry"), "{before}");
        }
        // A label may be jumped to; one call alone gains nothing.
        let label = ["f", "g"].map(|name| function(name, "mov r24, r2\n.L1:\n\tcall _Rh"));
        assert!(!shared(&(label.concat() + &called)).contains("entry"));
        let alone = function("f", "mov r24, r2; call _Rh") + &called;
        assert!(!shared(&alone).contains("entry"));
    }
}
