//! A branch over a jump becomes a branch.
//!
//! ```text
//!   breq .L7                 brne .L9
//!   rjmp .L9            →  .L7:
//! .L7:
//! ```
//!
//! A branch reaches 63 words, and LLVM does without where it is not sure. Where `.L9` is further
//! away, another `rjmp .L9` within reach does as well: the branch goes there. Distances are those
//! of the code as it stands, with calls of two words; it only becomes shorter.
//!
//! **Gain**: 2 bytes each, and a cycle. No register and no flag is touched.

use std::collections::HashMap;

use super::asm::{Code, Function, Line, Program};
use super::flow::code;
use super::machine::skips;

/// Words that a branch reaches forward; backward it is one more.
const REACH: i32 = 63;

/// Turns the branches of all functions.
pub fn turn(program: &mut Program) {
    let mut islands = 0;
    for function in program.functions_mut() {
        while turn_first(function, &mut islands, false) {}
        while turn_first(function, &mut islands, true) {}
    }
}

/// Turns the first branch of a function that can be turned; by way of another jump if `far`.
/// Whether there was one.
fn turn_first(function: &mut Function, islands: &mut usize, far: bool) -> bool {
    let lines = &function.lines;
    let (at, labels) = places(lines);
    for n in 0..lines.len().saturating_sub(2) {
        let [Line::Code(branch), Line::Code(jump), Line::Label(next)] = &lines[n..n + 3] else {
            continue;
        };
        let Some(other) = opposite(&branch.name) else { continue };
        let skipped = n.checked_sub(1).and_then(|n| code(&lines[n])).is_some_and(skips);
        if jump.name != "rjmp" || branch.operands != *next || skipped {
            continue;
        }
        let reaches = |to: i32| (-REACH - 1..=REACH).contains(&(to - at[n] - 1));
        let goal = jump.operands.clone();
        if labels.get(&*goal).is_some_and(|to| reaches(*to)) {
            let turned = Line::Code(Code { name: other.into(), operands: goal });
            function.lines.splice(n..n + 2, [turned]);
            return true;
        }
        if !far {
            continue;
        }
        let way = (0..lines.len()).find(|&to| {
            to != n + 1 && reaches(at[to]) && matches!(&lines[to], Line::Code(code) if code == jump)
        });
        if let Some(way) = way {
            let island = format!(".Lisland_{islands}");
            *islands += 1;
            let turned = Code { name: other.into(), operands: island.clone() };
            // The later one first, so that the earlier stays where it is.
            let label = Line::Label(island);
            if way > n {
                function.lines.insert(way, label);
                function.lines.splice(n..n + 2, [Line::Code(turned)]);
            } else {
                function.lines.splice(n..n + 2, [Line::Code(turned)]);
                function.lines.insert(way, label);
            }
            return true;
        }
    }
    false
}

/// Where each line is, in words, and each label.
fn places(lines: &[Line]) -> (Vec<i32>, HashMap<&str, i32>) {
    let (mut all, mut labels, mut here) = (Vec::new(), HashMap::new(), 0);
    for line in lines {
        all.push(here);
        match line {
            Line::Label(label) => {
                labels.insert(&**label, here);
            }
            Line::Code(code) => here += words(&code.name),
            // A comment, or an instruction of a person's; what repeats itself may be long.
            Line::Other(text) => {
                here += match text.trim().chars().next() {
                    None | Some(';') => 0,
                    Some('.') => 1000,
                    Some(_) => 2,
                }
            }
        }
    }
    (all, labels)
}

/// Words of an instruction, at most.
pub fn words(name: &str) -> i32 {
    match name {
        "call" | "jmp" | "lds" | "sts" => 2,
        _ => 1,
    }
}

