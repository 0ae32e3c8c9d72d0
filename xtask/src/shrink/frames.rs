//! One routine that saves registers, and one that restores them.
//!
//! A function of LLVM's begins and ends like this, with up to 18 registers:
//!
//! ```text
//!   push r8 … push r17                     pop r29, pop r28
//!   push r28, push r29                     pop r17 … pop r8
//!   in r28, SPL; in r29, SPH               ret
//!   sbiw r28, FRAME                                      ▲
//!   in r0, SREG; cli; out SPH, r29;        adiw r28, FRAME; in r0, SREG; cli; out SPH, r29;
//!   out SREG, r0; out SPL, r28             out SREG, r0; out SPL, r28
//! ```
//!
//! It becomes
//!
//! ```text
//!   ldi r26, FRAME                         adiw r28, FRAME
//!   call stepwright_save_8                 jmp stepwright_restore_8
//! ```
//!
//! X and Z are free at both ends: arguments and results are in r8 to r25. The stack is what it
//! was, from the return address on, so arguments on it are found. A function without a frame
//! has one of 0 bytes; then Y is saved beside the others, which takes 2 bytes of stack more
//! where it was not.
//!
//! **Cost**: 22 cycles a call. **Gain**: 2,300 bytes of a controller's 32,000.
//!
//! A function that never ends has nothing to restore, and saves nothing.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::asm::{Code, Function, Line, Program};
use super::routines::is_busy;

/// Bytes that a function must gain. The routines cost cycles, so one with less stays as it is.
const LEAST: usize = 4;
/// Bytes that a function must gain if it is called often ([`is_busy`]).
const BUSY: usize = 12;

/// Functions that stay as they are, by parts of their symbols: what the main loop does at a time,
/// which is bounded to 200 µs (`planning_burst`, `order_burst`).
const KEPT: &[&str] = &["9main_loop4plan", "9main_loop4work"];

/// Shares the beginnings and ends of a program's functions.
pub fn share(program: &mut Program) {
    let mut used = BTreeMap::new();
    for function in program.functions_mut() {
        if KEPT.iter().any(|part| function.name.contains(part)) {
            continue;
        }
        let Some(frame) = Frame::of(function) else { continue };
        if frame.ends.is_empty() {
            function.lines.drain(frame.saves.clone());
        } else if frame.gain() >= if is_busy(&function.name) { BUSY } else { LEAST } {
            let routine = used.entry(frame.lowest).or_insert(Used::default());
            routine.bare |= frame.size.is_none();
            frame.replace(function);
        }
    }
    if !used.is_empty() {
        program.append(routines(&used));
    }
}

/// How the routines of a lowest register are used.
#[derive(Clone, Copy, Default)]
struct Used {
    /// Also by functions without a frame.
    bare: bool,
}

/// What a function saves.
#[derive(Debug, PartialEq, Eq)]
struct Frame {
    /// Its lowest register; all above are saved with it. 18 stands for Y alone.
    lowest: u8,
    /// Bytes of its frame; none if it has no frame pointer.
    size: Option<u8>,
    /// Lines of its beginning: the registers.
    saves: std::ops::Range<usize>,
    /// … and all.
    begin: std::ops::Range<usize>,
    /// Lines of its ends, behind the taking down of the frame.
    ends: Vec<std::ops::Range<usize>>,
}

/// Moves the stack pointer to Y.
const MOVE: [&str; 5] = ["in r0, 63", "cli", "out 62, r29", "out 63, r0", "out 61, r28"];

impl Frame {
    /// Of a function that saves registers, if it is of a form that is known.
    fn of(function: &Function) -> Option<Frame> {
        let lines = &function.lines;
        let mut at = lines.iter().position(|line| matches!(line, Line::Code(_)))?;
        let first = at;
        let mut saved = Vec::new();
        while let Some(register) = operand(lines, at, "push") {
            saved.push(register);
            at += 1;
        }
        let lowest = match *saved.first()? {
            lowest @ 2..=17 => lowest,
            28 => 18,
            _ => return None,
        };
        let saves = first..at;
        let every: Vec<u8> = (lowest..=17).chain([28, 29]).collect();
        let mut size = None;
        if is(lines, at, "in r28, 61") {
            // Registers in between would move arguments on the stack.
            if !is(lines, at + 1, "in r29, 62") || saved != every {
                return None;
            }
            let (bytes, taken) = sum(lines, at + 2, "sbiw")?;
            size = Some(bytes);
            at += 2 + taken;
            if !moves(lines, at) {
                return None;
            }
            at += MOVE.len();
        } else if !saved.is_sorted() || saved.iter().any(|register| !every.contains(register)) {
            return None;
        }
        let begin = first..at;

        let mut ends = Vec::new();
        for (end, code) in function.code() {
            match &*code.name {
                "ret" => {}
                // Not a function of C's convention, or one that ends in another.
                "reti" | "ijmp" | "jmp" => return None,
                "rjmp" if !code.operands.starts_with(".L") => return None,
                _ => continue,
            }
            let pops = end.checked_sub(saved.len())?;
            let pairs = (pops..end).zip(saved.iter().rev());
            if !pairs.into_iter().all(|(at, register)| operand(lines, at, "pop") == Some(*register))
            {
                return None;
            }
            let from = if size.is_some() { pops.checked_sub(MOVE.len())? } else { pops };
            if size.is_some() && !moves(lines, from) {
                return None;
            }
            ends.push(from..end + 1);
        }
        Some(Frame { lowest, size, saves, begin, ends })
    }

