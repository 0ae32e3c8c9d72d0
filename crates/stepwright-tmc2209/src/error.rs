//! Errors.

use core::fmt;

use stepwright::{MoveError, OutOfRange};

use crate::faults::DriverFaults;

/// Why a driver was not set up, or did not answer. `E` is the error of its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverError<E> {
    /// The line itself failed.
    Line(E),
    /// The driver did not answer three times: check its power, the wire, its address (MS1 and MS2).
    Silent,
    /// The driver answered, but did not take a write three times: noise on the line.
    NotTaken,
    /// The chip that answers is no TMC2209: it reports this version instead of 0x21.
    OtherChip(u8),
    /// The driver can't do what was requested.
    Range(OutOfRange),
    /// The driver was not set up, or not to the end.
    NotSetUp,
    /// The driver lost its settings while it was set up.
    Reset,
}

impl<E> From<OutOfRange> for DriverError<E> {
    fn from(range: OutOfRange) -> Self {
        DriverError::Range(range)
    }
}

impl<E: fmt::Debug> fmt::Display for DriverError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DriverError::Line(error) => write!(f, "the driver's line: {error:?}"),
            DriverError::Silent => {
                f.write_str("the driver does not answer: look at its power, the wire, its address")
            }
            DriverError::NotTaken => {
                f.write_str("the driver takes no writes: is there noise on its line?")
            }
            DriverError::OtherChip(version) => {
                write!(f, "this is no TMC2209: it says version {version:#x}, not 0x21")
            }
            DriverError::Range(range) => range.fmt(f),
            DriverError::NotSetUp => f.write_str("the driver is not set up: call set_up"),
            DriverError::Reset => {
                f.write_str("the driver was reset while it was set up: look at its power")
            }
        }
    }
}

impl<E: fmt::Debug> core::error::Error for DriverError<E> {}

/// Why an axis was not homed. Its position is unknown. `E` is the error of the driver's line, `P`
/// that of its pin DIAG.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotHomed<E, P> {
    /// No stall within the longest search: the threshold is too low, or the speed is below that of
    /// the stall set-up.
    NoStall,
    /// Two stalls within the least distance: the axis is stuck, or the threshold is too high.
    TooSoon,
    /// The axis was stopped from elsewhere.
    Stopped,
    /// The driver has a fault, or had one; it may have raised DIAG because of that.
    Faulty(DriverFaults),
    /// A move was refused.
    Move(MoveError),
    /// The driver failed.
    Driver(DriverError<E>),
    /// The pin DIAG failed.
    Pin(P),
}

impl<E, P> From<MoveError> for NotHomed<E, P> {
    fn from(error: MoveError) -> Self {
        NotHomed::Move(error)
    }
}

impl<E, P> From<DriverError<E>> for NotHomed<E, P> {
    fn from(error: DriverError<E>) -> Self {
        NotHomed::Driver(error)
    }
}

impl<E: fmt::Debug, P: fmt::Debug> fmt::Display for NotHomed<E, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("not homed: ")?;
        match self {
            NotHomed::NoStall => f.write_str(
                "no stall on all the way: raise the threshold or the speed, or let it go further",
            ),
            NotHomed::TooSoon => f.write_str(
                "it stalled within the least distance, twice: lower the threshold or the \
                 acceleration, and see that it moves freely",
            ),
            NotHomed::Stopped => f.write_str("the axis was stopped"),
            NotHomed::Faulty(faults) => write!(f, "the driver is at fault: {faults}"),
            NotHomed::Move(error) => error.fmt(f),
            NotHomed::Driver(error) => error.fmt(f),
            NotHomed::Pin(error) => write!(f, "DIAG: {error:?}"),
        }
    }
}

impl<E: fmt::Debug, P: fmt::Debug> core::error::Error for NotHomed<E, P> {}
