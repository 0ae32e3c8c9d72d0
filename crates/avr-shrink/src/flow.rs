//! The control flow of a function: its blocks, and the registers and flags that are read later.

use std::collections::HashMap;

use super::asm::{Function, Line, instruction};
use super::calls::Calls;
use super::effects::{Effect, GIVEN, Kind, Set, TAKEN, UNKNOWN, effect};

/// Consecutive lines with one entry, and all exits at the end.
#[derive(Debug)]
pub(crate) struct Block {
    pub lines: std::ops::Range<usize>,
    /// The blocks that follow.
    pub next: Vec<usize>,
    /// The blocks before it.
    pub before: Vec<usize>,
}

/// A function's blocks.
#[derive(Debug)]
pub(crate) struct Flow {
    pub blocks: Vec<Block>,
    /// The effect of each line; `None` for labels.
    pub effects: Vec<Option<Effect>>,
    /// The lines after an instruction that may skip them: they are not changed.
    pub pinned: Vec<bool>,
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
        let mut effects = Vec::with_capacity(lines.len());
        for line in lines {
            effects.push(match line {
                Line::Label(_) => None,
                Line::Code(code) => {
                    let mut effect = effect(code)?;
                    match &*code.name {
                        "call" if !code.operands.starts_with("__") => {
                            effect.reads &= !TAKEN;
                            effect.reads |= calls.taken(&code.operands);
                        }
                        "ret" => {
                            effect.reads &= !GIVEN;
                            effect.reads |= calls.given(&function.name);
                        }
                        _ => {}
                    }
                    Some(effect)
                }
                Line::Other(text) => by_hand(text),
            });
        }
        // Saving a register does not use it: the caller gets it back.
        for (effect, line) in effects.iter_mut().zip(lines).skip(1) {
            match (effect, line) {
                (Some(effect), Line::Code(code)) if code.name == "push" => effect.reads = 0,
                _ => break,
            }
        }
        let kind = |n: usize| effects[n].map(|effect: Effect| effect.kind);
        let mut pinned = vec![false; lines.len()];
        let mut begins = vec![false; lines.len() + 1];
        begins[0] = true;
        for n in 0..lines.len() {
            match kind(n) {
                None => begins[n] = true,
                Some(Kind::Branch | Kind::Jump | Kind::Leave) => begins[n + 1] = true,
                Some(Kind::Skip) => {
                    if !matches!(lines.get(n + 1), Some(Line::Code(_))) {
                        return None;
                    }
                    begins[n + 1] = true;
                    *begins.get_mut(n + 2)? = true;
                    pinned[n + 1] = true;
                }
                _ => {}
            }
        }
        let starts: Vec<usize> = (0..lines.len()).filter(|&n| begins[n]).collect();
        let mut at = vec![0; lines.len()];
        let mut blocks = Vec::new();
        for (index, &start) in starts.iter().enumerate() {
            let end = starts.get(index + 1).copied().unwrap_or(lines.len());
            at[start..end].fill(index);
            blocks.push(Block { lines: start..end, next: Vec::new(), before: Vec::new() });
        }
        for index in 0..blocks.len() {
            let last = blocks[index].lines.end - 1;
            let target = || match &lines[last] {
                Line::Code(code) => labels.get(code.operands.as_str()).map(|&n| at[n]),
                _ => None,
            };
            let mut next = Vec::new();
            match kind(last) {
                Some(Kind::Leave) => {}
                Some(Kind::Jump) => next.push(target()?),
                Some(Kind::Branch) => next.extend([target()?, index + 1]),
                Some(Kind::Skip) => next.extend([index + 1, index + 2]),
                _ => next.push(index + 1),
            }
            // A function that never returns may end in a call.
            next.retain(|&block| block < blocks.len());
            for &block in &next {
                blocks[block].before.push(index);
            }
            blocks[index].next = next;
        }
        Some(Flow { blocks, effects, pinned })
    }

    /// The registers and flags that are read after each line.
    pub fn live(&self) -> Vec<Set> {
        let mut begin = vec![0; self.blocks.len()];
        let mut behind = vec![0; self.effects.len()];
        let mut changed = true;
        while changed {
            changed = false;
            for (index, block) in self.blocks.iter().enumerate().rev() {
                let mut live = block.next.iter().fold(0, |live, &next| live | begin[next]);
                for n in block.lines.clone().rev() {
                    behind[n] = live;
                    if let Some(effect) = self.effects[n] {
                        live = live & !effect.sure | effect.reads;
                    }
                }
                changed |= begin[index] != live;
                begin[index] = live;
            }
        }
        behind
    }

    /// Whether r1 is certainly 0 at a line: a product changes it until it is cleared. Hand-written
    /// assembly leaves it 0.
    pub fn has_zero(&self, function: &Function, line: usize) -> bool {
        let zero = |lines: std::ops::Range<usize>| {
            function.lines[lines.clone()].iter().zip(lines).fold(true, |zero, (text, n)| {
                let code = text.code().zip(self.effects[n]);
                match code.filter(|(_, effect)| effect.writes & 2 != 0) {
                    Some((code, _)) => code.is("clr r1") || code.is("eor r1, r1"),
                    None => zero,
                }
            })
        };
        let here = self.blocks.iter().find(|block| block.lines.contains(&line));
        self.blocks.iter().all(|block| zero(block.lines.clone()))
            && here.is_some_and(|block| zero(block.lines.start..line))
    }
}

