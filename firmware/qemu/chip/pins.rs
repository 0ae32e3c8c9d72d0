//! A port that QEMU's board lacks: memory stands in for it, and QEMU's plugin sees the stores.

use stepwright::drive::Axes;
use stepwright_controller::{Panel, PinPort, PortPins, Turned};
use stepwright_device::Reset;

use crate::board::{CLEAR, DIR, ENABLE, SET, STEP};
use crate::timer;

/// The port with STEP and DIR.
pub struct Port;

impl PinPort for Port {
    const STEP: u32 = STEP;
    const DIR: u32 = DIR;

    #[inline(always)]
    fn set(bits: u32, high: bool) {
        let first = if high { SET } else { CLEAR };
        // SAFETY: 128 words of RAM that the linker does not use (`memory.x`).
        unsafe { ((first + (bits as usize & 0x7F) * 4) as *mut u32).write_volatile(bits) };
    }

    #[inline(always)]
    fn turned() -> &'static Turned {
        static TURNED: Turned = Turned::new();
        &TURNED
    }
}

/// STEP and DIR of all axes.
pub type StepPins = PortPins<Port>;

/// The pins around the motors. There are no switches and no watchdog.
pub struct BoardPins(());

impl BoardPins {
    /// Leaves the drivers off.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new() -> BoardPins {
        Port::set(1 << ENABLE, true);
        BoardPins(())
    }
}

impl Panel for BoardPins {
    #[inline(always)]
    fn count(&mut self) -> u32 {
        timer::count()
    }

    fn set_enable(&mut self, high: bool) {
        Port::set(1 << ENABLE, high);
    }

    fn reset(&mut self) -> Reset {
        Reset::Power
    }

    fn set_reverse(&mut self, axes: Axes) {
        StepPins::reverse(axes);
    }
}
