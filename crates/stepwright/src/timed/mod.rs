//! The timed driver: speed that changes on a clock, as the Arduino driver describes it.
//!
//! A motor steps at a virtual top, the clocks between two steps, which a
//! [`fit`](crate::timer::fit) brings to a timer. At a fixed interval the top grows
//! or shrinks by a modification, which may double or halve each time; the motion ends
//! after this many steps or milliseconds, or never.
//!
//! ```text
//!        foreground                                 step interrupt
//!   SetSpeed ─► Driver ── begin, stop ─────────────► Pace ─► when the next step is due
//!              ▲  └────── two numbers: next, after ──►│ │
//!   update_check          (without IRQ_TIMING)        │ └─ updates under IRQ_TIMING
//!   callbacks  ◄───────── status ────────────────────┘
//! ```
//!
//! | file | what |
//! | --- | --- |
//! | `order` | control bits, the order, result codes, status bits |
//! | `ramp` | one update |
//! | `pace` | the interrupt's half |
//! | `stepper` | that with a motor's windings: what an interrupt calls |
//! | `driver` | the foreground's half |
//! | `dump` | the article's debug dump |
//! | `profile` | the same as an iterator of delays, and as a feed of the engine |
//!
//! **Error.** None against the article's arithmetic: all of it is integers, and a time is
//! the sum of the intervals that were played. The times of updates are exact multiples of
//! their interval, as the interrupt computes them from the steps themselves and needs no
//! clock. What is ours where the article is silent: an update that would leave the
//! valid range is not made, but sets `FAULT` (and `TIMER_DIV_ERROR` if it is too slow), and
//! the motor goes on at its last valid speed; milliseconds end between two steps.

mod driver;
mod dump;
mod order;
mod pace;
mod profile;
mod ramp;
mod stepper;

pub use driver::{Driver, Hold};
pub use dump::{Dump, Field};
pub use order::{Call, Code, Control, SetSpeed, Status};
pub use pace::{Counts, Model, Pace};
pub use profile::Timed;
pub use stepper::Stepper;
