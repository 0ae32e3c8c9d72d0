//! STEP and DIR, and the pins around the motors, all on port C.

use stepwright::drive::Axes;
use stepwright_controller::{AXES, Panel, PinPort, PortPins, Register, Turned};
use stepwright_device::Reset;

use crate::board::{DIR, EMERGENCY, ENABLE, FAULT, STEP, SWITCHES};
use crate::chip::register;
use crate::timer;

/// A register of port C.
const fn port(offset: usize) -> Register {
    register(0x400E_1200 + offset)
}

/// Gives pins to the program, not to a peripheral.
const PROGRAM: Register = port(0x00);
const OUTPUTS: Register = port(0x10);
const INPUTS: Register = port(0x14);
const SET: Register = port(0x30);
const CLEAR: Register = port(0x34);
const LEVELS: Register = port(0x3C);
const PULL_UP: Register = port(0x64);

/// The bits of all axes.
const ALL: u32 = (1 << AXES) - 1;

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
        PROGRAM.write(pins);
    }
}

/// STEP and DIR of all axes.
pub type StepPins = PortPins<Port>;

/// The pins around the motors, the reason of the last reset, and the watchdog.
pub struct BoardPins(());

/// The watchdog's registers: control, with a key, and mode.
const WATCHDOG: Register = register(0x400E_1A50);
const WATCHDOG_MODE: Register = register(0x400E_1A54);
/// The reset controller's status, with the reason.
const REASON: Register = register(0x400E_1A04);

impl BoardPins {
    /// Pulls the inputs up, leaves the drivers off, and sets the watchdog to reset the chip after
    /// 250 ms.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new() -> BoardPins {
        const PINS: u32 = ALL << SWITCHES | 1 << EMERGENCY | 1 << FAULT;
        PULL_UP.write(PINS);
        INPUTS.write(PINS);
        PROGRAM.write(PINS | 1 << ENABLE);
        SET.write(1 << ENABLE);
        OUTPUTS.write(1 << ENABLE);
        // In counts of 1/256 s. The mode can be set only once; the watchdog runs from power-up on.
        WATCHDOG_MODE.write(64 << 16 | 1 << 13 | 64);
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
        WATCHDOG.write(0xA5 << 24 | 1);
    }

    fn switches(&self) -> Axes {
        (LEVELS.read() >> SWITCHES & ALL) as Axes
    }

    fn emergency(&self) -> bool {
        LEVELS.read() >> EMERGENCY & 1 != 0
    }

    fn driver_fault(&self) -> bool {
        LEVELS.read() >> FAULT & 1 != 0
    }

    fn set_enable(&mut self, high: bool) {
        Port::set(1 << ENABLE, high);
    }

    fn reset(&mut self) -> Reset {
        match REASON.read() >> 8 & 7 {
            0 => Reset::Power,
            2 => Reset::Watchdog,
            _ => Reset::Other,
        }
    }

    fn set_reverse(&mut self, axes: Axes) {
        StepPins::reverse(axes);
    }
}
