//! The machine of the slave: the motors with their supervisor.

use core::task::Poll;

use stepwright::{Axis, AxisSet, Change, Control, Order, OrderedMotors, Travel};
use stepwright_protocol::{AxisId, Machine, Refusal, Setting, Settings};

use crate::panel::BoardIo;
use crate::supervisor::Supervisor;

/// The parts of a device, borrowed while it handles a line.
pub(crate) struct DeviceMachine<'a, 'q, E, P, const N: usize, const Q: usize> {
    pub(crate) motors: &'a mut OrderedMotors<'q, E, N, Q>,
    /// The number of axes that the board has, of the N.
    pub(crate) axes: u8,
    pub(crate) supervisor: &'a mut Supervisor,
    pub(crate) panel: &'a mut P,
}

impl<E: Control, P: BoardIo, const N: usize, const Q: usize> Machine
    for DeviceMachine<'_, '_, E, P, N, Q>
{
    fn axes(&self) -> u8 {
        self.axes.min(N as u8)
    }

    fn busy(&self, axis: AxisId) -> bool {
        self.motors.busy(axis)
    }

    fn prepare(&mut self, axis: AxisId, order: &Order) -> Result<(), Refusal> {
        if self.supervisor.stopper(self.panel).is_some() {
            return Err(Refusal::Fault);
        }
        let (index, travel) = (axis.index() as u8, order.travel);
        let blocked = self.supervisor.blocked(self.panel);
        if blocked.on(travel.forward()) >> index & 1 != 0 && travel != Travel::By(0) {
            return Err(Refusal::Fault);
        }
        Machine::prepare(self.motors, axis, order)
    }

    fn commit(&mut self) -> Poll<Result<(), Refusal>> {
        // The drivers are switched on before the first axis begins, which may be ready before the
        // last.
        let wait = || self.supervisor.enable(self.panel);
        self.motors.commit(wait).map_err(Refusal::from)
    }

    fn cancel(&mut self) {
        self.motors.cancel();
    }

    fn stop(&mut self, axis: AxisId) {
        Machine::stop(self.motors, axis);
    }

    fn change(&mut self, axes: u8, change: Change) -> Result<(), Refusal> {
        if let Change::Target(steps) = change {
            let blocked = self.supervisor.blocked(self.panel);
            let mut bit = 1;
            for axis in Axis::all() {
                let forward = self.motors.is_ahead(axis, steps);
                if axes & bit & blocked.on(forward) != 0 {
                    return Err(Refusal::Fault);
                }
                bit <<= 1;
            }
        }
        Ok(self.motors.change(AxisSet::from_bits(axes), change)?)
    }

    fn kill(&mut self) {
        self.motors.kill();
        self.supervisor.killed(self.panel);
    }

    fn position(&self, axis: AxisId) -> Option<i64> {
        Machine::position(self.motors, axis)
    }

    fn uncertain(&self) -> u8 {
        self.motors.uncertain()
    }

    fn closed(&self) -> u8 {
        self.supervisor.closed(self.panel)
    }

    fn zero(&mut self, axis: AxisId) {
        Machine::zero(self.motors, axis);
    }

    fn max_rate(&self) -> u32 {
        self.motors.max_rate().min(self.supervisor.settings.get(Setting::MaxSpeed))
    }

    fn late(&self) -> u32 {
        self.motors.late()
    }

    fn clear_late(&mut self) {
        self.motors.clear_late();
    }

    fn lease(&mut self, millis: u16) -> Result<(), Refusal> {
        self.supervisor.lease = millis;
        // The silence before this line does not count for the lease.
        self.supervisor.receive(self.panel);
        Ok(())
    }

    fn settings(&mut self) -> Option<&mut Settings> {
        Some(&mut self.supervisor.settings)
    }

    fn set_up(&mut self) {
        self.supervisor.store.save();
        self.supervisor.apply(self.motors, self.panel);
    }
}
