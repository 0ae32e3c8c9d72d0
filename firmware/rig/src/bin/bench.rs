//! Measures the firmware on the simulated chip: `cargo xtask bench avr`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use stepwright_rig::Board;
use stepwright_rig::bench::{Table, measure};

/// Measure the firmware and print the table.
#[derive(Parser)]
struct Args {
    /// The board; the stored table is the Uno's
    #[arg(long, default_value = "uno")]
    board: Board,
    /// Where the table is stored
    #[arg(long, value_name = "FILE", default_value = "bench/avr.json")]
    file: PathBuf,
    /// Compare with the stored table, and fail where a figure has worsened by
    /// more than 2 %, a rate by more than 5 %; without it, store the table
    #[arg(long)]
    check: bool,
    /// Measure only what this row takes, and store and compare nothing
    #[arg(long, value_name = "ROW", conflicts_with = "check")]
    only: Option<String>,
}

fn main() -> Result<ExitCode> {
    let args = Args::parse();
    let stored = Table::read(&args.file);
    let known = stored.as_ref().ok().cloned().unwrap_or_default();
    let table = measure(args.board, known, args.check, args.only.as_deref())?;
    print!("{table}");
    if args.only.is_some() {
        return Ok(ExitCode::SUCCESS);
    }
    let complaints = if args.check {
        table.complaints(Some(&stored?))
    } else {
        table.write(&args.file)?;
        table.complaints(None)
    };
    for complaint in &complaints {
        eprintln!("{complaint}");
    }
    Ok(if complaints.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
