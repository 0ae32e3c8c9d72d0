//! `cargo xtask test`: all checks that must pass before a change lands.
//!
//! Each step checks one thing and passes or fails. After a failure the others still run, so that
//! one run shows all failures. A step whose subject is missing fails; no step is skipped silently.

mod apart;
mod api;
mod book;
mod chips;
mod code;
mod cross;
mod examples;
mod firmware;
mod flash;
mod invariants;
mod lanes;
mod package;
mod page;
pub mod pico;
mod ports;
mod programs;
mod pyserial;
pub mod python;
mod qemu;
mod rig;
mod sigrok;
#[cfg(test)]
mod systems;
mod uno;
mod wasm;
mod words;

use std::time::Instant;

use anyhow::Result;
use clap::builder::PossibleValuesParser;
use lanes::Ended;

use crate::processor;
use crate::setup::{self, Need};
use crate::workspace::Workspace;

/// A check.
#[derive(Clone, Copy)]
struct Step {
    name: &'static str,
    /// The description for `--list`.
    what: &'static str,
    /// The needs that are installed first, if missing.
    needs: &'static [&'static Need],
    run: fn(&Workspace) -> Result<()>,
}

/// The needs of a boot loader on the simulated chip.
const FLASH_NEEDS: &[&Need] = &[setup::CROSS, setup::AVR_GCC, setup::SIMAVR, setup::ARDUINO];

/// Python, the needs of a simulated Uno, and Node for a second check of types.
const PYTHON_NEEDS: &[&Need] =
    &[setup::PYTHON, setup::NODE, setup::CROSS, setup::AVR_GCC, setup::SIMAVR];

/// The needs of a browser at a simulated chip.
const PAGE_CHIP_NEEDS: &[&Need] = &[setup::CROSS, setup::AVR_GCC, setup::SIMAVR, setup::NODE];

/// The steps. Those that fail fastest come first.
const STEPS: &[Step] = &[
    Step { name: "fmt", what: "the code is formatted", needs: &[], run: code::fmt },
    Step {
        name: "words",
        what: "plain words, one name for one thing, short files",
        needs: &[],
        run: words::run,
    },
    Step {
        name: "invariants",
        what: "what must never be in the code is not",
        needs: &[],
        run: invariants::run,
    },
    Step { name: "clippy", what: "no lint complains", needs: &[], run: code::clippy },
    Step { name: "unit", what: "unit, property and doc tests", needs: &[], run: code::unit },
    Step { name: "doc", what: "the documentation builds, links hold", needs: &[], run: code::doc },
    Step {
        name: "book",
        what: "the book builds without a warning, and all links of the documentation hold",
        needs: &[],
        run: book::run,
    },
    Step { name: "examples", what: "numbered examples run", needs: &[], run: examples::run },
    Step {
        name: "package",
        what: "what ships can be published, installed and depended on",
        needs: &[],
        run: package::run,
    },
    Step {
        name: "cross",
        what: "core and protocol build for AVR and Cortex-M0",
        needs: &[setup::CROSS],
        run: cross::run,
    },
    Step {
        name: "firmware",
        what: "the firmwares build, fit, and can't panic",
        needs: crate::firmware::NEEDS,
        run: firmware::run,
    },
    Step {
        name: "image",
        what: "the firmwares that `stepwright flash` carries were built from the code",
        needs: &[],
        run: crate::image::check,
    },
    Step {
        name: "rig",
        what: "the firmwares do what they should on a simulated chip",
        needs: crate::rig::TESTS_NEED,
        run: rig::run_tests,
    },
    Step {
        name: "chips",
        what: "the firmware for every chip of 32 bits builds and keeps within its bounds",
        needs: crate::qemu::BUILD_NEEDS,
        run: chips::run,
    },
    Step {
        name: "qemu",
        what: "the firmware for Cortex-M0 and RISC-V does in QEMU what the virtual board does",
        needs: crate::qemu::BUILD_NEEDS,
        run: qemu::run_tests,
    },
    Step {
        name: "ticks",
        what: "seeded travels of every law have the same ticks on the host and on every chip",
        needs: crate::ticks::NEEDS,
        run: crate::ticks::run_tests,
    },
    Step {
        name: "pico",
        what: "the firmware for a Pico in rp2040js, its PIO in a second emulator too",
        needs: pico::NEEDS,
        run: pico::run,
    },
    Step {
        name: "ports",
        what: "the command over --port on a simulated chip, edge by edge as on the virtual board",
        needs: crate::rig::NEEDS,
        run: ports::run,
    },
    Step {
        name: "bench",
        what: "the firmware's figures are as good as the stored ones",
        needs: crate::rig::NEEDS,
        run: rig::run_bench,
    },
    Step {
        name: "pyserial",
        what: "a Python master drives the virtual board",
        needs: &[setup::PYTHON],
        run: pyserial::run,
    },
    Step {
        name: "python",
        what: "the Python package builds, installs, and drives boards",
        needs: PYTHON_NEEDS,
        run: python::run,
    },
    Step {
        name: "senders",
        what: "foreign senders of G-code drive a virtual machine",
        needs: crate::senders::NEEDS,
        run: crate::senders::test,
    },
    Step {
        name: "sigrok",
        what: "sigrok-cli reads a dump of a virtual board's edges",
        needs: &[setup::SIGROK],
        run: sigrok::run,
    },
    Step {
        name: "uno",
        what: "the example on a simulated Uno: home, targets, two terminals, a pulled plug",
        needs: crate::rig::NEEDS,
        run: uno::run,
    },
    Step {
        name: "flash",
        what: "`stepwright flash` writes firmwares through real boot loaders, simulated",
        needs: FLASH_NEEDS,
        run: flash::run,
    },
    Step {
        name: "wasm",
        what: "the page's planner and virtual board are built from the code, and do as the host's",
        needs: &[setup::NODE],
        run: wasm::run_tests,
    },
    Step {
        name: "page",
        what: "a browser drives a board by the page of `stepwright serve`",
        needs: &[setup::NODE],
        run: page::run,
    },
    Step {
        name: "page-chip",
        what: "a browser drives a simulated Uno, by WebSocket and by WebSerial",
        needs: PAGE_CHIP_NEEDS,
        run: page::run_chip,
    },
    Step {
        name: "api",
        what: "nothing moves without control, and the API answers as it is described",
        needs: &[setup::PYTHON],
        run: api::run,
    },
    Step { name: "fuzz", what: "the protocol stands random bytes", needs: &[], run: code::fuzz },
];

