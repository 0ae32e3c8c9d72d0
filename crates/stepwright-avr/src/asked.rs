//! Any law on any drive: the step interrupt makes the step, then computes the delay to the next
//! step by the law.
//!
//! ```text
//!   law: an iterator of delays ──► interrupt of a 16-bit timer ──► Output: step and direction,
//!   (1 µs each; 0 is left out)     deadlines, freely running        or windings with any table
//! ```
//!
//! For laws that are fast enough for the interrupt: the published listing takes about 1,000 cycles
//! a step, 2,600 at most; its form with the remainder carried takes 700. Slower laws are computed
//! ahead, in the main loop: `law.rs`. One line makes a motor from a timer, a law and a drive:
//! [`asked_motor!`](crate::asked_motor).

use stepwright::drive::{Coils, Drive, Port, PortDrive};

use crate::guarded::Guarded;
use crate::laps::Laps;
use crate::slot::Slot;
use crate::timed::Timer;

/// A drive with a switchable current.
pub trait Output: Drive {
    /// Switches the current on, at the motor's present phase.
    fn on(&mut self) {}
    /// Switches the current off.
    fn off(&mut self) {}
}

impl<P: Port> Output for PortDrive<P> {}

impl<P: Port> Output for Coils<P> {
    fn on(&mut self) {
        Coils::on(self);
    }
    fn off(&mut self) {
        Coils::off(self);
    }
}

/// Clocks of the timer per tick of the law, 1 µs.
const TICK: u32 = 16;
/// A longer delay lasts as long as this: 268 s.
const LONGEST: u32 = u32::MAX / TICK;
/// Clocks from the order to the first step: set-up time of DIR, and time for the current to rise.
const LEAD: u32 = 16_000;
/// Cycles for which STEP is high, in addition to the calls: 2 µs.
const PULSE: u32 = 32;
/// A motor, owned by the step interrupt.
pub struct Motor<L, O> {
    law: Option<L>,
    output: Option<O>,
    laps: Laps,
    /// The law's first delay, until it has passed; 0 if there is none.
    first: u32,
    /// The last interval.
    last: u32,
    /// The next event switches the current off.
    resting: bool,
}

impl<L: Iterator<Item = u32>, O: Output> Motor<L, O> {
    /// A motor at rest, without a drive.
    pub const fn new() -> Motor<L, O> {
        Motor { law: None, output: None, laps: Laps::new(), first: 0, last: LEAD, resting: false }
    }

    fn begin(&mut self, timer: &mut impl Timer, law: L, first: u32, forward: bool) {
        let Some(output) = &mut self.output else { return };
        output.direction(0, forward);
        output.on();
        (self.law, self.first) = (Some(law), first);
        (self.last, self.resting) = (LEAD, false);
        self.laps.begin(timer, LEAD);
    }

    /// The step interrupt.
    #[inline(always)]
    pub fn on_compare(&mut self, timer: &mut impl Timer) {
        loop {
            if self.laps.is_due() {
                let Some(next) = self.event() else { return timer.enable(false) };
                self.laps.next(next);
            }
            if self.laps.wait(timer) {
                return;
            }
        }
    }

    /// Makes the step that is due. Returns the clocks from there to the next event.
    #[inline(always)]
    fn event(&mut self) -> Option<u32> {
        let output = self.output.as_mut()?;
        if self.resting {
            output.off();
            self.law = None;
            return None;
        }
        output.begin(1);
        avr_device::asm::delay_cycles(PULSE);
        output.end(1);
        let delay = match core::mem::take(&mut self.first) {
            0 => self.law.as_mut()?.find(|delay| *delay != 0),
            first => Some(first),
        };
        match delay {
            Some(delay) => self.last = delay.min(LONGEST).wrapping_mul(TICK),
            // The rotor gets the same time to settle.
            None => self.resting = true,
        }
        Some(self.last)
    }
}

impl<L: Iterator<Item = u32>, O: Output> Default for Motor<L, O> {
    fn default() -> Self {
        Motor::new()
    }
}

/// The foreground's handle to a motor and its timer.
pub struct AvrEngine<L: 'static, O: 'static, T>(Guarded<Motor<L, O>, T>);

impl<L: Iterator<Item = u32>, O: Output, T: Timer> AvrEngine<L, O, T> {
    /// Starts the timer.
    ///
    /// # Safety
    /// See [`Guarded::new`].
    pub unsafe fn new(motor: &'static Slot<Motor<L, O>>) -> AvrEngine<L, O, T> {
        // SAFETY: the caller's promise.
        AvrEngine(unsafe { Guarded::new(motor) })
    }

    /// Puts the motor on this drive. The motor must rest.
    pub fn wire(&mut self, output: O) {
        self.0.with(|motor, _| {
            let output = motor.output.insert(output);
            output.off();
        });
    }

    /// Moves the motor by the delays of a law, in µs; without delays it does not move. A delay of more than
    /// 268 s (2²⁸ µs) lasts for 268 s.
    pub fn play(&mut self, mut law: L, forward: bool) {
        let Some(first) = law.next() else { return };
        self.0.with(|motor, timer| motor.begin(timer, law, first, forward));
    }

    /// Whether the motor moves.
    pub fn is_moving(&mut self) -> bool {
        self.0.with(|motor, _| motor.law.is_some())
    }
}

/// Makes a module for a motor, with a function that takes it, from a name, a law, a drive, a timer
/// and its vector.
#[macro_export]
macro_rules! asked_motor {
    ($(#[$doc:meta])* mod $name:ident, $law:ty, $drive:ty, $timer:ident, $vector:ident) => {
        $(#[$doc])*
        mod $name {
            use super::*;
            use $crate::asked::{AvrEngine, Motor};
            use $crate::slot::Slot;
            use $crate::timed::{Timer as _, $timer};

            static MOTOR: Slot<Motor<$law, $drive>> = Slot::new(Motor::new());

            $crate::handler!($vector, $vector, {
                // SAFETY: this is the interrupt that owns them; it runs with interrupts off.
                unsafe { MOTOR.get().on_compare(&mut $timer::steal()) };
            });

            /// Takes the motor.
            ///
            /// # Safety
            /// To be called once, with interrupts off.
            pub unsafe fn take() -> AvrEngine<$law, $drive, $timer> {
                // SAFETY: the caller's promise; it is this timer's interrupt.
                unsafe { AvrEngine::new(&MOTOR) }
            }
        }
    };
}
