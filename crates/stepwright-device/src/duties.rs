//! The duties: drivers, switches, the silent host.

use stepwright::drive::Axes;
use stepwright::{Control, Group, Ticks};
use stepwright_protocol::{AxisId, Order, Refusal, Setting, Settings, Travel};

use crate::limits;
use crate::panel::Panel;
use crate::store::Store;

/// What a device keeps in mind besides its motors and its line.
pub(crate) struct Duties {
    pub(crate) settings: Settings,
    pub(crate) store: Store,
    /// Whether the drivers are on.
    enabled: bool,
    /// Whether the host was silent for too long.
    silent: bool,
    /// When the drivers were switched on last, in ms.
    enabled_at: u32,
    /// When a motor moved last, in ms.
    moved_at: u32,
    /// When the last line was complete, in ms.
    heard_at: u32,
    /// The present, as of the last look at it, in ms.
    now: u32,
}

impl Duties {
    /// As at power-up: the settings are those of the memory, the drivers off.
    pub(crate) fn new(panel: &mut impl Panel) -> Duties {
        let (store, settings) = Store::load(panel);
        let now = panel.millis();
        Duties {
            settings,
            store,
            enabled: false,
            silent: false,
            enabled_at: now,
            moved_at: now,
            heard_at: now,
            now,
        }
    }

    /// A set of axes among the settings.
    fn axes(&self, setting: Setting) -> Axes {
        self.settings.get(setting) as Axes
    }

    /// Has the board, the engine and the pins follow the settings.
    pub(crate) fn apply<const N: usize, const Q: usize>(
        &mut self,
        group: &mut Group<'_, N, Q>,
        engine: &mut impl Control,
        panel: &mut impl Panel,
    ) {
        let board = group.board_mut();
        let ticks = board.rate.hz().div_ceil(1000);
        let micros = |setting| ticks.wrapping_mul(self.settings.get(setting)).div_ceil(1000);
        let pulse = micros(Setting::Pulse);
        board.timing.pulse = pulse;
        board.timing.setup = micros(Setting::Setup);
        board.timing.hold = micros(Setting::Hold);
        // A pause as long as the pulse, and what the board can do.
        let cost = board.cost.first().copied().unwrap_or(0);
        board.timing.min_interval = cost.max(pulse.wrapping_mul(2));
        engine.set_timing(board.timing);
        panel.set_reverse(self.axes(Setting::Reverse));
        self.set_enable(panel);
        self.moved_at = panel.millis();
    }

    /// Sets the pin that enables the drivers.
    fn set_enable(&self, panel: &mut impl Panel) {
        panel.set_enable(self.enabled == (self.settings.get(Setting::EnableHigh) != 0));
    }

    /// Axes whose switch is closed.
    fn closed(&self, panel: &impl Panel) -> Axes {
        !(panel.switches() ^ self.axes(Setting::SwitchHigh)) & self.axes(Setting::Switches)
    }

    /// Whether the switch of this axis lies in this direction.
    fn is_ahead(&self, axis: usize, forward: bool) -> bool {
        (self.axes(Setting::SwitchForward) >> axis & 1 != 0) == forward
    }

    /// Whether the settings and the switches allow an order; whether it moves.
    pub(crate) fn check(
        &self,
        axis: AxisId,
        order: &Order,
        panel: &impl Panel,
    ) -> Result<bool, Refusal> {
        limits::check(&self.settings, order)?;
        let forward = match order.travel {
            Travel::By(distance) if distance.get() == 0 => return Ok(false),
            Travel::By(distance) => distance.get() > 0,
            Travel::Endless(direction) => direction == stepwright_protocol::Direction::Forward,
        };
        let closed = self.closed(panel) >> axis.index() & 1 != 0;
        if closed && self.is_ahead(axis.index(), forward) {
            return Err(Refusal::Fault);
        }
        Ok(true)
    }

    /// How long a travel that is ordered now has to wait for the drivers.
    pub(crate) fn wait(&self, panel: &impl Panel, ticks_per_second: u32) -> Ticks {
        let since = panel.millis().wrapping_sub(self.enabled_at);
        let delay = self.settings.get(Setting::Enable);
        if delay == 0 || (self.enabled && since > delay) {
            return 0;
        }
        // One more: the present millisecond has begun already.
        let passed = if self.enabled { since } else { 0 };
        let left = delay.saturating_sub(passed).saturating_add(1);
        ticks_per_second.div_ceil(1000).saturating_mul(left)
    }

    /// A travel begins.
    pub(crate) fn enable(&mut self, panel: &mut impl Panel) {
        let now = panel.millis();
        self.moved_at = now;
        if !self.enabled {
            self.enabled = true;
            self.enabled_at = now;
            self.set_enable(panel);
        }
    }

    /// A line is complete, whatever it says: the host is there.
    pub(crate) fn hear(&mut self, panel: &impl Panel) {
        self.heard_at = panel.millis();
        self.silent = false;
    }

    /// Looks after everything once.
    pub(crate) fn poll<const N: usize, const Q: usize>(
        &mut self,
        group: &mut Group<'_, N, Q>,
        engine: &mut impl Control,
        panel: &mut impl Panel,
    ) {
        self.heed_switches(group, engine, panel);
        self.store.poll(panel, &self.settings);
        let now = panel.millis();
        if now != self.now {
            self.now = now;
            self.heed_time(group, engine, panel);
        }
    }

    /// Stops what moves towards a closed switch.
    fn heed_switches<const N: usize, const Q: usize>(
        &self,
        group: &mut Group<'_, N, Q>,
        engine: &mut impl Control,
        panel: &impl Panel,
    ) {
        let closed = self.closed(panel);
        if closed == 0 {
            return;
        }
        for axis in 0..N as u8 {
            if closed >> axis & 1 != 0
                && self.is_ahead(axis.into(), group.is_forward(axis))
                && group.is_busy(engine, axis)
            {
                group.halt(engine, 1 << axis);
            }
        }
    }

    /// A millisecond has passed.
    fn heed_time<const N: usize, const Q: usize>(
        &mut self,
        group: &mut Group<'_, N, Q>,
        engine: &mut impl Control,
        panel: &mut impl Panel,
    ) {
        if group.any_busy(engine) {
            self.moved_at = self.now;
            let limit = self.settings.get(Setting::Timeout);
            let silence = self.now.wrapping_sub(self.heard_at);
            if limit != 0 && silence >= limit && !self.silent {
                self.silent = true;
                for axis in 0..N as u8 {
                    group.brake(axis);
                }
            }
        } else if self.enabled {
            let limit = self.settings.get(Setting::Idle);
            if limit != 0 && self.now.wrapping_sub(self.moved_at) >= limit {
                self.enabled = false;
                self.set_enable(panel);
            }
        }
    }
}