/// The effect of a hand-written line: none for a comment. It may write everything; its reads are
/// known if the instruction is.
fn by_hand(text: &str) -> Option<Effect> {
    let text = text.trim();
    if text.starts_with(';') {
        return None;
    }
    let known = instruction(text).filter(|code| !matches!(&*code.name, "call" | "push" | "pop"));
    let known = known.and_then(|code| effect(&code));
    let known = known.filter(|effect| matches!(effect.kind, Kind::Plain | Kind::Outward));
    Some(Effect { reads: known.map_or(UNKNOWN.reads, |effect| effect.reads), ..UNKNOWN })
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
    fn blocks_follow_each_other_as_the_branches_say() {
        let body = "ldi r18, 9\n.L1:\ndec r18\nbrne .L1\nrjmp .L3\n.L2:\nnop\n.L3:\nret";
        let flow = Flow::of(&function(body), &Calls::default()).unwrap();
        let next: Vec<_> = flow.blocks.iter().map(|block| block.next.clone()).collect();
        // f, the loop, its end, an unreachable block, and the return.
        assert_eq!(next, [vec![1], vec![1, 2], vec![4], vec![4], vec![]]);
        assert_eq!(flow.blocks[1].before, [0, 1]);
        assert_eq!(flow.blocks[4].before, [2, 3]);
    }

    #[test]
    fn what_a_loop_reads_is_read_later() {
        let body = "ldi r26, 9\nldi r27, 9\n.L1:\nout 10, r26\nldi r27, 1\nbrne .L1\nret";
        let live = Flow::of(&function(body), &Calls::default()).unwrap().live();
        // After the second line: the loop reads r26, and overwrites r27.
        assert!(reads(live[2], 26) && !reads(live[2], 27));
        // After the branch the loop may begin again.
        assert!(reads(live[6], 26) && !reads(live[6], 27));
    }

    #[test]
    fn what_may_be_skipped_is_pinned_and_overwrites_nothing_for_sure() {
        let body = "ldi r26, 1\nsbrc r20, 0\nldi r26, 2\nout 10, r26\nret";
        let flow = Flow::of(&function(body), &Calls::default()).unwrap();
        assert_eq!(flow.pinned, [false, false, false, true, false, false]);
        assert!(reads(flow.live()[1], 26));
    }

    #[test]
    fn a_persons_instruction_reads_what_it_says() {
        let body = |by_hand: &str| {
            let function = function(&format!("ldi r26, 1\n;APP\n{by_hand}\n;NO_APP\nret"));
            reads(Flow::of(&function, &Calls::default()).unwrap().live()[1], 26)
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

    #[test]
    fn what_is_saved_at_the_beginning_is_not_read() {
        let body = "push r16\nldi r16, 1\npush r16\npop r16\npop r16\nret";
        let flow = Flow::of(&function(body), &Calls::default()).unwrap();
        let pushed = [1, 3].map(|n| reads(flow.effects[n].unwrap().reads, 16));
        assert_eq!(pushed, [false, true]);
    }
}
