//! The host's end of the serial line, with bytes at their real distance.

use std::collections::VecDeque;

use crate::silicon::Silicon;

/// A chip's receiver holds two bytes, and a third in the shift register until the next byte begins
/// there.
const RECEIVER: usize = 3;

/// The bytes on their way to the chip.
#[derive(Default)]
pub(crate) struct Line {
    /// The bytes to send, each with the earliest cycle at which it may begin.
    waiting: VecDeque<(u64, u8)>,
    /// The cycle from which the line is free.
    free: u64,
    /// The byte on the line, and the cycle at which it is complete.
    flying: Option<(u64, u8)>,
    /// Complete bytes that the firmware has not read.
    arrived: VecDeque<u8>,
    /// The bytes lost because the firmware did not read them in time.
    pub(crate) lost: u64,
    /// The lines to send in turn, each when the previous answer is complete.
    poll: Vec<Vec<u8>>,
    turn: usize,
    /// The number of answers to those lines.
    pub(crate) polled: u64,
}

impl Line {
    /// Sends `bytes` one after the other, not before `from`.
    pub(crate) fn send(&mut self, from: u64, bytes: &[u8]) {
        self.waiting.extend(bytes.iter().map(|&byte| (from, byte)));
    }

    /// Sends `lines` in turn from now on, until called with none.
    pub(crate) fn poll(&mut self, from: u64, lines: &[&str]) {
        let begin = self.poll.is_empty();
        self.poll = lines.iter().map(|line| [line.as_bytes(), b"\r"].concat()).collect();
        if begin {
            self.next_poll(from);
        }
    }

    pub(crate) fn is_polling(&self) -> bool {
        !self.poll.is_empty()
    }

    /// Notes that an answer is complete at `from`.
    pub(crate) fn answered(&mut self, from: u64) {
        if self.is_polling() {
            self.polled += 1;
            self.next_poll(from);
        }
    }

    fn next_poll(&mut self, from: u64) {
        if self.poll.is_empty() {
            return;
        }
        self.turn = (self.turn + 1) % self.poll.len();
        let line = self.poll[self.turn].clone();
        self.send(from, &line);
    }

    /// Handles a loss of power: bytes on the way are lost.
    pub(crate) fn cut(&mut self) {
        *self = Line { lost: self.lost, ..Line::default() };
    }

    /// Whether no bytes are on the way to the chip.
    pub(crate) fn is_idle(&self) -> bool {
        self.waiting.is_empty() && self.flying.is_none() && self.arrived.is_empty()
    }

    /// The cycle of the next event here.
    #[inline(always)]
    pub(crate) fn due(&self) -> u64 {
        if !self.arrived.is_empty() {
            return 0;
        }
        match (self.flying, self.waiting.front()) {
            (Some((done, _)), _) => done,
            (None, Some(&(from, _))) => from.max(self.free),
            (None, None) => u64::MAX,
        }
    }

    /// Handles the events that are due at `now`.
    pub(crate) fn tick(&mut self, now: u64, silicon: &mut Silicon) {
        if let Some((done, byte)) = self.flying
            && done <= now
        {
            self.flying = None;
            self.arrived.push_back(byte);
        }
        if self.flying.is_none()
            && let Some(&(from, byte)) = self.waiting.front()
            && from.max(self.free) <= now
        {
            self.waiting.pop_front();
            if self.arrived.len() + usize::from(!silicon.receiver_is_empty()) >= RECEIVER {
                self.arrived.pop_back();
                self.lost += 1;
                silicon.overrun();
            }
            // From the earliest cycle on, so that bytes follow each other exactly.
            let begin = from.max(self.free);
            self.free = begin + silicon.byte_time();
            self.flying = Some((self.free, byte));
        }
        if silicon.receiver_is_empty()
            && let Some(byte) = self.arrived.pop_front()
        {
            silicon.receive(byte);
        }
    }
}
