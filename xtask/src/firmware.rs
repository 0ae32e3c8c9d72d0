//! `cargo xtask firmware`: the firmware of a board, and how much of the chip it
//! fills.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use crate::program::{CONTROLLER, Program};
use crate::qemu;
use crate::small::SmallBoard;
use crate::toolchain::{ATMEGA328P, ATMEGA2560, Chip, Cross};
use crate::workspace::{Workspace, alone_in, output, put, run};
use crate::{check, setup, shrink};

/// Build the firmware of a board, as .elf and .hex.
#[derive(clap::Args)]
pub struct Firmware {
    /// uno, nano or mega; or a folder of `firmware` with a chip of 32 bits, whose options are none.
    board: String,
    /// The step timer of the Mega: 1, 3, 4 or 5.
    #[arg(long, default_value = "1", value_parser = ["1", "3", "4", "5"])]
    timer: String,
    /// For a cycle-accurate simulator: handlers spend the 4 cycles of their
    /// entry themselves.
    #[arg(long)]
    bench: bool,
    /// Only this program; give it again for another.
    #[arg(long, value_name = "NAME")]
    program: Vec<String>,
    /// Say which programs there are for the board, and build none.
    #[arg(long)]
    list: bool,
}

impl Firmware {
    /// Builds, and says what came of it.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        let avr = Board::value_variants().iter().find(|board| board.name() == self.board);
        let board = match avr.copied() {
            Some(board) => board,
            None => return small(ws, &self.board),
        };
        let timer = self.timer.parse()?;
        let build = Build { board, timer, bench: self.bench };
        let programs = if self.program.is_empty() {
            let mut all = Program::all(ws)?;
            all.retain(|program| program.fits(&build) && !program.is_test());
            all
        } else {
            let named = self.program.iter().map(|name| Program::named(ws, name));
            named.collect::<Result<_>>()?
        };
        if self.list {
            for Program { name, what, .. } in programs {
                println!("{name:<16}{what}");
            }
            return Ok(());
        }
        setup::ensure(NEEDS)?;
        for program in &programs {
            build.make(ws, program)?.print();
        }
        Ok(())
    }
}

/// Builds all programs of a board of 32 bits.
fn small(ws: &Workspace, name: &str) -> Result<()> {
    let board = SmallBoard::named(ws, name).with_context(|| {
        let avr: Vec<_> = Board::value_variants().iter().map(|board| board.name()).collect();
        format!("boards with an AVR are {}", avr.join(", "))
    })?;
    setup::ensure(qemu::BUILD_NEEDS)?;
    for elf in board.build(ws)? {
        println!("{}", elf.display());
        board.tell_size(&elf)?;
    }
    Ok(())
}

/// Where programs for AVRs are built, under `target`: one folder for all of them, as the parts for this
/// machine, which make the registers of a chip from its description, take most of the time.
pub const AVR: &str = "avr";

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
    /// Builds the controller.
    pub fn controller(self, ws: &Workspace) -> Result<Built> {
        self.make(ws, &Program::named(ws, CONTROLLER)?)
    }

    /// Builds a program and copies it to `target/firmware`, where it is named
    /// after its board: `uno.elf`, `uno-master.hex`, `mega-timer3-bench.elf`.
    pub fn make(self, ws: &Workspace, program: &Program) -> Result<Built> {
        if !program.fits(&self) {
            let (program, board) = (&program.name, self.board.name());
            bail!("the program {program} is not for a {board} on timer {}", self.timer);
        }
        let (chip, feature) = self.board.chip();
        let mut features = String::from(feature);
        let mut name = program.on(self.board);
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
        for wanted in program.features(self.board) {
            features += ",";
            features += wanted;
        }

        let cross =
            Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
        let built = ws.target.join(AVR);
        let _alone = alone_in(&built)?;
        let mut cargo = cross.cargo_in(ws, "rustc", &[chip], &built);
        cargo.current_dir(ws.root.join("firmware/avr"));
        cargo.args(["--release", "--features", &features]).args(program.target());
        // The others fit, and are measured as the compiler makes them.
        if self.board != Board::Mega && program.is_controller() {
            cargo.arg("--").args(shrink::flags(ws, program)?);
        }
        run(&mut cargo)?;
        let from = built.join(chip.triple).join("release").join(program.place());
        check::refuse(&from)?;

        let folder = ws.target.join("firmware");
        fs::create_dir_all(&folder)?;
        let elf = folder.join(&name).with_extension("elf");
        put(&from, &elf)?;
        let hex = elf.with_extension("hex");
        // What is kept over a reset is no part of the flash.
        let convert = ["-O", "ihex", "-R", ".eeprom", "-R", ".noinit"];
        let beside = built.join("program.hex");
        run(Command::new("avr-objcopy").args(convert).arg(&elf).arg(&beside))?;
        put(&beside, &hex)?;
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
pub fn size(elf: &Path) -> Result<(u32, u32)> {
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
