//! Prints the output of a simulated AVR with 128 KB of flash, line by line.
//!
//! `cargo xtask ticks` and the Python package's tests run the programs of `firmware/ticks` with it.

use std::io::{Write, stdout};
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Parser;
use stepwright_rig::board::HZ;
use stepwright_rig::{Chip, Image};

/// The longest time for a line: a travel of 255 pulses, 20 ms each.
const LONGEST: u64 = 10 * HZ;

/// Print what a simulated ATmega1284P says on its serial line.
#[derive(Parser)]
struct Args {
    /// The firmware
    elf: PathBuf,
    /// End after this many lines
    lines: usize,
}

fn main() -> Result<()> {
    let Args { elf, lines } = Args::parse();
    let mut chip = Chip::roomy(&Image::read(&elf)?);
    let (mut out, mut left, mut heard) = (stdout().lock(), lines, 0);
    while left > 0 {
        chip.run_for(HZ / 100);
        for byte in chip.take_said() {
            if left > 0 {
                out.write_all(&[byte])?;
                left -= usize::from(byte == b'\n');
                heard = chip.now();
            }
        }
        if chip.now() - heard > LONGEST {
            bail!("{}: silence, {left} lines before the end", elf.display());
        }
    }
    Ok(())
}
