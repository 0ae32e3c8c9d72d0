//! Motors whose orders have their own limits, as the slave's machine.

use core::hint::black_box;
use core::task::Poll;

use stepwright::{Axis, AxisSet, Change, Control, Order, OrderedMotors};

use crate::motion_params::whole_speed;
use crate::{AxisId, Machine, Refusal};

impl AxisId {
    /// The axis of N that a line addresses; `None` if there are fewer.
    #[inline(always)]
    pub fn of<const N: usize>(self) -> Option<Axis<N>> {
        Axis::new(self.index()).ok()
    }
}

impl<E: Control, const N: usize, const Q: usize> Machine for OrderedMotors<'_, E, N, Q> {
    fn axes(&self) -> u8 {
        N as u8
    }

    fn busy(&self, axis: AxisId) -> bool {
        axis.of().is_some_and(|axis| self.is_moving(axis))
    }

    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal> {
        let axis = axis.of().ok_or(Refusal::Axis)?;
        Ok(OrderedMotors::prepare(self, axis, order)?)
    }

    fn commit(&mut self) -> Poll<Result<(), Refusal>> {
        OrderedMotors::commit(self, || 0).map_err(Refusal::from)
    }

    fn cancel(&mut self) {
        OrderedMotors::cancel(self);
    }

    fn stop(&mut self, axis: AxisId) {
        if let Some(axis) = axis.of() {
            OrderedMotors::stop(self, axis);
        }
    }

    fn change(&mut self, axes: u8, change: Change) -> Result<(), Refusal> {
        Ok(OrderedMotors::change(self, AxisSet::from_bits(axes), change)?)
    }

    fn kill(&mut self) {
        OrderedMotors::kill(self);
    }

    fn position(&self, axis: AxisId) -> Option<i64> {
        axis.of().and_then(|axis| OrderedMotors::position(self, axis))
    }

    fn uncertain(&self) -> u8 {
        OrderedMotors::uncertain(self)
    }

    fn zero(&mut self, axis: AxisId) {
        if let Some(axis) = axis.of() {
            OrderedMotors::zero(self, axis);
        }
    }

    fn max_rate(&self) -> u32 {
        // `whole_speed` rounds up; this rounds down with the same division.
        whole_speed(self.max_speed().millisteps().saturating_sub(999))
    }

    fn late(&self) -> u32 {
        OrderedMotors::late(self)
    }

    fn clear_late(&mut self) {
        OrderedMotors::clear_late(self);
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
            Core::TooSteep { .. } => Refusal::TooSteep,
            Core::Unfit(Unfit::TooSlow | Unfit::Standstill | Unfit::BelowStart) => Refusal::TooSlow,
            Core::Unfit(Unfit::TooGentle) => Refusal::TooGentle,
            Core::Unfit(Unfit::TooLong) => Refusal::Travel,
            // Not a constant: a table of constants would take RAM on an AVR.
            Core::Unfit(Unfit::NoRamp | Unfit::Uneven | Unfit::Jerk) => black_box(Refusal::Ramp),
        }
    }
}
