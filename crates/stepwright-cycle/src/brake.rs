//! Braking: each step takes 2a off v².
//!
//! With n = v²/2a steps to go, rounded up so that the motor never brakes harder than it may, the
//! intervals grow like those of Austin's ramp in reverse:
//!
//! ```text
//!   c′ = c + 2c / (4n − 1)        the last one c′ = c·(1 + √2)
//! ```
//!
//! The division's remainder is carried. From ten steps on, the time to each step is within 2 % of
//! that at constant deceleration; the last steps exceed it by at most 5 %. 32 bits and one division
//! per step.

/// Whether motors can brake at a switch: with this a cycle does not fit into an Uno. If false, none
/// of its code is compiled.
pub(crate) const BRAKES: bool = cfg!(feature = "brakes");

/// The speed of a braking motor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Brake {
    hz: u32,
    decel: u32,
    /// Steps to go.
    left: u32,
    /// The last interval in 2⁻⁴ ticks, and the remainder of the last division.
    interval: u32,
    rest: u32,
    /// Whether no step of the braking has been made yet.
    first: bool,
}

impl Brake {
    /// Brakes from an interval of this many 2⁻¹⁶ ticks, at `decel` steps/s². `None` if the motor
    /// stands within a step.
    pub(crate) fn new(hz: u32, interval: u64, decel: u32) -> Option<Brake> {
        let left = way(hz, interval, decel)?;
        // Half of the range, so that twice the interval is within it.
        let interval = u32::try_from(interval >> 12).unwrap_or(u32::MAX).min(u32::MAX / 2);
        Some(Brake { hz, decel, left, interval, rest: 0, first: true })
    }

    /// Whether the motor stands by now, this long after its last step, in 2⁻¹⁶ ticks.
    pub(crate) fn is_over(&self, waited: u64) -> bool {
        way(self.hz, waited, self.decel).is_none()
    }

    /// The interval before the next step, in 2⁻¹⁶ ticks; `interval` is the interval without
    /// braking. `None` if the motor stands.
    pub(crate) fn next(&mut self, interval: u64) -> Option<u64> {
        if interval >> 12 > u64::from(self.interval) {
            // The program itself is slower than that: continue from its speed.
            *self = Brake::new(self.hz, interval, self.decel)?;
        }
        self.left = self.left.checked_sub(1)?;
        let c = self.interval;
        let parts = self.left.saturating_mul(4).saturating_add(3);
        let growth = match (core::mem::take(&mut self.first), self.left) {
            // From a speed to the mean speed of a step, which is half as far.
            (true, left) => c / left.saturating_mul(4).saturating_add(4),
            (false, 0) => c / 128 * 181,
            (false, _) => {
                let twice = (2 * c).saturating_add(self.rest);
                self.rest = twice % parts;
                twice / parts
            }
        };
        self.interval = c.saturating_add(growth).min(u32::MAX / 2);
        Some(interval.max(u64::from(self.interval) << 12))
    }
}

/// Steps to rest from an interval of this many 2⁻¹⁶ ticks: v²/2a, rounded up; `None` if less than
/// one. Speeds in 2⁻⁸ steps/s, up to 16.7 million steps/s.
fn way(hz: u32, interval: u64, decel: u32) -> Option<u32> {
    let v = ((u64::from(hz) << 24) / interval.max(1)).min(u32::MAX.into());
    let (square, fall) = (v * v, u64::from(decel) << 17);
    if fall == 0 || square < fall {
        return None;
    }
    // One division, not two: a remainder would be another.
    let steps = square.saturating_add(fall - 1) / fall;
    Some(u32::try_from(steps).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// v²/2a steps, at the times of constant deceleration.
        #[test]
        fn it_stands_after_its_way(
            hz in 1_000_000u32..100_000_000,
            speed in 20.0f64..50_000.0,
            decel in 10u32..1_000_000,
        ) {
            let own = (f64::from(hz) / speed * 65_536.0).round();
            let v = f64::from(hz) * 65_536.0 / own;
            let steps = v * v / 2.0 / f64::from(decel);
            prop_assume!(steps < 20_000.0);
            let brake = Brake::new(hz, own as u64, decel);
            prop_assert!(brake.is_some() == (steps >= 1.0) || (steps - 1.0).abs() < 1e-3);
            let Some(mut brake) = brake else { return Ok(()) };
            let (mut times, mut time) = (std::vec::Vec::new(), 0.0);
            while let Some(interval) = brake.next(own as u64) {
                time += interval as f64 / 65_536.0 / f64::from(hz);
                times.push(time);
            }
            let all = times.len() as f64;
            prop_assert!((-1e-3 * steps..=1.0).contains(&(all - steps)), "{all}, not {steps}");
            // As hard as that takes, and no harder than allowed.
            let a = v * v / 2.0 / all;
            prop_assert!(a <= f64::from(decel) * 1.001);
            for (n, time) in (1..).zip(times) {
                let exact = (v - (v * v - 2.0 * a * f64::from(n)).max(0.0).sqrt()) / a;
                // The first of few steps from a speed are not those of a ramp.
                let part = if all < 4.0 { 0.3 } else if all < 10.0 { 0.05 } else { 0.02 };
                prop_assert!((time - exact).abs() < part * exact, "{n} of {all}: {time}, not {exact}");
            }
        }

        #[test]
        fn nothing_panics(hz in any::<u32>(), interval in any::<u64>(), decel in any::<u32>()) {
            let mut brake = Brake::new(hz, interval, decel);
            for _ in 0..5 {
                _ = brake.as_mut().and_then(|brake| brake.next(interval / 2));
            }
        }
    }
}
