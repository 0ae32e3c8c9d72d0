//! The supervisor: drivers, switches, time-outs.

use stepwright::drive::Axes;
use stepwright::{Axis, Control, OrderedMotors, Ticks};
use stepwright_protocol::{Setting, Settings, Slave, Stop};

use crate::contacts::Contacts;
use crate::panel::BoardIo;
use crate::reset::Mark;
use crate::store::Store;

/// The directions that closed switches block.
pub(crate) struct Blocked {
    forward: Axes,
    backward: Axes,
}

impl Blocked {
    /// The axes that may not travel in this direction.
    pub(crate) fn on(&self, forward: bool) -> Axes {
        if forward { self.forward } else { self.backward }
    }
}

/// The state of a device besides its motors and its line.
pub(crate) struct Supervisor {
    pub(crate) settings: Settings,
    pub(crate) store: Store,
    /// Whether the drivers are on.
    enabled: bool,
    /// Whether the host was silent for too long.
    silent: bool,
    /// The lease that the host has requested, in ms; 0: none.
    pub(crate) lease: u16,
    /// The switches that count as closed since an earlier sample.
    contacts: Contacts,
    /// The time until drivers that were switched on may be used, in ms.
    settling: u16,
    /// The time when a motor last moved, in ms.
    moved_at: u32,
    /// The time when the last line was complete, in ms.
    heard_at: u32,
    /// The time at the last poll, in ms, modulo 256.
    now: u8,
}

impl Supervisor {
    /// The state before power-up.
    pub(crate) const OFF: Supervisor = Supervisor {
        settings: Settings::blank(),
        store: Store::NEW,
        enabled: false,
        silent: false,
        lease: 0,
        contacts: Contacts::OPEN,
        settling: 0,
        moved_at: 0,
        heard_at: 0,
        now: 0,
    };

    /// Sets the state at power-up: the settings are loaded from the memory, the drivers are off.
    /// True if the position is unknown.
    pub(crate) fn begin(&mut self, panel: &mut impl BoardIo) -> bool {
        self.store.find(panel, &mut self.settings);
        self.receive(panel);
        panel.begin()
    }

    /// A setting that is a set of axes.
    #[inline(always)]
    fn axes(&self, setting: Setting) -> Axes {
        self.settings.byte(setting)
    }

    /// Applies the settings to the board, the engine and the pins.
    pub(crate) fn apply<E: Control, const N: usize, const Q: usize>(
        &mut self,
        motors: &mut OrderedMotors<'_, E, N, Q>,
        panel: &mut impl BoardIo,
    ) {
        motors.set_drivers(
            self.ticks(panel, Setting::Pulse),
            self.ticks(panel, Setting::Setup),
            self.ticks(panel, Setting::Hold),
        );
        panel.set_reverse(self.axes(Setting::Reverse));
        self.set_enable(panel);
        self.moved_at = panel.millis();
    }

    /// A setting in microseconds, converted to ticks.
    #[inline(never)]
    fn ticks(&self, panel: &impl BoardIo, setting: Setting) -> Ticks {
        panel.ticks(self.settings.get(setting) as u16)
    }

    /// Sets the pin that enables the drivers.
    #[cfg_attr(target_arch = "avr", inline(never))]
    fn set_enable(&self, panel: &mut impl BoardIo) {
        panel.set_enable(self.enabled == (self.settings.byte(Setting::EnableHigh) != 0));
    }

    /// The axes whose switch is closed.
    pub(crate) fn closed(&self, panel: &impl BoardIo) -> Axes {
        !(panel.switches() ^ self.axes(Setting::SwitchHigh)) & self.axes(Setting::Switches)
    }

    /// The axes that may not travel forward now, and those that may not travel backward: their
    /// switch is closed, or counts as closed.
    pub(crate) fn blocked(&self, panel: &impl BoardIo) -> Blocked {
        let closed = self.closed(panel);
        let closed = closed | self.contacts.held() & self.axes(Setting::Switches);
        let forward = self.axes(Setting::SwitchForward);
        Blocked { forward: closed & forward, backward: closed & !forward }
    }

    /// The time from switching the drivers on to the first step, in ms, and one more, because the
    /// present millisecond has begun already.
    fn delay(&self) -> u16 {
        match self.settings.get(Setting::Enable) as u16 {
            0 => 0,
            delay => delay.wrapping_add(1),
        }
    }

    /// Switches the drivers on for a travel. Returns the time that it has to wait for them.
    pub(crate) fn enable(&mut self, panel: &mut impl BoardIo) -> Ticks {
        self.moved_at = panel.millis();
        panel.set_mark(Mark::MOVING);
        if !self.enabled {
            self.enabled = true;
            self.settling = self.delay();
            self.now = self.moved_at as u8;
            self.set_enable(panel);
        }
        panel.ticks(1000).wrapping_mul(self.settling.into())
    }

