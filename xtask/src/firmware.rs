//! `cargo xtask firmware`: the firmware of a board, and how much of the chip it
//! fills.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use crate::toolchain::{ATMEGA328P, ATMEGA2560, Chip, Cross};
use crate::workspace::{Workspace, output, run};
use crate::{check, setup, shrink};

/// Build the firmware of a board, as .elf and .hex.
#[derive(clap::Args)]
pub struct Firmware {
    board: Board,
    /// The step timer of the Mega: 1, 3, 4 or 5.
    #[arg(long, default_value = "1", value_parser = ["1", "3", "4", "5"])]
    timer: String,
    /// For a cycle-accurate simulator: handlers spend the 4 cycles of their
    /// entry themselves.
    #[arg(long)]
    bench: bool,
}

impl Firmware {
    /// Builds, and says what came of it.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        setup::ensure(NEEDS)?;
        let timer = self.timer.parse()?;
        let build = Build { board: self.board, timer, bench: self.bench };
        for program in Program::value_variants().iter().filter(|program| program.fits(build)) {
            build.make(ws, *program)?.print();
        }
        Ok(())
    }
}

/// What building takes.
pub const NEEDS: &[&setup::Need] = &[setup::CROSS, setup::AVR_GCC];

/// A board by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Board {
    /// Arduino Uno.
    Uno,
    /// Arduino Nano.
    Nano,
    /// Arduino Mega 2560.
    Mega,
}

/// One of the firmware's programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Program {
    /// The controller.
    Slave,
    /// One with S-curves for the Uno, without settings and switches.
    Curves,
    /// The other end of the wire.
    Master,
    /// The README's first example: a motor that moves while the main loop works.
    FirstMove,
    /// stepper_h's basic example: a motor cycle.
    Cycle,
    /// The Arduino driver's first validation case: the timed driver, slower.
    Case1,
    /// Its second: faster.
    Case2,
    /// Its third: polled, with a callback.
    Case3,
    /// The first in fast PWM, on an Uno.
    FastPwm,
    /// The demo of Austin's article, on six drives.
    Demo,
    /// The timed driver, ordered over the serial line by `stepwright timed --port`.
    Timed,
    /// Two motor shields on two timers of a Mega.
    Shields,
    /// An L6219 in quarter steps.
    L6219,
    /// What a step of the closed form costs an Uno.
    LawsClosed,
    /// Austin's laws, asked step by step, move a motor: the listing, its remainder carried.
    LawsListing,
    /// Likewise: general form, c/2n, a ramp that changes.
    LawsGeneral,
    /// Likewise: power term.
    LawsPower,
    /// Likewise: linear factor.
    LawsLinear,
    /// Likewise: piecewise.
    LawsPiecewise,
    /// For tests: what the compiler makes of wide numbers.
    #[value(skip)]
    Arithmetic,
    /// For tests: a function with arguments on its stack, which is refused for a Mega.
    #[value(skip)]
    Stacked,
}

impl Program {
    /// As in file names and in cargo's.
    pub const fn name(self) -> &'static str {
        match self {
            Program::Slave => "slave",
            Program::Curves => "curves",
            Program::Master => "master",
            Program::FirstMove => "first-move",
            Program::Cycle => "cycle",
            Program::Case1 => "case1",
            Program::Case2 => "case2",
            Program::Case3 => "case3",
            Program::FastPwm => "fast-pwm",
            Program::Demo => "demo",
            Program::Timed => "timed",
            Program::Shields => "shields",
            Program::L6219 => "l6219",
            Program::LawsClosed => "laws-closed",
            Program::LawsGeneral => "laws-general",
            Program::LawsPower => "laws-power",
            Program::LawsListing => "laws-listing",
            Program::LawsLinear => "laws-linear",
            Program::LawsPiecewise => "laws-piecewise",
            Program::Arithmetic => "arithmetic",
            Program::Stacked => "stacked",
        }
    }

    /// Whether there is such a program for a board. The examples have their own timers.
    pub fn fits(self, build: Build) -> bool {
        match self {
            Program::Slave | Program::Master => true,
            Program::FirstMove
            | Program::Cycle
            | Program::Case1
            | Program::Case2
            | Program::Case3
            | Program::Timed
            | Program::Demo
            | Program::L6219
            | Program::Arithmetic
            | Program::Stacked => build.timer == 1,
            // A Nano's boot loader leaves too little, and the Mega's controller has them.
            Program::Curves
            | Program::LawsClosed
            | Program::LawsGeneral
            | Program::LawsPower
            | Program::LawsListing
            | Program::LawsLinear
            | Program::LawsPiecewise => build.timer == 1 && build.board == Board::Uno,
            Program::FastPwm => build.board != Board::Mega,
            Program::Shields => build.timer == 1 && build.board == Board::Mega,
        }
    }

    /// Laws that are asked step by step.
    pub const LAWS: [Program; 6] = [
        Program::LawsClosed,
        Program::LawsListing,
        Program::LawsGeneral,
        Program::LawsPower,
        Program::LawsLinear,
        Program::LawsPiecewise,
    ];

    /// The first example, and those of the sources.
    pub const EXAMPLES: [Program; 10] = [
        Program::FirstMove,
        Program::Cycle,
        Program::Case1,
        Program::Case2,
        Program::Case3,
        Program::FastPwm,
        Program::Timed,
        Program::Demo,
        Program::Shields,
        Program::L6219,
    ];
}

