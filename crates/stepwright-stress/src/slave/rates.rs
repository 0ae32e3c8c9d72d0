//! Whether a board can step as slowly and as fast as an order needs.

use super::Expect;
use crate::judge::Judge;
use crate::limits::Limits;
use crate::reason::Reason;
use crate::settings;
use crate::track::Known;

impl Judge {
    /// Whether no interval exceeds 2³² ticks.
    pub(super) fn slow(&self, limits: &Limits) -> Expect {
        let hz = f64::from(self.board().hz);
        let mut slowest = 1.0 / limits.start;
        if limits.start == 0.0 {
            slowest = (2.0 / limits.up).sqrt() + (2.0 / limits.down).sqrt() + 1.0 / limits.top;
        }
        let most = 2f64.powi(32) / hz;
        let bent = limits.start == 0.0 && (6.0 / limits.jerk).cbrt() * 4.0 > most / 8.0;
        let slow = match slowest {
            s if s > most * 1.001 => Known::Yes,
            s if s > most * 0.999 || bent => Known::Maybe,
            _ => Known::No,
        };
        Expect::unless(slow, Reason::TooSlow)
    }

    /// Whether the board can step these axes this fast beside the axes that move.
    pub(super) fn fast(&self, fresh: &[(usize, f64, f64)], now: u64) -> Expect {
        let (mut least, mut most) = (0.0, 0.0);
        let (mut few, mut many) = (0, 0);
        for (n, track) in self.tracks.iter().enumerate() {
            if let Some((_, low, high)) = fresh.iter().find(|(axis, ..)| *axis == n) {
                (least, most, few, many) = (least + low, most + high, few + 1, many + 1);
            } else if track.busy(now, self.measure()) != Known::No {
                (most, many) = (most + track.highest, many + 1);
            }
        }
        if few == 0 {
            return Expect::YES;
        }
        let alone =
            |peak: fn(&(usize, f64, f64)) -> f64| fresh.iter().map(peak).fold(0.0, f64::max);
        let pulse = self.settings.get(settings::PULSE);
        // At least the load with the shortest pulse.
        let low = self.board().load(least, alone(|fresh| fresh.1), few, 1);
        let high = self.board().load(most, alone(|fresh| fresh.2), many, pulse);
        let fast = if low > 1.002 {
            Known::Yes
        } else if high > 0.998 {
            Known::Maybe
        } else {
            Known::No
        };
        let fast = Expect::unless(fast, Reason::TooFast);
        // Only the board knows what it can plan beside the moving axes.
        Expect {
            no: fast.no
                | self.reason(self.board().plans, Reason::TooSteep)
                | self.reason(self.board().plans, Reason::TooFast),
            ..fast
        }
    }
}