    /// Switches the drivers off after a stop of all axes at once, if the settings say so. With the
    /// drivers off, `check_time` no longer sets the mark, so this does.
    pub(crate) fn killed(&mut self, panel: &mut impl BoardIo) {
        if self.enabled && self.settings.byte(Setting::KillOff) != 0 {
            panel.set_mark(Mark::MOVED);
            self.enabled = false;
            self.set_enable(panel);
        }
    }

    /// Notes that a line is complete: any line is a sign of life from the host.
    pub(crate) fn receive(&mut self, panel: &impl BoardIo) {
        self.heard_at = panel.millis();
        self.silent = false;
    }

    /// The milliseconds since the last poll, modulo 256.
    #[inline(always)]
    fn passed(&self, panel: &impl BoardIo) -> u8 {
        (panel.millis() as u8).wrapping_sub(self.now)
    }

    /// Handles all inputs and times once.
    pub(crate) fn poll<E: Control, const N: usize, const Q: usize>(
        &mut self,
        slave: &mut Slave<N>,
        motors: &mut OrderedMotors<'_, E, N, Q>,
        panel: &mut impl BoardIo,
    ) {
        self.check_inputs(slave, motors, panel);
        let closed = self.closed(panel);
        let debounce = self.settings.byte(Setting::Debounce);
        self.contacts.sample(self.passed(panel), closed, debounce);
        self.check_switches(slave, motors, panel);
        self.store.poll(panel, &self.settings);
        let passed = self.passed(panel);
        if passed != 0 {
            self.now = self.now.wrapping_add(passed);
            self.settling = self.settling.saturating_sub(passed.into());
            // Only one, because mostly one has passed: a rest may be longer.
            motors.count_rest(panel.ticks(1000));
            self.check_time(slave, motors, panel);
        }
    }

    /// Stops the axes that move towards a closed switch.
    fn check_switches<E: Control, const N: usize, const Q: usize>(
        &self,
        slave: &mut Slave<N>,
        motors: &mut OrderedMotors<'_, E, N, Q>,
        panel: &impl BoardIo,
    ) {
        let blocked = self.blocked(panel);
        let mut bit: Axes = 1;
        for axis in Axis::all() {
            let forward = motors.is_forward(axis);
            if blocked.on(forward) & bit != 0 && motors.is_moving(axis) {
                motors.kill_at_switch(axis);
                slave.stopped(bit, Stop::Switch);
            }
            bit <<= 1;
        }
    }

    /// Handles the time after one or more milliseconds.
    fn check_time<E: Control, const N: usize, const Q: usize>(
        &mut self,
        slave: &mut Slave<N>,
        motors: &mut OrderedMotors<'_, E, N, Q>,
        panel: &mut impl BoardIo,
    ) {
        // The axes of an order begin between two calls: the mark and the drivers are theirs from
        // before.
        let busy = motors.any_moving() || slave.is_starting();
        let now = panel.millis();
        if busy {
            self.moved_at = now;
        } else if self.enabled {
            // An axis has moved since the drivers were switched on.
            panel.set_mark(Mark::MOVED);
        }
        self.check_lease(now, slave, motors);
        let (setting, since) =
            if busy { (Setting::Timeout, &self.heard_at) } else { (Setting::Idle, &self.moved_at) };
        let limit = self.settings.get(setting);
        if limit == 0 {
            return;
        }
        // The millisecond in which it began is not a whole one.
        if now.wrapping_sub(*since) <= limit {
            return;
        }
        if busy && !self.silent {
            self.silent = true;
            stop(slave, motors);
        } else if !busy && self.enabled {
            self.enabled = false;
            self.set_enable(panel);
        }
    }

    /// Ends a lease after a silence of its length, and all motion with it: the next host may not
    /// know of the lease.
    fn check_lease<E: Control, const N: usize, const Q: usize>(
        &mut self,
        now: u32,
        slave: &mut Slave<N>,
        motors: &mut OrderedMotors<'_, E, N, Q>,
    ) {
        if self.lease != 0 && now.wrapping_sub(self.heard_at) > self.lease.into() {
            self.lease = 0;
            stop(slave, motors);
        }
    }
}

/// Brakes all moving axes, because the host is silent.
fn stop<E: Control, const N: usize, const Q: usize>(
    slave: &mut Slave<N>,
    motors: &mut OrderedMotors<'_, E, N, Q>,
) {
    let mut bit: Axes = 1;
    for axis in Axis::all() {
        if motors.is_moving(axis) {
            motors.stop(axis);
            slave.stopped(bit, Stop::Timeout);
        }
        bit <<= 1;
    }
}
