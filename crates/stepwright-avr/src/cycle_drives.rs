//! Motor cycles on any drives: a `Cycle` in which each motor has its own drive.
//!
//! Like `cycle.rs`, without switches, ENABLE and the serial line. One line makes the motors from
//! their drives: [`cycle_motors!`](crate::cycle_motors).

use avr_device::interrupt;
use stepwright_cycle::{Clock, Cycle, Motor};

use crate::asked::Output;
use crate::board;
use crate::drives::Several;
use crate::slot::{Slot, token};
use crate::timer::Timer;

/// The cycles allowed for a step, and the least cycles between two steps of a motor: those of
/// [`cycle`](crate::cycle), and the time for a table of windings.
const COST: u16 = 2_000;

/// N motors, each on a drive.
pub type DrivenMotors<D, const N: usize> = Cycle<'static, Timer, Several<D, N>, (), N>;

/// Motors without drives, for a static: an Uno has no room for a temporary second `Cycle`.
#[doc(hidden)]
pub const fn none<D: Output, const N: usize>() -> DrivenMotors<D, N> {
    // SAFETY: it takes no memory, and it is not used before `take`, whose caller has the right to
    // it.
    let timer = unsafe { token() };
    let (motors, board) = ([Motor::new(1, 1); N], board::any_cycle(COST, COST as u32));
    Cycle::off(timer, Several::none(), (), motors, Clock::Deadlines, board)
}

/// Puts the motors on their drives, with the currents on.
///
/// # Safety
/// To be called once, with interrupts off; `store` belongs to timer 1's interrupt.
#[doc(hidden)]
pub unsafe fn take<D: Output, const N: usize>(
    store: &'static Slot<DrivenMotors<D, N>>,
    motors: [Motor; N],
    drives: [D; N],
) -> CycleMotors<D, N> {
    // SAFETY: called once.
    let _ = unsafe { Timer::start() };
    // SAFETY: interrupts are off.
    let cycle = unsafe { store.get() };
    for (motor, drive) in (0u8..).zip(drives) {
        cycle.drive().wire(motor, drive);
    }
    cycle.begin();
    for (motor, settings) in (0u8..).zip(motors) {
        // No cycle runs yet, and there are as many motors.
        let _ = cycle.set_motor(motor, settings);
    }
    CycleMotors(store)
}

/// The foreground's handle to the motors: each call holds off the step interrupt.
pub struct CycleMotors<D: 'static, const N: usize>(&'static Slot<DrivenMotors<D, N>>);

impl<D, const N: usize> CycleMotors<D, N> {
    /// Calls `ask` with the [`Cycle`].
    #[inline(always)]
    pub fn with<R>(&mut self, ask: impl FnOnce(&mut DrivenMotors<D, N>) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: no interrupt comes.
            ask(unsafe { self.0.get() })
        })
    }
}

/// Makes a module for motors of a cycle on timer 1, with a function that takes them, from a name, a
/// number of motors, and a drive.
#[macro_export]
macro_rules! cycle_motors {
    ($(#[$doc:meta])* mod $name:ident, $many:literal, $drive:ty) => {
        $(#[$doc])*
        mod $name {
            use super::*;
            use $crate::cycle_drives::{self, CycleMotors, DrivenMotors};
            use $crate::slot::Slot;

            static STORE: Slot<DrivenMotors<$drive, $many>> = Slot::new(cycle_drives::none());

            $crate::handler!(TIMER1_COMPA, TIMER1_COMPA, {
                // SAFETY: this is the interrupt that owns them; it comes once they are taken.
                unsafe { STORE.get().on_compare() }
            });

            /// Takes the motors, on these drives.
            ///
            /// # Safety
            /// To be called once, with interrupts off.
            pub unsafe fn take(
                motors: [stepwright_cycle::Motor; $many],
                drives: [$drive; $many],
            ) -> CycleMotors<$drive, $many> {
                // SAFETY: the caller's promise.
                unsafe { cycle_drives::take(&STORE, motors, drives) }
            }
        }
    };
}
