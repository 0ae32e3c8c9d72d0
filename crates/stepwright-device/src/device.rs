//! The whole of a board's foreground.

use stepwright::drive::Axes;
use stepwright::{Control, Steppers};
use stepwright_protocol::{Settings, Slave, Stop};

use crate::duties::Duties;
use crate::machine::Joined;
use crate::panel::Panel;

/// The motors of a device: every order of the line has its own limits.
pub(crate) type Motors<'q, E, const N: usize, const Q: usize> = Steppers<'q, E, N, Q, ()>;

/// A stepper controller with up to N axes, but for its step interrupt and its
/// pins.
///
/// `Q` runs are queued for each axis. The motors own their way to the engine; the panel is
/// lent for each call, for a simulation has it too.
pub struct Device<'q, E, const N: usize, const Q: usize> {
    slave: Slave<N>,
    motors: Motors<'q, E, N, Q>,
    duties: Duties,
    axes: u8,
}

impl<'q, E: Control, const N: usize, const Q: usize> Device<'q, E, N, Q> {
    /// As at power-up. `axes` of the N are connected.
    pub fn new(motors: Steppers<'q, E, N, Q, ()>, axes: u8, panel: &mut impl Panel) -> Self {
        let mut device = Device::blank(motors);
        device.begin(axes, panel);
        device
    }

    /// A device that has yet to [`begin`](Device::begin): zeros but for its motors, so that
    /// a static one takes no flash.
    #[inline(always)]
    pub const fn blank(motors: Steppers<'q, E, N, Q, ()>) -> Self {
        Device { slave: Slave::blank(), motors, duties: Duties::OFF, axes: 0 }
    }

    /// Reads the settings, has everything follow them, and leaves the drivers
    /// off until the first travel. The positions are 0, or unknown: see [`Reset`](crate::Reset). `axes`
    /// of the N are connected.
    pub fn begin(&mut self, axes: u8, panel: &mut impl Panel) {
        self.axes = axes;
        self.slave.begin();
        if self.duties.begin(panel) {
            self.motors.doubt();
            self.slave.stopped(Axes::MAX, Stop::Reset);
        }
        self.duties.apply(&mut self.motors, panel);
    }

    /// Whether it takes bytes: see [`Slave::listens`].
    pub fn listens(&self) -> bool {
        self.slave.listens()
    }

    /// Takes a byte from the line: see [`Slave::hear`].
    pub fn hear(&mut self, byte: u8, panel: &mut impl Panel) {
        let Device { slave, motors, duties, axes } = self;
        slave.hear(byte, &mut Joined { motors, axes: *axes, duties, panel });
    }

    /// Obeys a line that is complete, or does one piece of starting an order: see
    /// [`Slave::work`]. True while the answer is not ready; the host is not silent, for it
    /// waits for that.
    pub fn work(&mut self, panel: &mut impl Panel) -> bool {
        let Device { slave, motors, duties, axes } = self;
        let works = slave.work(&mut Joined { motors, axes: *axes, duties, panel });
        if works {
            self.duties.hear(panel);
        }
        works
    }

    /// Whether some of the last answer has yet to be pulled.
    pub fn is_speaking(&self) -> bool {
        self.slave.is_speaking()
    }

    /// The next byte of the answer: see [`Slave::speak`]. The silence of the host begins when
    /// the last one is asked for: neither a line that takes long nor its answer is a silence.
    pub fn speak(&mut self, panel: &mut impl Panel) -> Option<u8> {
        self.duties.hear(panel);
        let Device { slave, motors, duties, axes } = self;
        slave.speak(&mut Joined { motors, axes: *axes, duties, panel })
    }

    /// Tells that a byte was lost or damaged: see [`Slave::garbled`].
    pub fn garbled(&mut self) {
        self.slave.garbled();
    }

    /// Looks after the switches, the drivers, the time-out and the store, and
    /// does one piece of planning. Call it again at once while it answers
    /// true, and at least every millisecond: a switch is looked at as often.
    pub fn poll(&mut self, panel: &mut impl Panel) -> bool {
        self.attend(panel);
        self.plan()
    }

    /// The half of [`poll`](Device::poll) that is not planning: switches, times,
    /// settings.
    pub fn attend(&mut self, panel: &mut impl Panel) {
        self.duties.poll(&mut self.slave, &mut self.motors, panel);
    }

    /// The other half: one piece of planning. True if there may be more.
    pub fn plan(&mut self) -> bool {
        self.motors.plan()
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.duties.settings
    }

    /// Whether settings are still to be written to the memory.
    pub fn is_saving(&self) -> bool {
        self.duties.store.is_saving()
    }

    /// The motors. Their orders pass the duties by: no limit holds, and the drivers stay as
    /// they are.
    pub fn motors_mut(&mut self) -> &mut Steppers<'q, E, N, Q, ()> {
        &mut self.motors
    }

    /// The motors, to be asked where they are.
    pub fn motors(&self) -> &Steppers<'q, E, N, Q, ()> {
        &self.motors
    }
}
