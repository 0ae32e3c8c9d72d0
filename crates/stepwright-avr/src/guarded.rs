//! A motor that an interrupt owns, for the foreground: each call holds off the interrupt.

use core::marker::PhantomData;

use avr_device::interrupt;

use crate::slot::Slot;
use crate::timed::Timer;

/// The foreground's handle to a motor and its timer.
pub struct Guarded<M: 'static, T> {
    motor: &'static Slot<M>,
    timer: PhantomData<T>,
}

impl<M, T: Timer> Guarded<M, T> {
    /// Takes the motor, and starts the timer.
    ///
    /// # Safety
    /// To be called once for a motor, with interrupts off. `T` is the timer whose interrupt owns
    /// the motor.
    pub unsafe fn new(motor: &'static Slot<M>) -> Guarded<M, T> {
        let mut guarded = Guarded { motor, timer: PhantomData };
        guarded.with(|_, timer: &mut T| timer.start());
        guarded
    }

    /// Calls `look` with both while no interrupt comes.
    #[inline(always)]
    pub fn with<R>(&mut self, look: impl FnOnce(&mut M, &mut T) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: no interrupt comes.
            let (motor, mut timer) = unsafe { (self.motor.get(), T::steal()) };
            look(motor, &mut timer)
        })
    }
}
