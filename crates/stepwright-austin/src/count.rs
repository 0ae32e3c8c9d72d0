//! The parts that all laws share: the first delay, and delays in whole ticks.

use crate::share::share;
use stepwright::fixed::{self, ONE, Q32, Scale, root};
use stepwright::profile::{Bounds, Phase, Unfit, slope_of};
use stepwright::units::{Accel, Rate, Speed, Ticks};

/// How a ramp begins. At n = 1 Eq 12 takes off too little: 0.6 of c₀ is left instead of 0.4142
/// (Table 1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum C0 {
    /// c₀ by Eq 7, uncorrected: every later delay is too long by 1/0.676, so the ramp has 0.457 of
    /// the acceleration. The law's steps are computed with that value, so it reaches the same top
    /// speed.
    Exact,
    /// c₀ · 0.676 (Eq 15): starts with a fast step. The article recommends this.
    #[default]
    Reduced,
    /// c₀ by Eq 7 and c₁ = 0.4056·c₀: an almost perfect ramp.
    FirstStep,
}

impl C0 {
    /// The delay before the second pulse, and the count from which the formula continues. As 0.4056
    /// = 0.6 · 0.676, the formula itself makes c₁.
    pub(crate) fn counts(self, exact: Q32) -> (Q32, Q32) {
        let reduced = share(exact, 676, 1000);
        match self {
            C0::Exact => (exact, exact),
            C0::Reduced => (reduced, reduced),
            C0::FirstStep => (exact, reduced),
        }
    }

    /// The part of the acceleration that the ramp actually has: 0.676² or 1.
    pub(crate) const fn part(self) -> (u64, u64) {
        match self {
            C0::Exact => (28_561, 62_500),
            C0::Reduced | C0::FirstStep => (1, 1),
        }
    }
}

/// The parameters of every law with constant acceleration and a top speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Order {
    pub rate: Rate,
    pub top: Speed,
    pub accel: Accel,
    pub decel: Accel,
    pub c0: C0,
}

impl Order {
    pub const fn new(rate: Rate, top: Speed, accel: Accel) -> Order {
        Order { rate, top, accel, decel: accel, c0: C0::Reduced }
    }

    /// The order adjusted to `pulses` pulses.
    ///
    /// If the acceleration makes the very first step too fast to brake from (J = a/2d steps, Eq 18
    /// with n = 0), it is lowered until it is not.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn fitted(mut self, pulses: u32) -> Result<Order, Unfit> {
        if pulses > 1 << 31 {
            return Err(Unfit::TooLong);
        }
        let most = (2 * u64::from(pulses.max(1)) - 1).saturating_mul(self.decel.millisteps());
        if let Ok(most) = Accel::from_millisteps(most) {
            self.accel = self.accel.min(most);
        }
        let Order { rate, top, .. } = self;
        let (a2, d2) = (slope_of(self.accel), slope_of(self.decel));
        Bounds { rate, start: Speed::ZERO, top, a2, d2 }.check()?;
        Ok(self)
    }

    /// c₀ by Eq 7 for an acceleration.
    pub fn exact(&self, accel: Accel) -> Q32 {
        let slope = slope_of(accel);
        Scale::new(self.rate, slope).time(root(slope)) // √(2a) / a
    }

    /// c_min: the interval at the top speed, at least a tick.
    pub fn shortest(&self) -> Q32 {
        fixed::interval(self.rate, self.top).max(ONE)
    }
}

/// A law that computes each delay from the one before.
pub trait Law {
    /// Moves to the next delay. `left` delays of the travel are left, including this one.
    fn advance(&mut self, left: u32) -> Phase;

    /// The delay, in 2⁻³² ticks.
    fn count(&self) -> u64;

    /// Ends the way up. Returns the steps of the way down, including the hold after the last pulse.
    fn stop(&mut self) -> u32;
}

/// The pulses of a travel as delays in ticks. The first is 0.
#[derive(Clone, Debug)]
pub struct Pulses<L> {
    law: L,
    /// c₀, until it has been handed out.
    lead: Option<Q32>,
    shortest: Q32,
    /// Whether the pulse at time 0 is still to come.
    first: bool,
    /// The number of delays left.
    left: u32,
    /// The fraction of a tick that is carried, half a tick ahead.
    part: u32,
    phase: Phase,
}

impl<L: Law> Pulses<L> {
    pub(crate) fn new(law: L, lead: Q32, shortest: Q32, pulses: u32) -> Pulses<L> {
        Pulses {
            law,
            lead: Some(lead),
            shortest,
            first: pulses > 0,
            left: pulses.saturating_sub(1),
            part: 1 << 31,
            phase: Phase::Up,
        }
    }

    /// The phase of the last delay.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The last delay before it was rounded to ticks, in 2⁻³² ticks; valid from the third delay on,
    /// the second being the law's first.
    pub fn unrounded(&self) -> Q32 {
        self.law.count().max(self.shortest)
    }

    /// The law, and the number of delays left, plus one if the law's first step is the next of
    /// them.
    pub(crate) fn law(&mut self) -> (&mut L, u32) {
        let left = self.left + u32::from(self.lead.is_none()); // at most 2³¹
        (&mut self.law, left)
    }

    /// Brakes from here: ends after the steps of the way down, or where the travel would have ended
    /// anyway.
    pub fn stop(&mut self) {
        // The last step of the way down is the hold after the last pulse.
        self.left = self.left.min(self.law.stop().saturating_sub(1));
    }

    /// The delay by the formula, before it is rounded to ticks.
    fn count(&mut self) -> Q32 {
        let count = match self.lead.take() {
            Some(lead) => lead,
            None => {
                self.phase = self.law.advance(self.left);
                self.law.count()
            }
        };
        count.max(self.shortest)
    }
}

impl<L: Law> Iterator for Pulses<L> {
    type Item = Ticks;

    #[inline]
    fn next(&mut self) -> Option<Ticks> {
        if core::mem::take(&mut self.first) {
            return Some(0);
        }
        if self.left == 0 {
            return None;
        }
        let due = self.count().saturating_add(self.part.into());
        self.left -= 1;
        self.part = due as u32;
        Some((due >> 32) as Ticks)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = u64::from(self.left) + u64::from(self.first);
        let left = usize::try_from(left).unwrap_or(usize::MAX);
        (left, Some(left))
    }
}

impl<L: Law> ExactSizeIterator for Pulses<L> {}
