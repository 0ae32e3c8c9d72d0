//! `cargo xtask silence`: tests a streamed run whose host falls silent at random instants.

use anyhow::Result;
use clap::ValueEnum;

use crate::firmware::{self, Build};
use crate::program::Program;
use crate::workspace::{Workspace, run};
use crate::{rig, setup};

/// Have the host of a streamed run fall silent at random instants, and judge the board's edges.
#[derive(clap::Args)]
pub struct Silence {
    #[arg(long, default_value = "virtual")]
    board: Board,
    /// How many.
    #[arg(long, value_name = "N", default_value_t = 1_000)]
    instants: u64,
    /// The first seed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Board {
    Virtual,
    Uno,
    Mega,
}

impl Silence {
    /// Builds the programs, and judges the edges.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        let mut test = match self.board {
            Board::Virtual => {
                ws.cargo(["test", "--release", "--package=stepwright-feeder", "--test=silence"])
            }
            Board::Uno => chip(ws, firmware::Board::Uno)?,
            Board::Mega => chip(ws, firmware::Board::Mega)?,
        };
        test.args(["--", "--nocapture", "silence_at"]);
        test.env("STEPWRIGHT_INSTANTS", self.instants.to_string());
        run(test.env("STEPWRIGHT_SEED", self.seed.to_string()))
    }
}

/// The test on a simulated chip.
fn chip(ws: &Workspace, board: firmware::Board) -> Result<std::process::Command> {
    setup::ensure(rig::NEEDS)?;
    Build { board, timer: 1, bench: false }.make(ws, &Program::named(ws, "stream")?)?;
    let mut test = rig::cargo(ws, "test");
    test.args(["--release", "--test=stream"]).env("STEPWRIGHT_BOARD", board.name());
    Ok(test)
}
