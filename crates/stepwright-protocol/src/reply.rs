//! The answers of a slave: one line for each line.

use crate::Refusal;
use crate::answer::{Answer, DIGITS, NOTHING, line, value};
use crate::can::Abilities;
use crate::errors::Errors;
use crate::line::CR;
use crate::number::digits;
use crate::number::halves;
use crate::setting::{self, Listed, Setting, Value};
use crate::stop::Stops;
use crate::text::Decimal;

/// The protocol's version, with which the answer to `?` begins: 0.1.
pub const VERSION: (u8, u8) = (0, 1);

/// The answer to one line.
///
/// ```
/// use stepwright_protocol::Reply;
/// assert_eq!(Reply::Position(-12).bytes().collect::<Vec<u8>>(), b"-12\r");
/// assert_eq!(Reply::parse(b"-12"), Some(Reply::Position(-12)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reply {
    /// `Y`: accepted.
    Yes,
    /// `E`: refused; nothing has changed. A program's [`Fault`](crate::Fault) gives the reason.
    No,
    /// `R`, to F: ready for a new order.
    Ready,
    /// `B`, to F: busy with a travel.
    Busy,
    /// The answer to V: signed decimal steps, without a plus sign.
    Position(i64),
    /// The answer to `?`.
    Info(Info),
    /// The answer to `$` and a name.
    Setting(Value),
    /// The answer to `$`.
    Settings(Listed),
}

/// The slave's information about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Info {
    /// Major and minor version of the protocol.
    pub version: (u8, u8),
    /// The number of axes.
    pub axes: u8,
    /// The fastest rate at which it can step one axis, in steps/s.
    pub max: u32,
    /// Steps that came late since the last `!`.
    pub late: u32,
    /// Lines that were answered E since the last `!`, except empty ones.
    pub refused: u32,
    /// The reason of the last refusal.
    pub last: Option<Refusal>,
    /// Axes whose position is not known: bit 0 is axis 1. Decimal on the line.
    pub uncertain: u8,
    /// Why its axes have stopped; `None` from a firmware older than the word `stop`.
    pub stops: Option<Stops>,
    /// The errors since the last `!`; `None` from a firmware older than the word `errors`.
    pub errors: Option<Errors>,
    /// Its abilities; `None` from a firmware older than the word `can`.
    pub can: Option<Abilities>,
    /// The axes in the setting `switches` whose limit switch is closed now: bit 0 is axis 1.
    /// Decimal on the line. `None` from a firmware older than the word `closed`.
    pub closed: Option<u8>,
}

impl Reply {
    /// The longest answer of this version, to `$`, without its CR, in bytes.
    pub const LONGEST: usize = setting::LONGEST_LIST;

    /// The line to send, including its CR. The answer to `$` has all settings of this build, even
    /// if fewer were [`Listed`].
    pub fn bytes(self) -> impl Iterator<Item = u8> + Clone {
        let mut answer = Answer::NONE;
        let settings = line::SETTINGS;
        match self {
            Reply::Yes => answer.begin(line::YES, 1),
            Reply::No => answer.begin(line::NO, 1),
            Reply::Ready => answer.begin(line::READY, 1),
            Reply::Busy => answer.begin(line::BUSY, 1),
            Reply::Position(_) => answer.begin(line::POSITION, 1),
            Reply::Info(info) => answer.begin(line::INFO, 1 + u8::from(info.stops.is_some())),
            Reply::Setting(value) => answer.begin(settings + value.setting() as u8, 1),
            Reply::Settings(_) => answer.begin(settings, Setting::COUNT as u8),
        }
        let (can, errors, closed) = match self {
            Reply::Info(info) => (info.can, info.errors, info.closed),
            _ => (None, None, None),
        };
        let last = match self {
            Reply::Info(Info { last: Some(last), .. }) => last as u8 + 1,
            _ => 0,
        };
        let raw = core::iter::from_fn(move || {
            answer.next(last, |value, digits| {
                let number = match (self, value) {
                    (Reply::Info(info), value::STOPS..value::ERRORS) => {
                        let letters = info.stops.as_ref().map_or(&[][..], Stops::letters);
                        let letter = letters.get(usize::from(value - value::STOPS));
                        return letter.copied().unwrap_or(NOTHING);
                    }
                    _ => self.number(value),
                };
                digits.set(&mut number.unsigned_abs().to_le_bytes());
                if number < 0 { b'-' } else { DIGITS }
            })
        });
        let can = can.into_iter().flat_map(|can| core::iter::once(b' ').chain(can.line()));
        let errors = errors
            .into_iter()
            .flat_map(|errors| b" errors=".iter().copied().chain(errors.letters()));
        let closed = closed.into_iter().flat_map(|axes| {
            let mut digits = Decimal::NONE;
            digits.set(&mut [axes]);
            let digits = core::iter::from_fn(move || digits.next());
            b" closed=".iter().copied().chain(digits)
        });
        let tail = errors.chain(can).chain(closed);
        raw.filter(|byte| *byte != CR).chain(tail).chain(core::iter::once(CR))
    }

