//! The whole of a board's foreground.

use stepwright::drive::Axes;
use stepwright::{Control, Group};
use stepwright_protocol::{Controller, Settings, Slave, Stop};

use crate::duties::Duties;
use crate::machine::Joined;
use crate::panel::Panel;

/// A stepper controller with up to N axes, but for its step interrupt and its
/// pins.
///
/// `Q` runs are queued for each axis. The engine and the panel are lent for
/// each call, for an interrupt or a simulation has them too.
pub struct Device<'q, const N: usize, const Q: usize> {
    slave: Slave<N>,
    group: Group<'q, N, Q>,
    duties: Duties,
    axes: u8,
}

impl<'q, const N: usize, const Q: usize> Device<'q, N, Q> {
    /// As at power-up. `axes` of the N are connected.
    pub fn new(
        group: Group<'q, N, Q>,
        axes: u8,
        engine: &mut impl Control,
        panel: &mut impl Panel,
    ) -> Self {
        let mut device = Device::blank(group);
        device.begin(axes, engine, panel);
        device
    }

    /// A device that has yet to [`begin`](Device::begin): zeros but for its group, so that
    /// a static one takes no flash.
    #[inline(always)]
    pub const fn blank(group: Group<'q, N, Q>) -> Self {
        Device { slave: Slave::blank(), group, duties: Duties::OFF, axes: 0 }
    }

    /// Reads the settings, has everything follow them, and leaves the drivers
    /// off until the first travel. The positions are 0, or unknown: see [`Reset`](crate::Reset). `axes`
    /// of the N are connected.
    pub fn begin(&mut self, axes: u8, engine: &mut impl Control, panel: &mut impl Panel) {
        self.axes = axes;
        self.slave.begin();
        if self.duties.begin(panel) {
            self.group.doubt();
            self.slave.stopped(Axes::MAX, Stop::Reset);
        }
        self.duties.apply(&mut self.group, engine, panel);
    }

    /// Takes a byte from the line. At a CR it obeys, and returns true: see
    /// [`Slave::hear`].
    pub fn hear(&mut self, byte: u8, engine: &mut impl Control, panel: &mut impl Panel) -> bool {
        let controller = Controller { group: &mut self.group, engine, axes: self.axes };
        let mut machine = Joined { controller, duties: &mut self.duties, panel };
        self.slave.hear(byte, &mut machine)
    }

    /// Whether some of the last answer has yet to be pulled.
    pub fn is_speaking(&self) -> bool {
        self.slave.is_speaking()
    }

    /// The next byte of the answer: see [`Slave::speak`]. The silence of the host begins when
    /// the last one is asked for: neither a line that takes long nor its answer is a silence.
    pub fn speak(&mut self, engine: &mut impl Control, panel: &mut impl Panel) -> Option<u8> {
        self.duties.hear(panel);
        let controller = Controller { group: &mut self.group, engine, axes: self.axes };
        self.slave.speak(&mut Joined { controller, duties: &mut self.duties, panel })
    }

    /// Tells that a byte was lost or damaged: see [`Slave::garbled`].
    pub fn garbled(&mut self) {
        self.slave.garbled();
    }

    /// Looks after the switches, the drivers, the time-out and the store, and
    /// does one piece of planning. Call it again at once while it answers
    /// true, and at least every millisecond: a switch is looked at as often.
    pub fn poll(&mut self, engine: &mut impl Control, panel: &mut impl Panel) -> bool {
        self.attend(engine, panel);
        self.plan(engine)
    }

    /// The half of [`poll`](Device::poll) that is not planning: switches, times,
    /// settings.
    pub fn attend(&mut self, engine: &mut impl Control, panel: &mut impl Panel) {
        self.duties.poll(&mut self.slave, &mut self.group, engine, panel);
    }

    /// The other half: one piece of planning. True if there may be more.
    pub fn plan(&mut self, engine: &mut impl Control) -> bool {
        self.group.poll(engine)
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.duties.settings
    }

    /// Whether settings are still to be written to the memory.
    pub fn is_saving(&self) -> bool {
        self.duties.store.is_saving()
    }

    /// The motors.
    pub fn group(&self) -> &Group<'q, N, Q> {
        &self.group
    }

    /// The motors, to power them up: see [`Group::power_up`].
    pub fn group_mut(&mut self) -> &mut Group<'q, N, Q> {
        &mut self.group
    }

    /// The motors and the engine, for orders that need no line. They pass the
    /// duties by: no limit holds, and the drivers stay as they are.
    pub fn controller<'a, E: Control>(
        &'a mut self,
        engine: &'a mut E,
    ) -> Controller<'a, 'q, E, N, Q> {
        Controller { group: &mut self.group, engine, axes: self.axes }
    }
}
