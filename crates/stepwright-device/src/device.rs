//! The whole of a board's foreground.

use stepwright::drive::Axes;
use stepwright::{Control, OrderedMotors};
use stepwright_protocol::{Settings, Slave, Stop};

use crate::machine::DeviceMachine;
use crate::panel::BoardIo;
use crate::supervisor::Supervisor;

/// A stepper controller with up to N axes, but for its step interrupt and its
/// pins.
///
/// `Q` runs are queued for each axis. The motors own their way to the engine; the panel is
/// lent for each call, for a simulation has it too.
pub struct Device<'q, E, const N: usize, const Q: usize> {
    slave: Slave<N>,
    motors: OrderedMotors<'q, E, N, Q>,
    supervisor: Supervisor,
    axes: u8,
    /// Rounds that the next line may wait for planning yet.
    patience: u8,
}

/// Rounds of the main loop that a line waits at most until all is planned: 25 ms of an Uno.
const PATIENCE: u8 = 24;

impl<'q, E: Control, const N: usize, const Q: usize> Device<'q, E, N, Q> {
    /// As at power-up. `axes` of the N are connected.
    pub fn new(motors: OrderedMotors<'q, E, N, Q>, axes: u8, panel: &mut impl BoardIo) -> Self {
        let mut device = Device::blank(motors);
        device.begin(axes, panel);
        device
    }

    /// A device that has yet to [`begin`](Device::begin): zeros but for its motors, so that
    /// a static one takes no flash.
    #[inline(always)]
    pub const fn blank(motors: OrderedMotors<'q, E, N, Q>) -> Self {
        Device { slave: Slave::blank(), motors, supervisor: Supervisor::OFF, axes: 0, patience: 0 }
    }

    /// Reads the settings, has everything follow them, and leaves the drivers
    /// off until the first travel. The positions are 0, or unknown: see [`Reset`](crate::Reset). `axes`
    /// of the N are connected.
    pub fn begin(&mut self, axes: u8, panel: &mut impl BoardIo) {
        self.axes = axes;
        self.slave.begin();
        if self.supervisor.begin(panel) {
            self.motors.mark_positions_unknown();
            self.slave.stopped(Axes::MAX, Stop::Reset);
        }
        self.supervisor.apply(&mut self.motors, panel);
    }

    /// Whether it takes bytes: see [`Slave::listens`].
    pub fn listens(&self) -> bool {
        self.slave.listens()
    }

    /// Takes a byte from the line: see [`Slave::receive`].
    pub fn receive(&mut self, byte: u8, panel: &mut impl BoardIo) {
        let Device { slave, motors, supervisor, axes, .. } = self;
        slave.receive(byte, &mut DeviceMachine { motors, axes: *axes, supervisor, panel });
    }

    /// Obeys a line that is complete, or does one piece of starting an order: see
    /// [`Slave::work`]. True while the answer is not ready; the host is not silent, for it
    /// waits for that.
    ///
    /// A line that is no stop waits until everything has been [planned](Device::plan) once since
    /// the line before it, for 24 calls at most. A change takes as long as the runs of some
    /// milliseconds: several of them, one behind the other, would leave a queue dry.
    pub fn work(&mut self, panel: &mut impl BoardIo) -> bool {
        let Device { slave, motors, supervisor, axes, patience } = self;
        let can_wait = slave.can_wait();
        let works = if can_wait && *patience != 0 {
            *patience = patience.wrapping_sub(1);
            true
        } else {
            if can_wait {
                *patience = PATIENCE;
            }
            slave.work(&mut DeviceMachine { motors, axes: *axes, supervisor, panel })
        };
        if works {
            self.supervisor.receive(panel);
        }
        works
    }

    /// Whether some of the last answer has yet to be pulled.
    pub fn is_answering(&self) -> bool {
        self.slave.is_answering()
    }

    /// The next byte of the answer: see [`Slave::next_byte`]. The silence of the host begins when
    /// the last one is asked for: neither a line that takes long nor its answer is a silence.
    pub fn next_byte(&mut self, panel: &mut impl BoardIo) -> Option<u8> {
        self.supervisor.receive(panel);
        let Device { slave, motors, supervisor, axes, .. } = self;
        slave.next_byte(&mut DeviceMachine { motors, axes: *axes, supervisor, panel })
    }

    /// Tells that a byte was lost or damaged: see [`Slave::garbled`].
    pub fn garbled(&mut self) {
        self.slave.garbled();
    }

    /// Looks after the switches, the drivers, the time-out and the store, and
    /// does one piece of planning. Call it again at once while it answers
    /// true, and at least every millisecond: a switch is looked at as often.
    pub fn poll(&mut self, panel: &mut impl BoardIo) -> bool {
        self.poll_io(panel);
        self.plan()
    }

    /// The half of [`poll`](Device::poll) that is not planning: switches, times,
    /// settings.
    pub fn poll_io(&mut self, panel: &mut impl BoardIo) {
        self.supervisor.poll(&mut self.slave, &mut self.motors, panel);
    }

    /// The other half: one piece of planning. True if there may be more.
    pub fn plan(&mut self) -> bool {
        let more = self.motors.plan();
        if !more {
            self.patience = 0;
        }
        more
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.supervisor.settings
    }

    /// Whether settings are still to be written to the memory.
    pub fn is_saving(&self) -> bool {
        self.supervisor.store.is_saving()
    }

    /// The motors. Their orders pass the supervisor by: no limit holds, and the drivers stay as
    /// they are.
    pub fn motors_mut(&mut self) -> &mut OrderedMotors<'q, E, N, Q> {
        &mut self.motors
    }

    /// The motors, to be asked where they are.
    pub fn motors(&self) -> &OrderedMotors<'q, E, N, Q> {
        &self.motors
    }
}
