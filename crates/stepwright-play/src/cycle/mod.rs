//! Motor cycles: on the virtual board, and on a real one that runs the program `cycles`.
//!
//! | module | what |
//! | --- | --- |
//! | `text` | the file; a mistake in it ends the player |
//! | `player` | plays on the virtual board |
//! | `onlooker` | watches a player there, and may hold it up |
//! | `remote`, `port` | plays on a real board; the messages for its errors |
//! | `told` | the output about a cycle on either |
//!
//! ```
//! use std::fmt::Display;
//! use stepwright_play::cycle::{CyclePlayer, PlayText};
//! use stepwright_play::{PlayFormat, PlayVoice};
//!
//! struct Nobody;
//! impl PlayVoice for Nobody {
//!     fn result(&self, _: &dyn Display) {}
//!     fn note(&self, _: &dyn Display) {}
//!     fn asked(&self) -> bool {
//!         false
//!     }
//! }
//!
//! let text = PlayText::named("there.toml", r#"
//!     [[motor]]
//!     name = "X"
//!     step = 12_500
//!     smallest-delay-us = 100
//!     [[cycle]]
//!     move.X = { steps = 400, delay-us = 2000 }
//! "#);
//! let mut plan = stepwright_cyclefile::read(&text)?;
//! let mut stages = std::mem::take(&mut plan.stages);
//! let mut player = CyclePlayer::new(&plan, &text, (), PlayFormat::Json, &Nobody, None, 60);
//! player.play(&mut stages)?;
//! assert_eq!(player.positions(), [400 * 12_500]);
//! # Ok::<(), stepwright_play::PlayError>(())
//! ```

mod onlooker;
mod player;
mod port;
mod remote;
mod text;
mod told;

pub use onlooker::{Onlooker, PlayAhead, PlayPart};
pub use player::{CyclePlayer, PlayTape};
pub use port::failure;
pub use remote::CyclesOnBoard;
pub use text::PlayText;
