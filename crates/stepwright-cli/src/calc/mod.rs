//! `stepwright calc`: the calculators of the Arduino driver's article and stepper_h's documentation.
//!
//! | module | what |
//! | --- | --- |
//! | `timer` | a speed on a hardware timer: virtual top, prescaler, real rate |
//! | `range` | the lowest and the highest rate of a timer |
//! | `timed` | a speed that changes with the clock: modification, table, curve |
//! | `linear` | belts and screws: length of a step, linear speed |
//! | `delay` | which delays fit a timer's period, how far one can count |
//! | `driver` | reference voltage, jumpers for microsteps |
//! | [`clock`] | the options that say which timer it is |
//! | [`remote`] | all of them for a page |
//!
//! The options of each calculator are here; its [`Sheet`] comes from `stepwright_plan::calc`.

mod clock;
mod delay;
mod driver;
mod linear;
mod range;
mod remote;
mod timed;
mod timer;

pub use clock::{ClockArgs, misfit};
pub use remote::calculators;

use std::io::{self, Write};

use clap::Subcommand;

use crate::failure::{Failure, unless_closed};
use stepwright_plan::calc::CalcError;
use stepwright_plan::sheet::{Sheet, SheetFormat};

/// Calculate timers, delays, belts and drivers
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright calc timer 180                          a rate on an Arduino's timer
  stepwright calc timed 1rpm 500 --updates 11 --doubling
  stepwright calc belt --teeth 20 --delays 1500,650,330,180,80,40
  stepwright calc delay --period 200us
  stepwright calc vref 1.7A")]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

/// The calculators.
#[derive(Subcommand)]
enum What {
    Timer(timer::Args),
    Timed(timed::Args),
    Range(range::Args),
    Belt(linear::BeltArgs),
    Screw(linear::ScrewArgs),
    Delay(delay::Args),
    Vref(driver::VrefArgs),
    Microstep(driver::MicrostepArgs),
}

/// How the result is printed.
#[derive(clap::Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Output")]
struct Output {
    /// How to print it
    #[arg(long, value_enum, default_value_t = SheetFormat::Table)]
    format: SheetFormat,
}

impl Args {
    /// Computes the sheet.
    fn sheet(&self) -> Result<(Sheet, Output), Failure> {
        Ok(match &self.what {
            What::Timer(args) => (args.sheet()?, args.output),
            What::Timed(args) => (args.sheet()?, args.output),
            What::Range(args) => (args.sheet()?, args.output),
            What::Belt(args) => (args.sheet()?, args.output()),
            What::Screw(args) => (args.sheet()?, args.output()),
            What::Delay(args) => (args.sheet()?, args.output),
            What::Vref(args) => (args.sheet(), args.output),
            What::Microstep(args) => (args.sheet()?, args.output),
        })
    }

    /// Draws into the files that the command line names.
    fn draw(&self) -> Result<(), Failure> {
        if let What::Timed(args) = &self.what { args.draw() } else { Ok(()) }
    }
}

/// Computes and prints.
pub fn run(args: Args) -> Result<(), Failure> {
    let (sheet, Output { format }) = args.sheet()?;
    args.draw()?;
    let mut out = io::stdout().lock();
    unless_closed(sheet.write(&mut out, format).and_then(|()| out.flush()))
}

impl From<CalcError> for Failure {
    fn from(error: CalcError) -> Failure {
        let failure = Failure::new(error.to_string());
        match error {
            CalcError::Misfit { what, why } => misfit(&what, why),
            CalcError::Range(error) => error.into(),
            CalcError::Unit(error) => error.into(),
            CalcError::LongTurn { .. } => failure.status(2).hint("give it in rev/s or rpm"),
            CalcError::BelowOne { .. } => {
                failure.hint("--exact does not round it down to whole steps/s")
            }
            CalcError::Delays { .. } => Failure::usage(failure.message())
                .hint("give one delay for all of --microsteps, or one for each"),
            CalcError::NoDelays => Failure::usage(failure.message())
                .hint("add the delays that the motor wants, for example --delays 80us"),
            CalcError::NoMicrosteps { kinds, .. } => failure.hint(format!("it has {kinds}")),
            CalcError::SameTop { .. } => failure.hint("give another TO, or a --modification"),
            CalcError::TooManyUpdates { most, .. } => {
                failure.hint(format!("give at most {most} --updates"))
            }
        }
    }
}
