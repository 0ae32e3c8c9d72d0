//! The settings of a board, with one table of their names, units and ranges.

use crate::BadLine;
use crate::answer::setting_named;
use crate::flash::{Text, flash};
use crate::grammar::{ONE, SET};
use crate::number::halves;
use crate::raw_line::RawLine;

/// Makes [`Setting`] from the table.
macro_rules! settings {
    ($($([$later:ident])? $setting:ident, $name:literal, $unit:literal, $min:literal ..= $max:expr, $default:expr, $help:literal;)*) => {
        /// One setting of a board.
        ///
        /// ```
        /// use stepwright_protocol::Setting;
        /// let pulse = Setting::named(b"pulse-us").unwrap();
        /// assert_eq!(pulse, Setting::Pulse);
        /// assert_eq!((pulse.unit(), pulse.range(), pulse.default()), ("µs", 1..=20, 2));
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum Setting {
            $(#[doc = concat!("`", $name, "`: ", $help)] $setting,)*
        }

        impl Setting {
            /// Every setting, in the order of the answer to `$`.
            pub const ALL: [Setting; Setting::COUNT] =
                [$(Setting::$setting),*];

            /// The number of settings.
            pub const COUNT: usize =
                [$(Setting::$setting),*].len();

            /// Setting `index` of [`Setting::ALL`]. A chip would keep that array in RAM; this is
            /// code.
            pub(crate) fn numbered(index: u8) -> Option<Setting> {
                $({
                    if index == Setting::$setting as u8 {
                        return Some(Setting::$setting);
                    }
                })*
                None
            }

            /// The name, the same on the line, in the command and in files.
            pub const fn name(self) -> &'static str {
                match self { $(Setting::$setting => $name,)* }
            }

            /// Whether every firmware has this setting: some were added later.
            const fn is_everywhere(self) -> bool {
                match self { $(Setting::$setting => concat!("", $(stringify!($later))?).is_empty(),)* }
            }

            /// The unit of the value; empty for a switch or a set of axes.
            pub const fn unit(self) -> &'static str {
                match self { $(Setting::$setting => $unit,)* }
            }

            /// A description in one line.
            pub const fn help(self) -> &'static str {
                match self { $(Setting::$setting => $help,)* }
            }

            /// The smallest value: 0 or 1.
            const fn min(self) -> u32 {
                match self { $(Setting::$setting => $min,)* }
            }

            /// The largest value.
            const fn max(self) -> u32 {
                match self { $(Setting::$setting => $max,)* }
            }

            /// The value on a board that nobody has set up.
            pub const fn default(self) -> u32 {
                match self { $(Setting::$setting => $default,)* }
            }
        }

    };
}

