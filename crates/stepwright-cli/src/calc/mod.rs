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
//! The options of each calculator are here, its [`Sheet`] comes from `stepwright_plan::calc`.

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
use stepwright_plan::calc::{CalcError, DelayFit};
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
    /// A speed on a timer: virtual top, prescaler, the actual speed
    ///
    /// The virtual top is the clock over the steps/s, in 32 bits; the smallest
    /// prescaler with which it fits the timer's own bits is taken. As in the Arduino driver,
    /// a speed is first rounded down to whole steps/s, unless --exact is given.
    #[command(after_help = "\
Examples:
  stepwright calc timer 180                    steps/s
  stepwright calc timer 10rpm                  33 steps/s, 9.9 rpm in truth
  stepwright calc timer 10rpm --exact          33.333 steps/s, 10 rpm
  stepwright calc timer --top 0xE2345          a virtual top
  stepwright calc timer 20 --oscillator 8MHz --clkpr 4")]
    Timer(With<timer::Args>),
    /// A speed that changes at fixed intervals: the modification, and a table of it
    ///
    /// At every update the virtual top grows or shrinks by the modification. With
    /// --doubling the modification itself doubles (slower) or halves (faster) each time, which
    /// makes the change of speed more even.
    #[command(after_help = "\
Examples:
  The example of the manual, 29 updates from 6 to 800 steps/s:
    stepwright calc timed 6 800 --updates 29 --every 250ms
  Case 2, and its curve:
    stepwright calc timed 1rpm 500 --updates 11 --doubling --modification 2385000 \\
      --every 1s --plot case-2.png
  Both curves of section 8:
    stepwright calc timed 1000 51000 --tops --updates 50 --plot linear.png
    stepwright calc timed 1000 65536000 --tops --updates 16 --doubling --plot doubling.png")]
    Timed(With<timed::Args>),
    /// The lowest and the highest rate of a timer
    ///
    /// At the lowest rate the counter makes one round per step; the highest is limited by the
    /// step interrupt, to a step every 640 clocks on an AVR.
    #[command(after_help = "\
Examples:
  stepwright calc range                    timer 1 of an Uno
  stepwright calc range --timer avr8       timer 0, with 8 bits
  stepwright calc range --oscillator 8MHz --steps-per-rev 3200")]
    Range(With<range::Args>),
    /// A belt: length of a step, linear speed
    #[command(after_help = "\
Examples:
  stepwright calc belt --teeth 20                        GT2, steps from 1/1 to 1/32
  stepwright calc belt --teeth 20 --microsteps 16 --delays 80us
  stepwright calc belt --teeth 16 --pitch 3mm --speed 200rpm
  stepwright calc belt --teeth 20 --speed 60mm/s")]
    Belt(With<linear::BeltArgs>),
    /// A screw: length of a step, linear speed
    #[command(after_help = "\
Examples:
  stepwright calc screw --pitch 2mm --starts 4           8 mm a turn
  stepwright calc screw --pitch 5mm --microsteps 8 --delays 180us
  stepwright calc screw --pitch 1.5mm --speed 300rpm")]
    Screw(With<linear::ScrewArgs>),
    /// Which delays fit the period of a timer, and the range of positions
    ///
    /// For a driver with one interrupt for all motors: a step takes three periods of the
    /// timer, and its delay must be a whole number of them. Without --delays, those of
    /// stepper_h's motor.
    #[command(after_help = "\
Examples:
  stepwright calc delay --period 200us                   three motors on a 16 MHz AVR
  stepwright calc delay --period 20us --microsteps 16 --delays 80us
  stepwright calc delay --period 20us --distance 7500nm  how far positions reach")]
    Delay(With<DelayFit>),
    /// The reference voltage of a driver for a motor's current
    ///
    /// With sense resistors of 0.1 Ω the reference voltage of a DRV8825 in V is half the current in
    /// A. Set it 0.05 to 0.1 V lower: a motor must not whine or grow hot. Never unplug a motor from
    /// a driver that is on.
    #[command(after_help = "\
Examples:
  stepwright calc vref 1.7A
  stepwright calc vref 1.7 600mA 1.3
  stepwright calc vref 1A --driver a4988 --sense 68mOhm")]
    Vref(With<driver::VrefArgs>),
    /// The jumpers of a driver for microsteps
    #[command(after_help = "\
Examples:
  stepwright calc microstep                     all of a DRV8825
  stepwright calc microstep 16
  stepwright calc microstep --driver a4988 --steps-per-rev 400")]
    Microstep(With<driver::MicrostepArgs>),
}

/// The options of a calculator.
trait Calculator {
    /// Computes the sheet.
    fn sheet(&self) -> Result<Sheet, Failure>;

    /// Draws into the files that the command line names.
    fn draw(&self) -> Result<(), Failure> {
        Ok(())
    }
}

/// A calculator, and how its result is printed.
#[derive(clap::Args)]
struct With<C: clap::Args> {
    #[command(flatten)]
    calculator: C,
    /// How to print it
    #[arg(long, value_enum, default_value_t = SheetFormat::Table, help_heading = "Output")]
    format: SheetFormat,
}

impl Args {
    /// The calculator that was chosen, and how its result is printed.
    fn chosen(&self) -> (&dyn Calculator, SheetFormat) {
        match &self.what {
            What::Timer(with) => (&with.calculator, with.format),
            What::Timed(with) => (&with.calculator, with.format),
            What::Range(with) => (&with.calculator, with.format),
            What::Belt(with) => (&with.calculator, with.format),
            What::Screw(with) => (&with.calculator, with.format),
            What::Delay(with) => (&with.calculator, with.format),
            What::Vref(with) => (&with.calculator, with.format),
            What::Microstep(with) => (&with.calculator, with.format),
        }
    }
}

/// Computes and prints.
pub fn run(args: Args) -> Result<(), Failure> {
    let (calculator, format) = args.chosen();
    let sheet = calculator.sheet()?;
    calculator.draw()?;
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
