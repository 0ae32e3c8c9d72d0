//! Files for a page: the motion of their motors as a drawing, and runs that a page follows, holds and
//! stops.
//!
//! | module | what |
//! | --- | --- |
//! | `job` | a G-code job: planned within a limited time; run on a virtual board, or streamed to one |
//! | `job_drawing`, `thin`, `facts` | its drawing: points of the plan, thinned for a picture, and facts |
//! | `cycle_drawing` | motor cycles, as they are played on the virtual board |
//! | `cycle_run` | their run, in real time on the virtual board, or on a real one |
//!
//! ```
//! use stepwright_path::AxisPace;
//! use stepwright_play::page::PageJob;
//!
//! let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1e3, jump: 5.0, jerk: f64::INFINITY };
//! let text = "G0 X10\nG1 F600 X12 Y3\n";
//! let drawing = PageJob { name: "part.nc", text, axes: [axis; 3], laser: None }.draw()?;
//! assert_eq!((drawing.legs.len(), drawing.legs[1].kind), (2, "line"));
//! # Ok::<(), stepwright_play::PlayError>(())
//! ```

mod cycle_drawing;
mod cycle_run;
mod facts;
mod job;
mod job_drawing;
mod thin;

pub use cycle_drawing::draw_cycles;
pub use cycle_run::{play_cycles, play_cycles_on};
pub use job::PageJob;

use crate::stream::PlayWish;

/// Receives the progress of a run: seconds, the motors' positions, and the wish that they obey.
pub type PageListener<'a> = &'a mut dyn FnMut(f64, &[i64], PlayWish);