// Settings of four bytes first, then of two, then of one: `place` relies on this order. The first
// firmware had no row that begins with `[later]`. Sets of axes are the sum of 1 for X, 2 for Y, 4
// for Z.
settings! {
    MaxSpeed, "max-speed", "steps/s", 1..=1_000_000, 1_000_000,
        "an order with a higher top speed is refused";
    MaxAccel, "max-accel", "steps/s²", 1..=100_000_000, 100_000_000,
        "an order with a steeper ramp is refused; 100000000: no limit";
    Idle, "idle-ms", "ms", 0..=3_600_000, 0,
        "the drivers are switched off after a rest of this length; 0: never";
    [later] AheadX, "ahead-x", "steps", 0..=1_000_000_000, 0,
        "the soft limit of X, this far forward of 0";
    [later] AheadY, "ahead-y", "steps", 0..=1_000_000_000, 0,
        "the soft limit of Y, this far forward of 0";
    [later] AheadZ, "ahead-z", "steps", 0..=1_000_000_000, 0,
        "the soft limit of Z, this far forward of 0";
    [later] BehindX, "behind-x", "steps", 0..=1_000_000_000, 0,
        "the soft limit of X, this far backward of 0";
    [later] BehindY, "behind-y", "steps", 0..=1_000_000_000, 0,
        "the soft limit of Y, this far backward of 0";
    [later] BehindZ, "behind-z", "steps", 0..=1_000_000_000, 0,
        "the soft limit of Z, this far backward of 0";
    Timeout, "timeout-ms", "ms", 0..=60_000, 0,
        "moving axes brake when no line has come for this time; 0: never";
    Enable, "enable-ms", "ms", 0..=1000, 1,
        "from switching the drivers on to the first step";
    Setup, "setup-us", "µs", 0..=1000, 1,
        "DIR is set this long before a step";
    Hold, "hold-us", "µs", 0..=1000, 1,
        "DIR is kept this long after a step";
    Pulse, "pulse-us", "µs", 1..=20, 2,
        "STEP stays high for this time";
    Reverse, "reverse", "", 0..=7, 0,
        "axes that turn the other way round: 1 X, 2 Y, 4 Z, added up";
    EnableHigh, "enable-high", "", 0..=1, 0,
        "1: a high level switches the drivers on; 0: a low one";
    Switches, "switches", "", 0..=7, 0,
        "axes that have a limit switch: 1 X, 2 Y, 4 Z, added up";
    SwitchForward, "switch-forward", "", 0..=7, 0,
        "axes whose switch ends the travel forward; of the others, backward";
    SwitchHigh, "switch-high", "", 0..=7, 0,
        "axes whose closed switch reads high; of the others, low";
    [later] Debounce, "debounce-ms", "ms", 0..=250, 25,
        "a switch that was closed counts as open once it has been open for this time; 0: at once";
    Law, "law", "", 0..=1, 1,
        "1: a jerk that an order names bends its ramps (S-curve); 0: such an order is refused";
    [later] SafeStart, "safe-start", "", 0..=1, 0,
        "1: after a stop that no order asked for, or K, orders are refused until `!`";
    [later] HomeFirst, "home-first", "", 0..=1, 0,
        "1: G and @ are refused while the position is not known; g is not";
    [later] Emergency, "estop", "", 0..=2, 0,
        "the input of the emergency stop: 0 none; 1 a low level stops; 2 a high one, an opened contact";
    [later] DriverFault, "driver-fault", "", 0..=2, 0,
        "the fault input of the drivers: 0 none; 1 a low level is a fault; 2 a high one";
    [later] KillOff, "kill-off", "", 0..=1, 0,
        "1: K and the inputs that stop everything switch the drivers off too; 0: they stay on";
    [later] SoftLimits, "soft-limits", "", 0..=7, 0,
        "axes that have soft limits: 1 X, 2 Y, 4 Z, added up";
}

/// The lines of the settings, with a `#` for each number.
pub(crate) const NAMES: &[u8] = &names::<NAMES_LENGTH>(b"=#\n");
const NAMES_LENGTH: usize = names_length(3);

const fn names_length(behind: usize) -> usize {
    let (mut length, mut n) = (0, 0);
    while n < Setting::COUNT {
        length += Setting::ALL[n].name().len() + behind;
        n += 1;
    }
    length
}

/// All names, each followed by these bytes.
const fn names<const LENGTH: usize>(behind: &[u8]) -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let (mut to, mut n) = (0, 0);
    while n < Setting::COUNT {
        let name = Setting::ALL[n].name().as_bytes();
        let mut at = 0;
        while at < name.len() + behind.len() {
            bytes[to] = if at < name.len() { name[at] } else { behind[at - name.len()] };
            to += 1;
            at += 1;
        }
        n += 1;
    }
    bytes
}

impl Setting {
    /// The name, read from flash: it takes no RAM.
    pub(crate) fn text(self) -> Text {
        const LENGTH: usize = names_length(1);
        flash!(LENGTH, names(b"\0")).word(self as u8)
    }

    /// The range of its values.
    pub const fn range(self) -> core::ops::RangeInclusive<u32> {
        self.min()..=self.max()
    }

    /// Whether a number is inside the range.
    #[inline(never)]
    pub(crate) fn allows(self, number: u32) -> bool {
        let max = number_at(|at| LARGEST.byte(at.into()).unwrap_or(0), self as u8);
        number <= max && (number != 0 || self.min() == 0)
    }

    /// The setting with this name.
    pub fn named(name: &[u8]) -> Option<Setting> {
        Setting::numbered(setting_named(name)?)
    }
}

/// The largest value of every setting, packed as in [`Settings`].
const LARGEST: Text = flash!(Settings::SIZE, packed(true));
/// The defaults, packed in the same way.
const DEFAULTS: Text = flash!(Settings::SIZE, packed(false));