    /// Bytes that replacing it saves.
    fn gain(&self) -> usize {
        let all: usize =
            self.begin.len() + self.ends.iter().map(std::ops::Range::len).sum::<usize>();
        let new = if self.size.is_some() { 2 } else { 1 } + self.ends.len();
        2 * all.saturating_sub(new)
    }

    /// Has the function call the routines.
    fn replace(&self, function: &mut Function) {
        let what = if self.size.is_some() { "" } else { "bare_" };
        for end in self.ends.iter().rev() {
            let restore = Code::parse(&format!("jmp stepwright_restore_{what}{}", self.lowest));
            function.lines.splice(end.clone(), [Line::Code(restore)]);
        }
        let mut begin = Vec::new();
        if let Some(size) = self.size {
            begin.push(Line::Code(Code::parse(&format!("ldi r26, {size}"))));
        }
        let save = Code::parse(&format!("call stepwright_save_{what}{}", self.lowest));
        begin.push(Line::Code(save));
        function.lines.splice(self.begin.clone(), begin);
    }
}

/// The register of this instruction on this line.
fn operand(lines: &[Line], at: usize, name: &str) -> Option<u8> {
    match lines.get(at) {
        Some(Line::Code(code)) if code.name == name => {
            code.operands.strip_prefix('r')?.parse().ok()
        }
        _ => None,
    }
}

/// Whether this line is that instruction.
fn is(lines: &[Line], at: usize, text: &str) -> bool {
    matches!(lines.get(at), Some(Line::Code(code)) if code.is(text))
}

/// Whether the stack pointer is moved to Y from this line on.
fn moves(lines: &[Line], at: usize) -> bool {
    MOVE.iter().enumerate().all(|(n, text)| is(lines, at + n, text))
}

/// What is subtracted from Y, and the lines that takes.
fn sum(lines: &[Line], at: usize, name: &str) -> Option<(u8, usize)> {
    let Some(Line::Code(code)) = lines.get(at) else { return None };
    if code.name == name {
        return Some((code.operands.strip_prefix("r28, ")?.parse().ok()?, 1));
    }
    if code.name == "subi" && is(lines, at + 1, "sbci r29, 0") {
        return Some((code.operands.strip_prefix("r28, ")?.parse().ok()?, 2));
    }
    None
}

