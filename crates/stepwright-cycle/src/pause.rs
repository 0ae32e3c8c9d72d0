//! Pauses: the waiting motors, and on the fixed tick the time of the restart.
//!
//! ```text
//!   grid     ┊     ┊     ┊     ┊     ┊     ┊
//!            │  pause         resume ▏     │
//!   events      ├─ frozen ───────────┼ wait┤ all later by whole ticks
//! ```
//!
//! The grid continues while the motors stand. The elapsed time is counted at each interrupt, which
//! comes at least twice a turn of the counter, so that a pause may be longer than the counter.

use super::clock::{ANY_TICK, Beat};
use super::kept::Kept;
use super::strategy::Refusal;
use super::surroundings::MachineIo;
use super::{Cycle, State};
use stepwright::drive::{Axes, Drive};
use stepwright::engine::Frozen;
use stepwright::timer::{Count, StepTimer};
use stepwright::units::Ticks;

/// A cycle's pause.
pub(crate) struct Pause<C: Count, const N: usize> {
    /// The frozen axes of the engine.
    pub frozen: Frozen<C, N>,
    /// The steps of each motor.
    pub steps: [i64; N],
    /// Whether the pause ends as soon as the grid allows it.
    pub resumed: bool,
    /// The count at which time was counted last.
    seen: C,
    /// Time since the beginning beyond whole ticks of the grid, in the units of
    /// [`until_grid`](Beat::until_grid).
    passed: Kept<u64, ANY_TICK>,
}

impl<C: Count, const N: usize> Pause<C, N> {
    /// A pause that begins `now`.
    pub fn new(frozen: Frozen<C, N>, steps: [i64; N], now: C) -> Self {
        Pause { frozen, steps, resumed: false, seen: now, passed: Kept::new(0) }
    }

    /// Counts the time until `now`, which is less than a turn of the counter, and returns the ticks
    /// of the timer from `now` to the grid: 0 without a fixed tick.
    pub fn until_grid(&mut self, now: C, beat: &Beat) -> Ticks {
        let turn = (C::HOP << 2).wrapping_sub(1);
        let ticks = now.since(self.seen) as Ticks & turn;
        self.seen = now;
        let mut passed = self.passed.get();
        let ticks = beat.until_grid(&mut passed, ticks);
        self.passed.set(passed);
        ticks
    }
}

impl<T: StepTimer, D: Drive, S: MachineIo, const N: usize> Cycle<'_, T, D, S, N> {
    /// Pauses all motors where they are. On the fixed tick a pulse in progress ends.
    ///
    /// # Errors
    /// [`Refusal::NotRunning`] if no cycle runs.
    pub fn pause(&mut self) -> Result<(), Refusal> {
        if let State::Paused(pause) = &mut self.state
            && pause.resumed
        {
            // The motors have not continued yet.
            pause.resumed = false;
            return Ok(());
        }
        if !matches!(self.state, State::Running) {
            return Err(Refusal::NotRunning);
        }
        self.engine.drive().lower(Axes::MAX);
        let mut steps = [0; N];
        for (motor, steps) in (0u8..).zip(&mut steps) {
            *steps = self.engine.report(motor).position;
        }
        let now = self.engine.timer().now();
        self.state = State::Paused(Pause::new(self.engine.freeze(), steps, now));
        Ok(())
    }

    /// Continues: every step is delayed by the time of the pause; on the fixed tick by whole ticks,
    /// rounded up, so that all edges are on the grid again.
    ///
    /// # Errors
    /// [`Refusal::NotRunning`] if the cycle is not paused.
    pub fn resume(&mut self) -> Result<(), Refusal> {
        match &mut self.state {
            State::Paused(pause) if !pause.resumed => pause.resumed = true,
            _ => return Err(Refusal::NotRunning),
        }
        self.wait();
        Ok(())
    }

    /// Counts the time of a pause; continues if it has ended and the grid is near.
    #[inline(never)]
    pub(crate) fn wait(&mut self) {
        let State::Paused(pause) = &mut self.state else { return };
        let now = self.engine.timer().now();
        let to_grid = pause.until_grid(now, &self.beat);
        if !pause.resumed {
            return;
        }
        if to_grid > T::Count::HOP {
            return self.engine.timer().wake_at(now.plus(T::Count::HOP));
        }
        if let State::Paused(pause) = core::mem::replace(&mut self.state, State::Running) {
            self.engine.thaw(pause.frozen.later(to_grid));
        }
    }
}
