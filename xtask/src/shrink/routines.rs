//! Instructions that come several times in a row become a routine.
//!
//! ```text
//!   movw r24, r16                           stepwright_shared_3:
//!   call stepwright_hand_load       →         movw r24, r16
//!                                             jmp  stepwright_hand_load
//!   call stepwright_shared_3
//! ```
//!
//! Only where the stack, the flags of interrupts and the ways through a function have no part in
//! it, and nothing that a routine calls looks for arguments on the stack.
//!
//! **Cost**: 7 cycles each time, 2 less where it ends in a call. So the main loop and what starts
//! motors has none ([`BUSY`]): its time is bounded.

use std::collections::HashMap;
use std::fmt::Write;

use super::asm::{Code, Line, Program, key};
use super::branches::words;
use super::machine::skips;

/// Longest routine, in instructions.
const LONGEST: usize = 16;
/// Bytes that a routine saves, at least.
const LEAST: i32 = 2;
/// Bytes of a call: most reach with two.
const CALL: i32 = 2;
/// Functions that have none, by parts of their symbols: they are called once or more in what the
/// main loop does at a time (`planning_burst`, `order_burst`).
const BUSY: &[&str] = &[
    "9main_loop",
    "10stepwright5group",
    "10stepwright5motor",
    "10stepwright5entry",
    "10stepwright5board",
    "7planner4ramp",
    "7planner4runs",
];
/// How often all is looked through: a routine may be a part of another.
const ROUNDS: usize = 6;

/// Whether a function is called often in what the main loop does at a time.
pub fn is_busy(name: &str) -> bool {
    BUSY.iter().any(|part| name.contains(part))
}

/// Makes routines of what is worth it.
pub fn share(program: &mut Program) {
    let mut codes = Codes::default();
    let mut lines: Vec<Vec<Option<u32>>> = Vec::new();
    // In one order, wherever the program is built.
    let mut functions: Vec<_> = program.functions_mut().collect();
    functions.sort_by_cached_key(|function| key(&function.name));
    for function in &functions {
        let kept = is_busy(&function.name);
        let number = |line: &Line| match line {
            Line::Code(code) if !kept && (fits(code) || leaves(code)) => Some(codes.number(code)),
            _ => None,
        };
        let mut numbers: Vec<_> = function.lines.iter().map(number).collect();
        // What may be skipped is one instruction: no routine begins there.
        for (n, _) in function.code().filter(|(_, code)| skips(code)) {
            if let Some(next) = numbers.get_mut(n + 1) {
                *next = None;
            }
        }
        lines.push(numbers);
    }
    let mut routines = String::new();
    let mut made: Vec<(usize, usize, usize, u32)> = Vec::new();
    for _ in 0..ROUNDS {
        let mut any = false;
        for text in candidates(&lines, &codes) {
            let places = places(&lines, &text);
            if codes.gain(&text, places.len()) < LEAST {
                continue;
            }
            any = true;
            let name = format!("stepwright_shared_{}", codes.shared);
            codes.shared += 1;
            codes.write(&text, &name, &mut routines);
            let how = if codes.leaves(&text) { "jmp" } else { "call" };
            let call = codes.number(&Code { name: how.into(), operands: name });
            for (function, n) in places.into_iter().rev() {
                lines[function].splice(n..n + text.len(), [Some(call)]);
                made.push((function, n, text.len(), call));
            }
        }
        if !any {
            break;
        }
    }
    for (function, n, length, call) in made {
        let call = Line::Code(codes.all[call as usize].clone());
        functions[function].lines.splice(n..n + length, [call]);
    }
    program.append(routines);
}

/// Whether an instruction has no part in the stack, in interrupts or in the ways through a
/// function.
pub fn is_plain(code: &Code) -> bool {
    matches!(
        &*code.name,
        "mov"
            | "movw"
            | "ldi"
            | "ld"
            | "ldd"
            | "lds"
            | "st"
            | "std"
            | "sts"
            | "add"
            | "adc"
            | "sub"
            | "sbc"
            | "subi"
            | "sbci"
            | "and"
            | "andi"
            | "or"
            | "ori"
            | "eor"
            | "clr"
            | "cp"
            | "cpc"
            | "cpi"
            | "tst"
            | "adiw"
            | "sbiw"
            | "inc"
            | "dec"
            | "com"
            | "neg"
            | "lsl"
            | "lsr"
            | "rol"
            | "ror"
            | "asr"
            | "swap"
            | "mul"
    )
}

