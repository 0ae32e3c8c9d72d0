//! How many bytes wait before the wire.
//!
//! A short queue is best, as urgent bytes wait behind it. But a busy computer looks at the line seldom, and
//! the wire idles once the queue is empty. The queue therefore holds what the wire sends until the next look,
//! estimated by the longest time between two looks within the last second. After a change it is longer, as
//! the board has little ahead. On a noisy line it is short, as all of it would be sent again.

use stepwright_stream::send::QUEUED;

/// The longest queue, in µs of bytes.
const MOST: u64 = 40_000;
/// The shortest queue after a change, in µs of bytes.
const CHANGE: u64 = 25_000;
/// The length of one observation period, in µs. Two periods count: the present one and the one before.
const KEPT: u64 = 1_000_000;

/// Observations of the computer and the line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    /// When the line was last looked at.
    last: Option<u64>,
    /// The longest time between two looks, of the present period and of the one before.
    longest: [u64; 2],
    /// The number of retransmissions at the beginning of each of these periods.
    again: [u64; 2],
    begun: u64,
    /// Set by a change, until the board has enough ahead.
    pub(crate) changed: bool,
}

impl Pace {
    /// Notes a look at the line and the number of retransmissions; returns the µs of bytes that may wait
    /// before the wire.
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
        // The next look may come later than any before it.
        let seldom = 2 * self.longest[0].max(self.longest[1]);
        seldom.min(MOST).max(least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks at this distance for two seconds, beginning at `from`; returns the last answer.
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
        // Two quiet periods later the long pauses count no more.
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
