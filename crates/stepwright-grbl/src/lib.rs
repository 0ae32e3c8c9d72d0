//! A machine that any G-code sender can drive: grbl 1.1's protocol as a state machine without I/O.
//! It takes bytes and times, and returns answers, steps and switched outputs.
//!
//! ```text
//!   sender ──bytes──► receive ──┬─ real-time: ? ! ~ ^X, overrides ───────────────┐
//!                               └─ lines ─► $ orders                             ▼
//!                                         └► Reader ─► effects ─► Route ─► steps ─► GrblMachine
//!   sender ◄─answers─ take_answers                     (G-code)   (look-ahead)
//! ```
//!
//! ```
//! use stepwright_grbl::{Grbl, VirtualMill};
//! let mut grbl = Grbl::new(VirtualMill::default());
//! grbl.receive(0.0, b"G21 G91 G1 X1 F500\n");
//! let mut now = 0.0;
//! while grbl.is_moving() {
//!     now += 0.001;
//!     grbl.advance(now);
//! }
//! assert_eq!(grbl.machine().at, [250, 0, 0]); // $100=250.000 steps/mm
//! let said = String::from_utf8(grbl.take_answers()).unwrap();
//! assert!(said.starts_with("\r\nGrbl 1.1h ['$' for help]\r\n") && said.ends_with("ok\r\n"));
//! ```
//!
//! # What it does as grbl does
//!
//! Real-time bytes, status reports with their fields and their order, `$` orders, settings,
//! start-up lines, messages, errors, alarms, check mode, jogging, probing, homing, soft and hard
//! limits, work offsets, overrides, laser mode. `ok` and `error:N` come at the same moment as
//! grbl's: when a line has its place in the planner, or a dwell has ended.
//!
//! # What it does otherwise
//!
//! - **A position is never lost.** A reset, a limit or the end of a jog brakes along the path. Then
//!   comes the banner or the alarm. `ALARM:3` comes only from a board that was lost or has left the
//!   path.
//! - **An error ends a job.** After an error in G-code, lines are refused with `error:9` until
//!   [`QUIET`] seconds pass without a line, or `$X` or a reset comes: otherwise a part of what was
//!   sent ahead would be executed without the faulty line. [`Grbl::with_errors_passed`] selects
//!   grbl's way.
//! - A laser at rest is off, with M3 too. After an error it is off until the next M3 or M4.
//! - The planner has 128 blocks, and the speed at a corner comes from `$140` to `$142`, the start
//!   speeds of the motors in mm/min, unless `$11` asks for a junction deviation. `$150` to `$152` limit
//!   the jerk of the axes, in mm/s³.
//! - Homing finds the switches of Z, X and Y one after another, and measures from the switch's edge.
//! - `$0` to `$6`, `$12` and `$26` are kept for the sender and change nothing.

#![forbid(unsafe_code)]

mod fed;
mod homing;
mod kept;
mod line;
mod machine;
mod motion;
mod orders;
mod outputs;
mod overrides;
mod rates;
mod report;
mod session;
mod settings;
mod state;
mod work;

pub use fed::FedRun;
pub use kept::NotKept;
pub use line::QUIET;
pub use machine::{GrblMachine, Inputs, Outputs, VirtualMill};
pub use rates::RateJudge;
pub use session::{Grbl, KEPT, RX};
pub use settings::{GrblSettings, SettingFault};
