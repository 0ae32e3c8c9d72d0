//! Who looks on while cycles are played on the virtual board, and may hold them up.

use std::ops::Range;

use stepwright::Ticks;
use stepwright_path::LivePath;

use crate::PlayError;
use stepwright_cyclefile::MOST;

/// A part of what is played, and when it begins.
pub struct PlayPart<'a> {
    /// `line`, `arc`, `path`, `home`, `moves` or `rest`.
    pub kind: &'static str,
    /// Where it stands in the file.
    pub at: Range<usize>,
    /// Ticks since the board was switched on.
    pub begin: u64,
    /// The path, of a line or an arc, and ticks from the begin to the path's own.
    pub path: Option<(&'a LivePath, Ticks)>,
}

/// What an onlooker says to the player.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayAhead {
    /// It may be played up to this tick.
    On(u64),
    /// The motors are to brake, and the rest is not played. Said once.
    Stop,
}

/// An onlooker.
pub trait Onlooker {
    /// A part begins.
    fn part(&mut self, part: PlayPart);

    /// The motors are here now, at this tick. Called when one has moved.
    fn at(&mut self, ticks: u64, positions: &[i64; MOST]);

    /// How far it may be played; it is this tick.
    ///
    /// # Errors
    /// It is not to be played any further.
    fn may(&mut self, ticks: u64) -> Result<PlayAhead, PlayError>;
}
