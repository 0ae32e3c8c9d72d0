//! The control flow of a function, line by line, and the registers and flags that are read later.

use std::collections::HashMap;

use super::asm::{Function, Line, instruction};
use super::calls::Calls;
use super::effects::{Effect, GIVEN, Kind, NOTHING, Set, TAKEN, UNKNOWN, effect};

/// The control flow of a function.
#[derive(Debug)]
pub(crate) struct Flow {
    /// The effect of each line.
    pub effects: Vec<Effect>,
    /// The lines that may follow each line.
    pub next: Vec<Vec<usize>>,
    /// The lines that may precede each line.
    pub before: Vec<Vec<usize>>,
    /// The registers and flags that are read after each line.
    pub live: Vec<Set>,
}

impl Flow {
    /// The control flow of a function; `None` if it has an unknown instruction.
    pub fn of(function: &Function, calls: &Calls) -> Option<Flow> {
        let lines = &function.lines;
        let mut labels = HashMap::new();
        for (n, line) in lines.iter().enumerate() {
            if let Line::Label(name) = line {
                labels.insert(name.as_str(), n);
            }
        }
        let mut flow = Flow {
            effects: Vec::new(),
            next: Vec::new(),
            before: vec![Vec::new(); lines.len()],
            live: vec![0; lines.len()],
        };
        for (n, line) in lines.iter().enumerate() {
            let effect = match line {
                Line::Label(_) => NOTHING,
                Line::Code(code) => {
                    let effect = effect(code)?;
                    let reads = match &*code.name {
                        "call" if !code.a.starts_with("__") => {
                            effect.reads & !TAKEN | calls.taken(&code.a)
                        }
                        "ret" => effect.reads & !GIVEN | calls.given(&function.name),
                        _ => effect.reads,
                    };
                    Effect { reads, ..effect }
                }
                Line::Other(text) => by_hand(text),
            };
            let target = || labels.get(&*line.code()?.a).copied();
            let mut next = match effect.kind {
                Kind::Plain | Kind::Outward => vec![n + 1],
                Kind::Branch => vec![target()?, n + 1],
                Kind::Jump => vec![target()?],
                // What it skips must be one instruction.
                Kind::Skip => lines.get(n + 1)?.code().map(|_| vec![n + 1, n + 2])?,
                Kind::Leave => Vec::new(),
            };
            // A function that never returns may end in a call.
            next.retain(|&next| next < lines.len());
            next.iter().for_each(|&next| flow.before[next].push(n));
            flow.next.push(next);
            flow.effects.push(effect);
        }
        let mut changed = true;
        while changed {
            changed = false;
            for n in (0..lines.len()).rev() {
                let live = flow.next[n].iter().fold(0, |set, &next| set | flow.needs(next));
                changed |= flow.live[n] != live;
                flow.live[n] = live;
            }
        }
        Some(flow)
    }

    /// The registers and flags that are read from a line on.
    pub fn needs(&self, line: usize) -> Set {
        let effect = self.effects[line];
        self.live[line] & !effect.sure | effect.reads
    }
}

/// The effect of a hand-written line: none for a comment. It may write everything; its reads are
/// known if the instruction is.
fn by_hand(text: &str) -> Effect {
    let text = text.trim();
    if text.starts_with(';') {
        return NOTHING;
    }
    let known = instruction(text).filter(|code| !matches!(&*code.name, "call" | "push" | "pop"));
    let known = known.and_then(|code| effect(&code));
    let known = known.filter(|effect| matches!(effect.kind, Kind::Plain | Kind::Outward));
    Effect { reads: known.map_or(UNKNOWN.reads, |effect| effect.reads), ..UNKNOWN }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::asm::Program;

    /// A function of these lines.
    fn function(body: &str) -> Function {
        let text = format!("\t.type\tf,@function\nf:\n{body}\n.Lfunc_end0:\n");
        Program::parse(&text).functions_mut().next().expect("a function").clone()
    }

    fn reads(set: Set, register: u8) -> bool {
        set >> register & 1 != 0
    }

    #[test]
    fn lines_follow_each_other_as_the_branches_say() {
        let body = "ldi r18, 9\n.L1:\nsbrc r18, 0\ndec r18\nbrne .L1\nrjmp .L3\n.L3:\nret";
        let flow = Flow::of(&function(body), &Calls::default()).unwrap();
        let next: [&[usize]; 9] = [&[1], &[2], &[3], &[4, 5], &[5], &[2, 6], &[7], &[8], &[]];
        assert_eq!(flow.next, next);
        assert_eq!(flow.before[2], [1, 5]);
        assert_eq!(flow.before[5], [3, 4]);
    }

    #[test]
    fn what_a_loop_reads_is_read_later() {
        let body = "ldi r26, 9\nldi r27, 9\n.L1:\nout 10, r26\nldi r27, 1\nbrne .L1\nret";
        let live = Flow::of(&function(body), &Calls::default()).unwrap().live;
        // After the second line: the loop reads r26, and overwrites r27.
        assert!(reads(live[2], 26) && !reads(live[2], 27));
        // After the branch the loop may begin again.
        assert!(reads(live[6], 26) && !reads(live[6], 27));
    }

    #[test]
    fn what_may_be_skipped_overwrites_nothing_for_sure() {
        let body = "ldi r26, 1\nsbrc r20, 0\nldi r26, 2\nout 10, r26\nret";
        let flow = Flow::of(&function(body), &Calls::default()).unwrap();
        assert!(reads(flow.live[1], 26));
    }

    #[test]
    fn a_persons_instruction_reads_what_it_says() {
        let body = |by_hand: &str| {
            let function = function(&format!("ldi r26, 1\n;APP\n{by_hand}\n;NO_APP\nret"));
            reads(Flow::of(&function, &Calls::default()).unwrap().live[1], 26)
        };
        assert!(!body("wdr") && !body("in r24, 63\ncli") && body("mov r0, r26"));
        // It does not certainly overwrite a register either: it may be skipped.
        assert!(body("ldi r26, 2\nmov r0, r26"));
        for unknown in ["call g", "2: dec r20", "brne 2b", "des 3", "sbrc r20, 0", "push r20"] {
            assert!(body(unknown), "{unknown}");
        }
    }

    #[test]
    fn what_is_not_understood_has_no_flow() {
        for body in ["des 3\nret", "sbrc r20, 0\n.L1:\nret", "brne .L9\nret"] {
            assert!(Flow::of(&function(body), &Calls::default()).is_none(), "{body}");
        }
    }
}
