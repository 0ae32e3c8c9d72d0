//! The change of the virtual top from update to update.
//!
//! ```text
//!   top(k+1) = top(k) ± modification(k)
//!   modification(k+1) = modification(k)                      linear
//!                     = 2·modification(k)   slower           VARIABLE_PWR
//!                     = ⌊modification(k)/2⌋ faster           VARIABLE_PWR
//! ```
//!
//! Source: the Arduino driver, `motorSetSpeed` and section 8. Exact: integers.

use super::order::{Control, SetSpeed};
use crate::fit::{Fitted, Hardware, Misfit};

/// The present speed, and its remaining updates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Ramp {
    pub control: Control,
    pub top: u32,
    pub modification: u32,
    pub counts: u16,
}

impl Ramp {
    pub const OFF: Ramp = Ramp { control: Control::OFF, top: 0, modification: 0, counts: 0 };

    pub fn new(order: &SetSpeed) -> Ramp {
        let SetSpeed { control, top, modification, mod_counts: counts, .. } = *order;
        Ramp { control, top, modification, counts }
    }

    /// Makes one update, and returns how the new top fits the timer; if it does not fit, the top
    /// stays unchanged.
    #[inline(never)]
    pub fn update(&mut self, hardware: &Hardware) -> Result<Fitted, Misfit> {
        let faster = self.control.has(Control::FASTER);
        let top = if faster {
            self.top.saturating_sub(self.modification)
        } else {
            self.top.saturating_add(self.modification)
        };
        let fitted = hardware.fit(top)?;
        self.top = top;
        self.counts = self.counts.saturating_sub(1);
        if self.control.has(Control::VARIABLE_PWR) {
            let twice = self.modification.saturating_add(self.modification);
            self.modification = if faster { self.modification >> 1 } else { twice };
        }
        Ok(fitted)
    }

    /// Whether all updates stay in the valid range.
    pub fn stays_in_range(mut self, hardware: &Hardware) -> bool {
        if !self.control.has(Control::VARIABLE_PWR) {
            let all = u64::from(self.modification) * u64::from(self.counts);
            let top = u64::from(self.top);
            return if self.control.has(Control::FASTER) {
                top.saturating_sub(all) >= u64::from(hardware.min_top())
            } else {
                top + all <= u64::from(hardware.max_top())
            };
        }
        // After 32 halvings or doublings a modification is 0, or larger than any top.
        for _ in 0..self.counts.min(33) {
            if self.update(hardware).is_err() {
                return false;
            }
        }
        true
    }
}
