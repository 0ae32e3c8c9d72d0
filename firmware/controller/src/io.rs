//! The board's side of its device.

use stepwright::drive::Axes;
use stepwright::{Rate, Ticks};
use stepwright_device::{BoardIo, Mark, Memory, Reset, ResetIo};

use crate::kept;

/// A chip's pins around the motors, and its clock. None of the methods may wait.
pub trait Panel {
    /// The counter of the step timer. Called in the main loop, with the step interrupt enabled.
    fn count(&mut self) -> u32;

    /// Feeds the watchdog.
    fn feed(&mut self) {}

    /// The levels of the switches' pins, with pull-ups: a set bit is a high level.
    fn switches(&self) -> Axes {
        Axes::MAX
    }

    /// The level of the emergency stop's pin, with a pull-up.
    fn emergency(&self) -> bool {
        true
    }

    /// The level of the pin with the drivers' fault outputs, with a pull-up.
    fn driver_fault(&self) -> bool {
        true
    }

    /// Sets the level of the pin that enables the drivers.
    fn set_enable(&mut self, high: bool);

    /// Whether the board has an output for a laser, in the program for streams.
    const LASER: bool = false;

    /// Sets the power of the laser: 0, off, to 255. Called when it changes; it is off at first.
    fn set_power(&mut self, power: u8) {
        let _ = power;
    }

    /// The reason of the last reset. Called once.
    fn reset(&mut self) -> Reset;

    /// Sets the axes that turn the other way round. Called while all rest, and the longest
    /// `hold-us` after the last step.
    fn set_reverse(&mut self, axes: Axes);
}

/// A [`Panel`] with the time in milliseconds, and with RAM that outlasts a reset for the settings.
pub struct PortIo<P> {
    panel: P,
    rate: Rate,
    /// The count at the beginning of the present millisecond.
    begun: u32,
    millis: u32,
    reversed: Axes,
}

impl<P: Panel> PortIo<P> {
    /// For a chip whose step timer counts at `rate`. The time starts now.
    pub fn new(mut panel: P, rate: Rate) -> PortIo<P> {
        let begun = panel.count();
        PortIo { panel, rate, begun, millis: 0, reversed: 0 }
    }
}

impl<P: Panel> Memory for PortIo<P> {
    fn read(&mut self, address: u16) -> u8 {
        kept::byte(address)
    }

    fn start_write(&mut self, address: u16, byte: u8) {
        kept::set_byte(address, byte);
    }

    fn is_writing(&self) -> bool {
        false
    }
}

impl<P: Panel> ResetIo for PortIo<P> {
    fn reset(&mut self) -> Reset {
        self.panel.reset()
    }

    fn mark(&self) -> Mark {
        kept::mark()
    }

    fn set_mark(&mut self, mark: Mark) {
        kept::set_mark(mark);
    }
}

impl<P: Panel> BoardIo for PortIo<P> {
    #[inline(always)]
    fn tick(&mut self) {
        self.panel.feed();
        let milli = self.rate.micros(1_000);
        let count = self.panel.count();
        // A round takes less than half a turn of the counter.
        while count.wrapping_sub(self.begun) >= milli {
            self.begun = self.begun.wrapping_add(milli);
            self.millis = self.millis.wrapping_add(1);
        }
    }

    fn millis(&self) -> u32 {
        self.millis
    }

    fn ticks(&self, micros: u16) -> Ticks {
        self.rate.micros(micros.into())
    }

    fn switches(&self) -> Axes {
        self.panel.switches()
    }

    fn emergency(&self) -> bool {
        self.panel.emergency()
    }

    fn driver_fault(&self) -> bool {
        self.panel.driver_fault()
    }

    fn set_enable(&mut self, high: bool) {
        self.panel.set_enable(high);
    }

    fn set_reverse(&mut self, axes: Axes) {
        if self.reversed == axes {
            return;
        }
        self.reversed = axes;
        // Waits for the longest `hold-us`, 1 ms, because the last step may have been just now.
        let begun = self.panel.count();
        while self.panel.count().wrapping_sub(begun) < self.rate.micros(1_000) {}
        self.panel.set_reverse(axes);
    }
}
