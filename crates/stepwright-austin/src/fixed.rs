//! The published listing, delay for delay (Austin, 24.8 fixed point).
//!
//! ```text
//!   c32 −= trunc(2·c32 / (4n + 1))        c = (c32 + 128) >> 8
//! ```
//!
//! c32 is c in 2⁻⁸ ticks, and 4n + 1 a signed number of 16 bits: n = 1, 2 … up;
//! n = i − m down. Its states:
//!
//! ```text
//!   up    n + 1, until round(c) ≤ c_min (max) or the middle of the travel (down);
//!         an even travel repeats its middle delay
//!   max   c_min is held; c32 keeps the delay that it cut short
//!   down  from c32: as many steps as up from the middle, three fewer from max
//!   last  the delay after the last pulse, which nobody waits for: left out
//! ```
//!
//! The three steps are the program's own behaviour. It counts its steps from the second delay on,
//! notes at max how many it has counted, and begins the way down when that many remain: one step
//! late. The next step still has c_min, and the denominator is one step ahead. So the last delay is
//! 29,795 ticks where the first ramp delay is 30,000 (c₀ 50000, c_min 2500), and a ramp of up to
//! three steps has no way down.
//!
//! This works for ramps of up to 8191 steps whose changes are at least 2⁻⁸ ticks. Beyond, 4n + 1
//! overflows or the ramp stalls, and the delays are those of the [general form](super::general):
//! changes rounded to the nearest 2⁻³² ticks. The same applies where other implementations of the
//! listing fail: c_min above c₀ (all at c_min), and c₀ beyond 65,535.
//!
//! Error against the formula in f64, from truncation: at most 0.74 ticks in the document's demo (c₀
//! 50000, c_min 2500), and 11.4 at the end of the longest ramp that it supports, on the way up.

use super::count::Law;
use super::travel::{Slopes, Travel};
use crate::share::share;
use stepwright::fixed::Q32;
use stepwright::profile::Phase;
use stepwright::units::Ticks;

/// The last n for which 4n + 1 fits in 16 bits with a sign.
const MOST: u32 = 8_191;
/// Bits between 2⁻³² and 2⁻⁸ ticks.
const COARSE: u32 = 24;

/// The pulses of the published form. The first delay is 0.
///
/// ```
/// use stepwright_austin::Fixed;
/// let delays: Vec<u32> = Fixed::new(10, 50_000, 2_500).collect();
/// assert_eq!(
///     delays,
///     [0, 50_000, 30_000, 23_333, 19_744, 17_421, 17_421, 19_744, 23_333, 30_000]
/// );
/// ```
#[derive(Clone, Debug)]
pub struct Fixed {
    travel: Travel<Listing>,
    shortest: Q32,
    /// Whether the pulse at time 0, then c₀, are still to come.
    first: bool,
    lead: bool,
    /// The number of delays left.
    left: u32,
    phase: Phase,
}

impl Fixed {
    /// `pulses` pulses, with `c0` ticks before the second; no delay is less than `c_min` ticks
    /// (at least 1).
    pub fn new(pulses: u32, c0: Ticks, c_min: Ticks) -> Fixed {
        let shortest = Q32::from(c_min.max(1)) << 32;
        let listing = Listing { count: (Q32::from(c0) << 32).max(shortest), shortest, n: 0 };
        Fixed {
            travel: Travel::new(listing),
            shortest,
            first: pulses > 0,
            lead: true,
            left: pulses.saturating_sub(1),
            phase: Phase::Up,
        }
    }

    /// The phase of the last delay.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The last delay before it was rounded to ticks, in 2⁻³² ticks; valid from the second delay
    /// on.
    pub fn unrounded(&self) -> Q32 {
        self.travel.count().max(self.shortest)
    }

    /// Brakes from here, in as many steps as the ramp has taken; from c_min in three steps fewer.
    pub fn stop(&mut self) {
        self.left = self.left.min(self.travel.stop().saturating_sub(1));
    }
}

impl Iterator for Fixed {
    type Item = Ticks;

    #[inline]
    fn next(&mut self) -> Option<Ticks> {
        if core::mem::take(&mut self.first) {
            return Some(0);
        }
        if self.left == 0 {
            return None;
        }
        if !core::mem::take(&mut self.lead) {
            self.phase = self.travel.advance(self.left);
        }
        self.left -= 1;
        Some((self.unrounded().saturating_add(1 << 31) >> 32) as Ticks)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = u64::from(self.left) + u64::from(self.first);
        let left = usize::try_from(left).unwrap_or(usize::MAX);
        (left, Some(left))
    }
}

impl ExactSizeIterator for Fixed {}

/// Both ramps of the listing.
#[derive(Clone, Debug)]
pub struct Listing {
    count: Q32,
    shortest: Q32,
    n: u32,
}

/// The number of steps by which the way down from max is shorter than the way up.
const SHORT: u32 = 3;

impl Listing {
    /// Whether the delay, rounded to whole ticks, is c_min or less.
    #[inline]
    fn at_max(&self) -> bool {
        self.count.saturating_add(1 << 31) >> 32 <= self.shortest >> 32
    }

    /// 2c / d at step `n`.
    #[inline]
    fn change(&self, n: u32, d: u64) -> Q32 {
        let coarse = (self.count >> COARSE) * 2 / d;
        if n > MOST || coarse == 0 { share(self.count, 2, d) } else { coarse << COARSE }
    }
}

impl Slopes for Listing {
    #[inline]
    fn faster(&mut self, left: u32) -> bool {
        if self.at_max() || left <= self.n {
            return false;
        }
        self.n += 1;
        self.count -= self.change(self.n, 4 * u64::from(self.n) + 1);
        true
    }

    #[inline]
    fn slower(&mut self, j: u32) {
        let j = j.max(1);
        self.count = self.count.saturating_add(self.change(j, 4 * u64::from(j) - 1));
    }

    fn braking(&self) -> u32 {
        if self.at_max() { self.n.saturating_sub(SHORT) } else { self.n }
    }

    fn count(&self) -> Q32 {
        self.count
    }
}
