//! Orders to a board, as subcommands.
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
//! They share [`target`] (the board), [`able`] (its abilities), [`refused`] (reasons of refusals),
//! [`motion`] (speeds), [`law`] (ramp laws; [`by_law`] carries out Austin's), [`drive`] (starting,
//! watching, stopping), [`homing`] (failures of a homing), [`lease`] (braking when the host is
//! silent), [`progress`] (the display during a motion) and [`keys`] (keys during a motion, on a
//! [`terminal`]).

pub mod able;
mod by_law;
pub mod drive;
mod held;
pub mod home;
pub mod homing;
pub mod jog;
mod keys;
pub mod law;
pub mod lease;
mod left;
pub mod line;
pub mod look;
pub mod motion;
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
