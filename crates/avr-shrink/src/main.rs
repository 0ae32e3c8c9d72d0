//! The linker as a program: `-C linker=avr-shrink`. See the crate's README.

use std::process::ExitCode;

fn main() -> ExitCode {
    match avr_shrink::link::link(std::env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("avr-shrink: {error}");
            ExitCode::FAILURE
        }
    }
}
