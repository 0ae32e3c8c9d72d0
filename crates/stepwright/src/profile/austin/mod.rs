//! Austin: ramps from the delay before.
//!
//! ```text
//!   c₀ = f·√(2/a)                           Eq 7 (in steps: α = 1)
//!   c(n) = c(n−1) − 2·c(n−1) / (4n + 1)     Eq 12, 13
//! ```
//!
//! Up with n = 1, 2 …; down with n = −j, j steps before the end (Eq 14), which
//! is the exact inverse: going down takes back what going up did. Smooth
//! transitions to the top speed change the divisor or scale the change.
//!
//! | law | file | source |
//! | --- | --- | --- |
//! | the published listing, delay for delay | [`fixed`] | 24.8 fixed point |
//! | constant acceleration | [`general`] | Eq 7, 12–15, 18, 19 |
//! | the same, changing its acceleration anywhere | [`ramp`] | Eq 13, 17, 18 |
//! | the same, changing its mind: target, speeds, ramps | [`motion`] | Eq 13, 16, 18 |
//! | acceleration reduced in stages | [`piecewise`] | Figure 5 |
//! | a power of n in the divisor | [`power`] | Eq 20, 21 |
//! | the change scaled by a linear factor | [`linear`] | Eq 22–25 |
//!
//! All but the first hold c in 2⁻³² ticks, round each change to the nearest, and
//! carry the part of a tick from delay to delay: each delay lies within a tick
//! of its formula, and so does each pulse's time. The law in the interrupt,
//! [`direct`](crate::direct), is the listing's arithmetic with the division's
//! remainder carried.

mod count;
pub mod fixed;
pub mod general;
pub mod linear;
pub mod motion;
pub mod piecewise;
pub mod power;
pub mod ramp;
mod travel;

pub use count::{C0, Law, Pulses};
pub use fixed::Fixed;
pub use general::{Austin, Divisor};
pub use linear::LinearFactor;
pub use motion::Motion;
pub use piecewise::Piecewise;
pub use power::PowerTerm;
pub use ramp::{Ramp, Slope};
pub use travel::{Shadowed, Travel};
