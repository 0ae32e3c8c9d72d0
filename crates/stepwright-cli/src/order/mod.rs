//! Orders to a board: what a master can say, as subcommands.
//!
//! | module | subcommand |
//! | --- | --- |
//! | [`travel`] | `move` |
//! | [`run`] | `run` |
//! | [`jog`] | `jog` |
//! | [`retarget`] | `retarget` |
//! | [`watch`] | `watch` |
//! | [`home`] | `home` |
//! | [`stop`] | `stop`, `kill` |
//! | [`look`] | `status`, `position`, `zero` |
//! | [`send`] | `send` |
//! | [`settings`] | `settings` |
//! | [`ports`] | `ports` |
//!
//! They share [`target`] (which board), [`able`] (what it can do), [`refused`] (why it does not), [`motion`] (which speeds), [`law`] (which ramps; [`by_law`] carries Austin's out), [`drive`]
//! (start, watch, stop), [`homing`] (what comes after what), [`lease`] (what the board does without us), [`progress`] (what the user sees meanwhile) and [`keys`]
//! (what the user presses meanwhile, on a [`terminal`]).

pub mod able;
mod by_law;
pub mod drive;
mod held;
pub mod home;
pub mod homing;
pub mod jog;
mod keys;
mod law;
pub mod lease;
mod left;
pub mod line;
pub mod look;
pub mod motion;
pub mod places;
pub mod ports;
pub mod progress;
pub mod refused;
pub mod retarget;
pub mod run;
mod screen;
pub mod send;
pub mod settings;
pub mod stop;
pub mod target;
pub mod terminal;
pub mod travel;
pub mod watch;
