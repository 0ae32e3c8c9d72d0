//! The settings that the documentation names, with ranges and defaults.

/// A setting, by its place in `TABLE`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name(usize);

impl std::fmt::Debug for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// Name, least, most, default: the table of the README.
const TABLE: [(&str, u32, u32, u32); COUNT] = [
    ("max-speed", 1, 1_000_000, 1_000_000),
    ("max-accel", 1, 100_000_000, 100_000_000),
    ("idle-ms", 0, 3_600_000, 0),
    ("timeout-ms", 0, 60_000, 0),
    ("enable-ms", 0, 1000, 1),
    ("setup-us", 0, 1000, 1),
    ("hold-us", 0, 1000, 1),
    ("pulse-us", 1, 20, 2),
    ("reverse", 0, 7, 0),
    ("enable-high", 0, 1, 0),
    ("switches", 0, 7, 0),
    ("switch-forward", 0, 7, 0),
    ("switch-high", 0, 7, 0),
    ("law", 0, 1, 1),
];

/// How many there are.
pub const COUNT: usize = 14;

/// The highest top speed, in steps/s.
pub const MAX_SPEED: Name = Name(0);
/// The steepest ramp, in steps/s².
pub const MAX_ACCEL: Name = Name(1);
/// The silence after which moving axes brake, in ms.
pub const TIMEOUT: Name = Name(3);
/// From switching the drivers on to the first step, in ms.
pub const ENABLE: Name = Name(4);
/// DIR before STEP, in µs.
pub const SETUP: Name = Name(5);
/// DIR after STEP, in µs.
pub const HOLD: Name = Name(6);
/// STEP is high, in µs.
pub const PULSE: Name = Name(7);
/// Axes that turn the other way round.
pub const REVERSE: Name = Name(8);
/// The level that switches the drivers on.
pub const ENABLE_HIGH: Name = Name(9);
/// Axes that have a switch.
pub const SWITCHES: Name = Name(10);
/// Axes whose switch ends the travel forward.
pub const SWITCH_FORWARD: Name = Name(11);
/// Axes whose closed switch reads high.
pub const SWITCH_HIGH: Name = Name(12);
/// Whether a jerk bends the ramps.
pub const LAW: Name = Name(13);

/// The setting of this name, on a board that knows S-curves or not.
pub fn named(name: &str, jerk: bool) -> Option<Name> {
    Name::all(jerk).find(|known| known.word() == name)
}

impl Name {
    /// Every setting of a board that knows S-curves or not.
    pub fn all(jerk: bool) -> impl Iterator<Item = Name> {
        (0..COUNT).map(Name).filter(move |name| jerk || *name != LAW)
    }

    /// Its name on the line.
    pub fn word(self) -> &'static str {
        TABLE[self.0].0
    }

    /// Least and most.
    pub fn range(self) -> (u32, u32) {
        (TABLE[self.0].1, TABLE[self.0].2)
    }
}

/// What the settings of a board should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings([u32; COUNT]);

impl Settings {
    /// The defaults of a board, which knows S-curves or not.
    pub fn new(jerk: bool) -> Settings {
        let mut settings = Settings(TABLE.map(|row| row.3));
        settings.set(LAW, jerk.into());
        settings
    }

    /// The number of one.
    pub fn get(&self, name: Name) -> u32 {
        self.0[name.0]
    }

    /// One of a set of axes.
    pub fn has(&self, name: Name, axis: usize) -> bool {
        self.get(name) >> axis & 1 != 0
    }

    /// Sets one.
    pub fn set(&mut self, name: Name, number: u32) {
        self.0[name.0] = number;
    }
}
