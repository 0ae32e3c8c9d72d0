//! `cargo xtask stress`: plays random stories on the virtual board, or on the simulated chip.

use std::process::Command;

use anyhow::Result;
use clap::ValueEnum;

use crate::workspace::{Workspace, run};
use crate::{firmware, rig, setup};

/// Play random stories on a board and judge them by bytes and edges.
#[derive(clap::Args)]
pub struct Stress {
    #[arg(long, default_value = "virtual")]
    board: Board,
    /// How many stories [default: 1000000 on the virtual board, 10000 on a chip].
    #[arg(long, value_name = "N")]
    stories: Option<u64>,
    /// The first seed; a random one by default.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Threads; by default one for each core.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Board {
    Virtual,
    Uno,
    Mega,
}

impl Stress {
    /// Builds the programs, and plays the stories.
    pub fn run(self, ws: &Workspace) -> Result<()> {
        let chip = match self.board {
            Board::Virtual => return self.play(ws.cargo(VIRTUAL), 1_000_000),
            Board::Uno => firmware::Board::Uno,
            Board::Mega => firmware::Board::Mega,
        };
        setup::ensure(rig::NEEDS)?;
        rig::firmware(ws, chip, false)?;
        let mut stress = Command::new(rig::program(ws, "stress")?);
        rig::with_firmware(ws, &mut stress);
        stress.args(["--board", chip.name()]);
        self.play(stress, 10_000)
    }

    fn play(&self, mut stress: Command, stories: u64) -> Result<()> {
        stress.arg("--stories").arg(self.stories.unwrap_or(stories).to_string());
        for (name, number) in [("--seed", self.seed), ("--jobs", self.jobs.map(|jobs| jobs as u64))]
        {
            if let Some(number) = number {
                stress.arg(name).arg(number.to_string());
            }
        }
        run(&mut stress)
    }
}

const VIRTUAL: [&str; 5] = ["run", "--release", "--package", "stepwright-stress", "--"];