/// The steps to run before a commit: some minutes on a built checkout.
const QUICK: &[Step] = &[
    STEPS[0],
    STEPS[1],
    STEPS[2],
    STEPS[3],
    Step { name: "unit", what: "unit tests", needs: &[], run: code::units_alone },
    Step { name: "golden", what: "what the command prints", needs: &[], run: code::golden },
    Step {
        name: "chip",
        what: "the controller talks and moves on a simulated Uno",
        needs: crate::rig::NEEDS,
        run: rig::run_one,
    },
];

/// Run the tests, with all the set-up they need.
#[derive(clap::Args)]
pub struct Test {
    /// The quick ones: what to run before a commit.
    #[arg(long, conflicts_with = "only")]
    quick: bool,
    /// Only this step; give it again for another.
    #[arg(long, value_name = "STEP", value_parser = names())]
    only: Vec<String>,
    /// Say which steps there are, and run none.
    #[arg(long)]
    list: bool,
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(STEPS.iter().map(|step| step.name))
}

impl Test {
    /// Runs the steps. For several steps, prints the result of each, and repeats the end of the
    /// output of each that failed. The last line on stdout is then `N passed, M failed`, which CI
    /// counts. The exit status is 1 if one failed.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        let steps = if self.quick { QUICK } else { STEPS };
        if self.list {
            for step in steps {
                println!("{:<12}{}", step.name, step.what);
            }
            return Ok(());
        }
        let wanted =
            |step: &&Step| self.only.is_empty() || self.only.iter().any(|s| s == step.name);
        let steps: Vec<_> = steps.iter().filter(wanted).collect();
        let passed = match steps[..] {
            [step] => here(step, ws),
            _ => self.several(&steps, ws)?,
        };
        if !passed {
            std::process::exit(1);
        }
        Ok(())
    }

    /// Whether all passed.
    fn several(&self, steps: &[&Step], ws: &Workspace) -> Result<bool> {
        let ended = if self.quick {
            // The user sees the log.
            steps.iter().map(|step| Ended::here(step, ws)).collect()
        } else {
            // Two installations at once would conflict. A need that can't be met fails in its step.
            let needs: Vec<_> = steps.iter().flat_map(|step| step.needs).copied().collect();
            if let Err(error) = setup::ensure(&needs) {
                println!("{error:#}");
            }
            lanes::run(steps)?
        };
        for one in ended.iter().filter(|one| !one.last.is_empty()) {
            println!("\n=== the end of {}, which {}", one.name, one.verdict);
            one.last.iter().for_each(|line| println!("{line}"));
        }
        println!();
        for Ended { name, verdict, time, .. } in &ended {
            println!("{name:<12}{verdict}{:>8.1} s", time.as_secs_f32());
        }
        let passed = ended.iter().filter(|one| one.passed).count();
        println!("{passed} passed, {} failed", ended.len() - passed);
        Ok(passed == ended.len())
    }
}

/// Runs a step in this process. Returns whether it passed.
fn here(step: &Step, ws: &Workspace) -> bool {
    println!("\n=== {}: {}", step.name, step.what);
    let (start, before) = (Instant::now(), processor::time());
    let result = setup::ensure(step.needs).and_then(|()| (step.run)(ws));
    let (wall, used) = (start.elapsed(), processor::time().saturating_sub(before));
    match &result {
        Ok(()) => println!(
            "=== {} passed in {:.1} s, {:.1} s of a processor",
            step.name,
            wall.as_secs_f32(),
            used.as_secs_f32()
        ),
        Err(error) => println!("{error:#}\n=== {} FAILED", step.name),
    }
    result.is_ok()
}
