//! An estimate of the board's time, from the frames that the board has opened.
//!
//! A board counts spans of 2¹⁶ ticks by its timer. The timer is anywhere within a span when the axes start,
//! so the board's *gates* are up to one span ahead of the ticks since the start.

use stepwright_stream::player::AHEAD;

use crate::fine;

/// The slowest clock of a board, relative to the computer's: the resonator of an Uno.
const SLOWER: f64 = 0.995;

/// The span of a gate, in 2⁻⁸ ticks.
pub(crate) const SPAN: u64 = 1 << 24;

/// A lower bound of the board's gate time, in 2⁻⁸ ticks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoardClock {
    /// 2⁻⁸ ticks per µs.
    rate: f64,
    /// A moment of the computer in µs, and the board's time at that moment.
    known: Option<(u64, u64)>,
}

/// The gate time at which the board opens a frame with this start.
pub(crate) const fn opening(start: u64) -> u64 {
    (start >> 24).saturating_sub(AHEAD as u64) << 24
}

impl BoardClock {
    pub(crate) const fn new(hz: u32) -> BoardClock {
        BoardClock { rate: fine(hz as u64) as f64 / 1e6, known: None }
    }

    /// Converts µs to 2⁻⁸ ticks.
    pub(crate) fn ticks(&self, micros: u64) -> u64 {
        (micros as f64 * self.rate) as u64
    }

    /// Notes that the board has opened the frame with this start by `now`.
    pub(crate) fn opened(&mut self, start: u64, now: u64) {
        let at = self.at(now).unwrap_or(0).max(opening(start));
        self.known = Some((now, at));
    }

    /// The board's time at `now`; `None` before the first frame was opened.
    pub(crate) fn at(&self, now: u64) -> Option<u64> {
        let (then, at) = self.known?;
        Some(at + (now.saturating_sub(then) as f64 * self.rate * SLOWER) as u64)
    }
}
