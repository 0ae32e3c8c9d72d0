//! Milliseconds, without an interrupt.
//!
//! Timer 0 counts every 64 µs and wraps after 16.4 ms. The main loop reads it more often than that,
//! so it misses no wrap.

use crate::chip::TC0;

/// Counts milliseconds.
pub struct Clock {
    registers: TC0,
    /// The counter when it was last read.
    seen: u8,
    /// The time since the last whole millisecond, in units of 8 µs: 125 make one.
    part: u16,
}

impl Clock {
    /// A clock that is not running, for a static.
    ///
    /// # Safety
    /// It must not be read.
    #[cfg(feature = "stream")]
    pub(crate) const unsafe fn blank() -> Clock {
        // SAFETY: the caller's promise.
        Clock { registers: unsafe { crate::slot::token() }, seen: 0, part: 0 }
    }

    /// Starts timer 0.
    pub fn start(registers: TC0) -> Clock {
        registers.tccr0b().write(|w| w.cs0().prescale_1024());
        Clock { registers, seen: 0, part: 0 }
    }

    /// Whether another millisecond has passed. It reports one at a time. Call it at least every 16
    /// ms, and on average more often than once a millisecond.
    pub fn ticked(&mut self) -> bool {
        let now = self.registers.tcnt0().read().bits();
        self.part = self.part.wrapping_add(8 * u16::from(now.wrapping_sub(self.seen)));
        self.seen = now;
        let ticked = self.part >= 125;
        if ticked {
            self.part = self.part.wrapping_sub(125);
        }
        ticked
    }
}

/// The milliseconds since the start.
pub struct Millis {
    clock: Clock,
    millis: u32,
}

impl Millis {
    /// Starts timer 0, at 0 ms.
    pub fn start(registers: TC0) -> Millis {
        Millis { clock: Clock::start(registers), millis: 0 }
    }

    /// The milliseconds. Call it at least every 16 ms.
    pub fn get(&mut self) -> u32 {
        // `ticked` reports one at a time, and several may have passed.
        while self.clock.ticked() {
            self.millis = self.millis.wrapping_add(1);
        }
        self.millis
    }

    /// Waits until the milliseconds reach `millis`.
    pub fn wait_until(&mut self, millis: u32) {
        while (self.get().wrapping_sub(millis) as i32) < 0 {}
    }
}
