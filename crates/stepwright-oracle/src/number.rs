//! The numbers with which an ideal is computed.

use core::ops::{Add, Div, Mul, Sub};

/// A real number.
pub trait Number:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// Iterations of Newton's method from the precision of an `f64` to that of this type.
    const ROUNDS: u32;

    /// A whole number, rounded to nearest.
    fn whole(n: u64) -> Self;

    /// An `f64`, exactly.
    fn from_f64(x: f64) -> Self;

    /// The nearest `f64`.
    fn to_f64(self) -> f64;

    /// The square root; 0 for negative numbers.
    fn root(self) -> Self;
}

impl Number for f64 {
    const ROUNDS: u32 = 0;

    fn whole(n: u64) -> f64 {
        n as f64
    }

    fn from_f64(x: f64) -> f64 {
        x
    }

    fn to_f64(self) -> f64 {
        self
    }

    fn root(self) -> f64 {
        libm::sqrt(self.max(0.0))
    }
}
