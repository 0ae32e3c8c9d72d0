//! The tasks that wait for the rest of an axis.

use core::task::Waker;

/// The number of tasks that can wait for one axis; more than that keep waking each other until it
/// rests.
pub(crate) const MOST: usize = 4;

/// The wakers of the tasks that wait for the rest of an axis.
pub(crate) struct Waiters([Option<Waker>; MOST]);

impl Waiters {
    pub(crate) const NONE: Waiters = Waiters([const { None }; MOST]);

    /// Adds a waiting task. If there is no free slot, wakes the oldest one, which then waits again.
    pub(crate) fn add(&mut self, waker: &Waker) {
        let waits = |slot: &Option<Waker>| slot.as_ref().is_some_and(|own| own.will_wake(waker));
        if self.0.iter().any(waits) {
            return;
        }
        if self.0.iter().all(Option::is_some) {
            self.0.rotate_left(1);
            if let [.., last] = &mut self.0
                && let Some(first) = last.take()
            {
                first.wake();
            }
        }
        if let Some(free) = self.0.iter_mut().find(|slot| slot.is_none()) {
            *free = Some(waker.clone());
        }
    }

    /// Wakes all tasks and frees their slots.
    pub(crate) fn wake(&mut self) {
        for slot in &mut self.0 {
            if let Some(waker) = slot.take() {
                waker.wake();
            }
        }
    }
}