    /// The number that replaces a `#` of the line.
    fn number(&self, value: u8) -> i64 {
        let info = match self {
            Reply::Position(steps) => return *steps,
            Reply::Setting(value) => return value.number().into(),
            Reply::Settings(listed) => {
                return listed.settings.number(value - value::SETTINGS).into();
            }
            Reply::Info(info) => info,
            _ => return 0,
        };
        i64::from(match value {
            value::MAJOR => info.version.0.into(),
            value::MINOR => info.version.1.into(),
            value::AXES => info.axes.into(),
            value::MAX => info.max,
            value::LATE => info.late,
            value::REFUSED => info.refused,
            _ => info.uncertain.into(),
        })
    }

    /// Reads a complete line, without its CR; `None` if it is not an answer.
    ///
    /// It accepts answers of later versions: a position with a plus sign, and in the answer to `?`
    /// further words, fields in another order and unknown reasons. The fields of [`Info`] are
    /// required except those that are an `Option`, and in the answer to `$` every [`Setting`] that
    /// the first firmware had.
    pub fn parse(line: &[u8]) -> Option<Reply> {
        match line {
            b"Y" => Some(Reply::Yes),
            // A program adds its reason.
            b"E" | [b'E', b' ', ..] => Some(Reply::No),
            b"R" => Some(Reply::Ready),
            b"B" => Some(Reply::Busy),
            [b'0'..=b'9' | b'-' | b'+', ..] => position(line).map(Reply::Position),
            _ if line.starts_with(b"stepwright") => Info::parse(line).map(Reply::Info),
            _ if line.contains(&b' ') => Listed::parse(line).map(Reply::Settings),
            _ => Value::parse(line).ok()?.1.map(Reply::Setting),
        }
    }
}

