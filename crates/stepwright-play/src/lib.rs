//! Plays G-code jobs and files of motor cycles.
//!
//! ```text
//!                 ┌─► StreamedBoard ─► a board with the program `stream`
//!   job.nc ─────► JobPlan ─► gcode::begin ───┐
//!                                            ├─► a virtual board ─► edges, positions
//!   cycles.toml ─► CyclePlan ─► CyclePlayer ─┘
//!                         └──► CyclesOnBoard ──► a board with the program `cycles`
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | `gcode` | G-code jobs on the virtual board |
//! | `stream` | G-code jobs on a real one |
//! | `timed` | orders of the timed driver, on the virtual board |
//! | `cycle` | motor cycles, on the virtual board and on a real one |
//! | `page` | drawings of such files, and runs that a page follows |
//! | `edges` | the last edges of a virtual board's pins |
//! | `error` | why a file can't be played, with its place |
//! | `voice` | output during the playing, and interruption |

#![warn(missing_docs)]
#![forbid(unsafe_code)]

pub mod cycle;
pub mod edges;
mod error;
pub mod gcode;
pub mod page;
pub mod stream;
pub mod timed;
mod voice;

pub use error::{PlayError, PlayPlace};
pub use voice::{Mute, PlayFormat, PlayVoice};

use stepwright::Rate;

/// Ticks as µs, rounded to a ns.
pub fn micros(ticks: u64, rate: Rate) -> String {
    let hz = u128::from(rate.hz());
    let nanos = (u128::from(ticks) * 1_000_000_000 + hz / 2) / hz;
    match (nanos / 1000, nanos % 1000) {
        (us, 0) => us.to_string(),
        (us, part) => format!("{us}.{part:03}").trim_end_matches('0').to_owned(),
    }
}
