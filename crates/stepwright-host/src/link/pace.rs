//! The pace of a simulated board's time: real time, or as fast as it can be simulated.

use std::thread;
use std::time::{Duration, Instant};

use super::simulated::Simulated;

/// Nanoseconds in a second.
const NANO: u128 = 1_000_000_000;

/// How far the simulation may be ahead of real time before it waits.
const AHEAD: Duration = Duration::from_millis(1);

/// A simulated board with the pace of its time.
///
/// Each byte takes its time on the line, at the board's baud rate, before it arrives. A script that is sent all
/// at once has the same effect as on a chip.
pub struct Paced<B> {
    /// The board.
    pub board: B,
    /// When it was switched on; `None` if time passes as fast as it can be simulated.
    since: Option<Instant>,
    byte: u64,
}

impl<B: Simulated> Paced<B> {
    /// Switches the board's clock on.
    pub fn new(board: B, fast: bool) -> Paced<B> {
        let byte = board.byte_time();
        Paced { board, since: (!fast).then(Instant::now), byte }
    }

    /// Whether time passes only by calls.
    pub fn is_fast(&self) -> bool {
        self.since.is_none()
    }

    /// Ticks that a byte takes on the line.
    pub fn byte_time(&self) -> u64 {
        self.byte
    }

    /// The board's time since it was switched on.
    pub fn now(&self) -> Duration {
        let nanos = u128::from(self.board.now()) * NANO / self.hz();
        Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX))
    }

    /// Converts a time to ticks.
    pub fn ticks(&self, time: Duration) -> u64 {
        u64::try_from(time.as_nanos() * self.hz() / NANO).unwrap_or(u64::MAX)
    }

    fn hz(&self) -> u128 {
        self.board.hz().into()
    }

    /// Brings the board to the present, if it runs in real time.
    pub fn catch_up(&mut self) {
        if let Some(since) = self.since {
            let now = self.ticks(since.elapsed());
            if now > self.board.now() {
                self.board.run_until(now);
            }
        }
    }

    /// Lets time pass until `time` in ticks. In real time it waits for it.
    pub fn pass_until(&mut self, time: u64) {
        self.catch_up();
        if self.board.now() < time {
            self.board.run_until(time);
        }
        if let Some(since) = self.since {
            let ahead = self.now().saturating_sub(since.elapsed());
            if ahead > AHEAD {
                thread::sleep(ahead);
            }
        }
    }

    /// Lets this much time pass.
    pub fn pass(&mut self, time: Duration) {
        self.pass_until(self.board.now().saturating_add(self.ticks(time)));
    }

    /// Receives bytes that came since the board was last brought to the present: evenly spread over that time,
    /// but not faster than the line. Then the board is brought to the last byte. So a board whose program was
    /// delayed misses no more bytes than a chip, whose receiver never waits.
    pub fn receive_since(&mut self, bytes: &[u8]) {
        let present = self.since.map_or(0, |since| self.ticks(since.elapsed()));
        let away = present.saturating_sub(self.board.now());
        let each = (away / bytes.len().max(1) as u64).max(self.byte);
        for byte in bytes {
            self.board.run_until(self.board.now() + each);
            self.board.receive(*byte);
        }
        self.pass_until(self.board.now());
    }

    /// Receives a byte, after its time on the line.
    pub fn receive(&mut self, byte: u8) {
        self.pass_until(self.board.now() + self.byte);
        self.board.receive(byte);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line with 1,000 ticks per second, which notes when each byte came.
    #[derive(Default)]
    struct Line {
        now: u64,
        came: Vec<(u64, u8)>,
    }

    impl Simulated for Line {
        fn hz(&self) -> u32 {
            1_000
        }
        fn byte_time(&self) -> u64 {
            2
        }
        fn now(&self) -> u64 {
            self.now
        }
        fn run_until(&mut self, time: u64) {
            self.now = time;
        }
        fn receive(&mut self, byte: u8) {
            self.came.push((self.now, byte));
        }
        fn take_answers(&mut self) -> Vec<u8> {
            Vec::new()
        }
    }

    #[test]
    fn bytes_that_came_while_nobody_looked_came_one_after_another() {
        let mut line = Paced::new(Line::default(), false);
        line.since = Instant::now().checked_sub(Duration::from_millis(4_000));
        line.receive_since(b"abcd");
        let times: Vec<u64> = line.board.came.iter().map(|(time, _)| *time).collect();
        assert!(times[0] >= 1_000 && times[0] < 1_500, "{times:?}");
        assert!(times.windows(2).all(|two| two[1] - two[0] == times[0]), "{times:?}");
        assert!(line.board.now >= times[3]);
        let bytes: Vec<u8> = line.board.came.iter().map(|(_, byte)| *byte).collect();
        assert_eq!(bytes, b"abcd");
    }

    #[test]
    fn bytes_that_came_at_once_take_their_time() {
        let mut line = Paced::new(Line::default(), true);
        line.receive_since(b"abc");
        assert_eq!(line.board.came, [(2, b'a'), (4, b'b'), (6, b'c')]);
    }
}
