//! How a simulated board's time goes by: as ours does, or as fast as it can.

use std::thread;
use std::time::{Duration, Instant};

use super::simulated::Simulated;

/// Nanoseconds in a second.
const NANO: u128 = 1_000_000_000;

/// So far the simulation may run ahead of real time before it waits.
const AHEAD: Duration = Duration::from_millis(1);

/// A board whose time goes by at a pace.
///
/// Every byte that arrives takes its time on the line, at the board's baud
/// rate: so a script sent all at once does to it what it would do to a chip.
pub struct Paced<B> {
    /// The board.
    pub board: B,
    /// When it was switched on; `None` for as fast as the machine can.
    since: Option<Instant>,
    byte: u64,
}

impl<B: Simulated> Paced<B> {
    /// Switches the board's clock on.
    pub fn new(board: B, fast: bool) -> Paced<B> {
        let byte = board.byte_time();
        Paced { board, since: (!fast).then(Instant::now), byte }
    }

    /// Whether time passes only as it is told to.
    pub fn is_fast(&self) -> bool {
        self.since.is_none()
    }

    /// Ticks that a byte takes on the line.
    pub fn byte_time(&self) -> u64 {
        self.byte
    }

    /// The board's time.
    pub fn now(&self) -> Duration {
        let nanos = u128::from(self.board.now()) * NANO / self.hz();
        Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX))
    }

    /// So much time in ticks.
    pub fn ticks(&self, time: Duration) -> u64 {
        u64::try_from(time.as_nanos() * self.hz() / NANO).unwrap_or(u64::MAX)
    }

    fn hz(&self) -> u128 {
        self.board.hz().into()
    }

    /// Brings the board to the present, if it lives in real time.
    pub fn catch_up(&mut self) {
        if let Some(since) = self.since {
            let now = self.ticks(since.elapsed());
            if now > self.board.now() {
                self.board.run_until(now);
            }
        }
    }

    /// Lets time pass until `time` ticks, waiting for it if need be.
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

    /// Lets `time` pass.
    pub fn pass(&mut self, time: Duration) {
        self.pass_until(self.board.now().saturating_add(self.ticks(time)));
    }

    /// A byte arrives, after its time on the line.
    pub fn receive(&mut self, byte: u8) {
        self.pass_until(self.board.now() + self.byte);
        self.board.receive(byte);
    }
}
