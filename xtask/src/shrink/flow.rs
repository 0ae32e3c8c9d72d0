//! The ways through a function: its blocks, and what is read later.

use std::collections::HashMap;

use super::asm::{Code, Function, Line, Program};
use super::machine::{self, EVERYTHING, Effect, Kind, Set, Taken};

/// Lines that follow each other, with one way in and the ways out at their end.
#[derive(Debug)]
pub struct Block {
    pub lines: std::ops::Range<usize>,
    /// Blocks that follow.
    pub next: Vec<usize>,
    /// Blocks before it.
    pub before: Vec<usize>,
}

/// A function's blocks.
#[derive(Debug)]
pub struct Flow {
    pub blocks: Vec<Block>,
    /// What each line does; none for labels.
    pub effects: Vec<Option<Effect>>,
    /// Lines behind one that may skip them: they stay as they are.
    pub pinned: Vec<bool>,
}

impl Flow {
    /// The ways through a function; none if it has an instruction that is not known.
    pub fn of(function: &Function, taken: &Taken) -> Option<Flow> {
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
                    Some(machine::effect(code, |label| labels.contains_key(label), taken)?)
                }
                // Whatever a person wrote.
                Line::Other(_) => Some(Effect {
                    kind: Kind::Outward,
                    reads: EVERYTHING,
                    writes: EVERYTHING,
                    sure: 0,
                }),
            });
        }
        // What a function saves is of no use to it: its caller gets it back.
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
            // A function that never ends may end in a call.
            next.retain(|&block| block < blocks.len());
            for &block in &next {
                blocks[block].before.push(index);
            }
            blocks[index].next = next;
        }
        Some(Flow { blocks, effects, pinned })
    }

    /// What is read later, behind each line.
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
}

/// What the functions of a program read of their callers' registers.
pub fn taken(program: &mut Program) -> Taken {
    let mut all = Taken::default();
    // Each time round less is read by calls.
    for _ in 0..3 {
        let mut next = Taken::default();
        for function in program.functions_mut() {
            if let Some(flow) = Flow::of(function, &all) {
                let live = flow.live();
                let before = flow.effects[0].map_or(live[0], |_| EVERYTHING);
                next.no_more(&function.name, before);
            }
        }
        all = next;
    }
    all
}

/// The instruction of a line.
pub fn code(line: &Line) -> Option<&Code> {
    match line {
        Line::Code(code) => Some(code),
        _ => None,
    }
}
