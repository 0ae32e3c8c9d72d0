//! STEP and DIR, and the pins around the motors.

use stepwright::drive::Axes;
use stepwright_controller::{AXES, Panel, PinPort, PortPins, Register, StampPort, Stamps, Turned};
use stepwright_device::Reset;

use crate::board::{DIR, EMERGENCY, ENABLE, FAULT, STEP, SWITCHES};
use crate::timer;

/// A register of the port.
const fn port(offset: usize) -> Register {
    // SAFETY: the manual's table of GPIO.
    unsafe { Register::at(0x5000_0000 + offset) }
}

const SET: Register = port(0x508);
const CLEAR: Register = port(0x50C);
const IN: Register = port(0x510);
const OUTPUTS: Register = port(0x518);

/// The configuration of a pin as an input with a pull-up.
const PULLED_UP: u32 = 3 << 2;

/// The port with STEP and DIR.
pub struct Port;

impl PinPort for Port {
    const STEP: u32 = STEP;
    const DIR: u32 = DIR;

    #[inline(always)]
    fn set(bits: u32, high: bool) {
        if high { SET.write(bits) } else { CLEAR.write(bits) }
    }

    #[inline(always)]
    fn turned() -> &'static Turned {
        static TURNED: Turned = Turned::new();
        &TURNED
    }

    #[inline(always)]
    fn start(pins: u32) {
        CLEAR.write(pins);
        OUTPUTS.write(pins);
    }
}

impl StampPort for Port {
    #[inline(always)]
    fn count() -> u32 {
        timer::captured()
    }

    #[inline(always)]
    fn is_high(bit: u32) -> bool {
        IN.read() & bit != 0
    }

    fn stamps() -> &'static Stamps {
        static STAMPS: Stamps = Stamps::new();
        &STAMPS
    }
}

/// Allows the levels of all STEP pins to be read while they are outputs.
pub fn read_back() {
    for axis in 0..AXES as u32 {
        // An output with its input buffer connected.
        port(0x700 + 4 * (STEP + axis) as usize).write(1);
    }
}

/// STEP and DIR of all axes.
pub type StepPins = PortPins<Port>;

/// The pins around the motors, the reason of the last reset, and the watchdog.
pub struct BoardPins(());

/// POWER's reasons of the last reset: writing a 1 clears it.
// SAFETY: the manual's table of POWER.
const REASONS: Register = unsafe { Register::at(0x4000_0400) };

/// A register of the watchdog.
const fn watchdog(offset: usize) -> Register {
    // SAFETY: the manual's table of WDT.
    unsafe { Register::at(0x4001_0000 + offset) }
}

impl BoardPins {
    /// Pulls the inputs up, leaves the drivers off, and starts the watchdog: 250 ms.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new() -> BoardPins {
        for pin in SWITCHES.into_iter().chain([EMERGENCY, FAULT]) {
            port(0x700 + 4 * pin as usize).write(PULLED_UP);
        }
        SET.write(1 << ENABLE);
        OUTPUTS.write(1 << ENABLE);
        watchdog(0x504).write(8_192);
        watchdog(0x000).write(1);
        BoardPins(())
    }
}

impl Panel for BoardPins {
    #[inline(always)]
    fn count(&mut self) -> u32 {
        timer::count()
    }

    #[inline(always)]
    fn feed(&mut self) {
        watchdog(0x600).write(0x6E52_4635);
    }

    fn switches(&self) -> Axes {
        let levels = IN.read();
        let levels = SWITCHES.into_iter().rev().map(|pin| levels >> pin & 1);
        levels.fold(0, |axes, level| axes << 1 | level as Axes)
    }

    fn emergency(&self) -> bool {
        IN.read() >> EMERGENCY & 1 != 0
    }

    fn driver_fault(&self) -> bool {
        IN.read() >> FAULT & 1 != 0
    }

    fn set_enable(&mut self, high: bool) {
        Port::set(1 << ENABLE, high);
    }

    fn reset(&mut self) -> Reset {
        let reasons = REASONS.read();
        REASONS.write(reasons);
        match reasons {
            0 => Reset::Power,
            _ if reasons >> 1 & 1 != 0 => Reset::Watchdog,
            _ => Reset::Other,
        }
    }

    fn set_reverse(&mut self, axes: Axes) {
        StepPins::reverse(axes);
    }
}
