//! The slave's machine: the motors, and the duties that go with them.

use stepwright::{Change, Control, Order, Travel};
use stepwright_protocol::{AxisId, Controller, Machine, Refusal, Setting, Settings};

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

    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal> {
        #[cfg(feature = "safety")]
        if self.duties.stopper(self.panel).is_some() {
            return Err(Refusal::Fault);
        }
        let (index, travel) = (axis.index() as u8, order.travel);
        let blocked = self.duties.blocked(self.panel);
        if blocked.on(travel.forward()) >> index & 1 != 0 && travel != Travel::By(0) {
            return Err(Refusal::Fault);
        }
        self.controller.prepare(axis, order)
    }

    fn commit(&mut self) -> Result<(), Refusal> {
        let wait = self.duties.wait(self.panel);
        self.controller.commit_after(wait)?;
        self.duties.enable(self.panel);
        Ok(())
    }

    fn cancel(&mut self) {
        self.controller.cancel();
    }

    fn brake(&mut self, axis: AxisId) {
        self.controller.brake(axis);
    }

    fn change(&mut self, axes: u8, change: Change) -> Result<(), Refusal> {
        if let Change::Target(steps) = change {
            let blocked = self.duties.blocked(self.panel);
            let mut bit = 1;
            for axis in 0..N as u8 {
                let forward = self.controller.group.leads_forward(axis, steps);
                if axes & bit & blocked.on(forward) != 0 {
                    return Err(Refusal::Fault);
                }
                bit <<= 1;
            }
        }
        self.controller.change(axes, change)
    }

    fn kill(&mut self) {
        self.controller.kill();
        #[cfg(feature = "safety")]
        self.duties.killed(self.panel);
    }

    fn position(&self, axis: AxisId) -> Option<i64> {
        self.controller.position(axis)
    }

    fn uncertain(&self) -> u8 {
        self.controller.uncertain()
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

    #[cfg(feature = "safety")]
    fn lease(&mut self, millis: u16) -> Result<(), Refusal> {
        self.duties.lease = millis;
        Ok(())
    }

    fn settings(&mut self) -> Option<&mut Settings> {
        Some(&mut self.duties.settings)
    }

    fn set_up(&mut self) {
        self.duties.store.save();
        self.duties.apply(self.controller.group, self.controller.engine, self.panel);
    }
}
