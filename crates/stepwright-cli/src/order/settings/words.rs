//! Parses settings and values as a user writes them.

use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};
use std::ffi::OsStr;
use stepwright_protocol::{Setting, Value};

/// The range of a setting: `1 to 20 µs`.
pub fn allowed(setting: Setting) -> String {
    let (from, to) = (setting.range().start().to_string(), setting.range().end().to_string());
    format!("{from} to {to} {}", setting.unit()).trim_end().to_owned()
}

/// The setting with this name. The error lists the names.
pub fn setting(name: &str) -> Result<Setting, String> {
    Setting::named(name.as_bytes()).ok_or_else(|| {
        let names: Vec<_> = Setting::ALL.iter().map(|setting| setting.name()).collect();
        format!("there is no setting {name:?}; there are {}", names.join(", "))
    })
}

/// Parses the value of a setting. The error gives the range.
pub fn value(setting: Setting, number: &str) -> Result<Value, String> {
    // As in TOML: a plus sign and underscores between digits.
    let digits = number.strip_prefix('+').unwrap_or(number);
    let parts = digits.split('_');
    let plain = parts
        .clone()
        .all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()));
    let parsed = if plain { parts.collect::<String>().parse().ok() } else { None };
    parsed.and_then(|number| Value::new(setting, number)).ok_or_else(|| {
        format!("{} is {}, a whole number, and not {number:?}", setting.name(), allowed(setting))
    })
}

/// The description of a setting in help texts and files.
pub fn about(setting: Setting) -> String {
    format!("{} ({}, default {})", setting.help(), allowed(setting), setting.default())
}

/// Reads a name, and lets shells complete it.
#[derive(Clone)]
pub struct NameParser;

/// Reads `NAME=VALUE`, and lets shells complete the name.
#[derive(Clone)]
pub struct ValueParser;

impl TypedValueParser for NameParser {
    type Value = Setting;

    fn parse_ref(&self, cmd: &Command, arg: Option<&Arg>, text: &OsStr) -> Result<Setting, Error> {
        setting(&text.to_string_lossy()).map_err(|what| invalid(cmd, arg, text, &what))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |setting: Setting| PossibleValue::new(setting.name()).help(about(setting));
        Some(Box::new(Setting::ALL.into_iter().map(value)))
    }
}

impl TypedValueParser for ValueParser {
    type Value = Value;

    fn parse_ref(&self, cmd: &Command, arg: Option<&Arg>, text: &OsStr) -> Result<Value, Error> {
        let words = text.to_string_lossy();
        let parsed = match words.split_once('=') {
            None => Err("write NAME=VALUE, for example pulse-us=3".to_owned()),
            Some((name, number)) => setting(name).and_then(|setting| value(setting, number)),
        };
        parsed.map_err(|what| invalid(cmd, arg, text, &what))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        // Only for help and completions: they contain no values.
        let value = |setting: Setting| {
            PossibleValue::new(format!("{}=", setting.name())).help(about(setting))
        };
        Some(Box::new(Setting::ALL.into_iter().map(value)))
    }
}

fn invalid(cmd: &Command, arg: Option<&Arg>, text: &OsStr, what: &str) -> Error {
    let place = arg.map(ToString::to_string).unwrap_or_default();
    let text = text.to_string_lossy();
    let message = format!("invalid value '{text}' for '{place}': {what}\n");
    Error::raw(ErrorKind::ValueValidation, message).with_cmd(cmd)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_toml() {
        let speed = |text| value(Setting::MaxSpeed, text).map(Value::number);
        assert_eq!(speed("20_000"), Ok(20_000));
        assert_eq!(speed("+5"), Ok(5));
        for wrong in ["", "0", "1000001", "-5", "1.5", "0x10", "_5", "5_", "5 ", "99999999999"] {
            let error = speed(wrong).unwrap_err();
            assert!(error.contains("1 to 1000000 steps/s"), "{wrong}: {error}");
        }
    }

    #[test]
    fn what_is_allowed_is_said() {
        assert_eq!(allowed(Setting::Pulse), "1 to 20 µs");
        assert_eq!(allowed(Setting::Reverse), "0 to 7");
        assert!(setting("pulse").unwrap_err().contains("pulse-us, reverse,"));
    }
}
