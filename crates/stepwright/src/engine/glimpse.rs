//! What the foreground sees of the engine without holding its interrupt off.
//!
//! A copy of a position takes longer than a step may be late at 120,000
//! steps/s. So it is read while the interrupt comes and goes, and read again if
//! a run or an event has changed meanwhile: within a run only the count of the
//! steps that are left changes, and that is read on its own.

use super::track::{Event, Track, position};
use super::{Engine, Report};
use crate::direct::Direct;
use crate::queue::{Feed, element};
use crate::timer::{Count, StepTimer};

/// A feed that the foreground may look at while the step interrupt takes from it.
#[doc(hidden)]
pub trait Seen: Feed {
    /// Changes when another run is taken; or 0, if a run is a single step.
    ///
    /// # Safety
    /// `feed` points to a feed.
    unsafe fn stamp(feed: *const Self) -> u8;

    /// Steps that are left of the run that is played.
    ///
    /// # Safety
    /// `feed` points to a feed.
    unsafe fn left_now(feed: *const Self) -> u16;
}

/// Each run is a step: what was loaded tells them apart.
impl Seen for Direct {
    unsafe fn stamp(_: *const Self) -> u8 {
        0
    }

    unsafe fn left_now(_: *const Self) -> u16 {
        1
    }
}

impl<T: StepTimer, D, F: Seen, const N: usize> Engine<T, D, F, N> {
    /// Whether no travel of an axis is in progress; of the first one if there is
    /// no such axis. Looks at one byte.
    ///
    /// # Safety
    /// `engine` points to an engine, which only the step interrupt changes.
    pub unsafe fn is_idle(engine: *const Self, axis: u8) -> bool {
        // SAFETY: the caller's promise.
        unsafe { (&raw const (*Self::track(engine, axis)).event).read_volatile() == Event::Idle }
    }

    /// [`report`](Engine::report).
    ///
    /// # Safety
    /// `engine` points to an engine, which only the step interrupt changes.
    pub unsafe fn glimpse(engine: *const Self, axis: u8) -> Report {
        // SAFETY: the caller's promise.
        unsafe {
            let position = Self::position(engine, axis);
            let forward = Self::is_forward(engine, axis);
            Report { position, idle: Self::is_idle(engine, axis), forward }
        }
    }

    /// The direction of an axis' last or present travel; of the first one's if
    /// there is no such axis. Looks at one byte.
    ///
    /// # Safety
    /// `engine` points to an engine, which only the step interrupt changes.
    pub unsafe fn is_forward(engine: *const Self, axis: u8) -> bool {
        // SAFETY: the caller's promise.
        unsafe { (&raw const (*Self::track(engine, axis)).forward).read_volatile() }
    }

    /// The position of an axis; of the first one if there is no such axis.
    ///
    /// # Safety
    /// `engine` points to an engine, which only the step interrupt changes.
    pub unsafe fn position(engine: *const Self, axis: u8) -> i64 {
        // SAFETY: the caller's promise; every read is of one field, and volatile.
        unsafe {
            let track = Self::track(engine, axis);
            let axis = if usize::from(axis) < N { axis } else { 0 };
            let feed = element(&raw const (*engine).feeds, axis);
            loop {
                let before = Stamp::of(track, feed);
                let loaded = (&raw const (*track).loaded).read_volatile();
                let forward = (&raw const (*track).forward).read_volatile();
                let playing = match before.event {
                    Event::Step => F::left_now(feed),
                    Event::Far => 1,
                    Event::Hop if (&raw const (*track).then).read_volatile() == Event::Far => 1,
                    _ => 0,
                };
                if Stamp::of(track, feed) == before {
                    return position(loaded, forward, playing.wrapping_add(before.far));
                }
            }
        }
    }

    /// # Safety
    /// `engine` points to an engine.
    unsafe fn track(engine: *const Self, axis: u8) -> *const Track<T::Count> {
        let axis = if usize::from(axis) < N { axis } else { 0 };
        // SAFETY: the caller's promise.
        element(unsafe { &raw const (*engine).tracks }, axis)
    }
}

/// What changes when another run is loaded, or another event is waited for.
#[derive(PartialEq, Eq)]
struct Stamp {
    taken: u8,
    loaded: u8,
    event: Event,
    far: u16,
}

impl Stamp {
    /// # Safety
    /// `track` points to a track, `feed` to its feed.
    unsafe fn of<C: Count, F: Seen>(track: *const Track<C>, feed: *const F) -> Stamp {
        // SAFETY: the caller's promise.
        unsafe {
            Stamp {
                taken: F::stamp(feed),
                loaded: (&raw const (*track).loaded).cast::<u8>().read_volatile(),
                event: (&raw const (*track).event).read_volatile(),
                far: (&raw const (*track).far.count).read_volatile(),
            }
        }
    }
}
