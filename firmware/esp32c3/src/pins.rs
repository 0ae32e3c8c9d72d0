//! STEP and DIR, and the pins around the motors.

use esp_hal::gpio::{Input, InputConfig, InputPin, Level, Output, OutputConfig, OutputPin, Pull};
use esp_hal::peripherals::GPIO;
use stepwright::drive::Axes;
use stepwright_controller::{Panel, PinPort, PortPins, Turned};
use stepwright_device::Reset;

use crate::board::{DIR, ENABLE, STEP};
use crate::timer;

/// Makes a pin an output permanently.
pub fn output(pin: impl OutputPin + 'static, level: Level) {
    core::mem::forget(Output::new(pin, level, OutputConfig::default()));
}

/// The port with STEP and DIR.
pub struct Port;

impl PinPort for Port {
    const STEP: u32 = STEP;
    const DIR: u32 = DIR;

    #[inline(always)]
    fn set(bits: u32, high: bool) {
        let port = GPIO::regs();
        // SAFETY: one store that changes only the levels of these pins.
        unsafe {
            if high {
                port.out_w1ts().write(|w| w.bits(bits));
            } else {
                port.out_w1tc().write(|w| w.bits(bits));
            }
        }
    }

    #[inline(always)]
    fn turned() -> &'static Turned {
        static TURNED: Turned = Turned::new();
        &TURNED
    }
}

/// STEP and DIR of all axes.
pub type StepPins = PortPins<Port>;

/// The pins around the motors: the enable pin and the emergency stop. There are no switches,
/// because the chip has few pins.
pub struct BoardPins(Input<'static>);

impl BoardPins {
    /// Sets up the pin of the emergency stop.
    pub fn new(emergency: impl InputPin + 'static) -> BoardPins {
        BoardPins(Input::new(emergency, InputConfig::default().with_pull(Pull::Up)))
    }
}

impl Panel for BoardPins {
    #[inline(always)]
    fn count(&mut self) -> u32 {
        timer::count()
    }

    fn emergency(&self) -> bool {
        self.0.is_high()
    }

    fn set_enable(&mut self, high: bool) {
        Port::set(1 << ENABLE, high);
    }

    fn reset(&mut self) -> Reset {
        use esp_hal::rtc_cntl::SocResetReason;
        match esp_hal::system::reset_reason() {
            Some(SocResetReason::ChipPowerOn) => Reset::Power,
            _ => Reset::Other,
        }
    }

    fn set_reverse(&mut self, axes: Axes) {
        StepPins::reverse(axes);
    }
}
