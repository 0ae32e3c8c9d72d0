//! Orders of the timed driver, played on the virtual board: the steps, the updates, the debug dumps and
//! the callbacks, as numbers, as texts and as a figure.
//!
//! | module | what |
//! | --- | --- |
//! | `course` | plays an order |
//! | [`output`] | the result in the formats of `stepwright timed` |
//! | [`figure`] | its figure |
//!
//! ```
//! use stepwright::drive::sequence::BRIDGE_FULL;
//! use stepwright_play::timed::{TimedCourse, TimedOrder, TimedPlay, TimedWiring};
//! use stepwright_timed::fit::Hardware;
//! use stepwright_timed::{Control, SetSpeed};
//!
//! // 10 steps, 16,000,000 / 160,000 a second.
//! let control = Control::DRV_EN | Control::IRQ_TIMING;
//! let set_speed = SetSpeed { control, top: 160_000, limit: 10, ..SetSpeed::STOP };
//! let order = TimedOrder { set_speed, poll_ms: None, case: None, steps_per_turn: 200 };
//! let (sequence, signals) = (BRIDGE_FULL, Vec::new());
//! let wiring = TimedWiring { name: None, sequence, phase: 0, signals, wire: None };
//! let hardware = Hardware::avr16(16_000_000);
//! let play = TimedPlay {
//!     hardware,
//!     latched: false,
//!     order: &order,
//!     wiring: &wiring,
//!     for_ms: None,
//!     log: None,
//! };
//! let course = TimedCourse::play(&play)?;
//! assert_eq!(course.steps.len(), 10);
//! assert_eq!(course.steps[9] - course.steps[8], 160_000);
//! # Ok::<(), stepwright_play::PlayError>(())
//! ```

mod course;
pub mod figure;
pub mod output;

pub use course::{CourseStep, LoggedDump, Moments, SpeedUpdate, TimedCourse, TimedPlay, refused};

use stepwright::drive::Sequence;
use stepwright_sim::timed::{Change, published};
use stepwright_timed::SetSpeed;
use stepwright_timed::line::Wire;

/// An order, and the options for watching it.
pub struct TimedOrder {
    /// The order for the driver.
    pub set_speed: SetSpeed,
    /// The interval of the main program's checks in ms.
    pub poll_ms: Option<u32>,
    /// The validation case of the Arduino driver, if it is one.
    pub case: Option<u8>,
    /// Steps of one turn of the motor.
    pub steps_per_turn: u32,
}

impl TimedOrder {
    /// The time of the caller's clock at the call, in ms.
    pub fn call_ms(&self) -> u32 {
        if self.case.is_some() { published::CALL_MS } else { 0 }
    }

    /// The published log of a case.
    pub fn log(&self) -> &'static [published::Row] {
        match self.case {
            Some(1) => published::CASE_1.log,
            Some(2) => published::CASE_2.log,
            _ => &[],
        }
    }
}

/// The wiring of the motor.
pub struct TimedWiring {
    /// The name of the drive, if it was given.
    pub name: Option<String>,
    /// The rows of the motor's pattern.
    pub sequence: Sequence,
    /// The row to begin at.
    pub phase: u8,
    /// The pins to show.
    pub signals: Vec<WiredSignal>,
    /// The wiring for a real board, if its pins are known.
    pub wire: Option<Wire>,
}

impl WiredSignal {
    /// Whether the pin is high after this change.
    pub fn is_high(&self, change: &Change) -> bool {
        match self.what {
            SignalLevel::Line(bit) => change.levels >> bit & 1 != 0,
            SignalLevel::Enable => change.enabled,
            SignalLevel::Low => false,
        }
    }
}

/// A pin to show.
pub struct WiredSignal {
    /// Its name.
    pub name: String,
    /// The source of its level.
    pub what: SignalLevel,
}

/// The source of a pin's level.
#[derive(Clone, Copy)]
pub enum SignalLevel {
    /// A bit of the lines.
    Line(u8),
    /// High while the drivers are on.
    Enable,
    /// Always low: a brake.
    Low,
}
