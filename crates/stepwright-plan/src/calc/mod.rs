//! The calculators of the Arduino driver's article and stepper_h's documentation: timers, belts,
//! delays and drivers.
//!
//! ```
//! use stepwright_plan::calc::Gearing;
//!
//! let motor =
//!     Gearing { microsteps: vec![16], delays: vec![80.0], speed: None, steps_per_rev: 200 };
//! let sheet = motor.belt(20, 2.0).unwrap(); // 20 teeth of 2 mm
//! assert_eq!(sheet.facts[0].value.shown(), "40"); // mm a turn
//! assert_eq!(sheet.rows[0][2].shown(), "12.5"); // µm a step
//! ```
//!
//! Each calculator makes a [`Sheet`](crate::sheet::Sheet). `stepwright_timed::fit` fits the timer.

mod clock;
mod delay;
mod driver;
mod linear;
mod range;
mod timed;
mod timer;

use std::fmt;

use stepwright::OutOfRange;
use stepwright_timed::fit::Misfit;
use stepwright_units::UnitError;

use crate::sheet::Cell;
pub use clock::{TimerKind, virtual_top};
pub use delay::DelayFit;
pub use driver::StepDriver;
pub use linear::Gearing;
pub use range::range;
pub use timed::{TimedTable, TopChange, TopUpdate};
pub use timer::{TimerSpeed, timer};

/// Why there is no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CalcError {
    /// An interval that the timer can't make.
    Misfit {
        /// The name of the speed or top with this interval.
        what: String,
        /// Why.
        why: Misfit,
    },
    /// A number that the core can't hold.
    Range(OutOfRange),
    /// A value whose unit is not known.
    Unit(UnitError),
    /// A speed in millimetres, but the travel of a turn is too long for millimetres.
    LongTurn {
        /// The speed as typed.
        speed: String,
        /// The travel of a turn in mm.
        travel: String,
    },
    /// A speed that rounds down to nothing.
    BelowOne {
        /// As typed.
        given: String,
    },
    /// The number of delays matches the number of kinds of microsteps in no way.
    Delays {
        /// Delays.
        delays: usize,
        /// Kinds of microsteps.
        kinds: usize,
    },
    /// Own microsteps, but no delays.
    NoDelays,
    /// The driver does not have these microsteps.
    NoMicrosteps {
        /// The driver.
        driver: &'static str,
        /// The microsteps.
        only: u32,
        /// The microsteps that the driver has.
        kinds: String,
    },
    /// A change from a virtual top to the same virtual top.
    SameTop {
        /// The speed at the start.
        from: String,
        /// The speed at the end.
        to: String,
        /// The virtual top of both.
        top: u32,
    },
    /// Less than one clock for each update.
    TooManyUpdates {
        /// Updates.
        updates: u16,
        /// Clocks in all.
        way: u32,
        /// The highest possible number of updates.
        most: u32,
    },
}

impl fmt::Display for CalcError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CalcError::Misfit { what, why } => write!(f, "{what}: {why}"),
            CalcError::Range(error) => error.fmt(f),
            CalcError::Unit(error) => error.fmt(f),
            CalcError::LongTurn { speed, travel } => write!(
                f,
                "--speed {speed}: millimetres are for turns of 0.000001 to 4294.967295 mm, not {travel}"
            ),
            CalcError::BelowOne { given } => write!(f, "{given} is less than one step/s"),
            CalcError::Delays { delays, kinds } => {
                write!(f, "{delays} delays for {kinds} kinds of microsteps")
            }
            CalcError::NoDelays => f.write_str("--microsteps without --delays"),
            CalcError::NoMicrosteps { driver, only, .. } => {
                write!(f, "{driver}: no steps of 1/{only}")
            }
            CalcError::SameTop { from, to, top } => {
                write!(f, "{from} and {to} are the same virtual top, {top}")
            }
            CalcError::TooManyUpdates { updates, way, .. } => write!(
                f,
                "{updates} updates are too many for a change of {way} clocks: less than one each"
            ),
        }
    }
}

impl std::error::Error for CalcError {}

impl From<UnitError> for CalcError {
    fn from(error: UnitError) -> CalcError {
        CalcError::Unit(error)
    }
}

/// `1/16` in text, 16 in CSV and JSON.
fn fraction(micro: u32) -> Cell {
    Cell::Real(micro.into(), format!("1/{micro}"))
}
