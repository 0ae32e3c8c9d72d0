//! The settings `$0` to `$152`: ranges, defaults and formats.

use std::fmt::Write;

/// The values that a setting can have.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// 0 or 1.
    Switch,
    /// Whole numbers from 0 to this.
    Whole(u16),
    /// Numbers from 0 to 10⁶, written with three digits after the point.
    Number,
    /// Numbers above 0, up to 10⁶, in the same format.
    Positive,
}

/// A setting of the table.
struct Row {
    number: u8,
    kind: Kind,
    /// The default value.
    default: f64,
}

const fn row(number: u8, kind: Kind, default: f64) -> Row {
    Row { number, kind, default }
}

/// All settings in the order in which `$$` prints them.
///
/// `$140` to `$142` are not grbl's: how much the speed of an axis may jump at a corner, which is the
/// start speed of its motor. Nor are `$150` to `$152`: the limit of its jerk in mm/s³; 0 is none.
const TABLE: [Row; 40] = [
    row(0, Kind::Whole(255), 10.0),
    row(1, Kind::Whole(255), 25.0),
    row(2, Kind::Whole(255), 0.0),
    row(3, Kind::Whole(255), 0.0),
    row(4, Kind::Switch, 0.0),
    row(5, Kind::Switch, 0.0),
    row(6, Kind::Switch, 0.0),
    row(10, Kind::Whole(255), 1.0),
    row(11, Kind::Number, 0.0),
    row(12, Kind::Number, 0.002),
    row(13, Kind::Switch, 0.0),
    row(20, Kind::Switch, 0.0),
    row(21, Kind::Switch, 0.0),
    row(22, Kind::Switch, 0.0),
    row(23, Kind::Whole(255), 0.0),
    row(24, Kind::Positive, 25.0),
    row(25, Kind::Positive, 500.0),
    row(26, Kind::Whole(65_535), 250.0),
    row(27, Kind::Positive, 1.0),
    row(30, Kind::Number, 1_000.0),
    row(31, Kind::Number, 0.0),
    row(32, Kind::Switch, 0.0),
    row(100, Kind::Positive, 250.0),
    row(101, Kind::Positive, 250.0),
    row(102, Kind::Positive, 250.0),
    row(110, Kind::Positive, 1_000.0),
    row(111, Kind::Positive, 1_000.0),
    row(112, Kind::Positive, 1_000.0),
    row(120, Kind::Positive, 50.0),
    row(121, Kind::Positive, 50.0),
    row(122, Kind::Positive, 50.0),
    row(130, Kind::Number, 200.0),
    row(131, Kind::Number, 200.0),
    row(132, Kind::Number, 200.0),
    row(140, Kind::Positive, 100.0),
    row(141, Kind::Positive, 100.0),
    row(142, Kind::Positive, 100.0),
    row(150, Kind::Number, 0.0),
    row(151, Kind::Number, 0.0),
    row(152, Kind::Number, 0.0),
];

/// The largest value of a number with a point.
const MOST: f64 = 1e6;

/// The least value of a [`Positive`](Kind::Positive) number.
const LEAST: f64 = 0.001;

/// Why a setting was not changed, with grbl's error number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingFault {
    /// 2: the value is not a number, or outside the setting's range.
    Number,
    /// 3: the setting does not exist.
    Unknown,
    /// 4: the value is negative.
    Negative,
    /// 6: the step pulse is shorter than 3 µs.
    ShortPulse,
    /// 10: soft limits need homing.
    NeedsHoming,
}

impl SettingFault {
    /// The error number of grbl 1.1.
    pub const fn number(self) -> u8 {
        match self {
            SettingFault::Number => 2,
            SettingFault::Unknown => 3,
            SettingFault::Negative => 4,
            SettingFault::ShortPulse => 6,
            SettingFault::NeedsHoming => 10,
        }
    }
}

/// The settings of a machine.
///
/// ```
/// use stepwright_grbl::GrblSettings;
/// let mut settings = GrblSettings::default();
/// settings.set(100, 80.0)?;
/// assert_eq!(settings.line(100).as_deref(), Some("$100=80.000"));
/// assert_eq!(settings.set(101, -1.0).unwrap_err().number(), 4);
/// # Ok::<(), stepwright_grbl::SettingFault>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GrblSettings([f64; TABLE.len()]);

