//! A power of n in the divisor (Austin, Eq 20, 21).
//!
//! ```text
//!   c(n) = c(n−1) − 2·c(n−1) / (4n + 1 + k·n^p)
//!   k = 4 / n_t^(p−1)          n_t = v² / 2a, the steps to the top speed v
//! ```
//!
//! so k·n^p = 4n·r^(p−1) with r = n/n_t, which stays in range for every p. The approach to the top
//! speed is asymptotic. The formula is followed while there is room for the way down, which is a
//! ramp with the deceleration in reverse: a travel goes up for half of its steps, and speeds that
//! the way down could not have are left out. If the formula exceeds the top speed, the top speed is
//! kept.
//!
//! With n_t = 200 steps, p = 4 reaches 0.99864 of the top speed after 1,000 steps and 0.99995 after
//! 4,000; p = 2 reaches 0.914 and 0.977. With n_t below some ten steps any p may fall short.
//!
//! Error against the formulas in f64: each delay below one tick, the time of each pulse below one
//! tick or 2⁻³⁰ of the elapsed time.

use super::count::{C0, Order, Pulses};
use super::travel::{Curve, Shadowed, Travel};
use crate::share::share;
use stepwright::fixed::{Q32, divide, multiply, shl, shr, zeros};
use stepwright::profile::{Unfit, slope_of};
use stepwright::units::{Accel, Rate, Speed};

/// The supported powers.
pub const POWERS: core::ops::RangeInclusive<u8> = 2..=9;

/// A travel that approaches its top speed by a power term.
///
/// ```
/// use stepwright_austin::PowerTerm;
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
    /// From rest to `top`, initially at `accel`, and back to rest. `power` is limited to
    /// [`POWERS`]; the higher, the sharper the knee.
    pub fn new(rate: Rate, top: Speed, accel: Accel, power: u8) -> PowerTerm {
        let power = power.clamp(*POWERS.start(), *POWERS.end());
        PowerTerm { order: Order::new(rate, top, accel), power }
    }

    /// This travel with another deceleration.
    pub const fn with_decel(mut self, decel: Accel) -> PowerTerm {
        self.order.decel = decel;
        self
    }

    /// This travel with another way to begin.
    pub const fn with_c0(mut self, c0: C0) -> PowerTerm {
        self.order.c0 = c0;
        self
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn delays(&self, pulses: u32) -> Result<Pulses<Travel<Shadowed<Knee>>>, Unfit> {
        Ok(self.constants(pulses)?.delays(pulses))
    }

    /// The constants that the steps of a travel of `pulses` pulses need.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn constants(&self, pulses: u32) -> Result<PowerConstants, Unfit> {
        let order = self.order.fitted(pulses)?;
        let from_rest = |accel| {
            let (lead, count) = order.c0.counts(order.exact(accel));
            let (slope, top) = (slope_of(accel), order.top.squared());
            // 1/n_t = 2a / v²; less than a step to the top speed counts as one.
            let (n, d) = order.c0.part();
            let quarter = divide(slope.min(4 * top), 4 * top, 63); // top ≤ 10¹⁸
            (lead, (count, share(quarter, 4 * n, d).min(1 << 63)))
        };
        let ((lead, rise), (_, fall)) = (from_rest(order.accel), from_rest(order.decel));
        Ok(PowerConstants { lead, shortest: order.shortest(), rise, fall, power: self.power })
    }
}

/// The constants of a travel with a power term: delays in 2⁻³² ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PowerConstants {
    /// The first delay.
    pub lead: Q32,
    /// c_min.
    pub shortest: Q32,
    /// For the way up: the delay from which the formula continues, and 1/n_t in 2⁻⁶³, at most 1.
    pub rise: (Q32, u64),
    /// The same for the way down, as a ramp from rest.
    pub fall: (Q32, u64),
    /// p, one of [`POWERS`].
    pub power: u8,
}

impl PowerConstants {
    /// The delay before each of `pulses` pulses; the first is 0.
    pub fn delays(&self, pulses: u32) -> Pulses<Travel<Shadowed<Knee>>> {
        let PowerConstants { lead, shortest, rise, fall, power } = *self;
        let knee = |(count, part)| Knee { count, change: count, n: 0, part, power };
        let travel = Travel::new(Shadowed::new(knee(rise), knee(fall), shortest));
        Pulses::new(travel, lead, shortest, pulses)
    }
}

/// A ramp from rest with its power term.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Knee {
    count: Q32,
    /// By how much the last step up shortened the delay.
    change: Q32,
    n: u32,
    /// 1/n_t in 2⁻⁶³.
    part: u64,
    power: u8,
}

