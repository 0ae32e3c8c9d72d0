//! The slave's machine: the motors, and the duties that go with them.

use stepwright::Control;
use stepwright_protocol::{AxisId, Controller, Machine, Order, Refusal, Setting, Settings};

use crate::duties::Duties;
use crate::panel::Panel;

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
        let mut moves = false;
        for (axis, order) in orders.clone() {
            moves |= self.duties.check(axis, &order, self.panel)?;
        }
        // The drivers' delay is part of this travel's lead and of no other's.
        let board = self.controller.group.board_mut();
        let lead = board.lead;
        board.lead = lead.saturating_add(self.duties.wait(self.panel, board.rate.hz()));
        let started = self.controller.start(orders);
        self.controller.group.board_mut().lead = lead;
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

    fn settings(&self) -> Option<Settings> {
        Some(self.duties.settings)
    }

    fn set_up(&mut self, settings: Settings) {
        self.duties.settings = settings;
        self.duties.store.save();
        self.duties.apply(self.controller.group, self.controller.engine, self.panel);
    }
}
