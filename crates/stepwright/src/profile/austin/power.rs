//! A power of n in the divisor (document 002, Eq 20, 21).
//!
//! ```text
//!   c(n) = c(n−1) − 2·c(n−1) / (4n + 1 + k·n^p)
//!   k = 4 / n_t^(p−1)          n_t = v² / 2a, the steps to the top speed v
//! ```
//!
//! so k·n^p = 4n·r^(p−1) with r = n/n_t, which stays in range for every p. The
//! approach to the top speed is asymptotic: the ramp ends, and its speed is
//! kept, where 1/1024 of the top speed is left. Down goes a ramp with the
//! deceleration back.
//!
//! For p = 2 that takes 512·n_t steps: a travel of ordinary length falls short
//! of the top speed. With n_t below some ten steps every p may.
//!
//! Error against the formulas in f64: each delay below one tick, each pulse's time
//! below one tick or 2⁻³⁰ of the time that has passed.

use super::count::{C0, Order, Pulses};
use super::travel::{Curve, Shadowed, Travel};
use crate::fixed::{Q32, divide, multiply, share, shl, shr, zeros};
use crate::profile::{Unfit, path::slope_of};
use crate::units::{Accel, Rate, Speed};

/// The powers that can be had.
pub const POWERS: core::ops::RangeInclusive<u8> = 2..=9;

/// A travel that approaches its top speed by a power term.
///
/// ```
/// use stepwright::profile::austin::PowerTerm;
/// use stepwright::{Accel, Rate, Speed};
/// let law = PowerTerm::new(Rate::MHZ, Speed::from_steps(400)?, Accel::from_steps(400)?, 4);
/// assert_eq!(law.delays(2000)?.count(), 2000);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PowerTerm {
    order: Order,
    power: u8,
}

impl PowerTerm {
    /// From rest to `top`, at `accel` first, and back to rest. `power` is
    /// brought into [`POWERS`]; the higher, the sharper the knee.
    pub fn new(rate: Rate, top: Speed, accel: Accel, power: u8) -> PowerTerm {
        let power = power.clamp(*POWERS.start(), *POWERS.end());
        PowerTerm { order: Order::new(rate, top, accel), power }
    }

    /// The same with a deceleration of its own.
    pub const fn with_decel(mut self, decel: Accel) -> PowerTerm {
        self.order.decel = decel;
        self
    }

    /// The same with another way to begin.
    pub const fn with_c0(mut self, c0: C0) -> PowerTerm {
        self.order.c0 = c0;
        self
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't hold it.
    pub fn delays(&self, pulses: u32) -> Result<Pulses<Travel<Shadowed<Knee>>>, Unfit> {
        let order = self.order.fitted(pulses)?;
        let shortest = order.shortest();
        let from_rest = |accel| {
            let (lead, count) = order.c0.counts(order.exact(accel));
            let (slope, top) = (slope_of(accel), order.top.squared());
            // 1/n_t = 2a / v²; less than a step to the top speed counts as one.
            let (n, d) = order.c0.part();
            let quarter = divide(slope.min(4 * top), 4 * top, 63); // top ≤ 10¹⁸
            let part = share(quarter, 4 * n, d).min(1 << 63);
            (lead, Knee { count, n: 0, part, power: self.power })
        };
        let ((lead, rise), (_, fall)) = (from_rest(order.accel), from_rest(order.decel));
        let enough = shortest.saturating_add(shortest >> 10);
        let travel = Travel::new(Shadowed::new(rise, fall, enough));
        Ok(Pulses::new(travel, lead, shortest, pulses))
    }
}

/// A ramp from rest with its power term.
#[derive(Clone, Debug)]
pub struct Knee {
    count: Q32,
    n: u32,
    /// 1/n_t in 2⁻⁶³.
    part: u64,
    power: u8,
}

impl Knee {
    /// r^(p−1) in 2⁻³², saturating.
    fn term(&self) -> Q32 {
        let (high, low) = multiply(self.part, self.n.into()); // 2⁻⁶³
        let r = shl(high, 33) | low >> 31;
        let mut term = r;
        for _ in 2..self.power {
            let (high, low) = multiply(term, r);
            if high >> 32 != 0 {
                return u64::MAX;
            }
            term = high << 32 | low >> 32;
        }
        term
    }

    /// 2 / (4n ± 1 + 4n·r^(p−1)) as a fraction of two integers.
    fn change(&self, odd: i64) -> (u64, u64) {
        let fours = 4 * u64::from(self.n);
        let (high, low) = multiply(fours, self.term()); // 2⁻³²
        let plain = fours.wrapping_add_signed(odd);
        let (low, carry) = low.overflowing_add(plain << 32);
        let high = high + (plain >> 32) + u64::from(carry); // < 2³⁴
        let by = 64 - zeros(high);
        let d = if by == 0 { low } else { shl(high, 64 - by) | shr(low, by) };
        (shr(2 << 32, by), d)
    }
}

impl Curve for Knee {
    fn up(&mut self) {
        self.n = self.n.saturating_add(1);
        let (n, d) = self.change(1);
        self.count -= share(self.count, n, d);
    }

    fn down(&mut self) -> (u64, u64) {
        let change = self.change(-1);
        self.n = self.n.saturating_sub(1).max(1);
        change
    }

    fn steps(&self) -> u32 {
        self.n
    }

    fn count(&self) -> Q32 {
        self.count
    }
}
