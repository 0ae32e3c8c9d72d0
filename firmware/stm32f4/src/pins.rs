//! STEP and DIR, and the pins around the motors, all on port C.

use stepwright::drive::Axes;
use stepwright_controller::{AXES, Panel, PinPort, PortPins, StampPort, Stamps, Turned};
use stepwright_device::Reset;
use stm32f4xx_hal::pac::{GPIOC, IWDG};

use crate::board::{DIR, EMERGENCY, ENABLE, FAULT, STEP, SWITCHES};
use crate::timer;

/// The bits of all axes.
const ALL: u32 = (1 << AXES) - 1;

/// `value` in the two bits of each pin of `bits`.
const fn pairs(bits: u32, value: u32) -> u32 {
    let (mut pairs, mut pin) = (0, 0);
    while pin < 16 {
        if bits >> pin & 1 != 0 {
            pairs |= value << (2 * pin);
        }
        pin += 1;
    }
    pairs
}

/// Configures the port's pins: STEP, DIR and the enable pin as outputs, all others as inputs.
pub fn start_pins(port: &GPIOC) -> StepPins {
    const OUTPUTS: u32 = ALL << STEP | ALL << DIR | 1 << ENABLE;
    const INPUTS: u32 = ALL << SWITCHES | 1 << EMERGENCY | 1 << FAULT;
    // SAFETY: once, because there is one `GPIOC`.
    let pins = unsafe { StepPins::new() };
    Port::set(1 << ENABLE, true);
    // SAFETY: bits according to the reference manual.
    unsafe {
        port.moder().write(|w| w.bits(const { pairs(OUTPUTS, 1) }));
        port.ospeedr().write(|w| w.bits(const { pairs(OUTPUTS, 1) }));
        port.pupdr().write(|w| w.bits(const { pairs(INPUTS, 1) }));
    }
    pins
}

/// The same, and starts the watchdog.
pub fn start(port: GPIOC, watchdog: IWDG, reasons: u32) -> (StepPins, BoardPins) {
    let pins = start_pins(&port);
    // 32 kHz / 4, 250 ms. It runs on its own clock, and can't be switched off again.
    // SAFETY: keys and values according to the reference manual.
    unsafe {
        watchdog.kr().write(|w| w.bits(0x5555));
        watchdog.pr().write(|w| w.bits(0));
        watchdog.rlr().write(|w| w.bits(2_000));
        watchdog.kr().write(|w| w.bits(0xCCCC));
    }
    (pins, BoardPins { port, watchdog, reasons })
}

/// The port with STEP and DIR.
pub struct Port;

impl PinPort for Port {
    const STEP: u32 = STEP;
    const DIR: u32 = DIR;

    #[inline(always)]
    fn set(bits: u32, high: bool) {
        // SAFETY: one store that changes only the levels of these pins.
        unsafe { (*GPIOC::ptr()).bsrr().write(|w| w.bits(if high { bits } else { bits << 16 })) };
    }

    #[inline(always)]
    fn turned() -> &'static Turned {
        static TURNED: Turned = Turned::new();
        &TURNED
    }
}

impl StampPort for Port {
    #[inline(always)]
    fn count() -> u32 {
        timer::count()
    }

    #[inline(always)]
    fn is_high(bit: u32) -> bool {
        // SAFETY: a read of one register, which has the levels of outputs too.
        unsafe { (*GPIOC::ptr()).idr().read().bits() & bit != 0 }
    }

    fn stamps() -> &'static Stamps {
        static STAMPS: Stamps = Stamps::new();
        &STAMPS
    }
}

/// STEP and DIR of all axes.
pub type StepPins = PortPins<Port>;

/// The pins around the motors, the reason of the last reset, and the watchdog.
pub struct BoardPins {
    port: GPIOC,
    watchdog: IWDG,
    reasons: u32,
}

impl BoardPins {
    fn level(&self, pin: u32) -> bool {
        self.port.idr().read().bits() >> pin & 1 != 0
    }
}

impl Panel for BoardPins {
    #[inline(always)]
    fn count(&mut self) -> u32 {
        timer::count()
    }

    #[inline(always)]
    fn feed(&mut self) {
        // SAFETY: the key that reloads the watchdog.
        self.watchdog.kr().write(|w| unsafe { w.bits(0xAAAA) });
    }

    fn switches(&self) -> Axes {
        (self.port.idr().read().bits() >> SWITCHES & ALL) as Axes
    }

    fn emergency(&self) -> bool {
        self.level(EMERGENCY)
    }

    fn driver_fault(&self) -> bool {
        self.level(FAULT)
    }

    fn set_enable(&mut self, high: bool) {
        Port::set(1 << ENABLE, high);
    }

    fn reset(&mut self) -> Reset {
        // IWDGRSTF; PORRSTF. Power-up sets BORRSTF too, a brown-out sets only that.
        match self.reasons {
            reasons if reasons >> 29 & 1 != 0 => Reset::Watchdog,
            reasons if reasons >> 27 & 1 != 0 => Reset::Power,
            _ => Reset::Other,
        }
    }

    fn set_reverse(&mut self, axes: Axes) {
        StepPins::reverse(axes);
    }
}
