//! The `stepwright` command: plan, move and watch stepper motors.
//!
//! One subcommand is one module with `Args` (what clap reads) and
//! `run(args) -> Result<(), Failure>`; to add one, write it and name it in
//! [`Command`]. What several of them share:
//!
//! | module | what |
//! | --- | --- |
//! | [`failure`] | errors, hints and the exit status |
//! | [`quantity`] | speeds and accelerations with their units |
//! | [`plot`] | figures as .svg, .png and .html |

mod completions;
mod failure;
mod plan;
mod plot;
mod quantity;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Real-time motion for stepper motors
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Plan(Box<plan::Args>),
    Completions(completions::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Plan(args) => plan::run(*args),
        Command::Completions(args) => completions::run(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
