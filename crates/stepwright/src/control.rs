//! The foreground's interface to an engine.

use crate::drive::{Axes, Drive};
use crate::engine::{Engine, Playing, Report, Timing};
use crate::queue::Source;
use crate::timer::StepTimer;

/// The calls that the foreground makes to the engine.
///
/// Implemented by [`Engine`] itself where there is no interrupt (a simulation); on a chip, by a
/// wrapper that holds the step interrupt off during each call.
pub trait Control {
    /// See [`Engine::start`].
    fn start(&mut self, axes: Axes);
    /// See [`Engine::kill`].
    fn kill(&mut self, axes: Axes);
    /// See [`Engine::report`].
    fn report(&self, axis: u8) -> Report;
    /// Whether no travel of an axis is in progress. Called often: for this call an engine behind an
    /// interrupt should not hold that interrupt off, see [`Engine::is_idle`].
    fn is_idle(&self, axis: u8) -> bool {
        self.report(axis).idle
    }
    /// The position of an axis, as in [`report`](Control::report).
    fn position(&self, axis: u8) -> i64 {
        self.report(axis).position
    }
    /// The direction of an axis, as in [`report`](Control::report).
    fn is_forward(&self, axis: u8) -> bool {
        self.report(axis).forward
    }
    /// See [`Engine::playing`].
    fn playing(&mut self, axis: u8) -> Playing;
    /// See [`Engine::set_position`].
    fn set_position(&mut self, axis: u8, position: i64);
    /// See [`Engine::set_timing`].
    fn set_timing(&mut self, timing: Timing);
    /// See [`Engine::late`].
    fn late(&self) -> u32;
    /// See [`Engine::clear_late`].
    fn clear_late(&mut self);
    /// Called after entries may have been queued: an engine that prepares its queue in the
    /// foreground does so now.
    fn refill(&mut self) {}
}

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Control for Engine<T, D, S, N> {
    fn start(&mut self, axes: Axes) {
        Engine::start(self, axes);
    }
    fn kill(&mut self, axes: Axes) {
        Engine::kill(self, axes);
    }
    fn report(&self, axis: u8) -> Report {
        Engine::report(self, axis)
    }
    fn playing(&mut self, axis: u8) -> Playing {
        Engine::playing(self, axis)
    }
    fn set_position(&mut self, axis: u8, position: i64) {
        Engine::set_position(self, axis, position);
    }
    fn set_timing(&mut self, timing: Timing) {
        Engine::set_timing(self, timing);
    }
    fn late(&self) -> u32 {
        Engine::late(self)
    }
    fn clear_late(&mut self) {
        Engine::clear_late(self);
    }
}
