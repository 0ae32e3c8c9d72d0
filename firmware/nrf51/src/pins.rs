//! STEP and DIR, and the pins around the motors.

use stepwright::drive::{Axes, Drive};
use stepwright_controller::{AXES, Panel, Register, Turned};
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

/// How a pin is configured: an input with a pull-up.
const PULLED_UP: u32 = 3 << 2;

static TURNED: Turned = Turned::new();

/// Sets DIR of an axis.
#[inline(always)]
fn set_dir(axis: u8, high: bool) {
    // Of an axis that there is not, a pin beyond the last.
    let bit = 1u32.wrapping_shl(DIR + u32::from(axis));
    if high { SET.write(bit) } else { CLEAR.write(bit) }
}

/// STEP and DIR of all axes.
pub struct StepPins(());

impl StepPins {
    /// Makes them outputs, low.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new() -> StepPins {
        let all = ((1 << AXES) - 1) << STEP | ((1 << AXES) - 1) << DIR;
        CLEAR.write(all);
        OUTPUTS.write(all);
        StepPins(())
    }
}

impl Drive for StepPins {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        SET.write(u32::from(axes) << STEP);
    }

    #[inline(always)]
    fn end(&mut self, axes: Axes) {
        CLEAR.write(u32::from(axes) << STEP);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        set_dir(axis, TURNED.direction(axis, forward));
    }
}

/// The pins around the motors, why the board has begun, and its watchdog.
pub struct BoardPins(());

/// POWER's reasons of the last reset: written ones are cleared.
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
        if high { SET.write(1 << ENABLE) } else { CLEAR.write(1 << ENABLE) }
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
        let levels = TURNED.reverse(axes);
        for axis in 0..AXES as u8 {
            set_dir(axis, levels >> axis & 1 != 0);
        }
    }
}
