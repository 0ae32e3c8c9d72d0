//! What a board lends its device: a few pins, the time, some bytes.

use stepwright::Ticks;
use stepwright::drive::Axes;

use crate::reset::{Mark, Reset};

/// Bytes that outlast a loss of power: an EEPROM.
///
/// A byte whose writing is cut off by a loss of power may hold anything
/// afterwards; an implementation MUST leave all others alone.
pub trait Memory {
    /// The byte at this address. Asked only while no byte is being written.
    fn read(&mut self, address: u16) -> u8;

    /// Begins to write a byte, and does not wait for its end (3.4 ms on an
    /// AVR). Called only while no other is being written.
    fn start_write(&mut self, address: u16, byte: u8);

    /// Whether a byte is being written.
    fn is_writing(&self) -> bool;
}

/// The pins around the motors, and the time.
///
/// In a set of axes, bit 0 is the first. All methods are called from the
/// foreground, and none may wait.
pub trait BoardIo: Memory {
    /// A round of the main loop begins: the time to look at a clock, and to tell a watchdog
    /// that all is well.
    fn tick(&mut self) {}

    /// Milliseconds since some moment; it wraps after 2³².
    fn millis(&self) -> u32;

    /// This many microseconds (at most 1000) in ticks of the step timer, rounded
    /// up. The panel's, for on a chip it is a product with a constant.
    fn ticks(&self, micros: u16) -> Ticks;

    /// The levels of the switches' pins: a set bit is a high one. The pin of
    /// an axis that has no switch may read anything.
    fn switches(&self) -> Axes;

    /// The level of the emergency stop's pin: true is high, as with nothing connected and a
    /// pull-up.
    fn emergency(&self) -> bool {
        true
    }

    /// The level of the pin to which the fault outputs of the drivers lead, likewise.
    fn driver_fault(&self) -> bool {
        true
    }

    /// Sets the level of the pin that enables the drivers.
    fn set_enable(&mut self, high: bool);

    /// Why the board has begun. Asked once.
    fn reset(&mut self) -> Reset;

    /// The mark that was set last, also before a reset; anything when RAM has lost
    /// it, as it does without power.
    fn mark(&self) -> Mark;

    /// Sets the mark. A reset MUST find the old one or this one, or none.
    fn set_mark(&mut self, mark: Mark);

    /// These axes turn the other way round from now on: forward is a low DIR.
    /// It MUST set the DIR pins again as well. Called only while all axes rest, perhaps since
    /// this moment: where a pin changes it MUST wait for 1 ms before, the longest `hold-us`.
    fn set_reverse(&mut self, axes: Axes);
}
