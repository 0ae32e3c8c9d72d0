//! The values that all axes share: the timer's rate, and the fit.

use crate::num::{Hand, Num, hand, whole};
use crate::profile::Fit;
use crate::units::{Rate, Ticks};

/// The timer's rate and the fit, in the form that the formulas need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// 2f, in ticks · 0.001 steps/s.
    pub(super) twice: Num,
    /// The inverse of `twice`.
    pub(super) inverse: Num,
    /// The longest run, in ticks; a single step may always take longer.
    pub(super) longest: Num,
    /// The largest error of a step within a run, in ticks, as a power of two, with which a number
    /// is quickly compared.
    pub(super) bound: i8,
    /// The longest ramp run and the longest level run, as powers of two.
    pub(super) ramp_size: u8,
    pub(super) level_size: u8,
}

impl Clock {
    /// A constant if rate and fit are constants: then a chip does not compute it.
    #[inline(always)]
    pub(crate) const fn new(rate: Rate, fit: &Fit) -> Clock {
        // 2000 · rate: twice the rate, and speeds are in thousandths.
        let (twice, inverse) = Num::and_inverse(2000 * rate.hz() as u64);
        let (longest, _) = Num::and_inverse(fit.longest as u64);
        let bits = 63 - (fit.error | 1).leading_zeros() as i16;
        let (ramp_size, level_size) = (fit.ramp_size, fit.level_size);
        Clock { twice, inverse, longest, bound: (bits - 32) as i8, ramp_size, level_size }
    }

    /// The interval at a speed; for 0 larger than any number in use.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn interval(&self, v: &Num) -> Hand {
        hand(v).under(&self.twice).scaled(-1)
    }

    /// The rate of steps that take this many ticks each, in thousandths of a step per second, at
    /// most `u32::MAX`.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn in_a_second(&self, ticks: Ticks) -> u32 {
        whole(ticks).under(&self.twice).scaled(-1).split().0
    }

    /// The longest run with this mean interval, as a power of two: not too long, and the spread of
    /// its intervals, which is less than the interval, within 31 bits of 2⁻¹⁶ ticks.
    pub(super) fn longest_of(&self, mean: &Num) -> i8 {
        if hand(mean).below(17) { self.longest.doublings_of(mean).max(0) } else { 0 }
    }

    /// 2²⁸ ticks or more, in 1000 s, as a power of two.
    pub(super) fn second_eighth(&self) -> i8 {
        // 2²⁹ / 2f, which is less than 2³⁰ and more than 2⁻¹⁶.
        self.inverse.exponent().wrapping_add(29) as i8
    }
}