const fn packed(largest: bool) -> [u8; Settings::SIZE] {
    let mut bytes = [0; Settings::SIZE];
    let mut n = 0;
    while n < Setting::COUNT {
        let setting = Setting::ALL[n];
        let number = if largest { setting.max() } else { setting.default() };
        let (from, length) = place(setting as u8);
        let mut at = 0;
        while at < length {
            bytes[(from + at) as usize] = (number >> (8 * at)) as u8;
            at += 1;
        }
        n += 1;
    }
    bytes
}

/// The position of a setting among the bytes, and the number of its bytes.
const fn place(index: u8) -> (u8, u8) {
    if index < LONG {
        (index.wrapping_mul(4), 4)
    } else if index < SHORT {
        (index.wrapping_mul(2).wrapping_add(2 * LONG), 2)
    } else {
        (index.wrapping_add(2 * LONG + SHORT), 1)
    }
}

/// The settings with an index below this take four bytes each.
const LONG: u8 = longer_than(u16::MAX as u32);
/// The settings with an index below this take at least two bytes.
const SHORT: u8 = longer_than(u8::MAX as u32);

/// The number of settings whose largest value is above this. They come first.
const fn longer_than(largest: u32) -> u8 {
    let (mut count, mut n) = (0, 0);
    while n < Setting::COUNT {
        if Setting::ALL[n].max() > largest {
            assert!(count == n, "long numbers first");
            count += 1;
        }
        n += 1;
    }
    count as u8
}

/// A setting with a value inside its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Value {
    setting: Setting,
    number: u32,
}

impl Value {
    /// `number` for `setting`, or `None` when it is outside the range.
    ///
    /// ```
    /// use stepwright_protocol::{Setting, Value};
    /// assert_eq!(Value::new(Setting::Pulse, 3).unwrap().number(), 3);
    /// assert!(Value::new(Setting::Pulse, 21).is_none());
    /// ```
    pub fn new(setting: Setting, number: u32) -> Option<Value> {
        if setting.allows(number) { Some(Value { setting, number }) } else { None }
    }

    /// The setting.
    pub const fn setting(self) -> Setting {
        self.setting
    }

    /// The value, in the setting's unit.
    pub const fn number(self) -> u32 {
        self.number
    }

    /// Reads `name=number`, or `name` alone.
    pub(crate) fn parse(text: &[u8]) -> Result<(Setting, Option<Value>), BadLine> {
        let mut raw = RawLine::NOTHING;
        raw.read_setting(text)?;
        match raw.letter {
            ONE => Ok((raw.setting, None)),
            SET => Ok((raw.setting, Value::new(raw.setting, raw.number))),
            _ => Err(BadLine::Setting),
        }
    }
}

/// The number of a setting, from the bytes that `byte` returns.
fn number_at(byte: impl Fn(u8) -> u8, index: u8) -> u32 {
    let (from, length) = place(index);
    let mut number = 0;
    let mut at = from.wrapping_add(length);
    while at != from {
        at = at.wrapping_sub(1);
        number = number << 8 | u32::from(byte(at));
    }
    number
}

/// The longest possible list of all settings, in bytes.
pub(crate) const LONGEST_LIST: usize = {
    // `=` and a space after each name, but no space after the last number.
    let (mut length, mut n) = (names_length(2) - 1, 0);
    while n < Setting::COUNT {
        length += 1 + match Setting::ALL[n].max().checked_ilog10() {
            Some(digits) => digits as usize,
            None => 0,
        };
        n += 1;
    }
    length
};

/// The settings that a board has listed. A board with a small chip does not have all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Listed {
    pub(crate) settings: Settings,
    /// A bit for each of [`Setting::ALL`].
    present: u32,
}

impl Listed {
    /// The settings of a board that has all of them.
    pub fn all(settings: Settings) -> Listed {
        const { assert!(Setting::COUNT <= 32) };
        Listed { settings, present: u32::MAX >> (32 - Setting::COUNT as u32) }
    }

    /// The value of a setting; `None` if the board does not have it.
    pub fn get(&self, setting: Setting) -> Option<Value> {
        let present = self.present >> (setting as u32) & 1 != 0;
        present.then(|| self.settings.value(setting))
    }

