//! `cargo run --release -p stepwright-stress`: random stories on the virtual board.

use std::process::ExitCode;

use clap::Parser;
use stepwright_stress::run::Run;
use stepwright_stress::{make, simulate};

const EXAMPLES: &str = "\
Examples:
  stepwright-stress                            10,000 stories of a random seed
  stepwright-stress --stories 1000000 --jobs 2
  stepwright-stress --seed 7 --stories 1       the story of one seed
  stepwright-stress --seed 7 --stories 1 --print
  stepwright-stress --replay story.txt         a story that was kept

The seeds of a run are consecutive. A story that breaks a rule is printed as a text for
--replay, with as few lines as break the same rule.";

/// Plays random stories on the virtual board and judges them by bytes and edges.
#[derive(Parser)]
#[command(name = "stepwright-stress", after_help = EXAMPLES)]
struct Cli {
    #[command(flatten)]
    run: Run,
}

fn main() -> ExitCode {
    match Cli::parse().run.run(make::story, simulate) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
