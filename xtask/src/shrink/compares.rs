//! A comparison with 0 is left out where the flags say it already, or is made in one go.
//!
//! ```text
//!   and r24, r19             and r24, r19
//!   cpi r24, 0           →   breq .L7
//!   breq .L7
//!
//!   cp r26, r1           →   sbiw r26, 0
//!   cpc r27, r1
//! ```
//!
//! In the first form the zero flag is the same, and the carry may not be: whether somebody
//! still reads it is looked up on both ways. In the second, where r1 is 0 as it always is
//! between functions' instructions, all flags that a branch reads are the same.
//!
//! **Gain**: 2 bytes and a cycle each.

use super::asm::{Code, Function, Line, Program};

/// Instructions that are looked at for who reads the flags.
const AHEAD: usize = 24;

/// Goes through all functions.
pub fn leave_out(program: &mut Program) {
    for function in program.functions_mut() {
        let mut n = 0;
        while n + 2 < function.lines.len() {
            if in_one_go(function, n) || known(function, n) {
                function.lines.remove(n + 1);
            }
            n += 1;
        }
    }
}

/// Whether a comparison of 16 bits with 0 begins here; it is made one of one instruction,
/// and the next line is to go.
fn in_one_go(function: &mut Function, n: usize) -> bool {
    let [Line::Code(low), Line::Code(high), Line::Code(branch)] = &function.lines[n..n + 3] else {
        return false;
    };
    let pair = ["r24, r25", "r26, r27", "r28, r29", "r30, r31"].iter().find(|pair| {
        let (a, b) = pair.split_at(3);
        low.is(&format!("cp {a}, r1")) && high.is(&format!("cpc {}, r1", &b[2..]))
    });
    let Some(pair) = pair else { return false };
    if !equality(branch) {
        return false;
    }
    function.lines[n] = Line::Code(Code::parse(&format!("sbiw {}, 0", &pair[..3])));
    true
}

/// Whether the line behind this one compares with 0 what this one has computed, for a branch
/// that asks for no more.
fn known(function: &Function, n: usize) -> bool {
    let lines = &function.lines;
    let [Line::Code(computed), Line::Code(compared), Line::Code(branch)] = &lines[n..n + 3] else {
        return false;
    };
    // Not those with a carry: their zero flag is that of all bytes so far.
    let sets =
        ["and", "andi", "or", "ori", "eor", "add", "sub", "subi", "inc", "dec", "lsr", "lsl"];
    let register = computed.operands.split(',').next().unwrap_or("");
    let ways = || {
        let target = Line::Label(branch.operands.clone());
        let there = lines.iter().position(|line| *line == target);
        there.is_some_and(|there| unread(lines, there)) && unread(lines, n + 3)
    };
    sets.contains(&&*computed.name)
        && compared.is(&format!("cpi {register}, 0"))
        && equality(branch)
        && ways()
}

/// Whether it branches by the zero flag alone.
fn equality(code: &Code) -> bool {
    ["breq", "brne"].contains(&&*code.name)
}

/// Whether nobody reads the flags from this line on, before they are set again.
fn unread(lines: &[Line], from: usize) -> bool {
    for line in lines.iter().skip(from).take(AHEAD) {
        let code = match line {
            Line::Label(_) => continue,
            Line::Code(code) => code,
            Line::Other(_) => return false,
        };
        match &*code.name {
            "cp" | "cpi" | "add" | "sub" | "subi" | "adiw" | "sbiw" | "lsl" | "lsr" | "neg" => {
                return true;
            }
            // A function leaves no flags, nor expects any.
            "call" | "ret" => return true,
            "mov" | "movw" | "ldi" | "ld" | "ldd" | "lds" | "st" | "std" | "sts" | "push"
            | "pop" | "and" | "andi" | "or" | "ori" | "eor" | "inc" | "dec" | "clr" => {}
            _ => return false,
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What becomes of these instructions, with a return at `.L7`.
    fn left(body: &str) -> String {
        let body = body.replace("; ", "\n\t");
        let text = format!("\t.type\tf,@function\nf:\n\t{body}\n.L7:\n\tret\n.Lfunc_end0:\n");
        let mut program = Program::parse(&text);
        leave_out(&mut program);
        let function = program.functions_mut().next().expect("a function");
        let code: Vec<String> =
            function.code().map(|(_, code)| format!("{} {}", code.name, code.operands)).collect();
        code.join("; ").replace("; ret ", "")
    }

    #[test]
    fn what_the_flags_say_is_not_asked_again() {
        assert_eq!(left("and r24, r19; cpi r24, 0; breq .L7"), "and r24, r19; breq .L7");
        assert_eq!(
            left("dec r20; cpi r20, 0; brne .L7; ldi r24, 1"),
            "dec r20; brne .L7; ldi r24, 1"
        );
    }

    #[test]
    fn two_bytes_are_compared_in_one_go() {
        assert_eq!(left("cp r26, r1; cpc r27, r1; brne .L7"), "sbiw r26, 0; brne .L7");
    }

    #[test]
    fn what_is_needed_stays() {
        for needed in [
            // Another register, another number, another question.
            "and r24, r19; cpi r25, 0; breq .L7",
            "and r24, r19; cpi r24, 1; breq .L7",
            "and r24, r19; cpi r24, 0; brlo .L7",
            // The zero flag of all bytes so far.
            "sbc r24, r19; cpi r24, 0; breq .L7",
            // The carry is read, here or there.
            "and r24, r19; cpi r24, 0; breq .L7; brlo .L7",
            "add r24, r19; cpi r24, 0; breq .L7; mov r20, r21; adc r20, r20",
            "add r24, r19; cpi r24, 0; breq .L8; ret ; .L8:; rol r24",
            // Not a pair that the instruction knows, or not 0.
            "cp r22, r1; cpc r23, r1; breq .L7",
            "cp r24, r1; cpc r26, r1; breq .L7",
            "cp r24, r2; cpc r25, r2; breq .L7",
            "cp r24, r1; cpc r25, r1; brlt .L7",
        ] {
            let before = needed.matches("r1;").count() + needed.matches("cpi").count();
            let after = left(needed);
            assert_eq!(
                after.matches("r1;").count() + after.matches("cpi").count(),
                before,
                "{after}"
            );
            assert!(!after.contains("sbiw"), "{after}");
        }
    }
}
