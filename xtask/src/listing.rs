//! The content of a firmware: its symbols, and its instructions as listed by `avr-objdump`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::workspace::output;

/// The names of all symbols.
pub fn symbols(elf: &Path) -> Result<Vec<String>> {
    let text = output(Command::new("avr-nm").arg(elf))?;
    Ok(text.lines().filter_map(|line| line.split(' ').next_back()).map(String::from).collect())
}

/// An instruction: its name and its operands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// The name, like `ldd`.
    pub name: String,
    /// The operands, like `r24, Y+3`.
    pub operands: String,
    /// The function that it calls or jumps to, if any.
    target: Option<String>,
}

/// A firmware's functions.
pub struct Listing(BTreeMap<String, Vec<Instruction>>);

impl Listing {
    /// Disassembles a firmware.
    pub fn of(elf: &Path) -> Result<Listing> {
        let args = ["--disassemble", "--no-show-raw-insn"];
        Ok(Listing::parse(&output(Command::new("avr-objdump").args(args).arg(elf))?))
    }

    /// Parses the output of `avr-objdump`.
    pub fn parse(text: &str) -> Listing {
        let mut functions = BTreeMap::new();
        let mut body: &mut Vec<Instruction> = &mut Vec::new();
        for line in text.lines() {
            if let Some(name) = line.strip_suffix(">:").and_then(|line| line.split('<').nth(1)) {
                body = functions.entry(name.to_string()).or_default();
            } else if let Some(instruction) = instruction(line) {
                body.push(instruction);
            }
        }
        Listing(functions)
    }

    /// All functions and their instructions.
    pub fn functions(&self) -> impl Iterator<Item = (&str, &[Instruction])> {
        self.0.iter().map(|(name, body)| (name.as_str(), body.as_slice()))
    }

    /// All functions that can be reached from this one, including itself; empty if there is no such
    /// function.
    pub fn reached(&self, from: &str) -> BTreeSet<&str> {
        let mut reached = BTreeSet::new();
        let mut next: Vec<&str> =
            self.0.get_key_value(from).map(|(name, _)| name.as_str()).into_iter().collect();
        while let Some(name) = next.pop() {
            if reached.insert(name) {
                let body = self.0.get(name).into_iter().flatten();
                next.extend(body.filter_map(|one| one.target.as_deref()));
            }
        }
        reached
    }

    /// Whether this function jumps to an address that is computed at run time.
    pub fn jumps_anywhere(&self, name: &str) -> bool {
        let body = self.0.get(name).into_iter().flatten();
        body.into_iter().any(|one| matches!(&*one.name, "icall" | "ijmp" | "eicall" | "eijmp"))
    }
}

/// Parses `    7c50:\tbrne\t.+34     \t; 0x7c74 <__vector_25+0x3e>`.
fn instruction(line: &str) -> Option<Instruction> {
    let mut fields = line.split('\t');
    fields.next()?.trim().strip_suffix(':')?;
    let name = fields.next()?.trim();
    let rest: String = fields.collect::<Vec<_>>().join(" ");
    let (operands, comment) = rest.split_once(';').unwrap_or((&rest, ""));
    // Loads and stores have such comments as well, without a meaning.
    let goes = name.starts_with("br") || ["call", "rcall", "jmp", "rjmp"].contains(&name);
    let target = comment.split(['<', '>']).nth(1).filter(|_| goes);
    Some(Instruction {
        name: name.into(),
        operands: operands.trim().into(),
        target: target.map(|target| target.split('+').next().unwrap_or(target).into()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
00000000 <__vectors>:
       0:\tjmp\t0x68\t; 0x68 <__ctors_end>
00007c36 <__vector_25>:
    7c36:\tpush\tr0
    7c46:\tlds\tr25, 0x00C0\t; 0x8000c0 <__TEXT_REGION_LENGTH__+0x7c00c0>
    7c50:\tbrne\t.+34     \t; 0x7c74 <__vector_25+0x3e>
    7c52:\tcall\t0x8000\t; 0x8000 <load>
    7c54:\treti
00008000 <load>:
    8000:\trjmp\t.+2      \t; 0x8010 <divide>
00008010 <divide>:
    8010:\ticall
";

    #[test]
    fn calls_are_followed_and_loads_are_not() {
        let listing = Listing::parse(TEXT);
        assert_eq!(listing.functions().count(), 4);
        let reached: Vec<_> = listing.reached("__vector_25").into_iter().collect();
        assert_eq!(reached, ["__vector_25", "divide", "load"]);
        assert!(listing.reached("no such").is_empty());
        assert!(listing.jumps_anywhere("divide") && !listing.jumps_anywhere("load"));
        let (_, body) = listing.functions().find(|(name, _)| *name == "__vector_25").unwrap();
        assert_eq!((&*body[1].name, &*body[1].operands), ("lds", "r25, 0x00C0"));
    }
}
