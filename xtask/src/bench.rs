//! `cargo xtask bench avr`: cycles, rates and sizes of the firmware, measured on the simulated chip
//! and stored in `bench/avr.json`. `cargo xtask bench cortex-m`: instructions and sizes of the
//! firmware for a Cortex-M0 and a Cortex-M4, in QEMU, stored in `bench/cortex-m.json`.
//! `cargo xtask bench python`: the time to make plans into arrays, compared with that of the core,
//! stored in `bench/python.json`.

use std::process::Command;

use anyhow::Result;
use clap::ValueEnum;

use crate::firmware::Board;
use crate::qemu;
use crate::small::SmallBoard;
use crate::workspace::{Workspace, run};
use crate::{rig, setup};

/// Measure the firmware, print the table and store it.
#[derive(clap::Args)]
pub struct Bench {
    what: What,
    /// Store nothing; fail where a figure is more than 2 % worse than the
    /// stored one, a rate more than 5 %. The bounds always hold, but for those
    /// that are known to be missed.
    #[arg(long)]
    check: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// The firmware of the Uno.
    Avr,
    /// That of the micro:bit, and that for a Cortex-M4.
    CortexM,
    /// The Python package.
    Python,
}

impl Bench {
    /// Builds the programs, and measures.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        match self.what {
            What::Avr => {
                setup::ensure(rig::NEEDS)?;
                avr(ws, self.check)
            }
            What::CortexM => {
                setup::ensure(qemu::BUILD_NEEDS)?;
                for board in ["nrf51", "mps2"] {
                    SmallBoard::named(ws, board)?.build(ws)?;
                }
                qemu::plugin(ws)?;
                cortex_m(ws, self.check)
            }
            What::Python => {
                setup::ensure(&[setup::PYTHON])?;
                crate::test::python::bench(ws, self.check)
            }
        }
    }
}

/// Measures the firmware of both Cortex-M chips, which is built already, like the plugin.
pub fn cortex_m(ws: &Workspace, check: bool) -> Result<()> {
    let root = qemu::prepare(ws)?;
    let mut bench = qemu::cargo(ws, "run", root.as_deref());
    bench.args(["--release", "--bin", "bench", "--"]).arg(ws.root.join("bench/cortex-m.json"));
    if check {
        bench.arg("--check");
    }
    run(&mut bench)
}

/// Measures the Uno's firmware.
pub fn avr(ws: &Workspace, check: bool) -> Result<()> {
    rig::firmware(ws, Board::Uno, false)?;
    rig::firmware(ws, Board::Uno, true)?;
    let mut bench = Command::new(rig::program(ws, "bench")?);
    rig::with_firmware(ws, &mut bench);
    bench.args(["--board", "uno", "--file"]).arg(ws.root.join("bench/avr.json"));
    if check {
        bench.arg("--check");
    }
    run(&mut bench)
}
