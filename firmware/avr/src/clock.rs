//! Milliseconds, without an interrupt.
//!
//! Timer 2 counts in 64 µs and wraps after 16.4 ms. The main loop asks more
//! often than that, so that no wrap is missed.

use core::hint::black_box;

use crate::chip::TC2;

/// Counts milliseconds.
pub struct Clock {
    registers: TC2,
    /// The counter when it was last read.
    seen: u8,
    /// Time since the last whole millisecond, in 8 µs: 125 make one.
    part: u16,
}

impl Clock {
    /// Lets timer 2 run.
    pub fn start(registers: TC2) -> Clock {
        registers.tccr2b().write(|w| w.cs2().prescale_1024());
        Clock { registers, seen: 0, part: 0 }
    }

    /// Whole milliseconds since the last call, 0 to 17. To be called at least
    /// every 16 ms.
    pub fn passed(&mut self) -> u8 {
        let now = self.registers.tcnt2().read().bits();
        self.part += 8 * u16::from(now.wrapping_sub(self.seen));
        self.seen = now;
        let mut passed = 0;
        // Opaque, or the compiler makes a division of this loop, which goes round
        // once at most but after a long delay.
        while black_box(self.part) >= 125 {
            self.part -= 125;
            passed += 1;
        }
        passed
    }
}
