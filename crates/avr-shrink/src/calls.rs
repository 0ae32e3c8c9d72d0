//! The registers that calls pass: those that a function reads of its caller's, and those of its
//! result that a caller reads.
//!
//! By the convention a call reads r8 to r25 and a return r18 to r25. Most functions use two or four
//! of them, and the values in the others are not needed.
//!
//! Both sets are computed as a fixed point from below: they grow until no function reads more. No
//! stage makes a function read a register that it did not read before, so the sets stay on the safe
//! side.
//!
//! A hand-written function reads all of them, unless a comment says which:
//!
//! ```text
//! ; half takes r24 r25
//! ```
//!
//! The reads after a return are unknown for a function that others may call: its name occurs
//! somewhere other than in a call by the compiler's code, or it is never called.

use std::collections::{HashMap, HashSet};

use super::asm::{Function, Line, Part, Program};
use super::effects::{GIVEN, Set, TAKEN, register};
use super::flow::Flow;

/// The registers that the functions of a program read and return, as far as known.
#[derive(Debug, Default)]
pub(crate) struct Calls {
    said: HashMap<String, Set>,
    taken: HashMap<String, Set>,
    given: HashMap<String, Set>,
}

impl Calls {
    /// The sets of a program.
    pub fn of(program: &mut Program) -> Calls {
        let open = open(program);
        let mut calls = Calls { said: said(&program.to_string()), ..Calls::default() };
        for function in program.functions_mut() {
            // A function whose flow is not known reads everything.
            if Flow::of(function, &calls).is_some() {
                calls.taken.insert(function.name.clone(), 0);
            }
            if !open.contains(&function.name) {
                calls.given.insert(function.name.clone(), 0);
            }
        }
        while program.functions_mut().fold(false, |more, function| calls.look(function) | more) {}
        calls
    }

    /// Examines a function once. Returns whether it reads more than was known.
    fn look(&mut self, function: &Function) -> bool {
        let Some(flow) = Flow::of(function, self) else { return false };
        let mut more = false;
        let mut add = |sets: &mut HashMap<String, Set>, name: &str, read: Set| {
            if let Some(set) = sets.get_mut(name) {
                more |= read & GIVEN & !*set != 0;
                *set |= read & GIVEN;
            }
        };
        // The first line is the label.
        add(&mut self.taken, &function.name, flow.live[0]);
        for (n, code) in function.code().filter(|(_, code)| code.name == "call") {
            add(&mut self.given, &code.a, flow.live[n]);
        }
        more
    }

    /// The registers that a call of this function reads.
    pub fn taken(&self, name: &str) -> Set {
        // Those below `GIVEN` are also preserved, so a return appears to read them.
        let found = self.taken.get(name).map(|taken| taken | TAKEN & !GIVEN);
        self.said.get(name).copied().or(found).unwrap_or(TAKEN)
    }

    /// The registers that are read after a return of this function.
    pub fn given(&self, name: &str) -> Set {
        self.given.get(name).copied().unwrap_or(GIVEN)
    }
}

/// The registers in comments of hand-written functions.
fn said(text: &str) -> HashMap<String, Set> {
    let said = text.lines().filter_map(|line| {
        let mut words = line.split_once(';')?.1.split_whitespace();
        let name = words.next()?;
        let takes = words.next() == Some("takes");
        let set = words.filter_map(register).fold(0, |set, register| set | 1 << register);
        takes.then(|| (name.to_string(), set))
    });
    said.collect()
}

/// The functions that code other than the compiler's may call.
fn open(program: &mut Program) -> HashSet<String> {
    let (mut open, mut called) = (HashSet::new(), HashSet::new());
    for part in &program.parts {
        match part {
            Part::Text(lines) => lines.iter().for_each(|line| mentions(line, &mut open)),
            Part::Function(function) => {
                let known = Flow::of(function, &Calls::default()).is_some();
                for line in &function.lines {
                    match line {
                        Line::Label(_) => {}
                        Line::Code(code) if known && code.name == "call" => {
                            called.insert(code.a.clone());
                        }
                        Line::Code(code) => mentions(&code.to_string(), &mut open),
                        Line::Other(text) => mentions(text, &mut open),
                    }
                }
            }
        }
    }
    let names = program.functions_mut().map(|function| function.name.clone());
    names.filter(|name| open.contains(name) || !called.contains(name)).collect()
}

/// Collects the names in a text, except in directives that only declare them.
fn mentions(text: &str, names: &mut HashSet<String>) {
    let directive = text.split_whitespace().next();
    if matches!(directive, Some(".type" | ".size" | ".section")) {
        return;
    }
    let part = |c: char| !(c.is_ascii_alphanumeric() || "_.$".contains(c));
    names.extend(text.split(part).filter(|name| !name.is_empty()).map(String::from));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(functions: &[(&str, &str)], text: &str) -> Program {
        let function = |(name, body): &(&str, &str)| {
            let body = body.replace("; ", "\n\t");
            format!("\t.type\t{name},@function\n{name}:\n\t{body}\n.Lfunc_end:\n")
        };
        let functions: String = functions.iter().map(function).collect();
        Program::parse(&format!("{functions}{text}"))
    }

    fn span(from: u8, to: u8) -> Set {
        (from..=to).fold(0, |set, register| set | 1 << register)
    }

    #[test]
    fn a_function_takes_what_it_reads_and_gives_what_is_read() {
        let mut program = program(
            &[
                ("a", "call b; sts M, r24\n.L1:; rjmp .L1"),
                ("b", "push r16; mov r16, r22; call c; mov r24, r16; pop r16; ret"),
                ("c", "sts M, r20; ret"),
            ],
            "",
        );
        let calls = Calls::of(&mut program);
        // And registers that may be preserved.
        let low = span(8, 17);
        assert_eq!(calls.taken("b"), low | 1 << 20 | 1 << 22);
        assert_eq!(calls.taken("c"), low | 1 << 20);
        assert_eq!((calls.given("b"), calls.given("c")), (1 << 24, 0));
        // Nothing calls a.
        assert_eq!(calls.given("a"), GIVEN);
        assert_eq!((calls.taken("d"), calls.given("d")), (TAKEN, GIVEN));
    }

    #[test]
    fn what_others_may_call_gives_everything() {
        let both = [("a", "call b; sts M, r1; ret"), ("b", "ldi r24, 1; ret")];
        for text in ["\tcall\tb", "\t.word\tgs(b)", "\t.globl\tb", "\tldi\tr30, lo8(gs(b))"] {
            assert_eq!(Calls::of(&mut program(&both, text)).given("b"), GIVEN, "{text}");
        }
        let by_hand = [("a", "call b\n\t;APP\n\tcall b\n\t;NO_APP\n\tret"), both[1]];
        assert_eq!(Calls::of(&mut program(&by_hand, "")).given("b"), GIVEN);
        let unknown = [("a", "des 1; call b; ret"), both[1]];
        assert_eq!(Calls::of(&mut program(&unknown, "")).given("b"), GIVEN);
        let jumps = [both[0], both[1], ("c", "jmp b")];
        assert_eq!(Calls::of(&mut program(&jumps, "")).given("b"), GIVEN);
    }

    #[test]
    fn a_function_by_hand_says_what_it_takes() {
        let text = "\t; half takes r24 r25\nhalf:\n\tlsr\tr25\n\tror\tr24\n\tret\n";
        let calls = Calls::of(&mut program(&[("a", "call half; ret")], text));
        assert_eq!((calls.taken("half"), calls.given("half")), (span(24, 25), GIVEN));
    }
}
