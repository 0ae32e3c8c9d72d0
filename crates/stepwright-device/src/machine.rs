//! The slave's machine: the motors, and the duties that go with them.

use stepwright::{Control, Travel};
use stepwright_protocol::{AxisId, Controller, Machine, Order, Refusal, Setting, Settings};

use crate::duties::Duties;
use crate::panel::Panel;

/// An axis that no board has.
const NOWHERE: u8 = u8::MAX;

/// A device for the time of a line.
pub(crate) struct Joined<'a, 'q, E, P, const N: usize, const Q: usize> {
    pub(crate) controller: Controller<'a, 'q, E, N, Q>,
    pub(crate) duties: &'a mut Duties,
    pub(crate) panel: &'a mut P,
}

impl<E: Control, P: Panel, const N: usize, const Q: usize> Machine for Joined<'_, '_, E, P, N, Q> {
    fn axes(&self) -> u8 {
        self.controller.axes()
    }

    fn busy(&self, axis: AxisId) -> bool {
        self.controller.busy(axis)
    }

    fn start<I>(&mut self, orders: I) -> Result<(), Refusal>
    where
        I: Iterator<Item = (AxisId, Order)> + Clone,
    {
        let blocked = self.duties.blocked(self.panel);
        let mut fault = false;
        // In one pass, for it is long code: an order that is refused here goes
        // on to an axis that no board has, so that the group starts none.
        let orders = orders.map(|(axis, order)| {
            let order: stepwright::Order = order.into();
            let (axis, travel) = (axis.index() as u8, order.travel);
            let stops = blocked.stops(axis, travel.forward()) && travel != Travel::By(0);
            fault |= stops;
            (if stops { NOWHERE } else { axis }, order)
        });
        // The drivers' delay is part of this travel's lead and of no other's.
        let board = self.controller.group.board_mut();
        let lead = board.lead;
        board.lead = lead.saturating_add(self.duties.wait(self.panel, board.rate.hz()));
        let started = self.controller.group.start(self.controller.engine, orders);
        self.controller.group.board_mut().lead = lead;
        if fault {
            return Err(Refusal::Fault);
        }
        started?;
        self.duties.enable(self.panel);
        Ok(())
    }

    fn brake(&mut self, axis: AxisId) {
        self.controller.brake(axis);
    }

    fn kill(&mut self) {
        self.controller.kill();
    }

    fn position(&self, axis: AxisId) -> Option<i64> {
        self.controller.position(axis)
    }

    fn zero(&mut self, axis: AxisId) {
        self.controller.zero(axis);
    }

    fn max_rate(&self) -> u32 {
        self.controller.max_rate().min(self.duties.settings.get(Setting::MaxSpeed))
    }

    fn late(&self) -> u32 {
        self.controller.late()
    }

    fn clear_late(&mut self) {
        self.controller.clear_late();
    }

    fn settings(&mut self) -> Option<&mut Settings> {
        Some(&mut self.duties.settings)
    }

    fn set_up(&mut self) {
        self.duties.store.save();
        self.duties.apply(self.controller.group.board_mut(), self.controller.engine, self.panel);
    }
}
