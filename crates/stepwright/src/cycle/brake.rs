//! A motor that comes to rest: each step costs it 2a of v².
//!
//! ```text
//!   w = v²,   w′ = w − 2a,   a step takes 2 / (v + v′)      (constant deceleration)
//! ```
//!
//! Speeds are in 0.001 steps/s, up to 4.29 million steps/s, so a time is good to
//! 2⁻²⁰ above 1000 steps/s. It stands when less than one step is left. A root and a
//! division in 64 bits a step: as much as a callback's delay costs.

/// The speed of a motor that brakes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Brake {
    hz: u32,
    /// w, in 10⁻⁶ (steps/s)².
    square: u64,
    /// 2a in the same.
    fall: u64,
}

/// Thousandths.
const MILLI: u64 = 1_000;

impl Brake {
    /// From an interval of so many 2⁻¹⁶ ticks, by steps/s². `None` if it stands
    /// within a step.
    pub(super) fn new(hz: u32, interval: u64, decel: u32) -> Option<Brake> {
        let fall = u64::from(decel).saturating_mul(2 * MILLI * MILLI);
        let brake = Brake { hz, square: square(hz, interval), fall };
        brake.rolls().then_some(brake)
    }

    /// Whether another step is left to make.
    fn rolls(&self) -> bool {
        self.fall > 0 && self.square >= self.fall
    }

    /// Whether it stands by now, so long after its last step, in 2⁻¹⁶ ticks.
    pub(super) fn is_over(&self, waited: u64) -> bool {
        square(self.hz, waited) < self.fall
    }

    /// The interval before its next step, in 2⁻¹⁶ ticks, which would come after
    /// `interval` if it did not brake. `None`: it stands.
    pub(super) fn next(&mut self, interval: u64) -> Option<u64> {
        self.square = self.square.min(square(self.hz, interval));
        if !self.rolls() {
            return None;
        }
        let v = self.square.isqrt();
        self.square = self.square.saturating_sub(self.fall);
        // Above 0, for w was: 2a is at least 2 steps/s².
        let twice = v.saturating_add(self.square.isqrt()).max(1);
        let ticks = (2 * MILLI * u64::from(self.hz)) << 16;
        Some(interval.max(ticks / twice))
    }
}

/// v² of a motor with an interval of so many 2⁻¹⁶ ticks.
fn square(hz: u32, interval: u64) -> u64 {
    let v = ((MILLI * u64::from(hz)) << 16) / interval.max(1);
    let v = v.min(u32::MAX.into());
    v * v
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
            let a = f64::from(decel);
            let v = f64::from(hz) * 65_536.0 / own;
            let steps = (v * v / 2.0 / a).floor();
            prop_assume!(steps < 20_000.0);
            let brake = Brake::new(hz, own as u64, decel);
            prop_assert_eq!(brake.is_some(), v * v >= 2.0 * a || (v * v / 2.0 / a - 1.0).abs() < 1e-4);
            let Some(mut brake) = brake else { return Ok(()) };
            let (mut made, mut time) = (0.0, 0.0);
            while let Some(interval) = brake.next(own as u64) {
                made += 1.0;
                time += interval as f64 / 65_536.0 / f64::from(hz);
                let left = v * v - 2.0 * a * made;
                // Near rest a thousandth of a step/s is a part of what is left.
                if left > 4.0 * a {
                    let exact = (v - left.sqrt()) / a;
                    prop_assert!((time - exact).abs() < 1e-4 * exact + 1e-9, "{time}, not {exact}");
                }
            }
            prop_assert!((made - steps).abs() <= 1.0, "{made}, not {steps}");
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
