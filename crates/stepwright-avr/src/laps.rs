//! A time any number of clocks ahead, on a counter of 16 bits. Far times take several laps.

use crate::timed::Timer;

/// From half the counter on, a future time can't be told from the past: it takes laps.
const FAR: u32 = 0x8000;
const LAP: u16 = 0x4000;

/// The time of the next event.
pub struct Laps {
    /// The value of the compare register.
    deadline: u16,
    /// Clocks from there to the event.
    left: u32,
}

impl Laps {
    /// Before the first event.
    pub const fn new() -> Laps {
        Laps { deadline: 0, left: 0 }
    }

    /// Sets the first event this many clocks from now, and enables its interrupt.
    pub fn begin(&mut self, timer: &mut impl Timer, clocks: u32) {
        self.left = clocks;
        self.deadline = timer.now();
        self.aim(timer);
        timer.clear();
        timer.enable(true);
    }

    /// Whether the event is due, and not only a lap.
    #[inline(always)]
    pub fn is_due(&self) -> bool {
        self.left == 0
    }

    /// Sets the next event this many clocks after the one that is due.
    #[inline(always)]
    pub fn next(&mut self, clocks: u32) {
        self.left = clocks;
    }

    /// Sets the compare register to the end of a lap, or to the event. True if that time is ahead.
    /// Otherwise it has passed: its interrupt is cleared, and the caller continues at once.
    #[inline(always)]
    pub fn wait(&mut self, timer: &mut impl Timer) -> bool {
        self.aim(timer);
        if (self.deadline.wrapping_sub(timer.now()) as i16) > 0 {
            return true;
        }
        timer.clear();
        false
    }

    #[inline(always)]
    fn aim(&mut self, timer: &mut impl Timer) {
        let lap = if self.left >= FAR { LAP } else { self.left as u16 };
        self.left = self.left.wrapping_sub(lap.into());
        self.deadline = self.deadline.wrapping_add(lap);
        timer.wake_at(self.deadline);
    }
}

impl Default for Laps {
    fn default() -> Self {
        Laps::new()
    }
}
