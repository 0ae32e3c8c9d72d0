//! The data of a recorder: every look at every axis.

use std::sync::{Mutex, MutexGuard, PoisonError};

use stepwright_keeper::report::LiveState;

/// The time between two looks at moving axes, in s, that a recording needs.
pub const LOOK: f64 = 0.02;

/// A look that comes later than this many intervals after the look before has missed others: at rest, and while
/// moving. A look that finds the axis at rest is told later, after two more questions: why it stopped, and
/// where.
const LATE: [f64; 2] = [3.0, 2.0];

/// The states of an axis, by their numbers.
pub const STATES: [&str; 4] = ["ready", "busy", "uncertain", "lost"];

/// The looks at an axis, one column for each value.
#[derive(Clone, Default)]
pub struct Track {
    /// Times in s of the board's clock.
    pub time: Vec<f64>,
    /// Positions in steps; NaN if not known.
    pub position: Vec<f64>,
    /// Speeds in steps/s.
    pub speed: Vec<f64>,
    /// States as indexes of [`STATES`].
    pub state: Vec<u8>,
    /// The number of looks that did not come in time while the axis moved.
    pub missed: u64,
    moved: bool,
}

/// The looks at all axes since the recording began.
#[derive(Default)]
pub struct Tracks(Mutex<Vec<Track>>);

impl Tracks {
    fn tracks(&self) -> MutexGuard<'_, Vec<Track>> {
        // Every change leaves a complete state.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds the looks that are new in this state.
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

    /// The track of an axis, counted from 0.
    pub fn of(&self, axis: usize) -> Track {
        self.tracks().get(axis).cloned().unwrap_or_default()
    }

    /// The number of axes that were seen.
    pub fn len(&self) -> usize {
        self.tracks().len()
    }
}