impl Board {
    /// Its name, as in file names.
    pub const fn name(self) -> &'static str {
        match self {
            Board::Uno => "uno",
            Board::Nano => "nano",
            Board::Mega => "mega",
        }
    }

    /// The chip, and the firmware's feature for it. A Nano is an Uno.
    const fn chip(self) -> (&'static Chip, &'static str) {
        match self {
            Board::Uno | Board::Nano => (&ATMEGA328P, "uno"),
            Board::Mega => (&ATMEGA2560, "mega"),
        }
    }

    /// Bytes of flash that the boot loader leaves, and of RAM.
    const fn room(self) -> (u32, u32) {
        match self {
            Board::Uno => (32_256, 2_048),
            Board::Nano => (30_720, 2_048),
            Board::Mega => (253_952, 8_192),
        }
    }
}

/// What is to be built.
#[derive(Clone, Copy)]
pub struct Build {
    /// For which board.
    pub board: Board,
    /// The step timer.
    pub timer: u8,
    /// Whether handlers spend their entry's cycles themselves.
    pub bench: bool,
}

impl Build {
    /// Builds a program and copies it to `target/firmware`, where it is named
    /// after its board: `uno.elf`, `uno-master.hex`, `mega-timer3-bench.elf`.
    pub fn make(self, ws: &Workspace, program: Program) -> Result<Built> {
        if !program.fits(self) {
            let (program, board) = (program.name(), self.board.name());
            bail!("the program {program} is not for a {board} on timer {}", self.timer);
        }
        let (chip, feature) = self.board.chip();
        let mut features = String::from(feature);
        let mut name = String::from(self.board.name());
        if program != Program::Slave {
            name += "-";
            name += program.name();
        }
        if self.timer != 1 {
            if feature != "mega" {
                bail!("the {} has no timer of 16 bits but timer 1", self.board.name());
            }
            features += &format!(",timer{}", self.timer);
            name += &format!("-timer{}", self.timer);
        }
        if self.bench {
            features += ",bench";
            name += "-bench";
        }
        match program {
            Program::Curves => features += ",s-curve",
            Program::Slave if self.board == Board::Mega => features += ",full",
            // A Nano's boot loader leaves 1,536 bytes less.
            Program::Slave if self.board == Board::Nano => {}
            Program::Slave => features += ",safety",
            _ => {}
        }

        let cross =
            Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
        // Two chips share a triple, so each has a folder of its own.
        let built = ws.target.join("avr").join(feature);
        let mut cargo = cross.cargo_in(ws, "rustc", &[chip], &built);
        cargo.current_dir(ws.root.join("firmware/avr"));
        cargo.args(["--release", "--features", &features, "--bin", program.name()]);
        // The others fit, and are measured as the compiler makes them.
        if self.board != Board::Mega && matches!(program, Program::Slave | Program::Curves) {
            cargo.arg("--").args(shrink::flags()?);
        }
        run(&mut cargo)?;
        let from = built.join(chip.triple).join("release").join(program.name());
        let from = from.with_extension("elf");
        check::refuse(&from)?;

        let folder = ws.target.join("firmware");
        fs::create_dir_all(&folder)?;
        let elf = folder.join(&name).with_extension("elf");
        fs::copy(from, &elf).context("copying the .elf")?;
        let hex = elf.with_extension("hex");
        // What is kept over a reset is no part of the flash.
        let convert = ["-O", "ihex", "-R", ".eeprom", "-R", ".noinit"];
        run(Command::new("avr-objcopy").args(convert).arg(&elf).arg(&hex))?;
        let (flash, ram) = size(&elf)?;
        Ok(Built { board: self.board, elf, hex, flash, ram })
    }
}

/// A firmware that has been built.
pub struct Built {
    board: Board,
    /// For simulators and objdump.
    pub elf: PathBuf,
    /// For avrdude.
    pub hex: PathBuf,
    /// Bytes of flash.
    pub flash: u32,
    /// Bytes of RAM, without the stack, which has the rest.
    pub ram: u32,
}

impl Built {
    fn print(&self) {
        let (flash, ram) = self.board.room();
        let line = |what: &str, used: u32, room: u32| {
            let percent = f64::from(used) * 100.0 / f64::from(room);
            println!("{what:<6}{used:>7} of {room:>6} bytes {percent:>5.1} %");
        };
        println!("{}\n{}", self.elf.display(), self.hex.display());
        line("flash", self.flash, flash);
        line("RAM", self.ram, ram);
    }
}

/// Bytes of flash and of RAM, without the stack.
fn size(elf: &Path) -> Result<(u32, u32)> {
    let text = output(Command::new("avr-size").arg(elf))?;
    sizes(&text).with_context(|| format!("what does avr-size say?\n{text}"))
}

/// From a table of text, data and bss, with a line of headings.
fn sizes(table: &str) -> Option<(u32, u32)> {
    let mut columns = table.lines().nth(1)?.split_whitespace().map(str::parse::<u32>);
    let mut column = || columns.next()?.ok();
    let (text, data, bss) = (column()?, column()?, column()?);
    Some((text + data, data + bss))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_takes_both_memories() {
        let table = "   text\t   data\t    bss\t    dec\t    hex\tfilename\n  33550\t    250\t    539\t  34339\t   8623\tx.elf\n";
        assert_eq!(sizes(table), Some((33_800, 789)));
        assert_eq!(sizes("avr-size: no such file"), None);
    }
}
