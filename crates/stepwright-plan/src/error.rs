//! Errors of planning.

use std::fmt;

use stepwright::profile::Unfit;

/// Why a travel can't be planned or compared.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanError {
    /// The core can't hold the travel.
    Unfit(Unfit),
    /// More than one step in a tick of the timer.
    TooFast {
        /// The highest speed, in steps/s.
        peak: f64,
        /// Ticks per second.
        hz: u32,
    },
    /// More steps than can be compared.
    TooMany {
        /// Steps of the travel.
        steps: u32,
        /// The highest number that can be compared.
        most: u32,
    },
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlanError::Unfit(unfit) => f.write_str(unfit.what()),
            PlanError::TooFast { peak, hz } => {
                write!(f, "{peak:.0} steps/s are more than one step a tick at {hz} Hz")
            }
            PlanError::TooMany { steps, .. } => {
                write!(f, "{steps} steps are too many to compare")
            }
        }
    }
}

impl std::error::Error for PlanError {}

impl From<Unfit> for PlanError {
    fn from(unfit: Unfit) -> PlanError {
        PlanError::Unfit(unfit)
    }
}
