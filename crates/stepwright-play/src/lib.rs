//! Plays G-code jobs and files of motor cycles.
//!
//! ```text
//!   job.nc ─────► JobPlan ─► gcode::begin ───┐
//!                                            ├─► a virtual board ─► edges, positions
//!   cycles.toml ─► CyclePlan ─► CyclePlayer ─┘
//!                         └──► CyclesOnBoard ──► a board with the program `cycles`
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | `gcode` | a job on the virtual board |
//! | `cycle` | motor cycles, there and on a real board |
//! | `error` | why a file can't be played, with its place |
//! | `voice` | what is said meanwhile, and who may break it off |

#![warn(missing_docs)]
#![forbid(unsafe_code)]

pub mod cycle;
mod error;
pub mod gcode;
mod voice;

pub use error::{PlayError, PlayPlace};
pub use voice::{PlayFormat, PlayVoice};

use stepwright::Rate;

/// Ticks in µs, to a ns.
pub fn micros(ticks: u64, rate: Rate) -> String {
    let hz = u128::from(rate.hz());
    let nanos = (u128::from(ticks) * 1_000_000_000 + hz / 2) / hz;
    match (nanos / 1000, nanos % 1000) {
        (us, 0) => us.to_string(),
        (us, part) => format!("{us}.{part:03}").trim_end_matches('0').to_owned(),
    }
}
