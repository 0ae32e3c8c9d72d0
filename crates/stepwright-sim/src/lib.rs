#![cfg_attr(not(feature = "std"), no_std)]
//! The virtual board: Stepwright's engine with simulated pins and time.
//!
//! Engine, planner and protocol are the real ones; only the timer and the pins are simulated. The command, the
//! tests and the page talk to a virtual board exactly as to a chip, and its edges are the chip's, tick for
//! tick.
//!
//! ```
//! use stepwright_sim::{Description, Edge, Queues, VirtualBoard};
//! let mut queues = Queues::default();
//! let mut board: VirtualBoard<u16, Vec<Edge>> =
//!     VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
//! for byte in *b"PO\rG+3\rE\r" {
//!     board.receive(byte);
//! }
//! assert_eq!(board.take_answers(), b"Y\rY\rY\r");
//! board.run_to_rest();
//! assert_eq!(board.position(0), Some(3));
//! assert_eq!(board.recorder().iter().filter(|e| e.is_step()).count(), 3);
//! ```
//!
//! Without the Cargo feature `std` the crate has the board alone, which does not allocate.

#[cfg(feature = "std")]
mod axis_drive;
mod board;
mod clock;
#[cfg(feature = "std")]
mod cycle;
mod description;
mod edge;
mod few;
mod hard_stop;
#[cfg(feature = "std")]
mod laws;
mod panel;
mod pins;
#[cfg(feature = "std")]
mod program;
mod shaft;
mod steppers;
#[cfg(feature = "std")]
mod stream;
mod switch;
#[cfg(feature = "std")]
pub mod timed;
#[cfg(feature = "std")]
pub mod vcd;

#[cfg(feature = "std")]
pub use axis_drive::AxisDrive;
pub use board::{AXES, Queues, VirtualBoard};
#[cfg(feature = "std")]
pub use clock::Now;
pub use clock::{LentNow, Present, SimTimer};
#[cfg(feature = "std")]
pub use cycle::{CycleBoard, CycleLineBoard, CyclePins, Stand};
pub use description::Description;
pub use edge::{Edge, Pin, Recorder};
#[cfg(not(feature = "std"))]
pub use few::Few;
pub use few::{Answers, EnableChanges};
pub use hard_stop::HardStop;
#[cfg(feature = "std")]
pub use laws::LawBoard;
pub use panel::{EMPTY, Eeprom, Remains};
#[cfg(feature = "std")]
pub use program::{ProgramBoard, SimProgram};
pub use shaft::Shaft;
pub use steppers::{
    SimEngine, VirtualSteppers, virtual_engine, virtual_steppers, virtual_steppers_of,
};
pub use stepwright_device::{Mark, Reset};
#[cfg(feature = "std")]
pub use stream::StreamBoard;
pub use switch::{Switch, Switched, run_switched};
