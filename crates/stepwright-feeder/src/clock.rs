//! When the board is where: by the frames that it has opened.
//!
//! A board counts spans of 2¹⁶ ticks by its timer, which is anywhere in one when all axes start. So
//! its *gates* are up to a span ahead of the ticks since the start.

use stepwright_stream::player::AHEAD;

use crate::fine;

/// A board's clock goes slower than the computer's by this part at most: an Uno's resonator.
const SLOWER: f64 = 0.995;

/// A span of a gate, in 2⁻⁸ ticks.
pub(crate) const SPAN: u64 = 1 << 24;

/// The time of the board's gates, in 2⁻⁸ ticks, as little as it can be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoardClock {
    /// 2⁻⁸ ticks a µs.
    rate: f64,
    /// µs, and the board's time then.
    known: Option<(u64, u64)>,
}

/// When a frame that starts then is opened, by the gates.
pub(crate) const fn opening(start: u64) -> u64 {
    (start >> 24).saturating_sub(AHEAD as u64) << 24
}

impl BoardClock {
    pub(crate) const fn new(hz: u32) -> BoardClock {
        BoardClock { rate: fine(hz as u64) as f64 / 1e6, known: None }
    }

    /// 2⁻⁸ ticks in these µs.
    pub(crate) fn ticks(&self, micros: u64) -> u64 {
        (micros as f64 * self.rate) as u64
    }

    /// A frame that starts then has been opened by now.
    pub(crate) fn opened(&mut self, start: u64, now: u64) {
        let at = self.at(now).unwrap_or(0).max(opening(start));
        self.known = Some((now, at));
    }

    /// The time now; `None` before it is known.
    pub(crate) fn at(&self, now: u64) -> Option<u64> {
        let (then, at) = self.known?;
        Some(at + (now.saturating_sub(then) as f64 * self.rate * SLOWER) as u64)
    }
}
