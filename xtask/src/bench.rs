//! `cargo xtask bench avr`: cycles, rates and sizes of the firmware, measured
//! on the simulated chip, with `bench/avr.json` as their store.

use std::process::Command;

use anyhow::Result;
use clap::ValueEnum;

use crate::firmware::Board;
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
}

impl Bench {
    /// Builds what is needed, and measures.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        setup::ensure(rig::NEEDS)?;
        let What::Avr = self.what;
        avr(ws, self.check)
    }
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
