//! The board's side of a device: a few pins, the time, some bytes.

use stepwright::Ticks;
use stepwright::drive::Axes;

use crate::reset::ResetIo;

/// Bytes that outlast a loss of power: an EEPROM.
///
/// A byte whose writing is cut off by a loss of power may hold anything afterwards; an
/// implementation MUST NOT affect any other byte.
pub trait Memory {
    /// The byte at this address. Called only while no byte is being written.
    fn read(&mut self, address: u16) -> u8;

    /// Begins to write a byte, and does not wait for the end (3.4 ms on an AVR). Called only while
    /// no other byte is being written.
    fn start_write(&mut self, address: u16, byte: u8);

    /// Whether a byte is being written.
    fn is_writing(&self) -> bool;
}

/// The pins around the motors, and the time.
///
/// In a set of axes, bit 0 is the first axis. All methods are called from the foreground, and none
/// may wait.
pub trait BoardIo: Memory + ResetIo {
    /// Called at the beginning of each round of the main loop: the place to read a clock and to
    /// feed a watchdog.
    fn tick(&mut self) {}

    /// The time in milliseconds since an arbitrary moment; it wraps after 2³².
    fn millis(&self) -> u32;

    /// Converts microseconds (at most 1000) to ticks of the step timer, rounded up. The panel does
    /// this because on a chip it is a product with a constant.
    fn ticks(&self, micros: u16) -> Ticks;

    /// The levels of the switches' pins: a set bit is a high level. The bit of an axis without a
    /// switch may be anything.
    fn switches(&self) -> Axes;

    /// The level of the emergency stop's pin: true is high, as with nothing connected and a
    /// pull-up.
    fn emergency(&self) -> bool {
        true
    }

    /// The level of the pin with the drivers' fault outputs, in the same way.
    fn driver_fault(&self) -> bool {
        true
    }

    /// Sets the level of the pin that enables the drivers.
    fn set_enable(&mut self, high: bool);

    /// Sets the axes that turn the other way round: their forward is a low DIR. It MUST also set
    /// the DIR pins. Called only while all axes rest, perhaps since this moment: before it changes
    /// a pin it MUST wait for 1 ms, the longest `hold-us`.
    fn set_reverse(&mut self, axes: Axes);
}
