//! `cargo xtask check FILE`: finds code in an AVR firmware that the compiler got wrong.
//!
//! A function with C's calling convention has 18 bytes of arguments in registers, and the rest on
//! the stack. On a chip whose program counter has 3 bytes (ATmega2560) the compiler (rustc 1.96,
//! LLVM 22) reads the latter a byte too low, as if after a return address of 2 bytes: the function
//! reads wrong values. On a chip with 2 bytes it is right.
//!
//! ```text
//!        Y+1 … frame   registers saved   return address   arguments
//!       └─────────────┴────────────────┴──1──┬──2──┬──3──┴─►
//!                                                  └ read from here on
//! ```
//!
//! So no function on such a chip may take an argument from the stack. This check finds such
//! functions in the linked firmware: they reach above the registers that they have saved. The
//! division of `u128` is one. (Products, divisions and shifts of 64 bits are right on both chips
//! for all operands: `firmware/rig/tests/arithmetic.rs`.)
//!
//! Functions from a C compiler are listed as well, though they are right.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::listing::{Instruction, Listing};
use crate::setup;
use crate::workspace::output;

/// Say whether AVR firmwares hold functions that the compiler gets wrong.
///
/// That is, on a Mega: functions with arguments on their stack. `firmware` does this with
/// each program that it builds; here are your own.
#[derive(clap::Args)]
pub struct Check {
    /// Linked firmwares, .elf
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Check {
    /// Checks each file. A wrong one is an error.
    pub fn run(self) -> Result<()> {
        setup::ensure(&[setup::AVR_GCC])?;
        for file in &self.files {
            refuse(file)?;
            println!("{}: nothing is compiled wrong that is known of", file.display());
        }
        Ok(())
    }
}

/// Refuses a firmware with functions that the compiler gets wrong.
pub fn refuse(elf: &Path) -> Result<()> {
    if !has_long_addresses(elf)? {
        return Ok(());
    }
    let listing = Listing::of(elf)?;
    let wrong: Vec<&str> = wrong(&listing).collect();
    ensure!(
        wrong.is_empty(),
        "{}: on this chip the compiler reads arguments on the stack a byte too low, and these \
         functions have some:\n  {}\nGive a function no more than 18 bytes of arguments (each \
         takes an even number), or a reference to a struct; do without division of u128",
        elf.display(),
        wrong.join("\n  ")
    );
    Ok(())
}

/// Whether return addresses have 3 bytes: the chip is of the family avr6.
fn has_long_addresses(elf: &Path) -> Result<bool> {
    let text = output(Command::new("avr-objdump").arg("--file-headers").arg(elf))?;
    let family = text.lines().find_map(|line| line.strip_prefix("architecture: avr"));
    let family = family.with_context(|| format!("{} is no AVR firmware", elf.display()))?;
    Ok(family.starts_with(":6,"))
}

/// The functions that have arguments on the stack.
fn wrong(listing: &Listing) -> impl Iterator<Item = &str> {
    listing.functions().filter(|(_, body)| takes_from_stack(body)).map(|(name, _)| name)
}

/// Whether a function reaches above the registers that it has saved, where its return address and
/// its arguments are.
///
/// A function with a frame begins like this, and then accesses everything relative to Y:
///
/// ```text
/// push …; in r28, 0x3d; in r29, 0x3e; sbiw r28, FRAME    or subi, sbci
/// ```
fn takes_from_stack(body: &[Instruction]) -> bool {
    let Some(begin) = body.iter().position(|one| one.operands.starts_with("r28, 0x3d")) else {
        return false;
    };
    let saved = body[..begin].iter().filter(|one| one.name == "push").count() as i32;
    let body = &body[begin + 2..];
    let frame = -moved(body, "r28").unwrap_or(0);
    // Positions are relative to Y after the prologue.
    let top = frame + saved;
    let mut y = frame;
    body.iter().enumerate().any(|(n, one)| {
        let rest = &body[n..];
        if let Some(by) = moved(rest, "r28") {
            // Y moves to the frame, away for accesses more than 63 bytes off, and back at the end.
            y += by;
        } else if one.name == "pop" {
            y = 0;
        }
        let pointer = one.operands.strip_suffix(", r28").filter(|_| one.name == "movw");
        let reached = match pointer {
            // A copy of Y, and the position to which it then points.
            Some(to) => moved(&rest[1..], to).map(|by| y + by),
            None => offset(one).map(|offset| y + offset),
        };
        reached.is_some_and(|place| place > top)
    })
}

/// The amount by which the first instructions move a pair of registers.
fn moved(body: &[Instruction], pair: &str) -> Option<i32> {
    let first = body.first()?;
    let low = number(first, pair)?;
    match &*first.name {
        "adiw" => Some(low),
        "sbiw" => Some(-low),
        "subi" => {
            let high = format!("r{}", pair.strip_prefix('r')?.parse::<u8>().ok()? + 1);
            let second = body.get(1).filter(|one| one.name == "sbci")?;
            let by = (number(second, &high)? << 8 | low) as u16;
            Some(i32::from(by.wrapping_neg() as i16))
        }
        _ => None,
    }
}

/// The number of `subi r28, 0x10`, if it is for this register.
fn number(one: &Instruction, register: &str) -> Option<i32> {
    let number = one.operands.strip_prefix(register)?.strip_prefix(", 0x")?;
    i32::from_str_radix(number, 16).ok()
}

/// The offset of `ldd r24, Y+3`.
fn offset(one: &Instruction) -> Option<i32> {
    let (_, after) = one.operands.split_once("Y+")?;
    let digits: String = after.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function with 3 registers saved, and a frame that `sub` makes.
    fn takes(sub: &str, body: &str) -> bool {
        let text = format!(
            "00000000 <f>:\n\
             0:\tpush\tr17\n 2:\tpush\tr28\n 4:\tpush\tr29\n\
             6:\tin\tr28, 0x3d\t; 61\n 8:\tin\tr29, 0x3e\t; 62\n{}{}",
            lines(sub),
            lines(body)
        );
        wrong(&Listing::parse(&text)).any(|name| name == "f")
    }

    fn lines(body: &str) -> String {
        body.split("; ")
            .map(|line| format!(" a:\t{}\t; 1\n", line.replacen(' ', "\t", 1)))
            .collect()
    }

    #[test]
    fn arguments_on_the_stack_lie_above_the_frame() {
        // A frame of 3 bytes and 3 registers: the return address is Y+7 to Y+9, and the
        // first argument Y+10. The compiler takes Y+9.
        assert!(takes("sbiw r28, 0x03", "ldd r24, Y+9"));
        assert!(takes("sbiw r28, 0x03", "ldd r24, Y+12"));
        assert!(!takes("sbiw r28, 0x03", "ldd r24, Y+3; std Y+1, r24"));
        // Without a frame.
        assert!(takes("nop ", "ldd r24, Y+6"));
    }

    #[test]
    fn far_arguments_are_reached_by_moving_y() {
        // A frame of 260 bytes: Y+266 and Y+20.
        let frame = "subi r28, 0x04; sbci r29, 0x01";
        assert!(takes(frame, "subi r28, 0x34; sbci r29, 0xFF; ldd r24, Y+62"));
        assert!(!takes(frame, "subi r28, 0xF4; sbci r29, 0xFF; ldd r24, Y+8"));
        assert!(takes("sbiw r28, 0x3c", "adiw r28, 0x13; ldd r16, Y+62; sbiw r28, 0x13"));
        // Y is restored.
        assert!(!takes("sbiw r28, 0x3c", "adiw r28, 0x3c; pop r29; pop r28; ret ; ldd r16, Y+60"));
    }

    #[test]
    fn a_pointer_to_an_argument_is_one() {
        assert!(takes("sbiw r28, 0x03", "movw r30, r28; adiw r30, 0x09"));
        assert!(takes("sbiw r28, 0x03", "movw r22, r28; subi r22, 0xF7; sbci r23, 0xFF"));
        // To the frame, and just after its end.
        assert!(!takes("sbiw r28, 0x03", "movw r30, r28; adiw r30, 0x01"));
        assert!(!takes("sbiw r28, 0x03", "movw r30, r28; adiw r30, 0x04"));
    }
}
