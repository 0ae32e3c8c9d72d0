//! Simulated time: a free-running counter with a compare register.

use core::cell::Cell;
use core::marker::PhantomData;
#[cfg(feature = "std")]
use std::rc::Rc;

use stepwright::timer::{Count, StepTimer};

use crate::AXES;

/// The present, in ticks since the board was switched on; shared by all parts of a board.
pub trait Present {
    /// The present time.
    fn get(&self) -> u64;

    /// Sets the present time.
    fn set(&self, time: u64);
}

/// The present of a board that borrows its queues, in which it is kept.
#[derive(Clone, Copy, Debug)]
pub struct LentNow<'q>(pub(crate) &'q Cell<u64>);

impl Present for LentNow<'_> {
    fn get(&self) -> u64 {
        self.0.get()
    }

    fn set(&self, time: u64) {
        self.0.set(time);
    }
}

/// The present of a board that borrows nothing.
#[cfg(feature = "std")]
#[derive(Clone, Debug, Default)]
pub struct Now(Rc<Cell<u64>>);

#[cfg(feature = "std")]
impl Present for Now {
    fn get(&self) -> u64 {
        self.0.get()
    }

    fn set(&self, time: u64) {
        self.0.set(time);
    }
}

/// A timer of the width of `C`, whose counter wraps as on a chip. Time passes only where the board lets it
/// pass, so a time that has passed matches a tick later.
#[derive(Debug)]
pub struct SimTimer<C, P> {
    now: P,
    wake: u64,
    /// Ticks between possible matches, for each axis; powers of two.
    grid: [u32; AXES],
    count: PhantomData<C>,
}

impl<C: Count, P: Present> SimTimer<C, P> {
    #[cfg(feature = "std")]
    pub(crate) fn new(now: P) -> SimTimer<C, P> {
        SimTimer::on_grid(now, [1; AXES])
    }

    pub(crate) fn on_grid(now: P, grid: [u32; AXES]) -> SimTimer<C, P> {
        SimTimer { now, wake: 0, grid, count: PhantomData }
    }

    /// The next match of the compare register.
    pub(crate) fn wake(&self) -> u64 {
        self.wake
    }

    fn count(&self) -> C {
        // The low bits of the time, for either width.
        C::of(C::fine(self.now.get() as u32, 0))
    }
}

impl<C: Count, P: Present> StepTimer for SimTimer<C, P> {
    type Count = C;
    /// The edges of a chip that holds its pulses.
    const SPIN: u32 = u32::MAX;

    fn now(&mut self) -> C {
        self.count()
    }

    fn wake_at(&mut self, at: C) {
        let ahead = i64::from(at.since(self.count())).max(1);
        self.wake = self.now.get().wrapping_add_signed(ahead);
    }

    fn reach(&self, axis: u8, at: C) -> C {
        let grid = self.grid.get(usize::from(axis)).copied().unwrap_or(1).max(1);
        // Modulo the counter, which is a multiple of the grid.
        let past = at.since(C::ZERO.0) as u32 & (grid - 1);
        if past == 0 { at } else { at.plus(grid - past) }
    }

    fn hold_until(&mut self, at: C) {
        let ahead = i64::from(at.since(self.count()));
        if ahead > 0 {
            self.now.set(self.now.get().wrapping_add_signed(ahead));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright_port_test::{TestPort, TimerProbe, check};

    struct Simulated<C: Count>(TimerProbe<SimTimer<C, Now>>);

    impl<C: Count> TestPort for Simulated<C> {
        type Timer = SimTimer<C, Now>;

        fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<Self::Timer>) -> R) -> R {
            ask(&mut self.0)
        }
        fn idle(&mut self) {
            Self::tick(self.0.timer());
            let timer = self.0.timer();
            if timer.wake() <= timer.now.get() {
                self.0.on_compare();
            }
        }
        fn tick(timer: &mut Self::Timer) {
            timer.now.set(timer.now.get() + 1);
        }
        fn set_count(&mut self, count: C) -> bool {
            let now = &self.0.timer().now;
            // A time with this count, after some turns of the counter.
            now.set((5 << 32) + u64::from(count.since(C::ZERO.0) as u32));
            true
        }
    }

    #[test]
    fn the_simulated_timer_keeps_the_contract() {
        let narrow =
            check(&mut Simulated(TimerProbe::new(SimTimer::<u16, Now>::new(Now::default()))), 2);
        assert!(narrow.is_ok_and(|checked| checked.wrapped), "{narrow:?}");
        let wide =
            check(&mut Simulated(TimerProbe::new(SimTimer::<u32, Now>::new(Now::default()))), 2);
        assert!(wide.is_ok_and(|checked| checked.wrapped), "{wide:?}");
    }
}
