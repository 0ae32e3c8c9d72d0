//! A distance or a position: `4000`, `-90deg`, `1.5turns`, `10mm`.

use std::str::FromStr;

use stepwright::Geometry;

use super::unit::{Kind, Unit};
use super::{Quantity, Rounded, UnitError};

/// A number of steps with its sign, or a length in another unit, as typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DistanceArg {
    backward: bool,
    size: Quantity,
}

impl FromStr for DistanceArg {
    type Err = String;

    fn from_str(text: &str) -> Result<DistanceArg, String> {
        let text = text.trim();
        let (backward, size) = match text.strip_prefix(['-', '\u{2212}']) {
            Some(size) => (true, size),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        let size = match Quantity::parse(size, Kind::Distance) {
            Ok(size) => size,
            Err(_) if !size.starts_with(|c: char| c == '.' || c.is_ascii_digit()) => {
                return Err("it begins with a number, like 4000, -90deg or 10mm".into());
            }
            Err(why) => return Err(why),
        };
        if size.unit == Unit::STEP && !size.number.times(1, 1).exact {
            return Err("a step is the least that a motor moves: give whole steps".into());
        }
        Ok(DistanceArg { backward, size })
    }
}

impl DistanceArg {
    /// Converts to whole steps, rounded once to nearest; `name` is the argument, for the message.
    /// Saturates at ±2⁶³.
    ///
    /// # Errors
    /// [`UnitError::NoMillimetres`]
    pub fn resolve(&self, geometry: &Geometry, name: &str) -> Result<Rounded<i64>, UnitError> {
        let Quantity { text, number, unit } = &self.size;
        let Some(steps) = unit.whole_steps(*number, geometry) else {
            return Err(self.size.no_millimetres(name));
        };
        let size = i64::try_from(steps.value).unwrap_or(i64::MAX);
        Ok(Rounded {
            value: if self.backward { -size } else { size },
            given: if self.backward { format!("-{text}") } else { text.clone() },
            per: Kind::Distance.per(),
            converted: *unit != Unit::STEP,
            exact: steps.exact,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(text: &str) -> Rounded<i64> {
        let geometry = Geometry::new(200).unwrap().travelling_nm(40_000_000).unwrap();
        text.parse::<DistanceArg>().unwrap().resolve(&geometry, "STEPS").unwrap()
    }

    /// 200 steps and 40 mm per turn.
    #[test]
    fn units_come_to_whole_steps() {
        for (text, steps, shown) in [
            ("4000", 4000, "4000 steps"),
            ("-4000", -4000, "-4000 steps"),
            ("+7steps", 7, "7 steps"),
            ("0", 0, "0 steps"),
            ("90deg", 50, "90deg → 50 steps"),
            ("−90°", -50, "-90° → -50 steps"),
            ("1.5 turns", 300, "1.5 turns → 300 steps"),
            ("-2rev", -400, "-2rev → -400 steps"),
            ("10mm", 50, "10mm → 50 steps"),
            ("0.1mm", 1, "0.1mm ≈ 1 step"),
            ("3.14159rad", 100, "3.14159rad ≈ 100 steps"),
            ("1deg", 1, "1deg ≈ 1 step"),
        ] {
            let held = held(text);
            assert_eq!((held.value, held.to_string()), (steps, shown.to_owned()), "{text}");
        }
    }

    /// Rounded once, halves up: 0.9° is half a step.
    #[test]
    fn rounding_is_to_the_nearest() {
        assert_eq!(
            [held("0.89deg").value, held("0.9deg").value, held("-0.9deg").value],
            [0, 1, -1]
        );
        assert_eq!(held("999999999999999999").value, 999_999_999_999_999_999);
        assert_eq!(held("999999999999999999turns").value, i64::MAX);
    }

    #[test]
    fn errors_say_what_is_allowed() {
        for (text, why) in [
            ("", "it begins with a number, like 4000, -90deg or 10mm"),
            ("far", "it begins with a number, like 4000, -90deg or 10mm"),
            ("1.5", "a step is the least that a motor moves: give whole steps"),
            (
                "10cm",
                "'cm' is no unit of a distance: use steps, turns, deg, rad or mm; a bare number is steps",
            ),
            (
                "10mm/s",
                "'mm/s' is a unit of speed; for a distance use steps, turns, deg, rad or mm",
            ),
        ] {
            assert_eq!(text.parse::<DistanceArg>().unwrap_err(), why, "{text}");
        }
        let alone = Geometry::new(200).unwrap();
        assert!("10mm".parse::<DistanceArg>().unwrap().resolve(&alone, "STEPS").is_err());
    }
}
