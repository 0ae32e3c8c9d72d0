//! The pins around the motors, the reason of the last reset, and the watchdog.

use stepwright::Rate;
use stepwright::drive::Axes;
use stepwright_controller::{AXES, Panel};
use stepwright_device::Reset;

use crate::board::{DIR, EMERGENCY, ENABLE, FAULT, SWITCHES};
use crate::chip::{self, Function};

/// The pins around the motors.
pub struct BoardPins {
    /// The ticks of the step timer in 64 µs.
    ticks: u32,
}

impl BoardPins {
    /// Pulls the inputs up, leaves the drivers off, and starts the watchdog: 250 ms. `rate` is the
    /// rate of [`count`](Panel::count), a whole number of ticks in 64 µs.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new(rate: Rate) -> BoardPins {
        for pin in SWITCHES.into_iter().chain([EMERGENCY, FAULT]) {
            chip::pull_up(pin, true);
            chip::give(pin, Function::Program, false);
        }
        chip::set_level(ENABLE, true);
        chip::make_output(ENABLE);
        chip::give(ENABLE, Function::Program, false);
        chip::start_watchdog();
        BoardPins { ticks: rate.micros(64) }
    }
}

/// The level of a pin.
fn level(pin: u32) -> bool {
    chip::levels() >> pin & 1 != 0
}

impl Panel for BoardPins {
    #[inline(always)]
    fn count(&mut self) -> u32 {
        // Modulo 2^32.
        (chip::micros().wrapping_mul(self.ticks.into()) >> 6) as u32
    }

    #[inline(always)]
    fn feed(&mut self) {
        chip::feed();
    }

    fn switches(&self) -> Axes {
        SWITCHES.into_iter().rev().fold(0, |axes, pin| axes << 1 | Axes::from(level(pin)))
    }

    fn emergency(&self) -> bool {
        level(EMERGENCY)
    }

    fn driver_fault(&self) -> bool {
        level(FAULT)
    }

    fn set_enable(&mut self, high: bool) {
        chip::set_level(ENABLE, high);
    }

    const LASER: bool = true;

    fn set_power(&mut self, power: u8) {
        chip::set_duty(power);
    }

    fn reset(&mut self) -> Reset {
        chip::reset()
    }

    fn set_reverse(&mut self, axes: Axes) {
        for axis in 0..AXES as u32 {
            chip::give(DIR + axis, Function::Pio, axes >> axis & 1 != 0);
        }
    }
}
