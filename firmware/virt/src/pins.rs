//! A port that `virt` has not: memory stands for it, and QEMU's plugin sees the stores.

use stepwright::drive::{Axes, Drive};
use stepwright_controller::{AXES, Panel, Turned};
use stepwright_device::Reset;

use crate::board::{CLEAR, DIR, ENABLE, SET, STEP};
use crate::timer;

static TURNED: Turned = Turned::new();

/// Raises pins by their bits, or lowers them.
#[inline(always)]
fn set(bits: u32, high: bool) {
    let first = if high { SET } else { CLEAR };
    // SAFETY: 128 words of RAM, of which the linker has nothing (`memory.x`).
    unsafe { ((first + (bits as usize & 0x7F) * 4) as *mut u32).write_volatile(bits) };
}

/// STEP and DIR of all axes.
pub struct StepPins(());

impl StepPins {
    /// Makes them low.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new() -> StepPins {
        set(((1 << AXES) - 1) << STEP | ((1 << AXES) - 1) << DIR, false);
        StepPins(())
    }
}

impl Drive for StepPins {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        set(u32::from(axes) << STEP, true);
    }

    #[inline(always)]
    fn end(&mut self, axes: Axes) {
        set(u32::from(axes) << STEP, false);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        set(1u32.wrapping_shl(DIR + u32::from(axis)), TURNED.direction(axis, forward));
    }
}

/// The pins around the motors. There are no switches and no watchdog.
pub struct BoardPins(());

impl BoardPins {
    /// Leaves the drivers off.
    ///
    /// # Safety
    /// Called once.
    pub unsafe fn new() -> BoardPins {
        set(1 << ENABLE, true);
        BoardPins(())
    }
}

impl Panel for BoardPins {
    #[inline(always)]
    fn count(&mut self) -> u32 {
        timer::count()
    }

    fn set_enable(&mut self, high: bool) {
        set(1 << ENABLE, high);
    }

    fn reset(&mut self) -> Reset {
        Reset::Power
    }

    fn set_reverse(&mut self, axes: Axes) {
        let levels = TURNED.reverse(axes);
        for axis in 0..AXES as u8 {
            set(1 << (DIR + u32::from(axis)), levels >> axis & 1 != 0);
        }
    }
}
