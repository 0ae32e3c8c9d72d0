//! The inputs that stop all axes: the emergency stop, and the fault of a driver.

use stepwright::drive::Axes;
use stepwright::{Axis, Control, OrderedMotors};
use stepwright_protocol::{Setting, Slave, Stop};

use crate::panel::BoardIo;
use crate::supervisor::Supervisor;

impl Supervisor {
    /// The input that is active now, if any. While it is active nothing may move.
    pub(crate) fn stopper(&self, panel: &impl BoardIo) -> Option<Stop> {
        let active = |setting, high: bool| match self.settings.byte(setting) {
            0 => false,
            1 => !high,
            _ => high,
        };
        if active(Setting::Emergency, panel.emergency()) {
            Some(Stop::Emergency)
        } else if active(Setting::DriverFault, panel.driver_fault()) {
            Some(Stop::Driver)
        } else {
            None
        }
    }

    /// Stops all axes at once, as K does, while an input is active. There is no ramp: an emergency
    /// stop must act at once, and a driver with a fault follows no ramp.
    pub(crate) fn check_inputs<E: Control, const N: usize, const Q: usize>(
        &mut self,
        slave: &mut Slave<N>,
        motors: &mut OrderedMotors<'_, E, N, Q>,
        panel: &mut impl BoardIo,
    ) {
        let Some(reason) = self.stopper(panel) else { return };
        let (mut busy, mut bit): (Axes, Axes) = (0, 1);
        for axis in Axis::all() {
            if motors.is_moving(axis) {
                busy |= bit;
            }
            bit <<= 1;
        }
        if busy != 0 {
            motors.kill();
        }
        slave.stopped(busy, reason);
        self.killed(panel);
    }
}
