//! What all axes share: the timer's rate, and how closely to follow a law.

use crate::num::{Hand, Num, hand, whole};
use crate::profile::Fit;
use crate::units::{Rate, Ticks};

/// The timer's rate and the fit, as the formulas want them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// 2f, in ticks · 0.001 steps/s.
    pub(super) twice: Num,
    /// Its inverse.
    pub(super) inverse: Num,
    /// Longest run, in ticks; a single step may always take longer.
    pub(super) longest: Num,
    /// Largest error of a step between two ends of runs, in ticks: as a power
    /// of two, which a number is quickly compared with.
    pub(super) bound: i8,
    /// Longest ramp run and longest level run, as powers of two.
    pub(super) ramp_size: u8,
    pub(super) level_size: u8,
}

impl Clock {
    /// A constant where rate and fit are constants: a chip does not compute it.
    #[inline(always)]
    pub(crate) const fn new(rate: Rate, fit: &Fit) -> Clock {
        // 2000 · rate: twice the rate, and a speed is in thousandths.
        let (twice, inverse) = Num::and_inverse(2000 * rate.hz() as u64);
        let (longest, _) = Num::and_inverse(fit.longest as u64);
        let bits = 63 - (fit.error | 1).leading_zeros() as i16;
        let (ramp_size, level_size) = (fit.ramp_size, fit.level_size);
        Clock { twice, inverse, longest, bound: (bits - 32) as i8, ramp_size, level_size }
    }

    /// The interval at a speed; beyond everything for 0.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn interval(&self, v: &Num) -> Hand {
        hand(v).under(&self.twice).scaled(-1)
    }

    /// Steps that take this many ticks each, in thousandths of a step per second, at most
    /// `u32::MAX`.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn in_a_second(&self, ticks: Ticks) -> u32 {
        whole(ticks).under(&self.twice).scaled(-1).split().0
    }

    /// Steps of this mean interval that may be one run, as a power of two: not too long,
    /// and their spread, less than the interval, within 31 bits of 2⁻¹⁶ ticks.
    pub(super) fn longest_of(&self, mean: &Num) -> i8 {
        if hand(mean).below(17) { self.longest.doublings_of(mean).max(0) } else { 0 }
    }

    /// 2²⁸ ticks or more, in 1000 s, as a power of two.
    pub(super) fn second_eighth(&self) -> i8 {
        // 2²⁹ / 2f, which is less than 2³⁰ and more than 2⁻¹⁶.
        self.inverse.exponent().wrapping_add(29) as i8
    }
}
