//! The slave's machine: a group of motors and the engine that moves them.

use core::hint::black_box;

use stepwright::{Change, Control, Group, Order, Ticks};

use crate::{AxisId, Machine, Refusal};

/// Joins a [`Group`] and its engine for the time of a call, so that the slave
/// can drive them: the same on the virtual board and on a chip.
pub struct Controller<'a, 'q, E, const N: usize, const Q: usize> {
    /// The motors.
    pub group: &'a mut Group<'q, N, Q>,
    /// The engine, or what holds its interrupt off.
    pub engine: &'a mut E,
    /// How many of the N axes the board has.
    pub axes: u8,
}

impl<E: Control, const N: usize, const Q: usize> Controller<'_, '_, E, N, Q> {
    /// [`Machine::commit`], `wait` ticks later than it could.
    ///
    /// # Errors
    /// As there.
    pub fn commit_after(&mut self, wait: Ticks) -> Result<(), Refusal> {
        Ok(self.group.commit(self.engine, wait)?)
    }
}

impl<E: Control, const N: usize, const Q: usize> Machine for Controller<'_, '_, E, N, Q> {
    fn axes(&self) -> u8 {
        self.axes.min(N as u8)
    }

    fn busy(&self, axis: AxisId) -> bool {
        self.group.is_busy(self.engine, axis.index() as u8)
    }

    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal> {
        Ok(self.group.prepare(self.engine, axis.index() as u8, order)?)
    }

    fn commit(&mut self) -> Result<(), Refusal> {
        self.commit_after(0)
    }

    fn cancel(&mut self) {
        self.group.cancel();
    }

    fn brake(&mut self, axis: AxisId) {
        self.group.brake(axis.index() as u8);
    }

    fn change(&mut self, axes: u8, change: Change) -> Result<(), Refusal> {
        Ok(self.group.change(self.engine, axes, change)?)
    }

    fn kill(&mut self) {
        self.group.kill(self.engine);
    }

    fn position(&self, axis: AxisId) -> Option<i64> {
        self.group.position(self.engine, axis.index() as u8)
    }

    fn uncertain(&self) -> u8 {
        self.group.uncertain()
    }

    fn zero(&mut self, axis: AxisId) {
        self.group.zero(self.engine, axis.index() as u8);
    }

    fn max_rate(&self) -> u32 {
        self.group.board().max_speed().steps()
    }

    fn late(&self) -> u32 {
        self.engine.late()
    }

    fn clear_late(&mut self) {
        self.group.clear(self.engine);
    }
}

impl From<stepwright::Refusal> for Refusal {
    #[inline(never)]
    fn from(refusal: stepwright::Refusal) -> Refusal {
        use stepwright::{Refusal as Core, profile::Unfit};
        match refusal {
            Core::Busy => Refusal::Busy,
            Core::Resting => Refusal::NoTravel,
            Core::NoAxis => Refusal::Axis,
            Core::TooFast { .. } => Refusal::TooFast,
            Core::Unfit(Unfit::TooSlow | Unfit::Standstill | Unfit::BelowStart) => Refusal::TooSlow,
            Core::Unfit(Unfit::TooGentle) => Refusal::TooGentle,
            Core::Unfit(Unfit::TooLong) => Refusal::Travel,
            // Not a constant: a table of constants would lie in an AVR's RAM.
            Core::Unfit(Unfit::NoRamp | Unfit::Uneven | Unfit::Jerk) => black_box(Refusal::Ramp),
        }
    }
}
