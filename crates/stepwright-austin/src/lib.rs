#![no_std]
#![forbid(unsafe_code)]
//! David Austin's stepper motor ramps: each delay from the one before.
//!
//! A ramp of constant acceleration needs a square root for the time of each step. Austin's article
//! of 2004 replaced it by one division: the next delay c(n) is the last one minus 2c/(4n + 1). Most
//! small stepper libraries are based on it. This crate has the published listing unchanged, the
//! general form with its own deceleration, ramps that change on the way, and the article's three
//! gentle transitions to the top speed. Each law is an iterator of delays in ticks of a timer, in
//! integers that are the same on an 8-bit chip and on a PC.
//!
//! ```
//! use stepwright::{Accel, Rate, Speed};
//! use stepwright_austin::Austin;
//!
//! // A timer of 1 MHz, at most 400 steps/s, up and down at 1000 steps/s².
//! let law = Austin::new(Rate::MHZ, Speed::from_steps(400)?, Accel::from_steps(1000)?);
//!
//! // 500 pulses: the delay before each, in µs. The first pulse comes at once.
//! let delays: Vec<u32> = law.delays(500)?.collect();
//! assert_eq!(delays.len(), 500);
//! assert_eq!(delays[..4], [0, 30_232, 18_139, 14_108]);
//! assert_eq!(delays[250], 2_500); // 400 steps/s
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! On a chip: wait for the delay, pulse, ask for the next delay; or let
//! [`Compress`](stepwright::compress::Compress) make runs of the delays, which the engine plays in
//! the background.
//!
//! # The way of the data
//!
//! ```text
//!  timer, top speed, ─► law ─────────────► Pulses ──► delays in ticks ─► your own loop
//!  acceleration         c(n) from c(n−1),  Iterator        │
//!                       2⁻³² ticks                          └─► Compress ─► runs ─► Engine
//! ```
//!
//! # The law
//!
//! ```text
//!   c₀ = f·√(2/a)                           Eq 7 (in steps: α = 1)
//!   c(n) = c(n−1) − 2·c(n−1) / (4n + 1)     Eq 12, 13
//! ```
//!
//! Up with n = 1, 2 …; down with n = −j, j steps before the end (Eq 14), which is the exact
//! inverse: the way down takes back what the way up did. Smooth transitions to the top speed change
//! the divisor or scale the change.
//!
//! | law | file | source |
//! | --- | --- | --- |
//! | the published listing, delay for delay | [`fixed`] | 24.8 fixed point |
//! | the same, carrying the remainder of each division | [`carried`]; as a feed of the engine [`direct`] | 24.8 fixed point |
//! | constant acceleration | [`general`] | Eq 7, 12–15, 18, 19 |
//! | the same, with changes of the acceleration anywhere | [`ramp`] | Eq 13, 17, 18 |
//! | the same, with changes of target, speeds and ramps | [`motion`] | Eq 13, 16, 18 |
//! | acceleration reduced in stages | [`piecewise`] | Figure 5 |
//! | a power of n in the divisor | [`power`] | Eq 20, 21 |
//! | the change scaled by a linear factor | [`linear`] | Eq 22–25 |
//!
//! A [`Recipe`] is any of the laws with its constants; a [`Station`] follows one, as ordered over
//! the serial line of [`line`](mod@line).
//!
//! All but the first two keep c in 2⁻³² ticks, round each change to nearest, and carry the fraction
//! of a tick from delay to delay: each delay is within a tick of its formula, and so is the time of
//! each pulse.
//!
//! # Source
//!
//! David Austin, *Generate stepper-motor speed profiles in real time*, Embedded.com, 30 December
//! 2004. Equation, figure and table numbers in these files are those of the article.

pub mod carried;
#[cfg(any(feature = "constant", feature = "transitions", feature = "power"))]
pub mod choice;
mod count;
pub mod direct;
pub mod fixed;
pub mod general;
#[cfg(any(feature = "constant", feature = "transitions", feature = "power"))]
pub mod line;
pub mod linear;
pub mod motion;
pub mod piecewise;
pub mod power;
pub mod ramp;
mod share;
#[cfg(any(feature = "constant", feature = "transitions", feature = "power"))]
pub mod station;
mod travel;

pub use carried::Carried;
#[cfg(any(feature = "constant", feature = "transitions", feature = "power"))]
pub use choice::{AnyLaw, LawName, Recipe};
pub use count::{C0, Law, Pulses};
pub use direct::Direct;
pub use fixed::Fixed;
pub use general::{Austin, Divisor};
pub use linear::LinearFactor;
pub use motion::Motion;
pub use piecewise::Piecewise;
pub use power::PowerTerm;
pub use ramp::{Ramp, Slope};
#[cfg(any(feature = "constant", feature = "transitions", feature = "power"))]
pub use station::Station;
pub use travel::{Shadowed, Travel};
