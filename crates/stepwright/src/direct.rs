//! The law in the interrupt itself: document 002's ramp, a step at a time.
//!
//! ```text
//!   c(n) = c(n−1) − 2·c(n−1) / (4n+1)      up: n = 1, 2 …
//!   c(n) = c(n−1) + 2·c(n−1) / (4n−1)      down: n counts back to 1
//! ```
//!
//! Nothing in the foreground can hold up a motor that is fed like this: each
//! delay is computed after the pulse before it has been emitted, and loaded one
//! step later. The price is a division a step.
//!
//! Delays are kept in 2⁻⁸ ticks, as in the document, and the division's
//! remainder is carried from step to step: at high speed, where 2c is less than
//! 4n+1, the delay still falls, so the ramp can't stall below its top speed. The
//! ramp down counts the steps of the ramp up, so it ends exactly.
//!
//! It is the arithmetic that a small chip can afford of
//! [`austin::Fixed`](crate::profile::austin::Fixed), which truncates as the published
//! listing does, and [`austin::Austin`](crate::profile::austin::Austin), which holds
//! the formula to a tick and takes accelerations; the tests hold them together.

use crate::queue::{Feed, Taken};
use crate::run::Run;
use crate::units::Ticks;

/// Fraction of a delay.
const BITS: u32 = 8;
/// Delays of 2²³ ticks (0.5 s at 16 MHz) or more are not for this law: twice a
/// delay fits 32 bits.
const LONGEST: Ticks = (1 << 23) - 1;

/// One travel along document 002's ramp.
///
/// ```
/// use stepwright::direct::Ramp;
/// // The document's demo: 1 MHz, the first delay 50000, the shortest 2500.
/// let delays: Vec<_> = Ramp::new(10, 50_000, 2_500).collect();
/// assert_eq!(delays[..5], [50_000, 30_000, 23_333, 19_744, 17_421]);
/// assert_eq!(delays.len(), 9); // between 10 pulses
/// ```
#[derive(Clone, Debug)]
pub struct Ramp {
    /// The next delay, in 2⁻⁸ ticks.
    delay: u32,
    /// The shortest, likewise.
    shortest: u32,
    /// Delays that are still to come.
    left: u32,
    /// Steps of the ramp so far: n.
    n: u32,
    /// What the division left over.
    rest: u32,
    /// The top speed was reached: the delay that it cut short, for the way down.
    top: Option<u32>,
    /// On the way down.
    down: bool,
}

impl Ramp {
    /// `pulses` pulses: the first delay is `first` ticks, the shortest
    /// `shortest`. Delays are at least 1 tick and at most 2²³ − 1; a `first`
    /// shorter than `shortest` is constant speed at `shortest`.
    pub fn new(pulses: u32, first: Ticks, shortest: Ticks) -> Ramp {
        let shortest = shortest.clamp(1, LONGEST) << BITS;
        let delay = (first.clamp(1, LONGEST) << BITS).max(shortest);
        Ramp {
            delay,
            shortest,
            left: pulses.saturating_sub(1),
            n: 0,
            rest: 0,
            top: None,
            down: false,
        }
    }

    /// Brakes from here, in as many steps as the ramp has taken.
    pub fn brake(&mut self) {
        self.left = self.left.min(self.n.max(1));
    }

    /// Prepares the delay after this one.
    fn prepare(&mut self) {
        // The delay after the last pulse, which nobody waits for, has n = 0.
        if self.left > self.n {
            self.speed_up();
        } else if self.left < self.n {
            self.slow_down();
        }
        // Else a step at the speed reached: the middle of an even travel.
    }

    fn speed_up(&mut self) {
        if self.down || self.delay <= self.shortest {
            return;
        }
        let n = self.n + 1;
        let divisor = n.saturating_mul(4).saturating_add(1);
        let dividend = (2 * self.delay).saturating_add(self.rest);
        let next = self.delay.saturating_sub(dividend / divisor);
        self.rest = dividend % divisor;
        self.n = n;
        if next <= self.shortest {
            (self.top, self.delay) = (Some(next.max(1)), self.shortest);
        } else {
            self.delay = next;
        }
    }

