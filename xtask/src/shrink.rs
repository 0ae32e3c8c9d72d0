//! Makes a program for an ATmega328P smaller: a pass over the compiler's assembly.
//!
//! LLVM writes every function for an AVR as if it stood alone, and a controller consists of a
//! hundred. A sixth of its code saves and restores registers and moves the stack pointer, another
//! sixth copies registers. A condition is made a byte, which is asked again. Most calls take two
//! words. These steps take that out, one a file:
//!
//! | file | what |
//! | --- | --- |
//! | `copies` | what a register holds is not put there again, what nobody reads is not computed |
//! | `truths` | a condition that is made a byte and asked again is a branch |
//! | `selects` | a condition that is asked for each half of a number is asked once |
//! | `renames` | a number is computed where it is wanted, and not copied there |
//! | `bases` | bytes near each other are reached from a pointer |
//! | `frames` | one routine saves the registers of all functions, one restores them |
//! | `entries` | an instruction before many calls of a function is before the function |
//! | `routines` | instructions that come several times are a routine |
//! | `branches` | a branch over a jump becomes a branch |
//! | `order` | functions stand near those that call them, so that calls take one word |
//!
//! What they know of the chip is in `machine`, the ways through a function are in `flow`, the text of
//! a program is in `asm`.
//!
//! **What is never touched**: assembly that a person wrote, which the compiler encloses in
//! `;APP` and `;NO_APP`, or puts before the first function, or is a whole function
//! (`asm::by_hand`). So the step interrupts and all that is timed by the cycle stay as they are;
//! an entry may stand before such a function, where nothing runs into it.
//! No access to memory or a port is left out, moved or made another.
//!
//! **How it is tested**: random functions are carried out before and after (`tests`), and every
//! test of the rig runs what comes of it.
//!
//! **Where it stands**: `cargo xtask firmware` has rustc call `cargo xtask link` as its linker.
//! That reads the assembly beside the program, and hands the linker what comes of it.
//! Only the controllers go this way. An ATmega2560 has room, and return addresses of three
//! bytes.

mod asm;
mod bases;
mod branches;
mod copies;
mod entries;
mod flow;
mod frames;
mod machine;
mod order;
mod renames;
mod routines;
mod selects;
mod truths;

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::workspace::run;

/// The text of a program, made smaller.
pub fn shrink(text: &str) -> String {
    let mut program = asm::Program::parse(text);
    let taken = flow::taken(&mut program);
    // Each makes room for the others.
    for _ in 0..3 {
        copies::leave_out(&mut program, &taken);
        truths::branch(&mut program, &taken);
        selects::join(&mut program, &taken);
        renames::leave_out(&mut program, &taken);
    }
    copies::leave_out(&mut program, &taken);
    bases::reach(&mut program, &taken);
    frames::share(&mut program);
    entries::share(&mut program);
    routines::share(&mut program);
    branches::turn(&mut program);
    order::order(&program.to_string())
}

/// The linker that rustc calls: makes the program smaller, and has avr-gcc link it.
#[derive(clap::Args)]
pub struct Link {
    /// What rustc says to a linker.
    #[arg(allow_hyphen_values = true, trailing_var_arg = true)]
    args: Vec<String>,
}

impl Link {
    /// Links.
    pub fn run(self) -> Result<()> {
        let mut args = self.args;
        args.retain(|arg| !arg.starts_with(VERSION));
        let at = args.iter().position(|arg| arg == "-o").context("no -o")?;
        let elf = Path::new(args.get(at + 1).context("nothing behind -o")?).to_path_buf();
        let object = args.iter_mut().find(|arg| arg.ends_with(".rcgu.o"));
        let object = object.context("no object of a program")?;
        *object = assemble(&elf)?.to_string_lossy().into();
        run(Command::new("avr-gcc").args(args))
    }
}

/// Makes the assembly beside a program smaller, and assembles it.
fn assemble(elf: &Path) -> Result<PathBuf> {
    let from = elf.with_extension("s");
    let text = fs::read_to_string(&from).with_context(|| format!("reading {}", from.display()))?;
    let to = elf.with_extension("small.s");
    fs::write(&to, shrink(&text)).with_context(|| format!("writing {}", to.display()))?;
    let object = elf.with_extension("small.o");
    let chip = ["-mmcu=atmega328p", "-mlink-relax", "--no-warn", "-o"];
    run(Command::new("avr-as").args(chip).arg(&object).arg(&to))?;
    Ok(object)
}

/// An argument for this linker alone: it names the pass to cargo, which links a program again
/// when the pass has changed.
const VERSION: &str = "--shrunk-by=";

/// What rustc is told for it to call this linker.
pub fn flags() -> Result<Vec<String>> {
    let this = this_program()?;
    let mut hasher = DefaultHasher::new();
    fs::read(&this)?.hash(&mut hasher);
    Ok(vec![
        "--emit=asm".into(),
        format!("-Clinker={}", this.display()),
        "-Zpre-link-args=link".into(),
        format!("-Clink-arg={VERSION}{:x}", hasher.finish()),
    ])
}

/// The file of this program. `cargo test` links it once more where packages get other features:
/// on a new checkout its file is replaced while it runs. Linux still has what runs.
fn this_program() -> Result<PathBuf> {
    let path = std::env::current_exe()?;
    if path.exists() {
        return Ok(path);
    }
    let copy = path.with_file_name("xtask-link");
    fs::copy("/proc/self/exe", &copy).context("copying this program: start it once more")?;
    Ok(copy)
}

#[cfg(test)]
mod tests;
