//! The settings of the documentation with their ranges and defaults.

use crate::story::Can;

/// A setting, by its index in `TABLE`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name(usize);

impl std::fmt::Debug for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// Name, least, most, default, and the boards that have it. Kept apart from the protocol's table.
const TABLE: [(&str, u32, u32, u32, On); COUNT] = [
    ("max-speed", 1, 1_000_000, 1_000_000, On::Every),
    ("max-accel", 1, 100_000_000, 100_000_000, On::Every),
    ("idle-ms", 0, 3_600_000, 0, On::Every),
    ("timeout-ms", 0, 60_000, 0, On::Every),
    ("enable-ms", 0, 1000, 1, On::Every),
    ("setup-us", 0, 1000, 1, On::Every),
    ("hold-us", 0, 1000, 1, On::Every),
    ("pulse-us", 1, 20, 2, On::Every),
    ("reverse", 0, 7, 0, On::Every),
    ("enable-high", 0, 1, 0, On::Every),
    ("switches", 0, 7, 0, On::Every),
    ("switch-forward", 0, 7, 0, On::Every),
    ("switch-high", 0, 7, 0, On::Every),
    ("law", 0, 1, 1, On::Jerk),
    ("ahead-x", 0, 1_000_000_000, 0, On::Every),
    ("ahead-y", 0, 1_000_000_000, 0, On::Every),
    ("ahead-z", 0, 1_000_000_000, 0, On::Every),
    ("behind-x", 0, 1_000_000_000, 0, On::Every),
    ("behind-y", 0, 1_000_000_000, 0, On::Every),
    ("behind-z", 0, 1_000_000_000, 0, On::Every),
    ("soft-limits", 0, 7, 0, On::Every),
    ("safe-start", 0, 1, 0, On::Every),
    ("home-first", 0, 1, 0, On::Every),
    ("estop", 0, 2, 0, On::Every),
    ("driver-fault", 0, 2, 0, On::Every),
    ("kill-off", 0, 1, 0, On::Every),
    ("debounce-ms", 0, 250, 25, On::Every),
];

/// The boards that have a setting.
#[derive(Clone, Copy, PartialEq, Eq)]
enum On {
    Every,
    Jerk,
}

/// The number of settings.
pub const COUNT: usize = 27;

/// The highest top speed, in steps/s.
pub const MAX_SPEED: Name = Name(0);
/// The steepest ramp, in steps/s².
pub const MAX_ACCEL: Name = Name(1);
/// The silence in ms after which moving axes brake.
pub const TIMEOUT: Name = Name(3);
/// The time in ms from switching the drivers on to the first step.
pub const ENABLE: Name = Name(4);
/// The time of DIR before STEP, in µs.
pub const SETUP: Name = Name(5);
/// The time of DIR after STEP, in µs.
pub const HOLD: Name = Name(6);
/// The time of STEP high, in µs.
pub const PULSE: Name = Name(7);
/// The axes with reversed direction.
pub const REVERSE: Name = Name(8);
/// The level that switches the drivers on.
pub const ENABLE_HIGH: Name = Name(9);
/// The axes with a switch.
pub const SWITCHES: Name = Name(10);
/// The axes whose switch ends the travel forward.
pub const SWITCH_FORWARD: Name = Name(11);
/// The axes whose closed switch reads high.
pub const SWITCH_HIGH: Name = Name(12);
/// Whether ramps have a limited jerk.
pub const LAW: Name = Name(13);
/// The soft limits forward of 0 by axis.
pub const AHEAD: [Name; 3] = [Name(14), Name(15), Name(16)];
/// The soft limits backward of 0 by axis.
pub const BEHIND: [Name; 3] = [Name(17), Name(18), Name(19)];
/// The axes with soft limits.
pub const SOFT_LIMITS: Name = Name(20);
/// Whether orders need `!` after a stop.
pub const SAFE_START: Name = Name(21);
/// Whether G and @ need a known position.
pub const HOME_FIRST: Name = Name(22);
/// The emergency stop: none, low level, high level.
pub const EMERGENCY: Name = Name(23);
/// The driver fault: none, low level, high level.
pub const DRIVER_FAULT: Name = Name(24);
/// Whether a stop at once switches the drivers off.
pub const KILL_OFF: Name = Name(25);
/// The time in ms for which a switch that has opened counts as closed.
pub const DEBOUNCE: Name = Name(26);

/// The setting of this name on a board with these features.
pub fn named(name: &str, can: Can) -> Option<Name> {
    Name::all(can).find(|known| known.word() == name)
}

impl Name {
    /// All settings of a board with these features.
    pub fn all(can: Can) -> impl Iterator<Item = Name> {
        (0..COUNT).map(Name).filter(move |name| match TABLE[name.0].4 {
            On::Every => true,
            On::Jerk => can.jerk,
        })
    }

    /// The name on the line.
    pub fn word(self) -> &'static str {
        TABLE[self.0].0
    }

    /// The least and the greatest value.
    pub fn range(self) -> (u32, u32) {
        (TABLE[self.0].1, TABLE[self.0].2)
    }
}

/// The expected settings of a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings([u32; COUNT]);

impl Settings {
    /// The defaults of a board with these features. Missing settings are off.
    pub fn new(can: Can) -> Settings {
        let mut settings = Settings([0; COUNT]);
        Name::all(can).for_each(|name| settings.set(name, TABLE[name.0].3));
        settings
    }

    /// The value of a setting.
    pub fn get(&self, name: Name) -> u32 {
        self.0[name.0]
    }

    /// Whether a set of axes has this axis.
    pub fn has(&self, name: Name, axis: usize) -> bool {
        self.get(name) >> axis & 1 != 0
    }

    /// Changes a setting.
    pub fn set(&mut self, name: Name, number: u32) {
        self.0[name.0] = number;
    }
}
