//! The controllers of an ATmega328P are linked by `avr-shrink`, which makes them smaller.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};

use anyhow::{Context, Result};

use crate::program::Program;
use crate::workspace::{Workspace, run};

/// LLVM's own passes, each told what is smaller on this chip. By bytes of the Uno's controller:
const LLVM: &[&str] = &[
    "inline-threshold=0",
    "split-spill-mode=size",
    "phi-node-folding-threshold=0",
    "enable-load-pre=false",
    "enable-pre=false",
    "tail-merge-size=1",
    "bonus-inst-threshold=0",
];

/// The arguments with which rustc has `avr-shrink` link a program.
pub fn flags(ws: &Workspace, program: &Program) -> Result<Vec<String>> {
    // Not in the dev profile: its folder is locked while the tests are built.
    run(&mut ws.cargo(["build", "--release", "--package", "avr-shrink"]))?;
    let linker = ws.released("avr-shrink");
    let mut flags = vec!["--emit=asm".into(), format!("-Clinker={}", linker.display())];
    flags.extend(LLVM.iter().map(|flag| format!("-Cllvm-args=-{flag}")));
    let mut argument = |name: &str, value: &str| flags.push(format!("-Clink-arg=--{name}={value}"));
    program.busy().for_each(|part| argument("busy", part));
    program.whole().for_each(|part| argument("whole", part));
    // Another linker has cargo link again.
    let mut hasher = DefaultHasher::new();
    fs::read(&linker).context("reading the linker")?.hash(&mut hasher);
    argument("shrunk-by", &format!("{:x}", hasher.finish()));
    Ok(flags)
}