    /// The values that the board has, in the order of [`Setting::ALL`].
    pub fn values(&self) -> impl Iterator<Item = Value> {
        Setting::ALL.into_iter().filter_map(|setting| self.get(setting))
    }

    /// Reads the answer to `$`. Unknown settings, which a later version may have, are skipped.
    pub(crate) fn parse(line: &[u8]) -> Option<Listed> {
        let mut listed = Listed { settings: Settings::new(), present: 0 };
        for word in line.split(|byte| *byte == b' ') {
            let (name, _) = halves(word, b'=')?;
            let Some(setting) = Setting::named(name) else { continue };
            listed.settings.set(Value::parse(word).ok()?.1?);
            listed.present |= 1u32.wrapping_shl(setting as u32);
        }
        let mut everywhere = Setting::ALL.into_iter().filter(|setting| setting.is_everywhere());
        everywhere.all(|setting| listed.get(setting).is_some()).then_some(listed)
    }
}

/// All settings of a board, each inside its range.
///
/// Stored as the bytes that a board keeps, [`Settings::SIZE`] of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Settings {
    bytes: [u8; Settings::SIZE],
}

impl Default for Settings {
    fn default() -> Settings {
        Settings::new()
    }
}

impl Settings {
    /// The number of bytes.
    pub const SIZE: usize = 2 * LONG as usize + SHORT as usize + Setting::COUNT;

    /// All 0, which is outside the range of some. Overwrite it with [`load`](Settings::load) or
    /// [`reset`](Settings::reset).
    pub const fn blank() -> Settings {
        Settings { bytes: [0; Settings::SIZE] }
    }

    /// The defaults.
    pub fn new() -> Settings {
        let mut settings = Settings::blank();
        settings.reset();
        settings
    }

    /// Sets every setting to its default; true if one had another value.
    #[inline(never)]
    pub fn reset(&mut self) -> bool {
        let mut changed = false;
        for (place, at) in self.bytes.iter_mut().zip(0..) {
            let byte = DEFAULTS.byte(at).unwrap_or(0);
            changed |= *place != byte;
            *place = byte;
        }
        changed
    }

    /// The value of a setting, in its unit.
    pub fn get(&self, setting: Setting) -> u32 {
        self.number(setting as u8)
    }

    /// The lowest byte of the value, which is the whole value of a switch or a set of axes.
    #[inline(always)]
    pub fn byte(&self, setting: Setting) -> u8 {
        let (at, _) = place(setting as u8);
        self.bytes.get(usize::from(at)).copied().unwrap_or(0)
    }

    /// The value of the setting with this index.
    #[inline(never)]
    pub(crate) fn number(&self, index: u8) -> u32 {
        number_at(|at| self.bytes.get(usize::from(at)).copied().unwrap_or(0), index)
    }

    /// The setting with its value.
    pub fn value(&self, setting: Setting) -> Value {
        Value { setting, number: self.get(setting) }
    }

    /// Sets a setting; true if it had another value before.
    pub fn set(&mut self, value: Value) -> bool {
        self.put(value.setting as u8, value.number)
    }

    /// Sets the setting with this index to a number inside its range.
    pub(crate) fn put(&mut self, index: u8, mut number: u32) -> bool {
        let (from, length) = place(index);
        let mut changes = false;
        for at in from..from.wrapping_add(length) {
            if let Some(byte) = self.bytes.get_mut(usize::from(at)) {
                changes |= *byte != number as u8;
                *byte = number as u8;
            }
            number >>= 8;
        }
        changes
    }

    /// The bytes to store. Their order and meaning may change with the version of this crate: store
    /// [`Settings::LAYOUT`] beside them.
    pub fn bytes(&self) -> &[u8; Settings::SIZE] {
        &self.bytes
    }

    /// The version of the bytes' meaning.
    pub const LAYOUT: u8 = 5;

    /// The settings that were stored as these bytes; `None` if a value is
    /// outside its range.
    pub fn from_bytes(bytes: [u8; Settings::SIZE]) -> Option<Settings> {
        let settings = Settings { bytes };
        settings.is_valid().then_some(settings)
    }

    /// Loads stored settings, whose bytes `byte` returns one after the other. Loads the defaults if
    /// a value is outside its range.
    pub fn load(&mut self, mut byte: impl FnMut() -> u8) {
        for place in &mut self.bytes {
            *place = byte();
        }
        if !self.is_valid() {
            self.reset();
        }
    }

