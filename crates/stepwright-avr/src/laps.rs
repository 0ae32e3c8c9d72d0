//! A time any number of clocks ahead, on a counter of 16 bits: what is far takes laps.

use crate::timed::Timer;

/// Longer than half the counter a time can't be told from the past: it takes laps.
const FAR: u32 = 0x8000;
const LAP: u16 = 0x4000;

/// When the next event is.
pub struct Laps {
    /// What the compare register holds.
    deadline: u16,
    /// Clocks from there to the event.
    left: u32,
}

impl Laps {
    /// Before the first event.
    pub const fn new() -> Laps {
        Laps { deadline: 0, left: 0 }
    }

    /// The first event is this many clocks from now; its interrupt may come.
    pub fn begin(&mut self, timer: &mut impl Timer, clocks: u32) {
        self.left = clocks;
        self.deadline = timer.now();
        self.aim(timer);
        timer.clear();
        timer.enable(true);
    }

    /// Whether the event is due, and not a lap.
    #[inline(always)]
    pub fn is_due(&self) -> bool {
        self.left == 0
    }

    /// The next event is this many clocks after the one that is due.
    #[inline(always)]
    pub fn next(&mut self, clocks: u32) {
        self.left = clocks;
    }

    /// Sets the compare register: a lap, or the rest. True if that is ahead; otherwise it has
    /// passed, its interrupt is none to wait for, and what is due is done at once.
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
