//! One routine that saves registers, and one that restores them, for all functions.
//!
//! A function compiled by LLVM begins and ends like this, with up to 18 registers:
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
//! The pass replaces this by
//!
//! ```text
//!   ldi r26, FRAME                         adiw r28, FRAME
//!   call avr_shrink_save_8                 jmp avr_shrink_restore_8
//! ```
//!
//! X and Z are free at both ends, because arguments and results are in r8 to r25. The stack is
//! unchanged from the return address on, so arguments on it are found. A function without a frame
//! gets one of 0 bytes, for which Y and the registers between are saved too: up to 18 bytes of
//! stack more.
//!
//! The saving routine returns by `ijmp` and leaves its caller's frame on the stack, so the call
//! must stay in its function. Therefore this stage is the last of those that change functions.
//!
//! A function that never returns restores nothing. Without a frame it need not save anything
//! either; with a frame it is not changed, because its arguments may lie above the saved registers.
//!
//! **Cost** of saving and restoring, in addition to a function's own: 22 cycles with a frame; 38
//! without, and 4 for each register that the function itself would not have saved.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::Spared;
use super::asm::{Code, Function, Line, Program};

/// The bytes that a function must gain.
const LEAST: usize = 4;
/// The bytes that a function must gain if it is called often.
const BUSY: usize = 12;

/// Shares the prologues and epilogues of a program's functions.
pub(crate) fn share(program: &mut Program, spared: &Spared) {
    // The lowest registers, each with whether a function without a frame uses it.
    let mut used: BTreeMap<u8, bool> = BTreeMap::new();
    for function in program.functions_mut() {
        let Some(frame) = Frame::of(function) else { continue };
        let least = if spared.is_busy(&function.name) { BUSY } else { LEAST };
        if frame.ends.is_empty() {
            if frame.size.is_none() {
                function.lines.drain(frame.begin);
            }
        } else if !spared.is_whole(&function.name) && frame.gain() >= least {
            *used.entry(frame.lowest).or_default() |= frame.size.is_none();
            frame.replace(function);
        }
    }
    if !used.is_empty() {
        program.append(&routines(&used));
    }
}

/// The registers and the frame that a function saves.
#[derive(Debug, PartialEq, Eq)]
struct Frame {
    /// The lowest register; all above are saved with it. 18 stands for Y alone.
    lowest: u8,
    /// The bytes of the frame; `None` without a frame pointer.
    size: Option<u8>,
    /// The lines of its beginning.
    begin: std::ops::Range<usize>,
    /// The lines of its ends, after the frame is removed.
    ends: Vec<std::ops::Range<usize>>,
}

/// Moves the stack pointer to Y.
const MOVE: [&str; 5] = ["in r0, 63", "cli", "out 62, r29", "out 63, r0", "out 61, r28"];

impl Frame {
    /// The frame of a function that saves registers, if its form is known.
    fn of(function: &Function) -> Option<Frame> {
        let lines = &function.lines;
        let (first, _) = function.code().next()?;
        let mut at = first;
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
        let every: Vec<u8> = (lowest..=17).chain([28, 29]).collect();
        let mut size = None;
        if is(lines, at, "in r28, 61") {
            // Additional saved registers would move arguments on the stack.
            if !is(lines, at + 1, "in r29, 62") || saved != every {
                return None;
            }
            let (bytes, taken) = subtracted(lines, at + 2)?;
            size = Some(bytes);
            at += 2 + taken;
            if !moves(lines, at) {
                return None;
            }
            at += MOVE.len();
        } else if !saved.is_sorted() || saved.iter().any(|register| !every.contains(register)) {
            return None;
        }

        let mut ends = Vec::new();
        for (end, code) in function.code() {
            match &*code.name {
                "ret" => {}
                // Not a function of C's convention, or a function that ends in another.
                "reti" | "ijmp" | "jmp" => return None,
                "rjmp" if !code.a.starts_with(".L") => return None,
                _ => continue,
            }
            let pops = end.checked_sub(saved.len())?;
            let mut pairs = (pops..end).zip(saved.iter().rev());
            if !pairs.all(|(at, register)| operand(lines, at, "pop") == Some(*register)) {
                return None;
            }
            let from = if size.is_some() { pops.checked_sub(MOVE.len())? } else { pops };
            if size.is_some() && !moves(lines, from) || function.is_skipped(from) {
                return None;
            }
            ends.push(from..end + 1);
        }
        Some(Frame { lowest, size, begin: first..at, ends })
    }

    /// The bytes that the replacement saves.
    fn gain(&self) -> usize {
        let all: usize =
            self.begin.len() + self.ends.iter().map(std::ops::Range::len).sum::<usize>();
        let new = if self.size.is_some() { 2 } else { 1 } + self.ends.len();
        2 * all.saturating_sub(new)
    }

    /// Replaces the function's prologue and epilogues by calls of the routines.
    fn replace(&self, function: &mut Function) {
        let what = if self.size.is_some() { "" } else { "bare_" };
        let code = |text: String| Line::Code(Code::parse(&text));
        for end in self.ends.iter().rev() {
            let restore = code(format!("jmp avr_shrink_restore_{what}{}", self.lowest));
            function.lines.splice(end.clone(), [restore]);
        }
        let size = self.size.map(|size| code(format!("ldi r26, {size}")));
        let save = code(format!("call avr_shrink_save_{what}{}", self.lowest));
        function.lines.splice(self.begin.clone(), size.into_iter().chain([save]));
    }
}

/// The register operand of this instruction on this line.
fn operand(lines: &[Line], at: usize, name: &str) -> Option<u8> {
    let code = lines.get(at)?.code().filter(|code| code.name == name)?;
    code.a.strip_prefix('r')?.parse().ok()
}

