//! The firmwares build, and what is true of their code is looked up there.

use anyhow::{Result, bail, ensure};
use clap::ValueEnum;

use crate::firmware::{Board, Build, Built, Program};
use crate::listing::{Instruction, Listing, symbols};
use crate::workspace::Workspace;

/// What the slave should take of an Uno's flash, in bytes: the rest is for its
/// user's own ideas. It takes more; `docs/benchmarks.md` says what for.
const AIM: u32 = 20_480;
/// What any program may take, and the slave until then: all that the boot loader of a Nano
/// leaves.
const FLASH: u32 = 30_720;
/// What any may take of the RAM, without its stack.
const RAM: u32 = 1_229;
/// And what is for an Uno alone: all that its boot loader leaves, and a stack of 700 bytes.
const ALONE: (u32, u32) = (32_256, 1_348);

/// The step interrupt's vector on each chip.
const STEP_328P: &str = "__vector_11";
const STEP_2560: &str = "__vector_17";
/// That of the timer's overflow, for fast PWM.
const OVERFLOW_328P: &str = "__vector_13";

/// Builds all programs for all boards, and looks at them.
pub fn run(ws: &Workspace) -> Result<()> {
    let mut complaints = Vec::new();
    for board in [Board::Uno, Board::Nano, Board::Mega] {
        let build = Build { board, timer: 1, bench: false };
        for program in Program::value_variants().iter().copied().filter(|one| one.fits(build)) {
            match build.make(ws, program) {
                Ok(built) => {
                    for complaint in look(board, program, &built)? {
                        complaints.push(format!("{}: {complaint}", built.elf.display()));
                    }
                }
                // The others may do.
                Err(error) => complaints.push(format!("{}: {error:#}", board.name())),
            }
        }
    }
    ensure!(complaints.is_empty(), "{}", complaints.join("\n"));
    Ok(())
}

/// What is wrong with a firmware.
fn look(board: Board, program: Program, built: &Built) -> Result<Vec<String>> {
    let mut wrong: Vec<String> =
        symbols(&built.elf)?.iter().filter_map(|name| forbidden(name)).collect();
    let listing = Listing::of(&built.elf)?;
    // A motor cycle's asks programs and callbacks, and divides where a bound is near.
    if !matches!(program, Program::Master | Program::Cycle) && !Program::LAWS.contains(&program) {
        let vector = match (program, board) {
            (Program::FastPwm, _) => OVERFLOW_328P,
            (_, Board::Mega) => STEP_2560,
            _ => STEP_328P,
        };
        let reached = listing.reached(vector);
        if reached.is_empty() {
            bail!("{}: there is no {vector}", built.elf.display());
        }
        for name in reached {
            if divides(name) || listing.jumps_anywhere(name) {
                wrong.push(format!("the step interrupt reaches {name}"));
            }
        }
    }
    if board == Board::Mega {
        for (name, body) in listing.functions() {
            if takes_from_stack(body) {
                wrong.push(format!("{name} takes arguments from the stack"));
            }
        }
    } else {
        let (flash, ram) = if program.fits(Build { board: Board::Nano, timer: 1, bench: false }) {
            (FLASH, RAM)
        } else {
            ALONE
        };
        for (what, used, most) in [("flash", built.flash, flash), ("RAM", built.ram, ram)] {
            if used > most {
                wrong.push(format!("{used} bytes of {what}, and only {most} are allowed"));
            }
        }
        if program != Program::Slave {
            return Ok(wrong);
        }
        if built.flash <= AIM {
            wrong.push(format!(
                "{} bytes of flash: the aim is met, let it be the limit",
                built.flash
            ));
        } else {
            println!("{}: {} bytes of flash, the aim is {AIM}: open", board.name(), built.flash);
        }
    }
    Ok(wrong)
}

/// Why a symbol may not be there.
fn forbidden(name: &str) -> Option<String> {
    let float = name.contains("5float")
        || (name.starts_with("__") && (name.contains("sf") || name.contains("df")));
    if name.contains("panic") {
        Some(format!("it can panic: {name}"))
    } else if float {
        Some(format!("it reckons in floats: {name}"))
    } else {
        None
    }
}

/// Whether a function is one of the compiler's divisions.
fn divides(name: &str) -> bool {
    name.contains("div") || ["modqi", "modhi", "modsi", "moddi"].iter().any(|m| name.contains(m))
}

/// Whether a function has arguments on the stack, for which it has more than
/// its nine pairs of registers.
///
/// On a chip with a program counter of 3 bytes the compiler (LLVM 21) looks for
/// them a byte too low: the function reads rubbish. Such a function must be
/// written in another way. A frame begins with the saved registers:
///
/// ```text
/// push …; in r28, 0x3d; in r29, 0x3e; sbiw r28, FRAME    or subi, sbci
/// ```
fn takes_from_stack(body: &[Instruction]) -> bool {
    let Some(begin) = body.iter().position(|one| one.operands.starts_with("r28, 0x3d")) else {
        return false;
    };
    let saved = body[..begin].iter().filter(|one| one.name == "push").count();
    let mut frame = 0;
    for one in body[begin..].iter().skip(2).take(2) {
        let Some((register, number)) = one.operands.split_once(", 0x") else { break };
        let number = usize::from_str_radix(number, 16).unwrap_or(0);
        match (&*one.name, register) {
            ("sbiw" | "subi", "r28") => frame = number,
            ("sbci", "r29") => frame += number << 8,
            _ => break,
        }
    }
    body.iter().any(|one| {
        let Some((_, after)) = one.operands.split_once("Y+") else { return false };
        let digits: String = after.chars().take_while(char::is_ascii_digit).collect();
        digits.parse::<usize>().is_ok_and(|offset| offset > frame + saved)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell() {
        assert!(forbidden("_RNvNtCs1_4core9panicking5panic").is_some());
        assert!(forbidden("__addsf3").is_some() && forbidden("__floatundidf").is_some());
        assert!(forbidden("__udivmodsi4").is_none() && forbidden("__vector_11").is_none());
        assert!(divides("__udivmodsi4") && !divides("__mulsi3"));
    }

    #[test]
    fn arguments_on_the_stack_lie_above_the_frame() {
        // A frame of 3 bytes and 3 saved registers: the return address of
        // 2 bytes is Y+7, an argument Y+9.
        let listing = |offset: u8| {
            Listing::parse(&format!(
                "00000000 <f>:\n\
                 0:\tpush\tr17\n 2:\tpush\tr28\n 4:\tpush\tr29\n\
                 6:\tin\tr28, 0x3d\t; 61\n 8:\tin\tr29, 0x3e\t; 62\n a:\tsbiw\tr28, 0x03\t; 3\n\
                 c:\tldd\tr24, Y+{offset}\t; 0x01\n"
            ))
        };
        let takes = |offset| listing(offset).functions().any(|(_, body)| takes_from_stack(body));
        assert!(takes(9) && !takes(3));
    }
}
