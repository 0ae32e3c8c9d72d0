//! The whole foreground of a board.

use stepwright::drive::Axes;
use stepwright::{Control, OrderedMotors};
use stepwright_protocol::{Settings, Slave, Stop};

use crate::machine::DeviceMachine;
use crate::panel::BoardIo;
use crate::supervisor::Supervisor;

/// A stepper controller with up to N axes, without its step interrupt and its pins.
///
/// `Q` runs are queued for each axis. The device owns the motors, which reach the engine
/// themselves. The panel is lent for each call, because a simulation uses it too.
pub struct Device<'q, E, const N: usize, const Q: usize> {
    slave: Slave<N>,
    motors: OrderedMotors<'q, E, N, Q>,
    supervisor: Supervisor,
    axes: u8,
    /// The rounds for which the next line may still wait for planning.
    patience: u8,
}

/// The most rounds of the main loop that a line waits for planning: 25 ms on an Uno.
const PATIENCE: u8 = 24;

impl<'q, E: Control, const N: usize, const Q: usize> Device<'q, E, N, Q> {
    /// The state at power-up. `axes` of the N are connected.
    pub fn new(motors: OrderedMotors<'q, E, N, Q>, axes: u8, panel: &mut impl BoardIo) -> Self {
        let mut device = Device::blank(motors);
        device.begin(axes, panel);
        device
    }

    /// A device before [`begin`](Device::begin): zeros except for its motors, so that a static one
    /// takes no flash.
    #[inline(always)]
    pub const fn blank(motors: OrderedMotors<'q, E, N, Q>) -> Self {
        Device { slave: Slave::blank(), motors, supervisor: Supervisor::OFF, axes: 0, patience: 0 }
    }

    /// Loads the settings, applies them, and leaves the drivers off until the first travel. The
    /// positions are 0, or unknown: see [`Reset`](crate::Reset). `axes` of the N are connected.
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

    /// Obeys a complete line, or does one piece of starting an order: see [`Slave::work`]. True
    /// while the answer is not ready. Meanwhile the host does not count as silent, because it waits
    /// for the answer.
    ///
    /// A line that is not a stop waits until everything has been [planned](Device::plan) once since
    /// the previous line, for 24 calls at most. A change takes as long as planning the runs of some
    /// milliseconds: several changes in a row would let a queue run dry.
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

    /// Whether part of the last answer is still to be sent.
    pub fn is_answering(&self) -> bool {
        self.slave.is_answering()
    }

    /// The next byte of the answer: see [`Slave::next_byte`]. The silence of the host begins when
    /// the last byte is requested: the time for a long line or for its answer does not count.
    pub fn next_byte(&mut self, panel: &mut impl BoardIo) -> Option<u8> {
        self.supervisor.receive(panel);
        let Device { slave, motors, supervisor, axes, .. } = self;
        slave.next_byte(&mut DeviceMachine { motors, axes: *axes, supervisor, panel })
    }

    /// Reports that a byte was lost or damaged: see [`Slave::garbled`].
    pub fn garbled(&mut self) {
        self.slave.garbled();
    }

    /// Handles the switches, the drivers, the time-out and the store, and does one piece of
    /// planning. Call it again at once while it returns true, and at least every millisecond,
    /// because it samples the switches.
    pub fn poll(&mut self, panel: &mut impl BoardIo) -> bool {
        self.poll_io(panel);
        self.plan()
    }

    /// The part of [`poll`](Device::poll) without planning: switches, times, settings.
    pub fn poll_io(&mut self, panel: &mut impl BoardIo) {
        self.supervisor.poll(&mut self.slave, &mut self.motors, panel);
    }

    /// The other part: one piece of planning. True if there may be more.
    pub fn plan(&mut self) -> bool {
        let more = self.motors.plan();
        if !more {
            self.patience = 0;
        }
        more
    }

    /// The present settings.
    pub fn settings(&self) -> &Settings {
        &self.supervisor.settings
    }

    /// Whether settings are still to be written to the memory.
    pub fn is_saving(&self) -> bool {
        self.supervisor.store.is_saving()
    }

    /// The motors. Orders given here bypass the supervisor: no limit applies, and the drivers are
    /// not switched.
    pub fn motors_mut(&mut self) -> &mut OrderedMotors<'q, E, N, Q> {
        &mut self.motors
    }

    /// The motors, to read positions.
    pub fn motors(&self) -> &OrderedMotors<'q, E, N, Q> {
        &self.motors
    }
}
