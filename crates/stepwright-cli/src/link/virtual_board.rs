//! A virtual board in this process.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use super::Link;
use crate::board::bench::Bench;
use crate::board::pace::Paced;
use crate::failure::Failure;

/// The line to a board whose time passes while we wait for it.
pub struct VirtualLink {
    board: Paced,
    /// Bytes on their way to us, and when each is here.
    coming: VecDeque<(u64, u8)>,
}

impl VirtualLink {
    /// Joins the line of a board.
    pub fn new(bench: Bench, fast: bool) -> VirtualLink {
        VirtualLink { board: Paced::new(bench, fast), coming: VecDeque::new() }
    }

    /// The board, for tests to look at.
    #[cfg(test)]
    pub fn bench(&mut self) -> &mut Bench {
        &mut self.board.bench
    }
}

impl Link for VirtualLink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            self.board.receive(byte);
            for answer in self.board.bench.take_answers() {
                let last = self.coming.back().map_or(0, |(time, _)| *time);
                let here = last.max(self.board.bench.now()) + self.board.byte_time();
                self.coming.push_back((here, answer));
            }
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        // Rounded up: to wait for less than a tick must not be no wait.
        let until = self.board.bench.now() + self.board.ticks(limit) + 1;
        let until = self.coming.front().map_or(until, |(time, _)| until.min(*time));
        self.board.pass_until(until);
        let now = self.board.bench.now();
        let mut count = 0;
        while let (Some((time, byte)), Some(slot)) = (self.coming.front(), buffer.get_mut(count)) {
            if *time > now {
                break;
            }
            *slot = *byte;
            count += 1;
            self.coming.pop_front();
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn name(&self) -> String {
        "the virtual board".to_owned()
    }

    fn finish(&mut self) -> Result<(), Failure> {
        self.board.bench.finish()
    }
}
