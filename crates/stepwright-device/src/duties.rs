//! The duties: drivers, switches, the silent host.

use stepwright::drive::Axes;
use stepwright::{Control, Group, Ticks};
use stepwright_protocol::{Setting, Settings};

use crate::panel::Panel;
use crate::store::Store;

/// Where closed switches lie.
pub(crate) struct Blocked {
    forward: Axes,
    backward: Axes,
}

impl Blocked {
    /// Whether this axis may not travel in this direction.
    pub(crate) fn stops(&self, axis: u8, forward: bool) -> bool {
        (if forward { self.forward } else { self.backward }) >> axis & 1 != 0
    }
}

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
        let hz = board.rate.hz();
        let pulse = micros(self.settings.get(Setting::Pulse), hz);
        board.timing.pulse = pulse;
        board.timing.setup = micros(self.settings.get(Setting::Setup), hz);
        board.timing.hold = micros(self.settings.get(Setting::Hold), hz);
        // A pause as long as the pulse, and what the board can do.
        let cost = board.cost.first().copied().unwrap_or(0);
        board.timing.min_interval = cost.max(pulse.wrapping_mul(2));
        engine.set_timing(board.timing);
        panel.set_reverse(self.axes(Setting::Reverse));
        self.set_enable(panel);
        self.moved_at = panel.millis();
    }

    /// Sets the pin that enables the drivers.
    #[cfg_attr(target_arch = "avr", inline(never))]
    fn set_enable(&self, panel: &mut impl Panel) {
        panel.set_enable(self.enabled == (self.settings.get(Setting::EnableHigh) != 0));
    }

    /// Axes whose switch is closed.
    fn closed(&self, panel: &impl Panel) -> Axes {
        !(panel.switches() ^ self.axes(Setting::SwitchHigh)) & self.axes(Setting::Switches)
    }

    /// Axes that may not travel forward now, and those that may not backward:
    /// their switch is closed.
    pub(crate) fn blocked(&self, panel: &impl Panel) -> Blocked {
        let closed = self.closed(panel);
        let forward = self.axes(Setting::SwitchForward);
        Blocked { forward: closed & forward, backward: closed & !forward }
    }

    /// How long a travel that is ordered now has to wait for the drivers.
    pub(crate) fn wait(&self, panel: &impl Panel, hz: u32) -> Ticks {
        let since = panel.millis().wrapping_sub(self.enabled_at);
        let delay = self.settings.get(Setting::Enable);
        if delay == 0 || (self.enabled && since > delay) {
            return 0;
        }
        // One more: the present millisecond has begun already.
        let passed = if self.enabled { since } else { 0 };
        let left = delay.saturating_sub(passed).saturating_add(1);
        micros(1000, hz).wrapping_mul(left)
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
        let blocked = self.blocked(panel);
        for axis in 0..N as u8 {
            if blocked.stops(axis, group.is_forward(axis)) && group.is_busy(engine, axis) {
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
        let busy = group.any_busy(engine);
        if busy {
            self.moved_at = self.now;
        }
        let (setting, since) =
            if busy { (Setting::Timeout, self.heard_at) } else { (Setting::Idle, self.moved_at) };
        let limit = self.settings.get(setting);
        if limit == 0 || self.now.wrapping_sub(since) < limit {
            return;
        }
        if busy && !self.silent {
            self.silent = true;
            for axis in 0..N as u8 {
                group.brake(axis);
            }
        } else if !busy && self.enabled {
            self.enabled = false;
            self.set_enable(panel);
        }
    }
}

/// `us` (at most 1000) in ticks of a timer of `hz`, rounded up.
///
/// By multiplication: a routine for division would take 1 KB of flash, and
/// nothing else needs one. 2⁴⁴ / 10⁶ is 17,592,186.04, so that the product, less
/// than 2⁶³, has the whole ticks exactly, or one more where they would be
/// rounded up anyway.
#[inline(never)]
fn micros(us: u32, hz: u32) -> Ticks {
    let millionths = u64::from(us).wrapping_mul(hz.into());
    let ticks = ((millionths.wrapping_mul(17_592_187) >> 32) as u32) >> 12;
    let short = u64::from(ticks).wrapping_mul(1_000_000) < millionths;
    ticks.wrapping_add(short.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright::Rate;

    #[test]
    fn times_are_those_of_the_core() {
        for hz in [100_000, 1_000_000, 9_500_417, 16_000_000, 20_000_000, 199_999_999, 200_000_000]
        {
            let rate = Rate::from_hz(hz).unwrap();
            for us in 0..=1000 {
                assert_eq!(micros(us, hz), rate.micros(us), "{us} at {hz}");
            }
        }
    }
}
