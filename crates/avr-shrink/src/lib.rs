//! Makes Rust programs for 8-bit AVR chips smaller: a pass over the compiler's assembly.
//!
//! LLVM writes every function for an AVR separately: it saves registers and moves the stack pointer
//! with its own instructions, copies registers back and forth, turns a condition into a byte and
//! tests it again, and calls with two words. These stages remove that, one stage per file:
//!
//! | file | stage |
//! | --- | --- |
//! | `copies` | removes instructions that change nothing which is read later |
//! | `truths` | turns a condition that is made a byte into a branch, compares a pair with 0 at once |
//! | `branches` | turns a branch over a jump into a branch, a call before a return into a jump |
//! | `frames` | shares one routine that saves the registers of all functions, and one that restores them |
//! | `order` | places functions near those that call them, so that calls take one word |
//!
//! `asm` has the text of a program, `effects` the effect of an instruction, `flow` the control flow
//! of a function, `values` what its registers hold, `calls` the registers that calls pass;
//! [`link`] is the linker that rustc calls.
//!
//! **Never changed**: hand-written assembly, which the compiler encloses in `;APP` and `;NO_APP`,
//! or puts before the first function, or which is a whole function. So an interrupt that is timed
//! by the cycle stays as it is. No access to memory or to a port is removed or moved.
//!
//! Return addresses must have 2 bytes: the pass does not work for an ATmega2560, which has 3, and
//! enough flash.
//!
//! ```
//! use avr_shrink::{Spared, shrink};
//! let function = "\t.section\t.text.f,\"ax\",@progbits\n\t.type\tf,@function\nf:\n\
//!     \tmov\tr30, r24\n\tsts\tLEVEL, r30\n\tret\n.Lfunc_end0:\n";
//! let small = shrink(function, &Spared::default())?;
//! assert!(small.contains("sts\tLEVEL, r24") && !small.contains("mov"));
//! # Ok::<(), String>(())
//! ```

mod asm;
mod branches;
mod calls;
mod copies;
mod effects;
mod flow;
mod frames;
pub mod link;
mod order;
mod truths;
mod values;

/// Functions that the stages treat specially, each identified by a part of its symbol.
///
/// A part of a mangled symbol is a path with lengths: `9main_loop4plan` is `main_loop::plan`.
#[derive(Clone, Debug, Default)]
pub struct Spared {
    /// Functions that are called often: they use the routines for registers only where that saves
    /// 12 bytes.
    pub busy: Vec<String>,
    /// Functions that save and restore registers themselves, because the routines cost 22 cycles or
    /// more.
    pub whole: Vec<String>,
}

impl Spared {
    fn is_busy(&self, symbol: &str) -> bool {
        self.busy.iter().any(|part| symbol.contains(part))
    }

    fn is_whole(&self, symbol: &str) -> bool {
        self.whole.iter().any(|part| symbol.contains(part))
    }

    /// Checks that each part occurs in a label of the program.
    fn check(&self, text: &str) -> Result<(), String> {
        let labels: Vec<&str> = text.lines().filter_map(asm::label).collect();
        let mut parts = self.busy.iter().chain(&self.whole);
        match parts.find(|part| !labels.iter().any(|label| label.contains(&***part))) {
            None => Ok(()),
            Some(part) => Err(format!(
                "no function's symbol has `{part}` in it, which is to be spared: if the function \
                 has another name now, name that; if it is gone or inlined, leave it out"
            )),
        }
    }
}

/// Makes the assembly of a program smaller.
///
/// # Errors
/// A text for the user: a part in `spared` occurs in no symbol of the program.
pub fn shrink(text: &str, spared: &Spared) -> Result<String, String> {
    spared.check(text)?;
    let mut program = asm::Program::parse(text);
    // Less is read by calls then.
    for _ in 0..2 {
        simplify(&mut program);
    }
    truths::shorten(&mut program);
    branches::turn(&mut program);
    frames::share(&mut program, spared);
    Ok(order::order(&program.to_string()))
}

/// Removes what is not needed in each function.
fn simplify(program: &mut asm::Program) {
    let calls = calls::Calls::of(program);
    for function in program.functions_mut() {
        // Each stage makes room for the other.
        while copies::leave_out(function, &calls) || truths::branch(function, &calls) {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An instruction as in `ldd r24, Y+3`.
    pub(crate) fn plain(code: &asm::Code) -> String {
        code.to_string().trim().replace('\t', " ")
    }

    /// The instructions that a stage leaves of these, without labels. A return
    /// follows them, and another at `.L7`.
    pub(crate) fn left(body: &str, stage: impl Fn(&mut asm::Program)) -> String {
        let body = body.replace("; ", "\n\t");
        let text =
            format!("\t.type\tf,@function\nf:\n\t{body}\n\tret\n.L7:\n\tret\n.Lfunc_end0:\n");
        let mut program = asm::Program::parse(&text);
        stage(&mut program);
        let function = program.functions_mut().next().expect("a function");
        let code: Vec<String> = function.code().map(|(_, code)| plain(code)).collect();
        let code = code.join("; ");
        code.strip_suffix("; ret; ret").unwrap_or(&code).into()
    }

    #[test]
    fn a_function_that_is_gone_is_named() {
        let spared = Spared { busy: vec!["4plan".into()], ..Spared::default() };
        let text = "\t.type\t_R4plan,@function\n_R4plan:\n\tret\n.Lfunc_end0:\n";
        assert!(shrink(text, &spared).is_ok());
        let gone = shrink(&text.replace("plan", "idea"), &spared).unwrap_err();
        assert!(gone.contains("no function's symbol has `4plan`"));
    }

    #[test]
    fn assembly_by_hand_stays_as_it_is() {
        const REPEATED: &str = "\tldi\tr16, 1\n\tldi\tr16, 1\n";
        // The pass shortens all of the compiler's own lines here.
        let with = |mark: &str| {
            let twice = format!("\tpush\tr16\n{REPEATED}");
            let branch = "\tbreq\t.L1\n\trjmp\t.L2\n.L1:\n";
            format!("{twice}{branch}{mark}\tsts\tM, r16\n.L2:\n\tpop\tr16\n\tret\t\n")
        };
        let made_smaller = |body: &str| {
            let section = "\t.section\t.text.f,\"ax\",@progbits";
            let text = format!("{section}\n\t.type\tf,@function\nf:\n{body}.Lfunc_end0:\n");
            shrink(&text, &Spared::default()).unwrap()
        };
        for mark in ["\treti\t\n", ".Ltmp3:\n", "\trjmp\t.-4\n", "again:\n"] {
            let small = made_smaller(&with(mark));
            assert!(small.contains(&with(mark)), "{small}");
        }
        // In a function of the compiler only the lines between these are hand-written.
        let mark = format!("\t;APP\n{REPEATED}\t;NO_APP\n");
        let small = made_smaller(&with(&mark));
        assert!(small.contains(&mark) && !small.contains("rjmp"), "{small}");
        assert_eq!(small.matches(REPEATED).count(), 1, "{small}");
    }
}
