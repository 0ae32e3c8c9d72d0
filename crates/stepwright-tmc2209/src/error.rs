//! What goes wrong.

use core::fmt;

use stepwright::{MoveError, OutOfRange};

use crate::faults::DriverFaults;

/// Why a driver was not set up, or did not answer. `E` is of its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverError<E> {
    /// The line itself.
    Line(E),
    /// No answer, three times: its power, the wire, its address (MS1 and MS2).
    Silent,
    /// It answers, and takes no writes, three times: noise on the line.
    NotTaken,
    /// Something answers that is no TMC2209: it says this version, 0x21 is right.
    OtherChip(u8),
    /// It can't do what was asked for.
    Range(OutOfRange),
    /// It was not set up.
    NotSetUp,
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
        }
    }
}

impl<E: fmt::Debug> core::error::Error for DriverError<E> {}

/// Why an axis is not homed. Its position is not known. `E` is of the driver's line, `P` of its pin DIAG.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotHomed<E, P> {
    /// No stall on all the way: the threshold is too low, or the speed below what was set up.
    NoStall,
    /// It stalled twice in less than the least distance: it is stuck, or the threshold is too high.
    TooSoon,
    /// Something else has stopped it.
    Stopped,
    /// The driver has raised DIAG because it is at fault.
    Faulty(DriverFaults),
    /// A move was refused.
    Move(MoveError),
    /// The driver.
    Driver(DriverError<E>),
    /// The pin.
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
