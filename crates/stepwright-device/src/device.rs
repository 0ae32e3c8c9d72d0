//! The whole of a board's foreground.

use stepwright::queue::Producer;
use stepwright::{Board, Control, Group};
use stepwright_protocol::{Controller, Reply, Settings, Slave};

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
    /// As at power-up: reads the settings, has everything follow them, and
    /// leaves the drivers off until the first travel. `axes` of the N are
    /// connected.
    #[cfg_attr(target_arch = "avr", inline(never))]
    pub fn new(
        mut group: Group<'q, N, Q>,
        axes: u8,
        engine: &mut impl Control,
        panel: &mut impl Panel,
    ) -> Self {
        let mut duties = Duties::new(panel);
        duties.apply(group.board_mut(), engine, panel);
        Device { slave: Slave::new(), group, duties, axes }
    }

    /// Likewise, and makes the group as well: a small chip has no room for one
    /// on its way.
    pub fn of(
        feeds: [Producer<'q, Q>; N],
        mut board: Board<N>,
        axes: u8,
        engine: &mut impl Control,
        panel: &mut impl Panel,
    ) -> Self {
        let mut duties = Duties::new(panel);
        duties.apply(&mut board, engine, panel);
        Device { slave: Slave::new(), group: Group::new(feeds, board), duties, axes }
    }

    /// Takes a byte from the line. At a CR it obeys and returns the answer,
    /// whose [`bytes`](Reply::bytes) go back on the line.
    pub fn push(
        &mut self,
        byte: u8,
        engine: &mut impl Control,
        panel: &mut impl Panel,
    ) -> Option<Reply> {
        let controller = Controller { group: &mut self.group, engine, axes: self.axes };
        let mut machine = Joined { controller, duties: &mut self.duties, panel };
        let reply = self.slave.push(byte, &mut machine)?;
        self.duties.hear(panel);
        Some(reply)
    }

    /// Tells that a byte was lost or damaged: see [`Slave::garbled`].
    pub fn garbled(&mut self) {
        self.slave.garbled();
    }

    /// Looks after the switches, the drivers, the time-out and the store, and
    /// does one piece of planning. Call it again at once while it answers
    /// true, and at least every millisecond: a switch is heeded as often.
    pub fn poll(&mut self, engine: &mut impl Control, panel: &mut impl Panel) -> bool {
        self.duties.poll(&mut self.group, engine, panel);
        self.group.poll(engine)
    }

    /// Calls all positions uncertain: see [`Group::doubt`].
    pub fn doubt(&mut self) {
        self.group.doubt();
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

    /// The motors and the engine, for orders that need no line. They pass the
    /// duties by: no limit holds, and the drivers stay as they are.
    pub fn controller<'a, E: Control>(
        &'a mut self,
        engine: &'a mut E,
    ) -> Controller<'a, 'q, E, N, Q> {
        Controller { group: &mut self.group, engine, axes: self.axes }
    }
}
