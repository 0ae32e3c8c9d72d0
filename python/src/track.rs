//! What a recorder writes down: every look at every axis.

use std::sync::{Mutex, MutexGuard, PoisonError};

use stepwright_keeper::report::LiveState;

/// Between two looks at axes that move, in s: what a recording is to have.
pub const LOOK: f64 = 0.02;

/// A look that comes this many of these later than the one before has missed others: one that finds
/// the axis at rest is told only when it was asked why, and where, once more.
const LATE: [f64; 2] = [3.0, 2.0];

/// The states that a look may find, by their numbers.
pub const STATES: [&str; 4] = ["ready", "busy", "uncertain", "lost"];

/// The looks at an axis, a column each.
#[derive(Clone, Default)]
pub struct Track {
    /// When, in s of the board's clock.
    pub time: Vec<f64>,
    /// Where it was, in steps; NaN where that was not known.
    pub position: Vec<f64>,
    /// How fast, in steps/s.
    pub speed: Vec<f64>,
    /// Its place in [`STATES`].
    pub state: Vec<u8>,
    /// Looks that did not come in their time while it moved.
    pub missed: u64,
    moved: bool,
}

/// The looks at all axes since the recording began.
#[derive(Default)]
pub struct Tracks(Mutex<Vec<Track>>);

impl Tracks {
    fn tracks(&self) -> MutexGuard<'_, Vec<Track>> {
        // Nothing here is changed by halves.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is known now: axes that were looked at since the last time.
    pub fn see(&self, state: &LiveState) {
        let mut tracks = self.tracks();
        let many = state.axes.len().max(tracks.len());
        tracks.resize_with(many, Track::default);
        for (axis, track) in state.axes.iter().zip(tracks.iter_mut()) {
            let number = STATES.iter().position(|one| *one == axis.state).unwrap_or(0) as u8;
            let last = track.time.last().copied();
            if last.is_some_and(|last| axis.time <= last) && track.state.last() == Some(&number) {
                continue;
            }
            if let Some(gap) = last.map(|last| axis.time - last)
                && track.moved
                && gap >= LATE[usize::from(axis.moving)] * LOOK
            {
                track.missed += ((gap / LOOK) as u64).saturating_sub(1);
            }
            track.moved = axis.moving;
            track.time.push(axis.time.max(last.unwrap_or(0.0)));
            track.position.push(axis.position.map_or(f64::NAN, |at| at as f64));
            track.speed.push(axis.speed);
            track.state.push(number);
        }
    }

    /// The track of an axis, from 0.
    pub fn of(&self, axis: usize) -> Track {
        self.tracks().get(axis).cloned().unwrap_or_default()
    }

    /// Axes that were seen.
    pub fn len(&self) -> usize {
        self.tracks().len()
    }
}
