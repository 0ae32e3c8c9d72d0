//! A condition that is asked twice for two halves of a number is asked once.
//!
//! ```text
//!   tst  r11                 tst  r11
//!   brmi .L1                 movw r16, r2
//!   movw r20, r8             brmi .L2
//! .L1:                 →     movw r20, r8
//!   tst  r11                 movw r22, r10
//!   movw r16, r2           .L2:
//!   brmi .L2
//!   movw r22, r10
//! .L2:
//! ```
//!
//! What stands between the two is made before both, if it has nothing to do with the first half.

use super::asm::{Code, Function, Line, Program};
use super::branches::opposite;
use super::flow::{Flow, code};
use super::machine::{Effect, FLAGS, Kind, Taken, register};

/// Goes through all functions.
pub fn join(program: &mut Program, taken: &Taken) {
    for function in program.functions_mut() {
        while joined(function, taken) || in_one_go(function, taken) {}
    }
}

/// Joins two of a function. Whether there were two.
fn joined(function: &mut Function, taken: &Taken) -> bool {
    let Some(flow) = Flow::of(function, taken) else { return false };
    for n in 0..function.lines.len() {
        if let Some(twice) = Twice::at(function, &flow, n) {
            twice.replace(function, n);
            return true;
        }
    }
    false
}

/// Two branches by one condition.
struct Twice {
    /// The label between.
    label: usize,
    /// The second test; none if the flags still say.
    test: Option<usize>,
    /// The second branch.
    branch: usize,
}

impl Twice {
    /// At the line of the first branch.
    fn at(function: &Function, flow: &Flow, n: usize) -> Option<Twice> {
        let lines = &function.lines;
        let first = code(&lines[n])?;
        opposite(&first.name)?;
        let quiet = |effect: Effect| {
            matches!(effect.kind, Kind::Plain | Kind::Outward)
                && (effect.reads | effect.writes) & FLAGS == 0
        };
        // What is done where it is not taken.
        let mut label = n + 1;
        let (mut reads, mut writes) = (0, 0);
        while let Line::Code(_) = lines.get(label)? {
            let effect = flow.effects[label]?;
            if effect.kind != Kind::Plain || !quiet(effect) {
                return None;
            }
            (reads, writes) = (reads | effect.reads, writes | effect.writes);
            label += 1;
        }
        let Line::Label(name) = &lines[label] else { return None };
        let comes = |line: &Line| code(line).is_some_and(|code| code.operands == *name);
        if *name != first.operands || lines.iter().filter(|line| comes(line)).count() != 1 {
            return None;
        }
        // What has been asked.
        let mut asked = n;
        let mut changed = writes;
        let question = loop {
            asked = asked.checked_sub(1)?;
            let effect = flow.effects[asked]?;
            if effect.writes & FLAGS != 0 {
                break code(&lines[asked])?;
            }
            if !quiet(effect) {
                return None;
            }
            changed |= effect.writes;
        };
        let mut test = None;
        let mut ahead = label + 1;
        loop {
            let effect = flow.effects[ahead]?;
            let line = code(&lines[ahead])?;
            if effect.kind == Kind::Branch {
                break;
            }
            if line == question && test.is_none() {
                let simple = ["tst", "cpi"].contains(&&*line.name);
                if !simple || effect.reads & changed != 0 {
                    return None;
                }
                test = Some(ahead);
            } else if !quiet(effect)
                || effect.writes & (reads | writes) != 0
                || effect.reads & writes != 0
            {
                return None;
            } else {
                changed |= effect.writes;
            }
            ahead += 1;
        }
        (code(&lines[ahead])?.name == first.name).then_some(Twice { label, test, branch: ahead })
    }

    /// Joins them.
    fn replace(self, function: &mut Function, n: usize) {
        let lines = &mut function.lines;
        let first: Vec<Line> = lines[n + 1..self.label].to_vec();
        let between = (self.label + 1..=self.branch).filter(|at| Some(*at) != self.test);
        let mut new: Vec<Line> = between.map(|at| lines[at].clone()).collect();
        new.extend(first);
        lines.splice(n..=self.branch, new);
    }
}

/// Two bytes are compared with 0 in one go. Whether there was such a place.
///
/// ```text
///   cp r26, r1; cpc r27, r1; breq   →   sbiw r26, 0; breq
///   cp r18, r1; cpc r19, r1; breq   →   or r18, r19; breq, if nobody reads r18 any more
/// ```
fn in_one_go(function: &mut Function, taken: &Taken) -> bool {
    let Some(flow) = Flow::of(function, taken) else { return false };
    let live = flow.live();
    for n in 0..function.lines.len().saturating_sub(2) {
        let [Some(low), Some(high), Some(branch)] =
            [n, n + 1, n + 2].map(|n| code(&function.lines[n]))
        else {
            continue;
        };
        let new = || {
            let a = register(low.operands.strip_suffix(", r1")?)?;
            let b = register(high.operands.strip_suffix(", r1")?)?;
            let asks = ["breq", "brne"].contains(&&*branch.name);
            if low.name != "cp" || high.name != "cpc" || !asks || a == b || flow.pinned[n] {
                return None;
            }
            let free = live[n + 1] >> a & 1 == 0 && live[n + 2] & FLAGS == 0;
            if a >= 24 && a % 2 == 0 && b == a + 1 {
                Some(Code { name: "sbiw".into(), operands: format!("r{a}, 0") })
            } else {
                free.then(|| Code { name: "or".into(), operands: format!("r{a}, r{b}") })
            }
        };
        if let Some(new) = new() {
            function.lines.splice(n..n + 2, [Line::Code(new)]);
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::super::tests;
    use super::*;

    fn left(body: &str) -> String {
        tests::left(body, join)
    }

    #[test]
    fn two_bytes_are_compared_in_one_go() {
        assert_eq!(left("cp r26, r1; cpc r27, r1; brne .L7"), "sbiw r26, 0; brne .L7");
        assert_eq!(left("cp r30, r1; cpc r18, r1; brne .L7"), "or r30, r18; brne .L7");
    }

    #[test]
    fn what_is_not_of_that_form_stays() {
        for stays in [
            // The byte is read behind it.
            "cp r22, r1; cpc r23, r1; breq .L7",
            "cp r24, r1; cpc r26, r1; breq .L7",
            // Not 0, or another question.
            "cp r24, r2; cpc r25, r2; breq .L7",
            "cp r24, r1; cpc r25, r1; brlt .L7",
        ] {
            assert_eq!(left(stays), stays);
        }
    }

    #[test]
    fn one_branch_does_for_both_halves() {
        let twice = "cpi r24, 0; brne .L1; movw r20, r8\n.L1:; cpi r24, 0; movw r16, r2; \
                     brne .L2; movw r22, r10\n.L2:";
        let once = "cpi r24, 0; movw r16, r2; brne .L2; movw r20, r8; movw r22, r10";
        assert_eq!(left(twice), once);
        // What is between has to do with the first half.
        let between = twice.replace("r16, r2", "r16, r20");
        assert!(left(&between).contains("brne .L1"));
        // It is another question.
        let other = twice.replace("\n.L1:; cpi r24, 0", "\n.L1:; cpi r24, 1");
        assert!(left(&other).contains("brne .L1"));
    }
}
