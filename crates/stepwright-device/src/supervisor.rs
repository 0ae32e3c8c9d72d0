//! The supervisor: drivers, switches, the silent host.

use stepwright::drive::Axes;
use stepwright::{Axis, Control, OrderedMotors, Ticks};
use stepwright_protocol::{Setting, Settings, Slave, Stop};

use crate::contacts::Contacts;
use crate::panel::BoardIo;
use crate::reset::Mark;
use crate::store::Store;

/// Where closed switches lie.
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

/// What a device keeps in mind besides its motors and its line.
pub(crate) struct Supervisor {
    pub(crate) settings: Settings,
    pub(crate) store: Store,
    /// Whether the drivers are on.
    enabled: bool,
    /// Whether the host was silent for too long.
    silent: bool,
    /// The silence that the host has asked to be stopped after, in ms; 0: none.
    pub(crate) lease: u16,
    /// The switches that were closed lately.
    contacts: Contacts,
    /// How long the drivers that were switched on are not to be used yet, in
    /// ms.
    settling: u16,
    /// When a motor moved last, in ms.
    moved_at: u32,
    /// When the last line was complete, in ms.
    heard_at: u32,
    /// The present, as of the last look at it, in ms, modulo 256.
    now: u8,
}

impl Supervisor {
    /// Before power-up.
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

    /// As at power-up: the settings are those of the memory, the drivers off.
    /// True if the position is unknown.
    pub(crate) fn begin(&mut self, panel: &mut impl BoardIo) -> bool {
        self.store.find(panel, &mut self.settings);
        self.receive(panel);
        let doubts = panel.reset().doubts(panel.mark());
        panel.set_mark(if doubts { Mark::MOVED } else { Mark::NONE });
        doubts
    }

    /// A set of axes among the settings.
    #[inline(always)]
    fn axes(&self, setting: Setting) -> Axes {
        self.settings.byte(setting)
    }

    /// Has the board, the engine and the pins follow the settings.
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

    /// A setting in microseconds, in ticks.
    #[inline(never)]
    fn ticks(&self, panel: &impl BoardIo, setting: Setting) -> Ticks {
        panel.ticks(self.settings.get(setting) as u16)
    }

    /// Sets the pin that enables the drivers.
    #[cfg_attr(target_arch = "avr", inline(never))]
    fn set_enable(&self, panel: &mut impl BoardIo) {
        panel.set_enable(self.enabled == (self.settings.byte(Setting::EnableHigh) != 0));
    }

    /// Axes whose switch is closed.
    pub(crate) fn closed(&self, panel: &impl BoardIo) -> Axes {
        !(panel.switches() ^ self.axes(Setting::SwitchHigh)) & self.axes(Setting::Switches)
    }

    /// Axes that may not travel forward now, and those that may not backward:
    /// their switch is closed, or was so lately.
    pub(crate) fn blocked(&self, panel: &impl BoardIo) -> Blocked {
        let closed = self.closed(panel);
        let closed = closed | self.contacts.held() & self.axes(Setting::Switches);
        let forward = self.axes(Setting::SwitchForward);
        Blocked { forward: closed & forward, backward: closed & !forward }
    }

    /// From switching the drivers on to the first step, in ms, and one more:
    /// the present millisecond has begun already.
    fn delay(&self) -> u16 {
        match self.settings.get(Setting::Enable) as u16 {
            0 => 0,
            delay => delay.wrapping_add(1),
        }
    }

    /// A travel begins: how long it has to wait for the drivers.
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

    /// Everything was stopped at once: the drivers go off if they are to. What moved is at
    /// rest, which is the last that they can tell.
    pub(crate) fn killed(&mut self, panel: &mut impl BoardIo) {
        if self.enabled && self.settings.byte(Setting::KillOff) != 0 {
            panel.set_mark(Mark::MOVED);
            self.enabled = false;
            self.set_enable(panel);
        }
    }

    /// A line is complete, whatever it says: the host is there.
    pub(crate) fn receive(&mut self, panel: &impl BoardIo) {
        self.heard_at = panel.millis();
        self.silent = false;
    }

    /// Milliseconds since the last look at the time, modulo 256.
    #[inline(always)]
    fn passed(&self, panel: &impl BoardIo) -> u8 {
        (panel.millis() as u8).wrapping_sub(self.now)
    }

    /// Looks after everything once.
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
            // One at a time, for they mostly are one: a rest may be longer.
            motors.pass(panel.ticks(1000));
            self.check_time(slave, motors, panel);
        }
    }

    /// Stops what moves towards a closed switch.
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

    /// A millisecond has passed, or some.
    fn check_time<E: Control, const N: usize, const Q: usize>(
        &mut self,
        slave: &mut Slave<N>,
        motors: &mut OrderedMotors<'_, E, N, Q>,
        panel: &mut impl BoardIo,
    ) {
        let busy = motors.any_moving();
        let now = panel.millis();
        if busy {
            self.moved_at = now;
        } else if self.enabled {
            // There has been a travel.
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

    /// A lease ends with the first silence of its length, and so does all motion: the
    /// next host may know nothing of it.
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

/// Brakes what moves, for the host is silent.
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