    /// Whether every value is inside its range.
    fn is_valid(&self) -> bool {
        let mut index = 0;
        while let Some(setting) = Setting::numbered(index) {
            if !setting.allows(self.number(index)) {
                return false;
            }
            index = index.wrapping_add(1);
        }
        true
    }
}

#[cfg(test)]
pub(crate) mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    pub(crate) fn any_value() -> impl Strategy<Value = Value> {
        // Every length of number, and both ends.
        let setting = proptest::sample::select(&Setting::ALL[..]);
        (setting, any::<u32>(), 0u32..32).prop_map(|(setting, number, bits)| {
            Value::new(setting, (number >> bits).clamp(setting.min(), setting.max())).unwrap()
        })
    }

    pub(crate) fn any_settings() -> impl Strategy<Value = Settings> {
        proptest::collection::vec(any_value(), 0..30).prop_map(|values| {
            let mut settings = Settings::new();
            for value in values {
                settings.set(value);
            }
            settings
        })
    }

    #[test]
    fn every_setting_has_its_own_name_and_a_default_inside_its_range() {
        for (n, setting) in Setting::ALL.into_iter().enumerate() {
            assert_eq!(Setting::numbered(n as u8), Some(setting));
            assert_eq!(Setting::named(setting.name().as_bytes()), Some(setting));
            assert!(setting.name().bytes().all(|b| b.is_ascii_lowercase() || b == b'-'));
            assert!(setting.range().contains(&setting.default()), "{setting:?}");
            assert!(!setting.help().is_empty());
            assert_eq!(Settings::new().get(setting), setting.default());
            // The word that can stand in place of a name.
            assert_ne!(setting.name(), "reset");
        }
        assert_eq!(Setting::numbered(Setting::COUNT as u8), None);
        assert_eq!(Setting::named(b""), None);
    }

    #[test]
    fn the_largest_values_fit_side_by_side() {
        let mut settings = Settings::new();
        for setting in Setting::ALL {
            let largest = Value::new(setting, *setting.range().end()).unwrap();
            settings.set(largest);
        }
        for setting in Setting::ALL {
            assert_eq!(settings.get(setting), *setting.range().end(), "{setting:?}");
            assert_eq!(Value::new(setting, setting.range().end() + 1), None);
        }
        assert_eq!(Settings::from_bytes(*settings.bytes()), Some(settings));
        assert_eq!(Settings::from_bytes([0xFF; Settings::SIZE]), None);
        // A pulse of 0 µs and a speed of 0 are outside their ranges.
        assert_eq!(Settings::from_bytes([0; Settings::SIZE]), None);
    }

    #[test]
    fn setting_the_same_again_changes_nothing() {
        let mut settings = Settings::new();
        let value = Value::new(Setting::Idle, 70_000).unwrap();
        assert!(settings.set(value));
        assert!(!settings.set(value));
        assert_eq!(settings.get(Setting::Idle), 70_000);
    }

    #[test]
    fn what_is_wrong_with_a_value_is_told_apart() {
        let seven = Value::new(Setting::Pulse, 7);
        assert_eq!(Value::parse(b"pulse-us=007"), Ok((Setting::Pulse, seven)));
        assert_eq!(Value::parse(b"pulse-us"), Ok((Setting::Pulse, None)));
        for (text, bad) in [
            (&b""[..], BadLine::Setting),
            (b"=2", BadLine::Setting),
            (b"pulse=2", BadLine::Setting),
            (b"pulse-us=", BadLine::Unknown),
            (b"pulse-us=+2", BadLine::Unknown),
            (b"pulse-us=2=2", BadLine::Unknown),
            (b"pulse-us=0", BadLine::Range),
            (b"pulse-us=21", BadLine::Range),
            (b"pulse-us=4294967298", BadLine::Range),
        ] {
            assert_eq!(Value::parse(text), Err(bad), "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn settings_leave_each_other_alone(settings in any_settings(), value in any_value()) {
            let mut changed = settings;
            changed.set(value);
            for setting in Setting::ALL {
                let before = settings.get(setting);
                let now = if setting == value.setting() { value.number() } else { before };
                prop_assert_eq!(changed.get(setting), now);
            }
        }
    }
}
