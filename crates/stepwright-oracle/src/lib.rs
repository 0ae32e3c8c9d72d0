//! The ideal times of the steps of a trapezoid and of an S-curve, as real numbers.
//!
//! The crate is the reference for the code that makes steps, so it shares no type, formula or
//! dependency with it. Speeds, accelerations and times are numbers in any consistent units.
//!
//! ```
//! use stepwright_oracle::{Double, IdealTrapezoid, Number};
//!
//! // From rest to 1000 steps/s at 2000 steps/s², and back: 500 ms, 250 steps each.
//! let [rest, top, twice, length] = [0, 1000, 2 * 2000, 1000].map(Double::whole);
//! let ideal = IdealTrapezoid::new((rest, rest), top, (twice, twice), length);
//! assert_eq!(ideal.time(Double::whole(250)).to_f64(), 0.5);
//! assert_eq!(ideal.total().to_f64(), 1.5);
//! ```
//!
//! | type | what |
//! | --- | --- |
//! | [`IdealTrapezoid`] | constant acceleration, a level, constant deceleration |
//! | [`IdealSCurve`] | the same with a limited jerk |
//! | [`Number`] | the numbers that both compute with: `f64`, or [`Double`] with 104 bits |
//!
//! Its own tests compare both with other formulas in 160 bits.

#![no_std]
#![warn(missing_docs)]
#![forbid(unsafe_code)]

mod double;
mod number;
mod s_curve;
mod trapezoid;

pub use double::Double;
pub use number::Number;
pub use s_curve::{IdealSCurve, JerkLimits};
pub use trapezoid::IdealTrapezoid;
