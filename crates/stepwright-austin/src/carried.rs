//! Austin's ramp, carrying the remainder of each division.
//!
//! ```text
//!   c(n) = c(n−1) − 2·c(n−1) / (4n+1)      up: n = 1, 2 …
//!   c(n) = c(n−1) + 2·c(n−1) / (4n−1)      down: n counts back
//!   c(0) = 0.676·f·√(2/a)                  Eq 7 and 15
//! ```
//!
//! Intervals are kept in 2⁻⁸ ticks, as in the article. The remainder of a division is added to the
//! next one: at high speed, where 2c is less than 4n+1, the interval still falls, so the ramp can't
//! stall below its top speed. [`Fixed`](super::Fixed) truncates instead, like the published
//! listing; [`Austin`](super::Austin) keeps to the formula within a tick. The ramp down counts the
//! steps of the ramp up, so it ends exactly, and mirrors it within 0.2 %.
//!
//! **Error.** Against constant acceleration the interval is 2.1 % off at n = 1, 0.75 % at n = 2 and
//! less than 0.04 % from n = 10 on; the number of steps of a ramp to its top speed is right within
//! 2 %.

use stepwright::units::Ticks;

/// Fractional bits of an interval.
pub(crate) const BITS: u32 = 8;
/// The longest interval of this law, 0.26 s at 16 MHz: with [`LAST_DIVISOR`], a remainder and twice
/// an interval fit in 32 bits.
pub(crate) const LONGEST: Ticks = (1 << 22) - 1;
/// A ramp has at most 2²⁹ steps.
const LAST_DIVISOR: u32 = 1 << 31;

/// One travel along Austin's ramp.
///
/// ```
/// use stepwright_austin::Carried;
/// // The article's demo: 1 MHz, the first delay 50000, the shortest 2500.
/// let delays: Vec<_> = Carried::new(10, 50_000, 2_500).collect();
/// assert_eq!(delays[..5], [50_000, 30_000, 23_333, 19_744, 17_421]);
/// assert_eq!(delays.len(), 9); // between 10 pulses
/// ```
#[derive(Clone, Debug)]
pub struct Carried {
    /// The next interval, in 2⁻⁸ ticks.
    delay: u32,
    /// 4n+1, for the n steps of the ramp so far.
    divisor: u32,
    /// The number of intervals left before those of the ramp down.
    margin: u32,
    /// The remainder of the division.
    rest: u32,
    /// The shortest interval, in 2⁻⁸ ticks.
    shortest: u32,
    /// The interval that the top speed cut short, for the way down; or 0.
    top: u32,
    /// Whether the travel is on the way down.
    down: bool,
}

impl Carried {
    /// No travel.
    pub const NONE: Carried =
        Carried { delay: 0, divisor: 0, margin: 0, rest: 0, shortest: 0, top: 0, down: false };

    /// `pulses` pulses: the first delay is `first` ticks, the shortest `shortest`. Delays are at
    /// least 1 tick and at most 2²² − 1; if `first` is shorter than `shortest`, the speed is
    /// constant at `shortest`.
    pub fn new(pulses: u32, first: Ticks, shortest: Ticks) -> Carried {
        let shortest = shortest.clamp(1, LONGEST) << BITS;
        let delay = (first.clamp(1, LONGEST) << BITS).max(shortest);
        Carried { delay, shortest, margin: pulses.saturating_sub(1), divisor: 1, ..Carried::NONE }
    }

    /// Brakes from here, in as many steps as the ramp has taken.
    pub fn stop(&mut self) {
        self.margin = 0;
    }

    /// The next interval, in 2⁻⁸ ticks.
    #[inline]
    pub(crate) fn step(&mut self) -> Option<u32> {
        let delay = self.delay;
        match self.margin.checked_sub(1) {
            None if self.divisor == 1 => return None,
            None => self.slow_down(),
            // A step at the speed reached: the middle of an even travel.
            Some(0) => self.margin = 0,
            Some(left) => {
                self.margin = left;
                self.speed_up();
            }
        }
        Some(delay)
    }

    fn speed_up(&mut self) {
        if self.delay <= self.shortest || self.divisor >= LAST_DIVISOR {
            return;
        }
        self.margin = self.margin.wrapping_sub(1); // for the way down
        self.divisor = self.divisor.wrapping_add(4);
        let dividend = self.delay.wrapping_mul(2).saturating_add(self.rest);
        let (less, rest) = divided(dividend, self.divisor);
        self.delay = self.delay.saturating_sub(less);
        self.rest = rest;
        if self.delay <= self.shortest {
            self.top = self.delay;
            self.delay = self.shortest;
        }
    }

