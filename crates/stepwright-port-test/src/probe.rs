//! A probe that takes the place of an engine.

use stepwright::Ticks;
use stepwright::timer::{Count, StepTimer};

/// Looks at a counter without a change after which it counts as standing still.
const STANDS: u32 = 1_000_000;

/// A timer with one deadline.
pub struct TimerProbe<T: StepTimer> {
    timer: T,
    /// The deadline; `None` after it has come.
    at: Option<T::Count>,
    /// The count at which the interrupt served the deadline.
    served: Option<T::Count>,
    spurious: u32,
}

impl<T: StepTimer> TimerProbe<T> {
    /// A probe with a running timer.
    pub const fn new(timer: T) -> TimerProbe<T> {
        TimerProbe { timer, at: None, served: None, spurious: 0 }
    }

    /// The step interrupt. Works like an engine: serves what is due, sets the compare register to the next
    /// deadline, and looks at the counter a second time before it leaves.
    pub fn on_compare(&mut self) {
        let mut nothing = true;
        loop {
            let now = self.timer.now();
            if let Some(at) = self.at
                && !at.is_after(now)
            {
                (self.at, self.served, nothing) = (None, Some(now), false);
            }
            let next = self.at.unwrap_or(now.plus(2 * T::Count::HOP - 1));
            self.timer.set_compare(next);
            if next.is_after(self.timer.now()) {
                break;
            }
        }
        self.spurious = self.spurious.saturating_add(nothing.into());
    }

    /// The timer.
    pub fn timer(&mut self) -> &mut T {
        &mut self.timer
    }

    /// Sets the deadline.
    pub(crate) fn set(&mut self, at: T::Count) {
        (self.at, self.served) = (Some(at), None);
        self.timer.wake_at(at);
    }

    /// The count at which the deadline was served.
    pub(crate) fn served(&self) -> Option<T::Count> {
        self.served
    }

    /// The number of interrupts without a deadline.
    pub(crate) fn spurious(&self) -> u32 {
        self.spurious
    }

    /// Looks at the counter until this many ticks have passed. False if it stands still.
    pub(crate) fn pass(&mut self, since: T::Count, ticks: i32, tick: impl Fn(&mut T)) -> bool {
        let until = since.plus(ticks as Ticks);
        (0..STANDS).any(|_| {
            tick(&mut self.timer);
            !until.is_after(self.timer.now())
        })
    }
}