/// Reads a signed number. It counts downwards, so that −2⁶³ needs no exception.
fn position(line: &[u8]) -> Option<i64> {
    let (plus, digits) = match line {
        [b'-', digits @ ..] => (false, digits),
        [b'+', digits @ ..] => (true, digits),
        digits => (true, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0i64;
    for byte in digits {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value.checked_mul(10)?.checked_sub(digit.into())?;
    }
    if plus { value.checked_neg() } else { Some(value) }
}

impl Info {
    fn parse(line: &[u8]) -> Option<Info> {
        let mut words = line.split(|byte| *byte == b' ');
        if words.next()? != b"stepwright" {
            return None;
        }
        let (major, minor) = halves(words.next()?, b'.')?;
        let version = (small(major)?, small(minor)?);
        let (mut axes, mut max, mut late) = (None, None, None);
        let (mut refused, mut last, mut uncertain) = (None, None, None);
        let (mut stops, mut errors, mut can, mut closed) = (None, None, None, None);
        for word in words {
            let Some((key, value)) = halves(word, b'=') else { continue };
            match key {
                b"axes" => axes = Some(small(value)?),
                b"max" => max = Some(digits(value).ok()?),
                b"late" => late = Some(digits(value).ok()?),
                b"refused" => refused = Some(digits(value).ok()?),
                b"last" if value == b"none" => last = Some(None),
                b"last" => last = Some(Some(Refusal::named(value))),
                b"uncertain" => uncertain = Some(small(value)?),
                b"stop" => stops = Some(Stops::parse(value)?),
                b"errors" => errors = Some(Errors::parse(value)),
                b"can" => can = Some(Abilities::parse(value)),
                b"closed" => closed = Some(small(value)?),
                _ => {}
            }
        }
        Some(Info {
            version,
            axes: axes?,
            max: max?,
            late: late?,
            refused: refused?,
            last: last?,
            uncertain: uncertain?,
            stops,
            errors,
            can,
            closed,
        })
    }
}

fn small(text: &[u8]) -> Option<u8> {
    digits(text).ok()?.try_into().ok()
}

#[cfg(test)]
pub(crate) mod tests {
    extern crate std;
    use super::*;
    use crate::can::tests::any_abilities;
    use crate::errors::tests::any_errors;
    use crate::setting::Settings;
    use crate::setting::tests::{any_settings, any_value};
    use crate::stop::tests::any_stops;
    use proptest::prelude::*;
    use std::vec::Vec;

    const INFO: Info = Info {
        version: VERSION,
        axes: 3,
        max: 120_000,
        late: 0,
        refused: 0,
        last: None,
        uncertain: 0,
        stops: None,
        errors: None,
        can: Some(Abilities::OWN),
        closed: Some(5),
    };

    /// The information of a board from before the words `can` and `closed`.
    fn old() -> Info {
        Info { can: None, closed: None, ..INFO }
    }

    fn info() -> impl Strategy<Value = Info> {
        let last = proptest::option::of(proptest::sample::select(&Refusal::ALL[..]));
        let can = proptest::option::of(any_abilities());
        let (stops, errors) =
            (proptest::option::of(any_stops()), proptest::option::of(any_errors()));
        type Numbers = ((u8, u8), u8, u32, u32, u32, u8, Option<u8>);
        (any::<Numbers>(), last, stops, errors, can).prop_map(
            |(numbers, last, stops, errors, can)| {
                let (version, axes, max, late, refused, uncertain, closed) = numbers;
                Info {
                    version,
                    axes,
                    max,
                    late,
                    refused,
                    last,
                    uncertain,
                    stops,
                    errors,
                    can,
                    closed,
                }
            },
        )
    }

    pub(crate) fn any_reply() -> impl Strategy<Value = Reply> {
        let word = &[Reply::Yes, Reply::No, Reply::Ready, Reply::Busy][..];
        prop_oneof![
            proptest::sample::select(word),
            (any::<i64>(), 0u32..64).prop_map(|(n, bits)| Reply::Position(n >> bits)),
            info().prop_map(Reply::Info),
            any_value().prop_map(Reply::Setting),
            any_settings().prop_map(|settings| Reply::Settings(Listed::all(settings))),
        ]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(reply in any_reply()) {
            let line: Vec<u8> = reply.bytes().collect();
            let (cr, line) = line.split_last().unwrap();
            prop_assert_eq!(*cr, b'\r');
            prop_assert!(line.len() <= Reply::LONGEST && !line.contains(&b'\r'));
            prop_assert_eq!(Reply::parse(line), Some(reply));
        }

        #[test]
        fn nothing_panics(line: Vec<u8>, tail: Vec<u8>) {
            let _ = Reply::parse(&line);
            let _ = Reply::parse(&[b"stepwright ", &tail[..]].concat());
            let _ = Reply::parse(&[b"-", &tail[..]].concat());
            let _ = Reply::parse(&[b"idle-ms=1 ", &tail[..]].concat());
        }
    }

    #[test]
    fn the_answer_to_a_question_mark() {
        let line: Vec<u8> = Reply::Info(INFO).bytes().collect();
        assert_eq!(
            core::str::from_utf8(&line),
            Ok("stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 \
                can=jerk,safety,sum closed=5\r")
        );
        // An old board, and a board without any ability.
        let line = b"stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0";
        assert_eq!(Reply::parse(line), Some(Reply::Info(old())));
        let uno = Reply::Info(Info { can: Some(Abilities::NONE), ..old() });
        assert_eq!(Reply::parse(&[line, &b" can=none"[..]].concat()), Some(uno));
    }

    #[test]
    fn the_answers_to_a_dollar() {
        let defaults = Listed::all(Settings::new());
        let line: Vec<u8> = Reply::Settings(defaults).bytes().collect();
        let all = "max-speed=1000000 max-accel=100000000 idle-ms=0 ahead-x=0 ahead-y=0 ahead-z=0 behind-x=0 behind-y=0 behind-z=0 timeout-ms=0 enable-ms=1 \
                   setup-us=1 hold-us=1 pulse-us=2 reverse=0 enable-high=0 switches=0 \
                   switch-forward=0 switch-high=0 debounce-ms=25 law=1 safe-start=0 home-first=0 \
                   estop=0 driver-fault=0 kill-off=0 soft-limits=0\r";
        assert_eq!(core::str::from_utf8(&line), Ok(all));
        let later = all.trim().replace("idle", "new=9 idle");
        assert_eq!(Reply::parse(later.as_bytes()), Some(Reply::Settings(defaults)));
        let missing = all.trim().replace(" pulse-us=2", "");
        assert_eq!(Reply::parse(missing.as_bytes()), None);
        let damaged = all.trim().replace("pulse-us=2", "pulse-us=2x");
        assert_eq!(Reply::parse(damaged.as_bytes()), None);
    }

    #[test]
    fn the_longest_answer_is_known() {
        let last = Refusal::ALL.into_iter().max_by_key(|r| r.name().len());
        let can = Some(Abilities::OWN);
        let (n, b) = (u32::MAX, u8::MAX);
        let most = Info {
            version: (b, b),
            axes: b,
            max: n,
            late: n,
            refused: n,
            last,
            uncertain: b,
            can,
            closed: Some(b),
            stops: Stops::parse(b"ZZZZZZZZ"),
            errors: Some(Errors::parse(b"STKEDRlcg")),
        };
        assert!(Reply::Info(most).bytes().count() < Reply::LONGEST);
        let mut most = Settings::new();
        for setting in Setting::ALL {
            most.set(Value::new(setting, *setting.range().end()).unwrap());
        }
        assert_eq!(Reply::Settings(Listed::all(most)).bytes().count(), Reply::LONGEST + 1);
        assert!(Reply::Position(i64::MIN).bytes().count() < Reply::LONGEST);
    }

    #[test]
    fn a_later_version_is_understood() {
        let line = b"stepwright 12.34 hello max=120000 axes=3 last=asleep late=0 new=x=y refused=0 uncertain=0";
        let later = Info { version: (12, 34), last: Some(Refusal::Other), ..old() };
        assert_eq!(Reply::parse(line), Some(Reply::Info(later)));
        assert_eq!(Reply::parse(b"+12"), Some(Reply::Position(12)));
    }

    #[test]
    fn a_damaged_answer_is_none() {
        for line in [
            &b""[..],
            b"y",
            b"YY",
            b"Y ",
            b"E1",
            b"-",
            b"+",
            b"--1",
            b"1-",
            b"1 ",
            b"0x1",
            b"9223372036854775808",
            b"-9223372036854775809",
            b"stepwright",
            b"stepwright 0.1",
            b"stepwright 0 axes=3 max=1 late=0 refused=0 last=none uncertain=0",
            b"stepwright 0.1 axes=3 max=1 late=0 refused=0 last=none",
            b"stepwright 0.1 axes=3 max=1 late=0 refused=0 last=none uncertain=256",
            b"stepwright 0.1 axes=3 max=x late=0 refused=0 last=none uncertain=0",
            b"pulse-us=0",
            b"pulse=2",
            b"=2",
            b" stepwright 0.1 axes=3 max=1 late=0 refused=0 last=none uncertain=0",
        ] {
            assert_eq!(Reply::parse(line), None, "{line:?}");
        }
        assert_eq!(Reply::parse(b"-9223372036854775808"), Some(Reply::Position(i64::MIN)));
    }
}
