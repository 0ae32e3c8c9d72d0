//! Who waits for the rest of an axis.

use core::task::Waker;

/// Tasks that wait for one axis; more than that wake each other until it rests.
pub(crate) const MOST: usize = 4;

/// The tasks that the rest of an axis wakes.
pub(crate) struct Waiters([Option<Waker>; MOST]);

impl Waiters {
    pub(crate) const NONE: Waiters = Waiters([const { None }; MOST]);

    /// Another task waits. Where there is no place left, the first one is woken, and waits again.
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

    /// Wakes them all: nobody waits any longer.
    pub(crate) fn wake(&mut self) {
        for slot in &mut self.0 {
            if let Some(waker) = slot.take() {
                waker.wake();
            }
        }
    }
}
