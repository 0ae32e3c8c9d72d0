//! A 32-bit counter with a compare register: the step timer of most chips.

use stepwright::Ticks;
use stepwright::timer::StepTimer;

/// The registers of such a timer. Each method accesses one or two of them.
pub trait CompareRegister {
    /// See [`StepTimer::LINGER`].
    const LINGER: Ticks;
    /// See [`StepTimer::REACTION`].
    const REACTION: Ticks;

    /// The counter, which counts up through all 32 bits.
    fn count(&mut self) -> u32;
    /// Writes the compare register. The interrupt is requested when the counter reaches it.
    fn compare(&mut self, at: u32);
    /// Withdraws the request of a match.
    fn clear(&mut self);
    /// Requests the interrupt.
    fn pend(&mut self);
}

/// The step timer made from these registers. Its order of accesses loses no deadline: write the
/// value, clear the old request, read the counter, and request the interrupt if the value has
/// passed. A cleared request is either the old value's, or the new value's, and then the counter
/// shows that the value has passed.
pub struct CompareTimer<R>(R);

impl<R: CompareRegister> CompareTimer<R> {
    /// A timer whose counter runs, and whose interrupt is held off.
    pub const fn new(register: R) -> CompareTimer<R> {
        CompareTimer(register)
    }
}

impl<R: CompareRegister> StepTimer for CompareTimer<R> {
    type Count = u32;
    const LINGER: Ticks = R::LINGER;
    const REACTION: Ticks = R::REACTION;

    #[inline(always)]
    fn now(&mut self) -> u32 {
        self.0.count()
    }

    #[inline(always)]
    fn wake_at(&mut self, at: u32) {
        self.set_compare(at);
        if at.wrapping_sub(self.now()) as i32 <= 0 {
            self.0.pend();
        }
    }

    #[inline(always)]
    fn set_compare(&mut self, at: u32) {
        self.0.compare(at);
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use core::cell::Cell;
    use std::rc::Rc;

    use stepwright_port_test::{Checked, TestPort, TimerFault, TimerProbe, check};

    use super::*;

    /// A counter like an STM32's TIM2 and a SAM3X's TC, with an interrupt controller: a match sets
    /// a flag, which requests the interrupt while it is set. Each access takes time.
    #[derive(Default)]
    struct Model {
        count: Cell<u32>,
        compare: Cell<u32>,
        flag: Cell<bool>,
        pended: Cell<bool>,
        access: u32,
    }

    impl Model {
        fn pass(&self, ticks: u32) {
            for _ in 0..ticks {
                self.count.set(self.count.get().wrapping_add(1));
                if self.count.get() == self.compare.get() {
                    self.flag.set(true);
                }
            }
        }
    }

    impl CompareRegister for Rc<Model> {
        const LINGER: Ticks = 0;
        const REACTION: Ticks = 0;

        fn count(&mut self) -> u32 {
            self.pass(self.access);
            self.count.get()
        }
        fn compare(&mut self, at: u32) {
            self.pass(self.access);
            self.compare.set(at);
        }
        fn clear(&mut self) {
            self.pass(self.access);
            self.flag.set(false);
        }
        fn pend(&mut self) {
            self.pended.set(true);
        }
    }

    struct Bench<T: StepTimer> {
        probe: TimerProbe<T>,
        model: Rc<Model>,
    }

    impl<T: StepTimer<Count = u32>> TestPort for Bench<T> {
        type Timer = T;

        fn with<R>(&mut self, ask: impl FnOnce(&mut TimerProbe<T>) -> R) -> R {
            ask(&mut self.probe)
        }

        fn idle(&mut self) {
            self.model.pass(1);
            if self.model.pended.replace(false) || self.model.flag.get() {
                self.probe.on_compare();
            }
        }

        fn set_count(&mut self, count: u32) -> bool {
            self.model.count.set(count);
            true
        }
    }

    /// A timer that ignores values that have passed.
    struct Forgets(Rc<Model>);

    impl StepTimer for Forgets {
        type Count = u32;

        fn now(&mut self) -> u32 {
            self.0.count()
        }
        fn wake_at(&mut self, at: u32) {
            self.0.compare(at);
            self.0.clear();
        }
    }

    fn tried<T: StepTimer<Count = u32>>(
        access: u32,
        timer: impl FnOnce(Rc<Model>) -> T,
    ) -> Result<Checked, TimerFault> {
        let model = Rc::new(Model { access, ..Model::default() });
        check(&mut Bench { probe: TimerProbe::new(timer(model.clone())), model }, 200)
    }

    #[test]
    fn the_order_loses_nothing() {
        for access in 1..=9 {
            let checked = tried(access, CompareTimer::new).unwrap();
            assert!(checked.wrapped && checked.values > 300, "{access}: {checked:?}");
            assert!(matches!(tried(access, Forgets), Err(TimerFault::Lost { .. })));
        }
    }
}
