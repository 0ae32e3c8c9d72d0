//! What stands where an engine does.

use stepwright::Ticks;
use stepwright::timer::{Count, StepTimer};

/// Looks at a counter after which it is taken to stand still.
const STANDS: u32 = 1_000_000;

/// A timer, with one deadline.
pub struct TimerProbe<T: StepTimer> {
    timer: T,
    /// The deadline; none once it has come.
    at: Option<T::Count>,
    /// The count at which the interrupt saw that it had come.
    served: Option<T::Count>,
    spurious: u32,
}

impl<T: StepTimer> TimerProbe<T> {
    /// Of a timer that counts.
    pub const fn new(timer: T) -> TimerProbe<T> {
        TimerProbe { timer, at: None, served: None, spurious: 0 }
    }

    /// The step interrupt. Does what an engine does: sees what is due, sets the compare register to
    /// what comes next, and looks again before it leaves.
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

    /// From now on this is the deadline.
    pub(crate) fn set(&mut self, at: T::Count) {
        (self.at, self.served) = (Some(at), None);
        self.timer.wake_at(at);
    }

    /// When the deadline was served.
    pub(crate) fn served(&self) -> Option<T::Count> {
        self.served
    }

    /// Interrupts that came for no deadline.
    pub(crate) fn spurious(&self) -> u32 {
        self.spurious
    }

    /// Looks at the counter until this many ticks have passed; false if it stands still.
    pub(crate) fn pass(&mut self, since: T::Count, ticks: i32, tick: impl Fn(&mut T)) -> bool {
        let until = since.plus(ticks as Ticks);
        (0..STANDS).any(|_| {
            tick(&mut self.timer);
            !until.is_after(self.timer.now())
        })
    }
}
