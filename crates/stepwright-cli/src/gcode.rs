//! `stepwright gcode`: a G-code job, looked at before anything moves.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use stepwright_plan::gcode::JobSurvey;
use stepwright_plan::sheet::SheetFormat;

use crate::failure::{Failure, unless_closed};

/// Look at a G-code job: its extents, distances, and first error
///
/// The dialect is that of grbl 1.1. A job that a controller would refuse is refused
/// here, with grbl's error number, the line and the column.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright gcode examples/gcode/badge.nc --plan
  stepwright gcode - --plan --format json < job.nc

Positions are the machine's, from its zero and without offsets. The dialect:
crates/stepwright-gcode/README.md")]
pub struct Args {
    /// The job; - is standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Survey it; nothing moves
    #[arg(long, required = true)]
    plan: bool,
    /// How to print it
    #[arg(long, value_enum, default_value_t = SheetFormat::Table, help_heading = "Output")]
    format: SheetFormat,
}

/// Reads the job and prints its survey.
pub fn run(args: Args) -> Result<(), Failure> {
    let path = &args.file;
    let name = path.display();
    let bytes: Box<dyn Read> = if path == Path::new("-") {
        Box::new(io::stdin().lock())
    } else {
        Box::new(File::open(path).map_err(|error| Failure::file("read", path, &error))?)
    };
    // A byte that can't be read ends the job, and is said before its survey.
    let mut unread = None;
    let bytes =
        BufReader::new(bytes).bytes().map_while(|byte| byte.map_err(|e| unread = Some(e)).ok());
    let survey = JobSurvey::of(bytes);
    if let Some(error) = unread {
        return Err(Failure::file("read", path, &error));
    }
    let survey = survey.map_err(|error| {
        let what = error.fault.to_string();
        let place = Failure::new(format!("{name}: {error}")).at(what, error.line as usize);
        place.column(error.column)
    })?;
    let mut out = io::stdout().lock();
    let sheet = survey.sheet(format!("G-code job {name}"));
    unless_closed(sheet.write(&mut out, args.format).and_then(|()| out.flush()))
}
