//! How many bytes wait before the wire.
//!
//! Few: what is urgent is behind them. But a computer that does other things looks at the line seldom, and
//! the wire rests when it has sent what waited. So as many wait as the wire sends until the next look, by the
//! longest time between two looks of the last second; and more behind a change, when the board has little
//! ahead. On a line with noise few: all of them would go again.

use stepwright_stream::send::QUEUED;

/// At most, in µs of bytes.
const MOST: u64 = 40_000;
/// Behind a change.
const CHANGE: u64 = 25_000;
/// What was seen counts for this long, and as long again, in µs.
const KEPT: u64 = 1_000_000;

/// What is known of the computer and the line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    /// The last look.
    last: Option<u64>,
    /// The longest time between two looks, of this second and of the one before.
    longest: [u64; 2],
    /// How often all was sent again, at the beginning of either.
    again: [u64; 2],
    begun: u64,
    /// Since a change, until the board has enough ahead.
    pub(crate) changed: bool,
}

impl Pace {
    /// A look at the line: µs of bytes that may wait before the wire, where all has been sent again so often.
    pub(crate) fn look(&mut self, now: u64, again: u64) -> u64 {
        if now.saturating_sub(self.begun) > KEPT {
            self.begun = now;
            self.longest = [0, self.longest[0]];
            self.again = [again, self.again[0]];
        }
        let since = now.saturating_sub(self.last.unwrap_or(now));
        self.last = Some(now);
        self.longest[0] = self.longest[0].max(since);
        if again != self.again[1] {
            return QUEUED;
        }
        let least = if self.changed { CHANGE } else { QUEUED };
        // The next look may come later than any before.
        let seldom = 2 * self.longest[0].max(self.longest[1]);
        seldom.min(MOST).max(least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks so far apart from `from` on, for two seconds: the last answer.
    fn looks(pace: &mut Pace, from: u64, apart: u64, again: u64) -> u64 {
        let times = (from..from + 2_100_000).step_by(apart as usize);
        times.map(|now| pace.look(now, again)).last().unwrap()
    }

    #[test]
    fn a_computer_that_looks_often_has_few_bytes_waiting() {
        let mut pace = Pace::default();
        assert_eq!(looks(&mut pace, 0, 1_000, 0), QUEUED);
        pace.changed = true;
        assert_eq!(pace.look(2_100_000, 0), CHANGE);
    }

    #[test]
    fn one_that_looks_seldom_has_as_many_as_it_needs() {
        let mut pace = Pace::default();
        assert_eq!(looks(&mut pace, 0, 12_000, 0), 24_000);
        assert_eq!(looks(&mut pace, 2_200_000, 300_000, 0), MOST);
        // It is forgotten.
        assert_eq!(looks(&mut pace, 5_000_000, 1_000, 0), QUEUED);
    }

    #[test]
    fn on_a_line_with_noise_few_wait() {
        let mut pace = Pace::default();
        assert_eq!(looks(&mut pace, 0, 12_000, 0), 24_000);
        pace.changed = true;
        assert_eq!(pace.look(2_110_000, 1), QUEUED);
        assert_eq!(looks(&mut pace, 2_120_000, 12_000, 1), CHANGE);
    }
}