/// Whether an instruction may stand in a routine.
fn fits(code: &Code) -> bool {
    match &*code.name {
        // Of these it is known that they take no arguments on the stack.
        "call" => {
            let simple = ["stepwright_", "__mul", "memcpy"];
            simple.iter().any(|start| code.operands.starts_with(start))
                && !code.operands.starts_with("stepwright_save")
        }
        _ => is_plain(code),
    }
}

/// Whether an instruction leaves its function: it ends a routine, which is jumped to.
fn leaves(code: &Code) -> bool {
    code.name == "ret" || code.name == "jmp" && code.operands.starts_with("stepwright_")
}

/// Instructions by number.
#[derive(Default)]
struct Codes {
    numbers: HashMap<Code, u32>,
    all: Vec<Code>,
    /// How many routines there are.
    shared: usize,
}

impl Codes {
    fn number(&mut self, code: &Code) -> u32 {
        *self.numbers.entry(code.clone()).or_insert_with(|| {
            self.all.push(code.clone());
            self.all.len() as u32 - 1
        })
    }

    /// Bytes of an instruction.
    fn bytes(&self, number: u32) -> i32 {
        match &*self.all[number as usize].name {
            "call" | "jmp" => CALL,
            name => 2 * words(name),
        }
    }

    /// Whether a text leaves its function.
    fn leaves(&self, text: &[u32]) -> bool {
        text.last().is_some_and(|&last| leaves(&self.all[last as usize]))
    }

    /// Whether a text ends in a call.
    fn calls(&self, text: &[u32]) -> bool {
        text.last().is_some_and(|&last| self.all[last as usize].name == "call")
    }

    /// What a routine of these saves that are there so often.
    fn gain(&self, text: &[u32], times: usize) -> i32 {
        let bytes: i32 = text.iter().map(|&number| self.bytes(number)).sum();
        let end = if self.calls(text) || self.leaves(text) { 0 } else { 2 };
        times as i32 * (bytes - CALL) - bytes - end
    }

    /// Writes a routine.
    fn write(&self, text: &[u32], name: &str, to: &mut String) {
        let _ = writeln!(to, "\t.section\t.text.{name},\"ax\",@progbits\n{name}:");
        let calls = self.calls(text);
        for (n, &number) in text.iter().enumerate() {
            let code = &self.all[number as usize];
            let _ = if calls && n + 1 == text.len() {
                writeln!(to, "\tjmp\t{}", code.operands)
            } else {
                writeln!(to, "{code}")
            };
        }
        if !calls && !self.leaves(text) {
            let _ = writeln!(to, "\tret\t");
        }
    }
}

/// Texts that come several times, the best first.
fn candidates(lines: &[Vec<Option<u32>>], codes: &Codes) -> Vec<Vec<u32>> {
    let mut seen: HashMap<Vec<u32>, usize> = HashMap::new();
    for function in lines {
        for run in function.split(Option::is_none) {
            let run: Vec<u32> = run.iter().flatten().copied().collect();
            for from in 0..run.len() {
                for to in from + 2..=(from + LONGEST).min(run.len()) {
                    // Nothing is behind what leaves.
                    if to > from + 1 && codes.leaves(&run[from..to - 1]) {
                        break;
                    }
                    *seen.entry(run[from..to].to_vec()).or_insert(0) += 1;
                }
            }
        }
    }
    let mut texts: Vec<(i32, Vec<u32>)> = seen
        .into_iter()
        .map(|(text, times)| (codes.gain(&text, times), text))
        .filter(|(gain, _)| *gain >= LEAST)
        .collect();
    // Ties in one order, always.
    texts.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    texts.into_iter().map(|(_, text)| text).collect()
}