/// A number as 64 bits with the highest set, times a power of two.
#[derive(Clone, Copy)]
struct Wide(u64, i32);

impl Wide {
    /// (high, low) · 2^power.
    #[inline(always)]
    fn new(product: (u64, u64), power: i32) -> Wide {
        let (top, by) = normal(&product);
        Wide(top, power + by)
    }

    fn times(self, other: Wide) -> Wide {
        Wide::new(multiply(self.0, other.0), self.1 + other.1)
    }

    /// In 2^−bits, for numbers that fit.
    fn fixed(self, bits: i32) -> u64 {
        match -(self.1 + bits) {
            by @ 0..=63 => shr(self.0, by as u8),
            _ => 0,
        }
    }
}

/// The upper 64 bits of (high, low) from its highest set bit on, and their power of two.
///
/// By reference: numbers of 16 bytes and more are too many arguments for a Mega.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn normal(&(high, low): &(u64, u64)) -> (u64, i32) {
    match zeros(high) {
        0 => (high, 64),
        64 => (shl(low, zeros(low)), -i32::from(zeros(low))),
        by => (shl(high, by) | shr(low, 64 - by), 64 - i32::from(by)),
    }
}

impl Knee {
    /// 4n·r^(p−1).
    fn term(&self) -> Wide {
        let r = Wide::new(multiply(self.part, self.n.into()), -63);
        (1..self.power).fold(Wide::new((0, 4 * u64::from(self.n)), 0), |term, _| term.times(r))
    }

    /// 2 / (4n ± 1 + 4n·r^(p−1)) as a fraction of two integers, with as many fractional bits as the
    /// divisor leaves of 63.
    fn change(&self, odd: i64) -> (u64, u64) {
        let plain = (4 * u64::from(self.n)).wrapping_add_signed(odd);
        let term = self.term();
        let bits = (i32::from(zeros(plain)) - 2).min(-2 - term.1);
        if bits < 0 {
            return (0, 1); // beyond 2⁶¹: less than a last place of c
        }
        (shl(2, bits as u8), shl(plain, bits as u8) + term.fixed(bits))
    }
}

impl Curve for Knee {
    fn up(&mut self) {
        self.n = self.n.saturating_add(1);
        // Each step takes off less than the one before: after one that takes off nothing, none
        // does. A small chip has no room for the shortcut.
        if self.change == 0 && cfg!(any(target_pointer_width = "64", target_family = "wasm")) {
            return;
        }
        let (n, d) = self.change(1);
        self.change = share(self.count, n, d);
        self.count -= self.change;
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

    /// All steps to come together take off less than 2n times the last step's change: without the
    /// power term c ~ n^−½, so that they take off c = 2n·(c/2n), and with it the changes shrink
    /// faster. Twice that covers all rounding.
    fn stays_above(&self, count: Q32) -> bool {
        let to_come = self.change.saturating_mul(4 * u64::from(self.n.max(1)));
        self.count.saturating_sub(count) > to_come
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A ramp that takes no shortcut: each change is computed, and no ramp equals another.
    #[derive(Clone, Debug)]
    struct Plain(Knee);

    impl PartialEq for Plain {
        fn eq(&self, _: &Plain) -> bool {
            false
        }
    }

    impl Curve for Plain {
        fn up(&mut self) {
            self.0.change = Q32::MAX;
            self.0.up();
        }

        fn down(&mut self) -> (u64, u64) {
            self.0.down()
        }

        fn steps(&self) -> u32 {
            self.0.steps()
        }

        fn count(&self) -> Q32 {
            self.0.count()
        }

        fn stays_above(&self, count: Q32) -> bool {
            self.0.stays_above(count)
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn shortcuts_change_no_delay(
            top in 1u32..20_000, accel in 1u32..200_000, decel in 1u32..200_000, even: bool,
            power in 2u8..10, pulses in 1u32..60_000,
        ) {
            let accel = Accel::from_steps(accel).unwrap();
            let decel = if even { accel } else { Accel::from_steps(decel).unwrap() };
            let law = PowerTerm::new(Rate::MHZ, Speed::from_steps(top).unwrap(), accel, power);
            let law = law.with_decel(decel);
            let Ok(PowerConstants { lead, shortest, rise, fall, power }) = law.constants(pulses)
            else { return Ok(()) };
            let plain = |(count, part)| Plain(Knee { count, change: count, n: 0, part, power });
            let plain = Travel::new(Shadowed::new(plain(rise), plain(fall), shortest));
            let plain = Pulses::new(plain, lead, shortest, pulses);
            prop_assert!(law.delays(pulses).unwrap().eq(plain));
        }
    }
}
