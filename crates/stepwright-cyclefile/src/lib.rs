//! Files of motor cycles: the moves of several motors, read and checked, with the place of every mistake.
//!
//! ```
//! use stepwright_cyclefile::{CycleText, read};
//!
//! let text = CycleText::named("there.toml", r#"
//!     [[motor]]
//!     name = "X"
//!     step = 12_500
//!     smallest-delay-us = 100
//!     [[cycle]]
//!     move.X = { steps = 400, delay-us = 2000 }
//! "#);
//! let plan = read(&text).unwrap();
//! assert_eq!((plan.names.len(), plan.stages.len()), (1, 1));
//!
//! let wrong = CycleText::named("there.toml", text.text.replace("400", "many"));
//! assert_eq!(read(&wrong).err().unwrap().line, 7);
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | `file` | the file, as serde reads it |
//! | `plan` | the file, checked: [`CyclePlan`] |
//! | `pins` | the pins of a board that a file names |
//! | `along` | a line or an arc from the positions of the motors |
//! | `joined` | several lines and arcs in one cycle, without a stop |
//! | `text` | the text, and the place of a mistake |

#![warn(missing_docs)]
#![forbid(unsafe_code)]

mod along;
mod file;
mod joined;
mod pins;
mod plan;
mod text;

pub use along::along;
pub use joined::{Joined, JoinedPath};
pub use pins::Pins;
pub use plan::{Act, CyclePlan, MOST, Move, Stage, Task, TimedAct, read};
pub use text::{CycleText, FileError, LONGEST};
