//! Random stories on the simulated chip: `cargo xtask stress --board uno`.

use std::process::ExitCode;

use anyhow::{Result, anyhow};
use clap::Parser;
use stepwright_rig::{Board, firmware, stress};
use stepwright_stress::run::Run;

/// Plays random stories on a simulated chip and judges them by bytes and edges.
#[derive(Parser)]
struct Args {
    /// The board
    #[arg(long, default_value = "uno")]
    board: Board,
    #[command(flatten)]
    run: Run,
}

fn main() -> Result<ExitCode> {
    let Args { board, run } = Args::parse();
    let image = firmware::load(board.name())?;
    let play = |story: &_, rules| stress::play(board, &image, story, rules);
    let clean = run.run(|seed| stress::story(board, seed), play).map_err(|error| anyhow!(error))?;
    Ok(if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
