#![no_std]
#![forbid(unsafe_code)]
//! The timed driver: a stepper motor whose speed changes on a clock.
//!
//! A speed is stored as a *virtual top*, the clocks of a timer between two steps, in 32 bits. An
//! order ([`SetSpeed`]) has the initial top; its change at a fixed interval of milliseconds, which
//! may double or halve each time; the number of these updates; and the end of the motion: after a
//! number of steps, after milliseconds, or never. The module [`fit`] fits a virtual top to a timer
//! of 8, 16 or 32 bits with a prescaler, and computes the deviation of the speed from the wanted
//! one.
//!
//! ```
//! use stepwright::drive::sequence::SHIELD;
//! use stepwright_sim::timed::TimedBoard;
//! use stepwright_timed::fit::Hardware;
//! use stepwright_timed::{Code, Control, Model, SetSpeed};
//!
//! // A 16-bit timer of an Arduino, and the motor shield, on the virtual board.
//! let timer = Hardware::avr16(16_000_000);
//! let mut board = TimedBoard::new(timer, Model::Ideal, SHIELD, 0);
//!
//! // 64,000 clocks a step, which are 250 steps/s; each 100 ms 16,000 clocks less, three
//! // times, so 1000 steps/s in the end; the motion stops after a second.
//! let order = SetSpeed {
//!     control: Control::DRV_EN
//!         | Control::SPEED_VARIABLE
//!         | Control::IRQ_TIMING
//!         | Control::FASTER
//!         | Control::ENDPOINT_MILLIS,
//!     top: 64_000,
//!     limit: 1_000,
//!     modification: 16_000,
//!     update_ms: 100,
//!     mod_counts: 3,
//! };
//! assert_eq!(board.set_speed(&order), Code::FINE);
//! board.run_for_millis(1_100);
//! assert!(!board.is_moving());
//! let steps = board.steps(); // the clock of each step
//! let [first, second, .., last_but_one, last] = steps[..] else { unreachable!() };
//! assert_eq!(second - first, 64_000);
//! assert_eq!(last - last_but_one, 16_000);
//! ```
//!
//! On a chip an interrupt calls [`Stepper`], which joins the interrupt's half ([`Pace`]) to a
//! motor's windings, and the main program has the [`Driver`]. [`Timed`] is the same motion as an
//! iterator of delays, for plots and for the engine of the crate [`stepwright`].
//!
//! # The way of the data
//!
//! ```text
//!        foreground                                 step interrupt
//!   SetSpeed ─► Driver ── begin, stop ─────────────► Pace ─► when the next step is due
//!              ▲  └────── two numbers: next, after ──►│ │
//!   update_check          (without IRQ_TIMING)        │ └─ updates under IRQ_TIMING
//!   callbacks  ◄───────── status ────────────────────┘
//! ```
//!
//! | file | content |
//! | --- | --- |
//! | `fit` | a wanted interval on a hardware timer: prescaler and count |
//! | `order` | control bits, the order, result codes, status bits |
//! | `ramp` | one update |
//! | `pace` | the interrupt's half |
//! | `stepper` | the interrupt's half with a motor's windings, called by an interrupt |
//! | `driver` | the foreground's half |
//! | `dump` | the article's debug dump |
//! | `profile` | an iterator of delays, and a feed of the engine |
//! | [`line`](mod@line) | the rows of a board's line, for both sides |
//! | `station` | a timer's motor, ordered over the line |
//!
//! # Source
//!
//! *Interrupt driven Arduino Stepper Motor Driver*, an article about a non-blocking driver with a
//! virtual 32-bit timer. Section numbers in these files are those of the article.
//!
//! # Errors of speed and time
//!
//! None against the article's arithmetic: all of it is in integers, and a time is the sum of the
//! intervals that were played. The times of updates are exact multiples of their interval: the
//! interrupt computes them from the steps themselves and needs no clock. Where the article is
//! silent, the behaviour is our choice: an update that would leave the valid range is not made, but
//! sets `FAULT` (and `TIMER_DIV_ERROR` if it is too slow), and the motor continues at its last
//! valid speed; milliseconds end between two steps.

mod driver;
mod dump;
pub mod fit;
pub mod line;
mod order;
mod pace;
mod profile;
mod ramp;
mod station;
mod stepper;

pub use driver::{Driver, Hold};
pub use dump::{Dump, Field};
pub use order::{Call, Code, Control, SetSpeed, Status};
pub use pace::{Counts, Model, Pace};
pub use profile::Timed;
pub use station::{TimedStation, WiredMotor};
pub use stepper::Stepper;
