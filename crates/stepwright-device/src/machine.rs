//! The slave's machine: the motors, and the duties that go with them.

use stepwright::Control;
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
        let (mut moves, mut refused) = (false, None);
        let (duties, panel) = (&*self.duties, &*self.panel);
        // In one pass, for it is long code. An order that is refused here goes
        // on to an axis that no board has, so that the group starts none.
        let checked = orders.map(|(axis, order)| match duties.check(axis, &order, panel) {
            Ok(one) => {
                moves |= one;
                (axis.index() as u8, order.into())
            }
            Err(refusal) => {
                refused = Some(refusal);
                (NOWHERE, order.into())
            }
        });
        // The drivers' delay is part of this travel's lead and of no other's.
        let board = self.controller.group.board_mut();
        let lead = board.lead;
        board.lead = lead.saturating_add(duties.wait(panel, board.rate.hz()));
        let started = self.controller.group.start(self.controller.engine, checked);
        self.controller.group.board_mut().lead = lead;
        let started = refused.map_or(started.map_err(Refusal::from), Err);
        if started.is_ok() && moves {
            self.duties.enable(self.panel);
        }
        started
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
        self.duties.apply(self.controller.group, self.controller.engine, self.panel);
    }
}