/// The routines themselves.
fn routines(used: &BTreeMap<u8, Used>) -> String {
    let mut text = String::from("\t.section .text.stepwright_saves,\"ax\",@progbits\n");
    for (lowest, how) in used {
        // A bare one has a frame of no bytes.
        if how.bare {
            let _ = writeln!(text, "stepwright_save_bare_{lowest}:\n\tldi r26, 0");
        }
        let _ = writeln!(text, "stepwright_save_{lowest}:\n\tpop r31\n\tpop r30");
        let _ = writeln!(text, "\trjmp .Lsave_{lowest}");
    }
    for register in 2..=17 {
        let _ = writeln!(text, ".Lsave_{register}:\n\tpush r{register}");
    }
    text += ".Lsave_18:
\tpush r28
\tpush r29
\tin r28, 61
\tin r29, 62
\tsub r28, r26
\tsbc r29, r1
\tin r0, 63
\tcli
\tout 62, r29
\tout 63, r0
\tout 61, r28
\tijmp
";
    for (lowest, how) in used {
        // Its code may have used Y.
        if how.bare {
            let _ = writeln!(text, "stepwright_restore_bare_{lowest}:");
            text += "\tin r28, 61\n\tin r29, 62\n";
        }
        let _ = writeln!(text, "stepwright_restore_{lowest}:\n\tldi r30, {}", 20 - lowest);
        let _ = writeln!(text, "\trjmp .Lrestore_{lowest}");
    }
    for register in 2..=17 {
        let _ = writeln!(text, ".Lrestore_{register}:\n\tldd r{register}, Y+{}", 20 - register);
    }
    text += ".Lrestore_18:
\tldd r26, Y+2
\tldd r27, Y+1
\tadd r28, r30
\tadc r29, r1
\tin r0, 63
\tcli
\tout 62, r29
\tout 63, r0
\tout 61, r28
\tmovw r28, r26
\tret
";
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function of these lines, with the pass done: its lines, and whether it has routines.
    fn shared(body: &str) -> (Vec<String>, bool) {
        let text = format!("\t.type\tf,@function\nf:\n{body}\n.Lfunc_end0:\n");
        let mut program = Program::parse(&text);
        share(&mut program);
        let code = program.functions_mut().flat_map(|function| function.code());
        let lines = code.map(|(_, code)| format!("{} {}", code.name, code.operands)).collect();
        (lines, program.to_string().contains("stepwright_saves"))
    }

    fn lines(names: &str, registers: impl IntoIterator<Item = u8>) -> String {
        registers.into_iter().map(|register| format!("\t{names}\tr{register}\n")).collect()
    }

    const BEGIN: &str = "\tin\tr28, 61\n\tin\tr29, 62\n\tsbiw\tr28, 6\n";
    const SET: &str = "\tin\tr0, 63\n\tcli\n\tout\t62, r29\n\tout\t63, r0\n\tout\t61, r28\n";

    /// Registers from `lowest` on, and a frame of 6 bytes.
    fn framed(lowest: u8) -> String {
        let saved: Vec<u8> = (lowest..=17).chain([28, 29]).collect();
        let push = lines("push", saved.iter().copied());
        let pop = lines("pop", saved.iter().rev().copied());
        format!("{push}{BEGIN}{SET}\tstd\tY+1, r24\n\tadiw\tr28, 6\n{SET}{pop}\tret")
    }

    #[test]
    fn a_frame_is_taken_and_given_back_by_routines() {
        let (lines, routines) = shared(&framed(12));
        let expected = [
            "ldi r26, 6",
            "call stepwright_save_12",
            "std Y+1, r24",
            "adiw r28, 6",
            "jmp stepwright_restore_12",
        ];
        assert_eq!(lines, expected);
        assert!(routines);
    }

    #[test]
    fn registers_alone_are_a_frame_of_no_bytes() {
        let saved = [8, 9, 14, 15, 16, 17];
        let push = lines("push", saved);
        let pop = lines("pop", saved.into_iter().rev());
        let body = format!("{push}\tmovw\tr8, r24\n{pop}\tret");
        let (lines, _) = shared(&body);
        // r10 to r13 are saved as well: nothing is on its stack that could move.
        assert_eq!(
            lines,
            ["call stepwright_save_bare_8", "movw r8, r24", "jmp stepwright_restore_bare_8"]
        );
    }

    #[test]
    fn what_is_not_understood_stays() {
        let gap = framed(12).replace("\tpush\tr13\n", "").replace("\tpop\tr13\n", "");
        let wrong = framed(12).replace("\tpop\tr13\n\tpop\tr12", "\tpop\tr12\n\tpop\tr13");
        let elsewhere = format!("{}\n\trjmp\tg", framed(12));
        let large = framed(12).replace("sbiw\tr28, 6", "subi\tr28, 6\n\tsbci\tr29, 1");
        for body in [gap, wrong, elsewhere, large] {
            let count = body.lines().count();
            let (lines, routines) = shared(&body);
            assert_eq!(lines.len(), count, "{body}");
            assert!(!routines);
        }
    }

    #[test]
    fn who_never_returns_saves_nothing() {
        let body = format!("{}{BEGIN}{SET}.L1:\n\trjmp\t.L1", lines("push", [16, 17, 28, 29]));
        let (lines, routines) = shared(&body);
        assert_eq!(lines.first().map(String::as_str), Some("in r28, 61"));
        assert!(!routines);
    }

    #[test]
    fn a_routine_restores_from_where_the_other_has_saved() {
        let text = routines(&BTreeMap::from([(2, Used { bare: true })]));
        let pushed: Vec<&str> =
            text.lines().filter_map(|line| line.trim().strip_prefix("push ")).collect();
        assert_eq!(pushed.len(), 18);
        // The last that is pushed is at Y+1.
        for (at, register) in pushed.iter().rev().enumerate() {
            let to = match *register {
                "r28" => "r26",
                "r29" => "r27",
                register => register,
            };
            assert!(text.contains(&format!("\tldd {to}, Y+{}\n", at + 1)), "{register}");
        }
        assert!(text.contains("stepwright_restore_2:\n\tldi r30, 18\n"));
    }
}