/// Where a text stands: in which function, and from which line on.
fn places(lines: &[Vec<Option<u32>>], text: &[u32]) -> Vec<(usize, usize)> {
    let mut places = Vec::new();
    for (index, function) in lines.iter().enumerate() {
        let mut n = 0;
        while n + text.len() <= function.len() {
            let here = &function[n..n + text.len()];
            if here.iter().zip(text).all(|(a, b)| *a == Some(*b)) {
                places.push((index, n));
                n += text.len();
            } else {
                n += 1;
            }
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::super::asm::Part;
    use super::*;

    /// What becomes of functions of these names that all have the same lines, and the routines
    /// that they share. The name of each routine is `routine`.
    fn shared(names: &[&str], body: &str) -> (Vec<String>, String) {
        let lines = body.replace("; ", "\n");
        let function = |name| format!("\t.type\t{name},@function\n{name}:\n{lines}\n.Lfunc_end:\n");
        let mut program = Program::parse(&names.iter().map(function).collect::<String>());
        share(&mut program);
        let plain = |line: &str| {
            let line = line.trim().replace('\t', " ");
            match line.split_once("stepwright_shared_") {
                Some((before, name)) if name.ends_with(':') => format!("{before}routine:"),
                Some((before, _)) => format!("{before}routine"),
                None => line,
            }
        };
        let join = |lines: &[String]| {
            let lines = lines.iter().flat_map(|lines| lines.lines());
            let code = lines.filter(|line| !line.is_empty() && !line.contains(".section"));
            code.map(plain).collect::<Vec<_>>().join("; ")
        };
        let left = program.functions_mut().map(|function| {
            join(&function.lines.iter().skip(1).map(Line::to_string).collect::<Vec<_>>())
        });
        let left = left.collect();
        let Some(Part::Text(made)) = program.parts.last() else { panic!("{program:?}") };
        (left, join(made))
    }

    const RUN: &str = "lds r24, M; lds r25, M+1; mov r20, r24; add r20, r25";

    #[test]
    fn two_functions_with_the_same_run_get_one_routine() {
        let (left, routine) = shared(&["f", "g"], &format!("cli; {RUN}; sei; ret"));
        assert_eq!(left, ["cli; call routine; sei; ret"; 2]);
        assert_eq!(routine, format!("routine:; {RUN}; ret"));
        // One alone has nothing to share.
        let body = format!("cli; {RUN}; sei; ret");
        assert_eq!(shared(&["f"], &body), (vec![body], String::new()));
    }

    #[test]
    fn what_leaves_is_jumped_to() {
        for end in ["ret", "jmp stepwright_restore_8"] {
            let (left, routine) = shared(&["f", "g"], &format!("cli; {RUN}; {end}"));
            assert_eq!(left, ["cli; jmp routine"; 2]);
            assert_eq!(routine, format!("routine:; {RUN}; {end}"));
        }
        // To a label of its own only the function itself can jump.
        let (left, routine) = shared(&["f", "g"], &format!("cli; {RUN}; jmp .L1"));
        assert_eq!(left, ["cli; call routine; jmp .L1"; 2]);
        assert_eq!(routine, format!("routine:; {RUN}; ret"));
    }

    #[test]
    fn a_routine_jumps_to_what_it_would_call_last() {
        let body = format!("cli; {RUN}; call __mulsi3; sei; ret");
        let (left, routine) = shared(&["f", "g"], &body);
        assert_eq!(left, ["cli; call routine; sei; ret"; 2]);
        assert_eq!(routine, format!("routine:; {RUN}; jmp __mulsi3"));
    }

    #[test]
    fn what_may_be_skipped_is_no_call() {
        for skip in ["sbrc r21, 0", "sbis 5, 1", "cpse r20, r21"] {
            let (left, routine) = shared(&["f", "g"], &format!("{skip}; inc r5; {RUN}; sei; ret"));
            assert_eq!(left, vec![format!("{skip}; inc r5; call routine; sei; ret"); 2]);
            assert_eq!(routine, format!("routine:; {RUN}; ret"));
        }
    }

    #[test]
    fn a_busy_function_has_none() {
        for part in BUSY {
            let busy = format!("_ZN{part}4work");
            let body = format!("cli; {RUN}; sei; ret");
            let (left, _) = shared(&[&busy, "f", "g"], &body);
            let call = "cli; call routine; sei; ret";
            assert_eq!(left, [&body, call, call], "{part}");
            assert_eq!(shared(&[&busy, "f"], &body), (vec![body.clone(); 2], String::new()));
        }
    }

    #[test]
    fn what_has_a_part_in_the_stack_or_the_way_stays() {
        for stays in [
            "push r5",
            "pop r5",
            "in r24, 61",
            "out 61, r28",
            "sbi 5, 1",
            "cli",
            "rjmp .L1",
            "breq .L1",
            "sbrc r24, 1",
            // It may look for arguments on the stack, or save on it.
            "call elsewhere",
            "call stepwright_save_8",
        ] {
            let body = format!("{}ret", format!("{stays}; ").repeat(9));
            assert_eq!(shared(&["f", "g"], &body), (vec![body; 2], String::new()));
        }
    }
}