    fn slow_down(&mut self) {
        if !core::mem::replace(&mut self.down, true) {
            self.rest = 0; // it belongs to the other ramp
            if self.top != 0 {
                self.delay = self.top;
            }
        }
        let dividend = self.delay.wrapping_mul(2).saturating_add(self.rest);
        let (more, rest) = divided(dividend, self.divisor.wrapping_sub(2));
        self.delay = self.delay.saturating_add(more);
        self.rest = rest;
        self.divisor = self.divisor.wrapping_sub(4);
    }
}

/// Quotient and remainder. Bit by bit: the quotient is short where time is short, at high speed,
/// and an 8-bit chip shifts one place at a time.
fn divided(mut dividend: u32, divisor: u32) -> (u32, u32) {
    if divisor == 0 {
        return (0, 0);
    }
    let (mut quotient, mut part, mut bits) = (0u32, divisor, 1u8);
    while part <= dividend >> 1 {
        part <<= 1;
        bits = bits.wrapping_add(1);
    }
    while bits != 0 {
        quotient <<= 1;
        if dividend >= part {
            dividend = dividend.wrapping_sub(part);
            quotient |= 1;
        }
        part >>= 1;
        bits = bits.wrapping_sub(1);
    }
    (quotient, dividend)
}

impl Iterator for Carried {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        Some(self.step()?.saturating_add(1 << (BITS - 1)) >> BITS)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn delays(pulses: u32, first: Ticks, shortest: Ticks) -> Vec<Ticks> {
        Carried::new(pulses, first, shortest).collect()
    }

    #[test]
    fn short_travels_of_the_document() {
        assert_eq!(delays(3, 50_000, 2_500), [50_000, 30_000]);
        assert_eq!(
            delays(10, 50_000, 2_500),
            [50_000, 30_000, 23_333, 19_744, 17_421, 17_421, 19_744, 23_333, 30_000]
        );
    }

    #[test]
    fn no_pulses_one_and_two() {
        assert!(delays(0, 50_000, 2_500).is_empty());
        assert!(delays(1, 50_000, 2_500).is_empty());
        assert_eq!(delays(2, 50_000, 2_500), [50_000]);
    }

    /// Every length: the right number of delays, none below the shortest, and the way down mirrors
    /// the way up within two thousandths.
    #[test]
    fn ramps_end_exactly() {
        for pulses in (2..400).chain([1_000, 4_001, 100_000]) {
            let all = delays(pulses, 50_000, 2_500);
            assert_eq!(all.len() as u32, pulses - 1);
            assert!(all.iter().all(|delay| (2_500..=50_000).contains(delay)));
            for (up, down) in all[1..].iter().zip(all.iter().rev()) {
                assert!(up.abs_diff(*down) <= up / 500 + 1, "{pulses} pulses: {up}, {down}");
            }
        }
    }

    /// 40,000 steps/s at 40,000 steps/s² on a 16 MHz chip: 20,000 ramp steps,
    /// at whose end the delay falls by less than 2⁻⁸ ticks a step.
    #[test]
    fn high_speed_does_not_stall() {
        let first = 76_500; // 0.676 · 16e6 · √(2 / 40,000)
        for shortest in [400, 200, 134] {
            let all = delays(400_000, first, shortest);
            let reached = all.iter().position(|delay| *delay <= shortest).unwrap();
            let speed = 16e6 / f64::from(shortest);
            let ideal = speed * speed / 80_000.0;
            let off = (reached as f64 - ideal).abs() / ideal;
            assert!(off < 0.02, "{shortest}: {reached} steps, {ideal} ideally");
            assert_eq!(all.len(), 399_999);
        }
    }

    #[test]
    fn a_top_speed_within_two_steps_is_kept() {
        // Faults of known implementations: endless acceleration, or being slower at first.
        assert_eq!(delays(6, 3_000, 2_500), [3_000, 2_500, 2_500, 2_500, 2_500]);
        assert_eq!(delays(4, 1_000, 2_500), [2_500, 2_500, 2_500]);
        assert!(delays(50, 0, 0).iter().all(|delay| *delay == 1));
        assert_eq!(delays(3, Ticks::MAX, Ticks::MAX), [LONGEST, LONGEST]);
    }

    #[test]
    fn braking_takes_the_ramp_back() {
        let mut ramp = Carried::new(100_000, 50_000, 2_500);
        let up: Vec<_> = ramp.by_ref().take(100).collect();
        ramp.stop();
        let down: Vec<_> = ramp.collect();
        assert!(down.len() >= 99 && down.len() <= 101, "{}", down.len());
        let last = down[down.len() - 1];
        assert!(last.abs_diff(up[1]) < 100, "{last}, {}", up[1]);
    }

    #[test]
    fn division_by_shifts() {
        for dividend in [0u32, 1, 6, 7, 8, 12_345_678, 1 << 31, u32::MAX] {
            for divisor in [1u32, 2, 3, 7, 80_001, 1 << 31, u32::MAX] {
                assert_eq!(divided(dividend, divisor), (dividend / divisor, dividend % divisor));
            }
        }
        assert_eq!(divided(5, 0), (0, 0));
    }
}
