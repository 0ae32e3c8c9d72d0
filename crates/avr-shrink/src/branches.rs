//! Turns a branch over a jump into a branch.
//!
//! ```text
//!   breq .L7                 brne .L9
//!   rjmp .L9            →  .L7:
//! .L7:
//! ```
//!
//! A branch reaches 63 words, and LLVM avoids it if the distance is not certain. The distances here
//! are those of the present code, with calls of two words; the code can only become shorter.
//!
//! A call before a return becomes a jump, in a function that saves no registers and so has none to
//! restore.
//!
//! **Gain**: 2 bytes each, and a cycle; for a return 4 cycles, and its place on the stack. No
//! register and no flag is changed.

use super::asm::{Code, Function, Line, Program};

/// The words that a branch reaches forward; backward one more.
const REACH: i32 = 63;

/// Turns the branches of all functions.
pub(crate) fn turn(program: &mut Program) {
    for function in program.functions_mut() {
        while turn_first(function) {}
        end_in_calls(function);
    }
}

/// Replaces a call before a return by a jump.
fn end_in_calls(function: &mut Function) {
    if function.code().any(|(_, code)| code.name == "push") {
        return;
    }
    for n in (1..function.lines.len().saturating_sub(1)).rev() {
        let [Line::Code(call), Line::Code(end)] = &function.lines[n..n + 2] else { continue };
        if call.name == "call" && end.name == "ret" && !function.is_skipped(n) {
            let jump = Code { name: "jmp".into(), ..call.clone() };
            function.lines.splice(n..n + 2, [Line::Code(jump)]);
        }
    }
}

/// Turns the first branch of a function that can be turned. Returns whether there was one.
fn turn_first(function: &mut Function) -> bool {
    let lines = &function.lines;
    let at = |line: usize| lines[..line].iter().map(words).sum::<i32>();
    for n in 0..lines.len().saturating_sub(2) {
        let [Line::Code(branch), Line::Code(jump), Line::Label(next)] = &lines[n..n + 3] else {
            continue;
        };
        let Some(other) = opposite(&branch.name) else { continue };
        if jump.name != "rjmp" || branch.a != *next || function.is_skipped(n) {
            continue;
        }
        let target = lines.iter().position(|line| *line == Line::Label(jump.a.clone()));
        if target.is_some_and(|to| (-REACH - 1..=REACH).contains(&(at(to) - at(n) - 1))) {
            let turned = Code { name: other.into(), ..jump.clone() };
            function.lines.splice(n..n + 2, [Line::Code(turned)]);
            return true;
        }
    }
    false
}

/// The most words that a line takes.
fn words(line: &Line) -> i32 {
    match line {
        Line::Label(_) => 0,
        Line::Code(code) => code.words(),
        // A comment, or a hand-written instruction; repetition may make it long.
        Line::Other(text) => match text.trim().chars().next() {
            None | Some(';') => 0,
            Some('.') => 1000,
            Some(_) => 2,
        },
    }
}

/// The branch with the opposite condition.
pub(crate) fn opposite(name: &str) -> Option<&'static str> {
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

    /// A function of these lines, after the pass.
    fn turned(body: &str) -> Vec<String> {
        let text = format!("\t.type\tf,@function\nf:\n{body}\n.Lfunc_end0:\n");
        let mut program = Program::parse(&text);
        turn(&mut program);
        let function = program.functions_mut().next().expect("a function");
        let lines = function.lines.iter().skip(1);
        lines
            .map(|line| match line {
                Line::Label(label) => format!("{label}:"),
                Line::Code(code) => crate::tests::plain(code),
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
    fn a_call_before_a_return_is_a_jump() {
        assert_eq!(turned("\tcall\tg\n\tcall\tg\n\tret"), ["call g", "jmp g"]);
        for body in [
            "push r16; call g; pop r16; call g; ret",
            "sbrc r24, 0; call g; ret",
            "call g; nop; ret",
        ] {
            let lines = turned(&body.replace("; ", "\n"));
            assert!(lines.contains(&"ret".into()), "{lines:?}");
        }
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
