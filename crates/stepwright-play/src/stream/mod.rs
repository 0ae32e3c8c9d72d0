//! G-code jobs on a board with the program `stream`.
//!
//! A [`StreamedBoard`] is met once, at rest, and [plays](StreamedBoard::play) one job after another. A
//! [`JobWatch`] sees where the board is, and may hold, resume, brake or kill it at any time; a
//! [`PlayOrder`] is one for another thread.
//!
//! ```no_run
//! use stepwright_host::Session;
//! use stepwright_host::link::serial::{LeaseWait, SerialLink, Share};
//! use stepwright_plan::gcode::{JobPlan, JobTerms};
//! use stepwright_play::stream::{PlayOrder, StreamedBoard};
//! use stepwright_play::Mute;
//! # use stepwright_path::AxisPace;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let axes = [AxisPace { step: 0.0125, speed: 200.0, accel: 1e3, jump: 5.0, jerk: 2e4 }; 3];
//! let link = SerialLink::open("/dev/ttyACM0".as_ref(), 115_200, Share::Alone, |_| LeaseWait::Over)?;
//! let mut board = StreamedBoard::meet(Session::new(Box::new(link)), 115_200, &Mute)?;
//! let job = std::fs::read("part.nc")?;
//! let uno = stepwright_sim::Description::uno().board;
//! let plan = JobPlan::on(job.iter().copied(), axes, &JobTerms::default(), &uno, |_, _| ())?;
//! let played = board.play(job, axes, &plan, &mut &PlayOrder::default())?;
//! println!("{:?} steps after {} s", played.position, played.seconds);
//! # Ok(())
//! # }
//! ```

mod board;
mod run;
mod wish;

pub use board::{GREETING, StreamedBoard, spelt};
pub(crate) use run::REPORT;
pub use run::{JobWatch, LOOK, Place, Streamed};
pub use wish::{Obeyed, PlayEnd, PlayOrder, PlayWish};
