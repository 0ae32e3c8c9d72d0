//! Parsers of numbers with a unit, for the calculators: for clap's `value_parser`.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// The parser of a whole number in a range.
pub fn whole_in<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone
where
    T: FromStr + PartialOrd + Display + Clone,
{
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        let (least, most) = (range.start(), range.end());
        number.ok_or_else(|| format!("give a whole number from {least} to {most}"))
    }
}

/// Parses a number with a unit; `units` has the value of each, and a number without a unit has the
/// first. Must be more than 0.
fn measure(text: &str, units: &[(&str, f64)]) -> Result<f64, String> {
    let text = text.trim();
    let end = text.find(|c: char| !matches!(c, '0'..='9' | '.')).unwrap_or(text.len());
    let (number, unit) = (&text[..end], text[end..].trim());
    let names = || units.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let value: f64 =
        number.parse().map_err(|_| format!("give a number, like 12.5, in {}", names()))?;
    let worth = match unit {
        "" => units.first().map_or(1.0, |(_, worth)| *worth),
        unit => match units.iter().find(|(name, _)| *name == unit) {
            Some((_, worth)) => *worth,
            None => return Err(format!("'{unit}' is no unit here: use {}", names())),
        },
    };
    match value * worth {
        value if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("it must be more than 0".into()),
    }
}

/// Microseconds: `80`, `80us`, `1.5ms`.
///
/// # Errors
/// The text of the problem.
pub fn micros(text: &str) -> Result<f64, String> {
    measure(text, &[("us", 1.0), ("µs", 1.0), ("ms", 1e3), ("s", 1e6)])
}

/// Millimetres: `2`, `2mm`, `0.5in`.
///
/// # Errors
/// The text of the problem.
pub fn millimetres(text: &str) -> Result<f64, String> {
    measure(text, &[("mm", 1.0), ("um", 1e-3), ("µm", 1e-3), ("nm", 1e-6), ("in", 25.4)])
}

/// Ampere: `1.7`, `1.7A`, `600mA`.
///
/// # Errors
/// The text of the problem.
pub fn ampere(text: &str) -> Result<f64, String> {
    measure(text, &[("A", 1.0), ("mA", 1e-3)])
}

/// Ohm: `0.1`, `100mOhm`.
///
/// # Errors
/// The text of the problem.
pub fn ohm(text: &str) -> Result<f64, String> {
    measure(text, &[("Ohm", 1.0), ("Ω", 1.0), ("mOhm", 1e-3), ("mΩ", 1e-3)])
}

/// Whole hertz: `16000000`, `16MHz`, `128kHz`.
///
/// # Errors
/// The text of the problem.
pub fn hertz(text: &str) -> Result<u32, String> {
    let hz = measure(text, &[("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6)])?.round();
    match hz >= 1.0 && hz <= f64::from(u32::MAX) {
        true => Ok(hz as u32),
        false => Err("a clock is 1 Hz to 4294.967295 MHz".into()),
    }
}

/// A virtual top or another whole number: `926533`, `0xE2345`.
///
/// # Errors
/// The text of the problem.
pub fn whole(text: &str) -> Result<u32, String> {
    let parsed = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(hex) => u32::from_str_radix(hex, 16),
        None => text.parse(),
    };
    parsed.map_err(|_| "give a whole number below 2^32, like 926533 or 0xE2345".into())
}

/// Microsteps per full step.
///
/// # Errors
/// The text of the problem.
pub fn microsteps(text: &str) -> Result<u32, String> {
    let number = text.strip_prefix("1/").unwrap_or(text);
    match number.parse() {
        Ok(n @ 1..=256) => Ok(n),
        _ => Err("microsteps are 1 to 256, like 16 or 1/16".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_units() {
        assert_eq!(micros("1.5ms"), Ok(1500.0));
        assert_eq!(micros("80"), Ok(80.0));
        assert_eq!(millimetres("2 mm"), Ok(2.0));
        assert_eq!(ampere("600mA"), Ok(0.6));
        assert_eq!(hertz("16MHz"), Ok(16_000_000));
        assert_eq!(hertz("128kHz"), Ok(128_000));
        assert_eq!(whole("0xE2345"), Ok(926_533));
        assert_eq!((microsteps("1/32"), microsteps("4")), (Ok(32), Ok(4)));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for text in ["", "x", "-3", "0", "0.0us", "3 fortnights", "1e3", "1.2.3us"] {
            assert!(micros(text).is_err(), "{text}");
        }
        assert!(hertz("5000MHz").is_err() && hertz("0.2Hz").is_err());
        assert!(whole("-1").is_err() && whole("0x").is_err() && whole("4294967296").is_err());
        assert!(microsteps("0").is_err() && microsteps("1/512").is_err());
    }
}
