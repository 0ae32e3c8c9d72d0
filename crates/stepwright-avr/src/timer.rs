//! The step timer: a free-running 16-bit counter at 16 MHz.
//!
//! Timer 1; on the Mega timer 3, 4 or 5 instead, if a feature selects it. They differ only in their
//! names. The counter is never stopped or set, and its compare register holds an absolute time, so
//! no tick is lost.
//!
//! A 16-bit register is read in two halves through a byte that all registers of the timer share.
//! The foreground therefore accesses the timer only while the step interrupt is held off
//! (`cycle.rs`).

use stepwright::timer::{Count, StepTimer};

/// The step timer's registers have the timer's number in their names.
macro_rules! timer {
    (
        $tc:ident, $count:ident, $compare:ident, $mode:ident, $prescaler:ident, $select:ident,
        $mask:ident, $enable:ident, $flags:ident, $matched:ident
    ) => {
        use crate::chip::$tc as Registers;

        impl Timer {
            /// Starts the counter, and enables the interrupt of its compare register. The timer's
            /// pins stay ordinary pins.
            ///
            /// # Safety
            /// To be called once.
            pub unsafe fn start() -> Timer {
                // SAFETY: the caller's promise.
                let registers = unsafe { Registers::steal() };
                registers.$mode().reset();
                registers.$prescaler().write(|w| w.$select().direct());
                registers.$mask().write(|w| w.$enable().set_bit());
                Timer(registers)
            }

            /// Enables its interrupt, or holds it off. A match that occurs meanwhile interrupts
            /// afterwards.
            pub fn enable(on: bool) {
                // SAFETY: nothing else uses the register, and this is its only bit in use.
                let registers = unsafe { Registers::steal() };
                registers.$mask().write(|w| w.$enable().bit(on));
            }
        }

        impl StepTimer for Timer {
            type Count = u16;

            const LINGER: u32 = LINGER;
            /// A step takes longer than a driver's pulse.
            const SPIN: u32 = u32::MAX;

            #[inline(always)]
            fn now(&mut self) -> u16 {
                self.0.$count().read().bits()
            }

            /// A program can't set the interrupt flag, so a time that has passed becomes one some
            /// ticks from now.
            fn wake_at(&mut self, mut at: u16) {
                loop {
                    self.set_compare(at);
                    let now = self.now();
                    if at.is_after(now) {
                        return;
                    }
                    at = now.plus(LINGER + 1);
                }
            }

            #[inline(always)]
            fn set_compare(&mut self, at: u16) {
                self.0.$compare().write(|w| w.set(at));
                // Discards a match of the previous time. A match of this time may be lost with it.
                self.0.$flags().write(|w| w.$matched().set_bit());
            }
        }
    };
}

/// The approximate cycles for leaving the interrupt and entering it again.
const LINGER: u32 = 64;

/// The step timer. There is only one.
pub struct Timer(Registers);

#[cfg(not(any(feature = "timer3", feature = "timer4", feature = "timer5")))]
timer!(TC1, tcnt1, ocr1a, tccr1a, tccr1b, cs1, timsk1, ocie1a, tifr1, ocf1a);
#[cfg(feature = "timer3")]
timer!(TC3, tcnt3, ocr3a, tccr3a, tccr3b, cs3, timsk3, ocie3a, tifr3, ocf3a);
#[cfg(feature = "timer4")]
timer!(TC4, tcnt4, ocr4a, tccr4a, tccr4b, cs4, timsk4, ocie4a, tifr4, ocf4a);
#[cfg(feature = "timer5")]
timer!(TC5, tcnt5, ocr5a, tccr5a, tccr5b, cs5, timsk5, ocie5a, tifr5, ocf5a);
