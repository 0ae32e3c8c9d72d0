//! `cargo xtask ticks`: computes the same travels on the host and on every chip, and compares the
//! checksums of their delays. The programs are in `firmware/ticks`, which defines the lines.
//!
//! | chip | simulated by | laws |
//! | --- | --- | --- |
//! | ATmega1284P, an Uno's core with 128 KB of flash | simavr | the S-curve by a program of its own |
//! | Cortex-M0 | QEMU's micro:bit, with 64 KB of RAM for the stack of the exact S-curve | all |
//! | Cortex-M3, M4, RISC-V | QEMU | all |
//! | WebAssembly | Node | all |

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::firmware;
use crate::qemu;
use crate::rig;
use crate::setup::{self, Need};
use crate::small;
use crate::toolchain::{ATMEGA1284P, Chip, Cross};
use crate::wasm;
use crate::workspace::{Guard, Workspace, alone_in, cargo_path, line, output, put, run};

/// The needs for building and simulating all of them.
pub const NEEDS: &[&Need] = &[setup::CROSS, setup::AVR_GCC, setup::SIMAVR, setup::NODE];

/// The law of an AVR's second program.
const ALONE: &str = "s-curve";

/// The travels of each law in the tests: a simulated AVR makes two or three a second.
const SAMPLE: [(&str, u32); 6] = [
    (AVR, 40),
    ("cortex-m0", 200),
    ("cortex-m3", 1_000),
    ("cortex-m4", 200),
    ("risc-v", 1_000),
    (WASM, 1_000),
];

/// The travels of each law with `--all`.
const ALL: u32 = 10_000;

const AVR: &str = "avr";
const WASM: &str = "wasm";

/// The longest time for a line, on a machine that is busy with other work.
const LIMIT: Duration = Duration::from_secs(60);

/// Compare seeded travels of every law on the host and on simulated chips: the delays are to be equal,
/// tick for tick.
#[derive(clap::Args)]
pub struct Ticks {
    /// 10,000 travels of each law on every chip; a simulated AVR takes hours for them.
    #[arg(long)]
    all: bool,
    /// This many travels of each law.
    #[arg(long, value_name = "N", conflicts_with = "all")]
    travels: Option<u32>,
    /// Only this chip; give it again for another.
    #[arg(long, value_name = "NAME", value_parser = SAMPLE.map(|(name, _)| name))]
    chip: Vec<String>,
}

impl Ticks {
    /// Builds the chosen programs, and compares.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        let asked = |name: &str| self.chip.is_empty() || self.chip.iter().any(|chip| chip == name);
        let travels = if self.all { Some(ALL) } else { self.travels };
        let sample = SAMPLE.into_iter().filter(|(name, _)| asked(name));
        let sample: Vec<_> = sample.map(|(name, few)| (name, travels.unwrap_or(few))).collect();
        setup::ensure(NEEDS)?;
        compare(ws, &sample).map(drop)
    }
}

/// Compares the sample of the tests.
pub fn run_tests(ws: &Workspace) -> Result<()> {
    compare(ws, &SAMPLE)?;
    // A separate workspace, which no other step formats.
    let folder = ws.root.join("firmware/ticks");
    run(ws.cargo(["fmt", "--check"]).current_dir(&folder))?;
    let mut clippy = ws.cargo(["clippy", "--release", "--target-dir"]);
    clippy.arg(ws.target.join("ticks")).args(["--", "-D", "warnings"]);
    run(clippy.current_dir(&folder))
}

/// A program on a chip.
struct Program {
    chip: &'static str,
    travels: u32,
    /// Whether it prints the lines of a law.
    says: fn(&str) -> bool,
    command: Command,
}

