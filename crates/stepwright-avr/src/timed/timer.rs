//! A timer's counter and compare register A, running freely at the I/O clock.

use crate::chip;

/// A timer of 16 bits.
pub trait Timer {
    /// The bit of its motor among those on motor shields, which share their enables.
    const SHIELD: u8;
    /// Its registers.
    ///
    /// # Safety
    /// For the interrupt that owns them, or while it can't come.
    unsafe fn steal() -> Self;
    /// Starts the counter.
    fn start(&mut self);
    /// The counter.
    fn now(&mut self) -> u16;
    /// Sets the compare register.
    fn wake_at(&mut self, at: u16);
    /// Clears the match flag.
    fn clear(&mut self);
    /// Enables or disables the interrupt of a match.
    fn enable(&mut self, on: bool);
}

macro_rules! timer {
    (
        $name:ident, $shield:literal, $tc:ident, $count:ident, $compare:ident, $prescaler:ident, $select:ident,
        $mask:ident, $enable:ident, $flags:ident, $flag:ident
    ) => {
        /// A timer.
        pub struct $name(chip::$tc);

        impl Timer for $name {
            const SHIELD: u8 = $shield;
            #[inline(always)]
            unsafe fn steal() -> $name {
                // SAFETY: the caller's promise.
                $name(unsafe { chip::$tc::steal() })
            }
            fn start(&mut self) {
                self.0.$prescaler().write(|w| w.$select().direct());
            }
            #[inline(always)]
            fn now(&mut self) -> u16 {
                self.0.$count().read().bits()
            }
            #[inline(always)]
            fn wake_at(&mut self, at: u16) {
                self.0.$compare().write(|w| w.set(at));
            }
            #[inline(always)]
            fn clear(&mut self) {
                self.0.$flags().write(|w| w.$flag().set_bit());
            }
            #[inline(always)]
            fn enable(&mut self, on: bool) {
                self.0.$mask().write(|w| w.$enable().bit(on));
            }
        }
    };
}

timer!(Timer1, 1, TC1, tcnt1, ocr1a, tccr1b, cs1, timsk1, ocie1a, tifr1, ocf1a);
#[cfg(feature = "mega")]
timer!(Timer3, 2, TC3, tcnt3, ocr3a, tccr3b, cs3, timsk3, ocie3a, tifr3, ocf3a);
#[cfg(feature = "mega")]
timer!(Timer4, 4, TC4, tcnt4, ocr4a, tccr4b, cs4, timsk4, ocie4a, tifr4, ocf4a);
#[cfg(feature = "mega")]
timer!(Timer5, 8, TC5, tcnt5, ocr5a, tccr5b, cs5, timsk5, ocie5a, tifr5, ocf5a);
