//! `stepwright ports`: lists the serial ports.

use std::path::PathBuf;

use serde_json::json;
use serial2::SerialPort;

use super::target::{Format, STAYS};
use crate::failure::Failure;
use crate::say;

/// List the serial ports of this computer
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  stepwright ports")]
pub struct Args {
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Lists the ports, one a line.
pub fn run(args: Args) -> Result<(), Failure> {
    let mut ports: Vec<PathBuf> = SerialPort::available_ports()
        .map_err(|error| Failure::new(format!("can't list the serial ports: {error}")))?;
    ports.sort();
    if args.format == Format::Json {
        say::json(json!(ports));
        return Ok(());
    }
    for port in &ports {
        say::result(port.display());
    }
    if ports.is_empty() {
        say::note(format_args!(
            "no serial port found: is the board plugged in, with a cable that carries data? {STAYS}"
        ));
    }
    Ok(())
}