impl Default for GrblSettings {
    fn default() -> GrblSettings {
        GrblSettings(TABLE.map(|row| row.default))
    }
}

impl GrblSettings {
    fn place(number: u8) -> Option<usize> {
        TABLE.iter().position(|row| row.number == number)
    }

    /// The value of a setting; 0 for an unknown setting.
    pub fn get(&self, number: u8) -> f64 {
        GrblSettings::place(number).map_or(0.0, |place| self.0[place])
    }

    /// Whether a setting is on.
    pub fn is_on(&self, number: u8) -> bool {
        self.get(number) != 0.0
    }

    /// The values of a setting for X, Y and Z; `number` is that of X.
    pub fn axes(&self, number: u8) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.get(number.saturating_add(axis)))
    }

    /// Whether a setting is a mask that has the bit of this axis.
    pub fn has(&self, number: u8, axis: usize) -> bool {
        (self.get(number) as u16).checked_shr(axis as u32).unwrap_or(0) & 1 != 0
    }

    /// Changes a setting.
    ///
    /// # Errors
    /// [`SettingFault`]; nothing is changed then.
    pub fn set(&mut self, number: u8, value: f64) -> Result<(), SettingFault> {
        let place = GrblSettings::place(number).ok_or(SettingFault::Unknown)?;
        if value < 0.0 {
            return Err(SettingFault::Negative);
        }
        let whole = |most: f64| value <= most && value.fract() == 0.0;
        let good = match TABLE[place].kind {
            Kind::Switch => whole(1.0),
            Kind::Whole(most) => whole(most.into()),
            Kind::Number => value <= MOST,
            Kind::Positive => (LEAST..=MOST).contains(&value),
        };
        match number {
            _ if !good => return Err(SettingFault::Number),
            0 if value < 3.0 => return Err(SettingFault::ShortPulse),
            20 if value != 0.0 && !self.is_on(22) => return Err(SettingFault::NeedsHoming),
            // Without homing, soft limits are switched off.
            22 if value == 0.0 => self.put(20, 0.0),
            _ => {}
        }
        // Makes −0 to 0.
        self.0[place] = value + 0.0;
        Ok(())
    }

    fn put(&mut self, number: u8, value: f64) {
        if let Some(place) = GrblSettings::place(number) {
            self.0[place] = value;
        }
    }

    /// A setting as in `$$`; `None` for an unknown setting.
    pub fn line(&self, number: u8) -> Option<String> {
        let place = GrblSettings::place(number)?;
        let mut line = format!("${number}=");
        let value = self.0[place];
        let written = match TABLE[place].kind {
            Kind::Switch | Kind::Whole(_) => write!(line, "{value:.0}"),
            Kind::Number | Kind::Positive => write!(line, "{value:.3}"),
        };
        written.ok().map(|()| line)
    }

    /// The numbers of all settings, in order.
    pub fn numbers() -> impl Iterator<Item = u8> {
        TABLE.iter().map(|row| row.number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_setting_does_not_take_is_refused() {
        let mut settings = GrblSettings::default();
        for (number, value, fault) in [
            (7, 1.0, SettingFault::Unknown),
            (0, 2.0, SettingFault::ShortPulse),
            (4, 2.0, SettingFault::Number),
            (3, 0.5, SettingFault::Number),
            (3, 256.0, SettingFault::Number),
            (100, 0.0, SettingFault::Number),
            (100, f64::NAN, SettingFault::Number),
            (100, 1e7, SettingFault::Number),
            (110, -5.0, SettingFault::Negative),
            (20, 1.0, SettingFault::NeedsHoming),
        ] {
            assert_eq!(settings.set(number, value), Err(fault), "${number}={value}");
        }
        assert_eq!(settings, GrblSettings::default());
    }

    #[test]
    fn soft_limits_go_with_homing() {
        let mut settings = GrblSettings::default();
        settings.set(22, 1.0).unwrap();
        settings.set(20, 1.0).unwrap();
        settings.set(22, 0.0).unwrap();
        assert!(!settings.is_on(20));
    }
}