/// Lets each of these chips compute this many travels of every law, and compares them with the
/// host's. Returns the files with the chips' output, named by the chip, followed by a dash and the
/// law if a program has a single law.
///
/// # Errors
/// A line differs; the error contains both lines.
pub fn compare(ws: &Workspace, sample: &[(&'static str, u32)]) -> Result<Vec<PathBuf>> {
    let most = sample.iter().map(|(_, travels)| *travels).max().unwrap_or(0);
    let host = host(ws, most)?;
    let mut programs = VecDeque::new();
    // The slowest chips come first.
    for &(chip, travels) in sample {
        match chip {
            AVR => {
                let simulator = rig::program(ws, "ticks")?;
                for (alone, elf) in [(true, avr(ws, true)?), (false, avr(ws, false)?)] {
                    let mut command = Command::new(&simulator);
                    let laws = host.laws.iter().filter(|law| (*law == ALONE) == alone).count();
                    command.arg(elf).arg((travels as usize * laws).to_string());
                    let says =
                        if alone { |law: &str| law == ALONE } else { |law: &str| law != ALONE };
                    programs.push_back(Program { chip, travels, says, command });
                }
            }
            WASM => {
                let mut command = Command::new("node");
                command.arg(ws.root.join("firmware/ticks/module.mjs")).arg(module(ws)?);
                programs.push_back(Program { chip, travels, says: |_| true, command });
            }
            _ => {
                let command = simulated(ws, chip)?;
                programs.push_back(Program { chip, travels, says: |_| true, command });
            }
        }
    }
    let waiting = Mutex::new(programs);
    let lane = || -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        loop {
            let next = waiting.lock().map(|mut all| all.pop_front()).ok().flatten();
            let Some(program) = next else { return Ok(files) };
            files.push(host.judge(ws, program)?);
        }
    };
    let lanes = thread::available_parallelism().map_or(2, usize::from);
    thread::scope(|scope| {
        let lanes: Vec<_> = (0..lanes).map(|_| scope.spawn(lane)).collect();
        let ended = lanes
            .into_iter()
            .map(|lane| lane.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        Ok(ended.collect::<Result<Vec<_>>>()?.concat())
    })
}

/// The output of the host.
struct Host {
    laws: Vec<String>,
    lines: Vec<String>,
}

/// The host's lines of this many travels of every law.
fn host(ws: &Workspace, travels: u32) -> Result<Host> {
    let (folder, target) = (ws.root.join("firmware/ticks"), ws.target.join("ticks"));
    let mut build = ws.cargo(["build", "--release", "--target-dir"]);
    run(build.arg(&target).current_dir(folder))?;
    let mut command = Command::new(target.join("release/stepwright-ticks"));
    let mut laws: Vec<String> = Vec::new();
    let mut lines = Vec::new();
    listen(&mut command, |said| {
        let mut words = said.split(' ');
        let (law, number) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        if number == "0" {
            laws.push(law.to_owned());
        }
        let more = number.parse::<u32>().context("a travel's number")? < travels;
        if more {
            lines.push(said.to_owned());
        }
        Ok(more)
    })?;
    Ok(Host { laws, lines })
}

impl Host {
    /// Reads the output of a chip, and compares it.
    fn judge(&self, ws: &Workspace, program: Program) -> Result<PathBuf> {
        let Program { chip, travels, says, mut command } = program;
        let laws: Vec<_> = self.laws.iter().filter(|law| says(law)).collect();
        let name = match laws[..] {
            [law] => format!("{chip}-{law}"),
            _ => chip.to_owned(),
        };
        let expected = self.lines.iter().filter(|line| says(line.split(' ').next().unwrap_or("")));
        let mut expected = expected.take(laws.len() * travels as usize).peekable();
        let count = laws.len() * travels as usize;
        let folder = ws.target.join("ticks/said");
        fs::create_dir_all(&folder)?;
        let path = folder.join(name).with_extension("txt");
        let mut file = File::create(&path)?;
        listen(&mut command, |said| {
            let Some(host) = expected.next() else { return Ok(false) };
            writeln!(file, "{said}")?;
            ensure!(said == host, "{chip} says `{said}`, the host `{host}`");
            Ok(expected.peek().is_some())
        })?;
        ensure!(expected.peek().is_none(), "{chip} ended before it had said all");
        println!("{chip}: {count} travels of {} laws are the host's", laws.len());
        Ok(path)
    }
}

/// Runs a program, and passes each line of its output to `hear`, as long as that returns true.
fn listen(command: &mut Command, mut hear: impl FnMut(&str) -> Result<bool>) -> Result<()> {
    command.stdin(Stdio::null()).stdout(Stdio::piped());
    let mut child = Guard(command.spawn().with_context(|| format!("starting {}", line(command)))?);
    let out = BufReader::new(child.0.stdout.take().context("its output")?);
    let (to, from) = channel();
    thread::spawn(move || {
        for line in out.lines().map_while(Result::ok) {
            if to.send(line).is_err() {
                return;
            }
        }
    });
    loop {
        match from.recv_timeout(LIMIT) {
            Ok(said) if hear(&said)? => {}
            Ok(_) => return Ok(()),
            Err(error) => bail!("{}: {error}", line(command)),
        }
    }
}

/// Builds a program of the AVR: that of the S-curve, or that of the other laws.
fn avr(ws: &Workspace, alone: bool) -> Result<PathBuf> {
    let cross = Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
    let built = ws.target.join(firmware::AVR);
    let _alone = alone_in(&built)?;
    let mut cargo = cross.cargo_in(ws, "rustc", &[&ATMEGA1284P], &built);
    cargo.current_dir(ws.root.join("firmware/ticks"));
    cargo.args(["--release", "--bin", "stepwright-ticks"]);
    if alone {
        // Optimised for speed, it would be larger than the flash.
        cargo.args(["--features", ALONE]).env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "z");
    }
    run(&mut cargo)?;
    let from = built.join(ATMEGA1284P.triple).join("release/stepwright-ticks.elf");
    keep(ws, &from, if alone { "avr-s-curve" } else { AVR })
}

/// Builds the program of a 32-bit chip. Returns the QEMU command that runs it.
fn simulated(ws: &Workspace, chip: &str) -> Result<Command> {
    let cross = Cross::find().context("no compiler for small chips: run `cargo xtask setup`")?;
    let folder = ws.root.join("firmware/ticks");
    let mut cargo = Command::new(cargo_path());
    cargo.args(["metadata", "--no-deps", "--format-version=1", "--manifest-path"]);
    let metadata: Value = serde_json::from_str(&output(cargo.arg(folder.join("Cargo.toml")))?)?;
    let data = &metadata["packages"][0]["metadata"]["chips"][chip];
    let triple = data["triple"].as_str().with_context(|| format!("no chip {chip}"))?;
    let triple: &'static str = triple.to_owned().leak();
    let built = ws.target.join("chips");
    let alone = alone_in(&built)?;
    let mut cargo = cross.cargo_in(ws, "build", &[&Chip { triple, flags: "" }], &built);
    small::link(&mut cargo, triple);
    // The same setting as for the boards, so that `core` is built once for a chip.
    cargo.env("CARGO_PROFILE_RELEASE_DEBUG", "line-tables-only");
    run(cargo.current_dir(&folder).args(["--release", "--bin", "stepwright-ticks"]))?;
    let elf = keep(ws, &built.join(triple).join("release/stepwright-ticks"), chip)?;
    drop(alone);
    let root = qemu::prepare(ws)?;
    let mut words = data["qemu"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let mut command = qemu::command(root.as_deref(), words.next().context("no QEMU")?);
    command.args(words).args(["-display", "none", "-monitor", "none", "-serial", "none"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(elf);
    Ok(command)
}

/// Builds the module for Node.
fn module(ws: &Workspace) -> Result<PathBuf> {
    let cross = Cross::find().context("no compiler for wasm: run `cargo xtask setup`")?;
    let built = ws.target.join("chips");
    let mut cargo = cross.cargo_with("core", ws, "rustc", &built);
    cargo.current_dir(ws.root.join("firmware/ticks"));
    cargo.args(["--target", wasm::BROWSER, "--release", "--lib", "--crate-type", "cdylib"]);
    cargo.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", wasm::linker()?);
    run(&mut cargo)?;
    Ok(built.join(wasm::BROWSER).join("release/stepwright_ticks.wasm"))
}

/// Copies a firmware to the common folder, because the next build overwrites it.
fn keep(ws: &Workspace, from: &Path, name: &str) -> Result<PathBuf> {
    let folder = ws.target.join("firmware");
    fs::create_dir_all(&folder)?;
    let to = folder.join(format!("ticks-{name}.elf"));
    put(from, &to)?;
    Ok(to)
}