/// The branch that goes where this one does not.
pub fn opposite(name: &str) -> Option<&'static str> {
    const PAIRS: [(&str, &str); 6] = [
        ("breq", "brne"),
        ("brlo", "brsh"),
        ("brcs", "brcc"),
        ("brmi", "brpl"),
        ("brlt", "brge"),
        ("brts", "brtc"),
    ];
    PAIRS.iter().find_map(|&(a, b)| match name {
        _ if name == a => Some(b),
        _ if name == b => Some(a),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What becomes of a function of these lines.
    fn turned(body: &str) -> Vec<String> {
        let text = format!("\t.type\tf,@function\nf:\n{body}\n.Lfunc_end0:\n");
        let mut program = Program::parse(&text);
        turn(&mut program);
        let function = program.functions_mut().next().expect("a function");
        let lines = function.lines.iter().skip(1);
        lines
            .map(|line| match line {
                Line::Label(label) => format!("{label}:"),
                Line::Code(code) => format!("{} {}", code.name, code.operands).trim().into(),
                Line::Other(text) => text.clone(),
            })
            .filter(|line| line != "nop")
            .collect()
    }

    fn nops(count: usize) -> String {
        "\tnop\n".repeat(count)
    }

    #[test]
    fn a_branch_over_a_jump_is_turned() {
        let body = format!("\tbreq\t.L7\n\trjmp\t.L9\n.L7:\n{}.L9:\n\tret", nops(62));
        assert_eq!(turned(&body), ["brne .L9", ".L7:", ".L9:", "ret"]);
        let body = format!(".L9:\n{}\tbrlo\t.L7\n\trjmp\t.L9\n.L7:\n\tret", nops(63));
        assert_eq!(turned(&body), [".L9:", "brsh .L9", ".L7:", "ret"]);
    }

    #[test]
    fn out_of_reach_it_stays() {
        for (before, behind) in [(0, 63), (64, 0)] {
            let label = if before > 0 { (".L9:\n", "") } else { ("", ".L9:\n") };
            let body = format!(
                "{}{}\tbreq\t.L7\n\trjmp\t.L9\n.L7:\n{}{}\tret",
                label.0,
                nops(before),
                nops(behind),
                label.1
            );
            assert!(turned(&body).contains(&"rjmp .L9".to_string()), "{before} {behind}");
        }
    }

    #[test]
    fn far_away_another_jump_within_reach_is_the_way() {
        let body = format!(
            "\tbreq\t.L7\n\trjmp\t.L9\n.L7:\n{}\trjmp\t.L9\n{}.L9:\n\tret",
            nops(20),
            nops(200)
        );
        let expected = ["brne .Lisland_0", ".L7:", ".Lisland_0:", "rjmp .L9", ".L9:", "ret"];
        assert_eq!(turned(&body), expected);
    }

    #[test]
    fn two_jumps_are_not_each_others_way() {
        let two = "\tbreq\t.L1\n\trjmp\t.L9\n.L1:\n\tbreq\t.L2\n\trjmp\t.L9\n.L2:\n";
        let lines = turned(&format!("{two}{}.L9:\n\tret", nops(200)));
        assert_eq!(lines.iter().filter(|line| *line == "rjmp .L9").count(), 1);
    }

    #[test]
    fn a_branch_that_may_be_skipped_stays() {
        let lines = turned("\tsbrc\tr24, 0\n\tbreq\t.L7\n\trjmp\t.L9\n.L7:\n.L9:\n\tret");
        assert_eq!(lines, ["sbrc r24, 0", "breq .L7", "rjmp .L9", ".L7:", ".L9:", "ret"]);
    }

    #[test]
    fn a_persons_code_counts_as_long() {
        let by_hand = "\t;APP\n\t.rept 99\n\tnop\n\t.endr\n\t;NO_APP\n";
        let lines = turned(&format!("\tbreq\t.L7\n\trjmp\t.L9\n.L7:\n{by_hand}.L9:\n\tret"));
        assert!(lines.contains(&"rjmp .L9".to_string()));
    }
}