    fn slow_down(&mut self) {
        if !core::mem::replace(&mut self.down, true) {
            self.rest = 0; // it belongs to the other ramp
            self.delay = self.top.take().unwrap_or(self.delay);
        }
        let divisor = self.n.saturating_mul(4).saturating_sub(1);
        let dividend = (2 * self.delay).saturating_add(self.rest);
        self.delay = (self.delay.saturating_add(dividend / divisor)).min(LONGEST << BITS);
        self.rest = dividend % divisor;
        self.n -= 1;
    }
}

impl Iterator for Ramp {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        self.left = self.left.checked_sub(1)?;
        let delay = self.delay;
        if self.left > 0 {
            self.prepare();
        }
        Some((delay + (1 << (BITS - 1))) >> BITS)
    }
}

/// A [`Ramp`] as a feed: the engine asks it for one step at a time.
#[derive(Clone, Debug)]
pub struct Direct {
    ramp: Ramp,
    /// Before the first pulse.
    lead: Option<Ticks>,
    /// Computed one step ahead.
    ready: Option<Ticks>,
}

impl Direct {
    /// Nothing to do.
    pub const fn idle() -> Direct {
        let ramp = Ramp { delay: 0, shortest: 0, left: 0, n: 0, rest: 0, top: None, down: false };
        Direct { ramp, lead: None, ready: None }
    }

    /// A travel: its first pulse comes `lead` ticks after the start.
    pub fn new(lead: Ticks, ramp: Ramp) -> Direct {
        Direct { ramp, lead: Some(lead), ready: None }
    }
}

impl Feed for Direct {
    fn take(&mut self) -> Taken {
        let now = match self.lead.take() {
            Some(lead) => Some(lead),
            None => self.ready.take(),
        };
        let Some(delay) = now else { return Taken::End };
        self.ready = self.ramp.next();
        Taken::Run(Run::steady(delay, 1))
    }

    fn clear(&mut self) {
        *self = Direct::idle();
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn delays(pulses: u32, first: Ticks, shortest: Ticks) -> Vec<Ticks> {
        Ramp::new(pulses, first, shortest).collect()
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

    /// Every length: the right number of delays, none below the shortest, and
    /// the way down mirrors the way up within a part of a thousand.
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
        // Faults of known implementations: running away, or being slower first.
        assert_eq!(delays(6, 3_000, 2_500), [3_000, 2_500, 2_500, 2_500, 2_500]);
        assert_eq!(delays(4, 1_000, 2_500), [2_500, 2_500, 2_500]);
        assert!(delays(50, 0, 0).iter().all(|delay| *delay == 1));
        assert_eq!(delays(3, Ticks::MAX, Ticks::MAX), [LONGEST, LONGEST]);
    }

    #[test]
    fn braking_takes_the_ramp_back() {
        let mut ramp = Ramp::new(100_000, 50_000, 2_500);
        let up: Vec<_> = ramp.by_ref().take(100).collect();
        ramp.brake();
        let down: Vec<_> = ramp.collect();
        assert!(down.len() >= 99 && down.len() <= 101, "{}", down.len());
        let last = down[down.len() - 1];
        assert!(last.abs_diff(up[1]) < 100, "{last}, {}", up[1]);
    }

    #[test]
    fn a_feed_is_a_step_ahead() {
        let mut feed = Direct::new(1_000, Ramp::new(3, 50_000, 2_500));
        for delay in [1_000, 50_000, 30_000] {
            assert_eq!(feed.take(), Taken::Run(Run::steady(delay, 1)));
        }
        assert_eq!(feed.take(), Taken::End);
    }
}