/// Whether the line is this instruction.
fn is(lines: &[Line], at: usize, text: &str) -> bool {
    lines.get(at).and_then(Line::code).is_some_and(|code| code.is(text))
}

/// Whether the lines from here on move the stack pointer to Y.
fn moves(lines: &[Line], at: usize) -> bool {
    MOVE.iter().enumerate().all(|(n, text)| is(lines, at + n, text))
}

/// The number subtracted from Y, and the count of lines.
fn subtracted(lines: &[Line], at: usize) -> Option<(u8, usize)> {
    let code = lines.get(at)?.code()?;
    let taken = match &*code.name {
        "sbiw" => 1,
        "subi" if is(lines, at + 1, "sbci r29, 0") => 2,
        _ => return None,
    };
    (code.a == "r28").then_some((code.b.parse().ok()?, taken))
}

/// The routines for these lowest registers.
fn routines(used: &BTreeMap<u8, bool>) -> String {
    let mut text = String::from("\t.section\t.text.avr_shrink_saves,\"ax\",@progbits\n");
    for (lowest, bare) in used {
        if *bare {
            let _ = writeln!(text, "avr_shrink_save_bare_{lowest}:\n\tldi\tr26, 0");
        }
        let _ = writeln!(text, "avr_shrink_save_{lowest}:\n\tpop\tr31\n\tpop\tr30");
        let _ = writeln!(text, "\trjmp\t.Lavr_shrink_save_{lowest}");
    }
    for register in 2..=17 {
        let _ = writeln!(text, ".Lavr_shrink_save_{register}:\n\tpush\tr{register}");
    }
    text += "\
.Lavr_shrink_save_18:
\tpush\tr28
\tpush\tr29
\tin\tr28, 61
\tin\tr29, 62
\tsub\tr28, r26
\tsbc\tr29, r1
\tin\tr0, 63
\tcli
\tout\t62, r29
\tout\t63, r0
\tout\t61, r28
\tijmp
";
    for (lowest, bare) in used {
        // The function may have used Y.
        if *bare {
            let _ = writeln!(text, "avr_shrink_restore_bare_{lowest}:");
            text += "\tin\tr28, 61\n\tin\tr29, 62\n";
        }
        let _ = writeln!(text, "avr_shrink_restore_{lowest}:\n\tldi\tr30, {}", 20 - lowest);
        let _ = writeln!(text, "\trjmp\t.Lavr_shrink_restore_{lowest}");
    }
    for register in 2..=17 {
        let _ = writeln!(text, ".Lavr_shrink_restore_{register}:");
        let _ = writeln!(text, "\tldd\tr{register}, Y+{}", 20 - register);
    }
    text += "\
.Lavr_shrink_restore_18:
\tldd\tr26, Y+2
\tldd\tr27, Y+1
\tadd\tr28, r30
\tadc\tr29, r1
\tin\tr0, 63
\tcli
\tout\t62, r29
\tout\t63, r0
\tout\t61, r28
\tmovw\tr28, r26
\tret
";
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the pass on a function of these lines. Returns its lines, and whether there are
    /// routines.
    fn shared(body: &str) -> (Vec<String>, bool) {
        let text = format!("\t.type\tf,@function\nf:\n{body}\n.Lfunc_end0:\n");
        let mut program = Program::parse(&text);
        share(&mut program, &Spared::default());
        let code = program.functions_mut().flat_map(|function| function.code());
        let lines = code.map(|(_, code)| crate::tests::plain(code)).collect();
        (lines, program.to_string().contains("avr_shrink_saves"))
    }

    fn lines(names: &str, registers: impl IntoIterator<Item = u8>) -> String {
        registers.into_iter().map(|register| format!("\t{names}\tr{register}\n")).collect()
    }

    const BEGIN: &str = "\tin\tr28, 61\n\tin\tr29, 62\n\tsbiw\tr28, 6\n";
    const SET: &str = "\tin\tr0, 63\n\tcli\n\tout\t62, r29\n\tout\t63, r0\n\tout\t61, r28\n";

    /// A function that saves the registers from `lowest` on, with a frame of 6 bytes.
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
            "call avr_shrink_save_12",
            "std Y+1, r24",
            "adiw r28, 6",
            "jmp avr_shrink_restore_12",
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
        // r10 to r13 are saved as well: there are no stack arguments that could move.
        assert_eq!(
            lines,
            ["call avr_shrink_save_bare_8", "movw r8, r24", "jmp avr_shrink_restore_bare_8"]
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
        let saved = [16, 17, 28, 29];
        let bare = format!("{}.L1:\n\trjmp\t.L1", lines("push", saved));
        assert_eq!(shared(&bare), (vec!["rjmp .L1".into()], false));
        // Its arguments may lie above the registers.
        let framed = format!("{}{BEGIN}{SET}.L1:\n\trjmp\t.L1", lines("push", saved));
        let (lines, routines) = shared(&framed);
        assert_eq!(lines.first().map(String::as_str), Some("push r16"));
        assert!(!routines);
    }

    #[test]
    fn a_routine_restores_from_where_the_other_has_saved() {
        let text = routines(&BTreeMap::from([(2, true)]));
        let pushed: Vec<&str> =
            text.lines().filter_map(|line| line.trim().strip_prefix("push\t")).collect();
        assert_eq!(pushed.len(), 18);
        // The register that is pushed last is at Y+1.
        for (at, register) in pushed.iter().rev().enumerate() {
            let to = match *register {
                "r28" => "r26",
                "r29" => "r27",
                register => register,
            };
            assert!(text.contains(&format!("\tldd\t{to}, Y+{}\n", at + 1)), "{register}");
        }
        assert!(text.contains("avr_shrink_restore_2:\n\tldi\tr30, 18\n"));
    }
}
