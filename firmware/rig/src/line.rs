//! The host's end of the serial line: bytes at their true distance.

use std::collections::VecDeque;

use crate::silicon::Silicon;

/// A chip's receiver holds two bytes, and a third in the register that the line is shifted into:
/// until the next one begins there.
const RECEIVER: usize = 3;

/// Bytes on their way to the chip.
#[derive(Default)]
pub(crate) struct Line {
    /// To be sent, and the cycle before which the first may not begin.
    waiting: VecDeque<(u64, u8)>,
    /// The line is free from then on.
    free: u64,
    /// The byte on the line and the cycle at which it is complete.
    flying: Option<(u64, u8)>,
    /// Complete, and not yet taken by the firmware.
    arrived: VecDeque<u8>,
    /// Bytes lost because the firmware did not take them in time.
    pub(crate) lost: u64,
    /// Lines to send in turn, each when the last answer is complete.
    poll: Vec<Vec<u8>>,
    turn: usize,
    /// Answers to those lines.
    pub(crate) polled: u64,
}

impl Line {
    /// Sends `bytes` one behind the other, not before `from`.
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

    /// An answer is complete at `from`.
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

    /// The power has gone: what was under way is lost.
    pub(crate) fn cut(&mut self) {
        *self = Line { lost: self.lost, ..Line::default() };
    }

    /// Whether nothing is under way to the chip.
    pub(crate) fn is_idle(&self) -> bool {
        self.waiting.is_empty() && self.flying.is_none() && self.arrived.is_empty()
    }

    /// The next cycle at which there is something to do here.
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

    /// Does what is due at `now`.
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
            // From when it could begin, so that bytes lie exactly side by side.
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
