//! The lines that a master sends: one command per line.

use core::fmt::{self, Write};

use stepwright::Speed;

use crate::Refusal;
use crate::flash::text;
pub use crate::grammar::Command;
use crate::line::CR;
use crate::number::{MilliSpeed, TopSpeed};
use crate::raw_line::RawLine;
use crate::text::{Bytes, Piece, Pieces};

impl Command {
    /// The longest line that is understood, without its CR, in bytes. Every command fits, with room
    /// for some leading zeros.
    pub const LONGEST: usize = 24;

    /// Reads a complete line, without its CR.
    ///
    /// # Errors
    /// [`BadLine`] for everything that is not exactly a line of the grammar. Spaces and the other
    /// case of a letter are not allowed.
    pub fn parse(line: &[u8]) -> Result<Command, BadLine> {
        let mut raw = RawLine::NOTHING;
        raw.read(line).map_err(|refusal| match refusal {
            _ if line.is_empty() => BadLine::Empty,
            refusal => refusal.into(),
        })?;
        Command::of(&raw)
    }

    /// The line for a top speed: `t`, or `m` where the speed is not a whole number of steps/s.
    /// `None` for a standstill.
    ///
    /// ```
    /// # use stepwright_protocol::Command;
    /// # use stepwright::Speed;
    /// let line = |millis| Command::top(Speed::from_millisteps(millis).unwrap());
    /// assert_eq!(line(500_000).unwrap().to_string(), "t500");
    /// assert_eq!(line(4).unwrap().to_string(), "m4");
    /// assert!(line(0).is_none());
    /// ```
    pub fn top(speed: Speed) -> Option<Command> {
        let millis = speed.millisteps();
        let whole = if millis.is_multiple_of(1000) { TopSpeed::new(millis / 1000) } else { None };
        whole.map(Command::Top).or_else(|| MilliSpeed::new(millis).map(Command::Milli))
    }

    /// The line to send, its CR included, at most 21 bytes.
    pub fn bytes(self) -> Bytes<Command> {
        Bytes::new(self)
    }
}

impl Pieces for Command {
    fn piece(&self, n: u8) -> Option<Piece> {
        let Some(at) = n.checked_sub(1) else { return Some(Piece::Text(self.letters())) };
        // The CR follows the last piece of the argument.
        let before = at.checked_sub(1).is_none_or(|last| self.argument(last).is_some());
        self.argument(at).or_else(|| before.then_some(Piece::Text(text!("\r"))))
    }
}

/// The line for a person to read, without its CR.
impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.bytes().filter(|byte| *byte != CR).try_for_each(|byte| f.write_char(byte.into()))
    }
}

/// The reason why a line is not a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BadLine {
    /// Nothing before the CR.
    Empty,
    /// Not a line of the grammar.
    Unknown,
    /// A line of the grammar with a number outside its range.
    Range,
    /// More than [`Command::LONGEST`] bytes.
    Long,
    /// `$` and a name that no setting has.
    Setting,
    /// A byte of the line was lost or damaged.
    Garbled,
}

/// Converts the reason of a refusal.
impl From<Refusal> for BadLine {
    fn from(refusal: Refusal) -> BadLine {
        match refusal {
            Refusal::Range => BadLine::Range,
            Refusal::Setting => BadLine::Setting,
            _ => BadLine::Unknown,
        }
    }
}

impl fmt::Display for BadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            BadLine::Empty => "an empty line",
            BadLine::Unknown => "not a line of this protocol",
            BadLine::Range => "a number outside its range",
            BadLine::Long => "a line of more than 24 bytes",
            BadLine::Setting => "no setting has this name",
            BadLine::Garbled => "a line with a lost byte",
        })
    }
}

impl core::error::Error for BadLine {}

#[cfg(test)]
pub(crate) mod tests {
    extern crate std;
    use super::*;
    use crate::setting::tests::any_value;
    use crate::{AxisId, Direction, Distance, Selection, Tens};
    use proptest::prelude::*;
    use std::string::ToString;
    use std::vec;
    use std::vec::Vec;

    fn whole<const MIN: u32, const MAX: u32>() -> impl Strategy<Value = crate::Whole<MIN, MAX>> {
        // Every length of number equally often, and both ends.
        prop_oneof![Just(MIN), Just(MAX), (MIN..=MAX, 0u32..32).prop_map(|(n, bits)| n >> bits)]
            .prop_map(crate::Whole::clamped)
    }

    pub(crate) fn axis() -> impl Strategy<Value = AxisId> {
        (1..=8u8).prop_map(|n| AxisId::numbered(n).unwrap())
    }

    pub(crate) fn any_command() -> impl Strategy<Value = Command> {
        use Command::*;
        let plain = proptest::sample::select(
            &[
                Program,
                Run(Direction::Forward),
                Run(Direction::Backward),
                Execute,
                Status,
                Stop,
                Kill,
                Select(Selection::All),
                Info,
                Clear,
                Settings,
                Reset,
            ][..],
        );
        let distance = any::<i32>().prop_map(Distance::new);
        prop_oneof![
            4 => plain,
            1 => whole().prop_map(StartTens),
            1 => whole().prop_map(TopTens),
            1 => whole().prop_map(Ramp),
            1 => whole().prop_map(Start),
            1 => whole().prop_map(Top),
            1 => whole().prop_map(Accel),
            1 => whole().prop_map(Decel),
            1 => whole().prop_map(Jerk),
            1 => whole().prop_map(Lease),
            2 => distance.clone().prop_map(Go),
            2 => distance.prop_map(Retarget),
            1 => axis().prop_map(Zero),
            1 => axis().prop_map(Position),
            1 => axis().prop_map(|a| Select(Selection::One(a))),
            1 => proptest::sample::select(&crate::Setting::ALL[..]).prop_map(Setting),
            2 => any_value().prop_map(Set),
        ]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(command in any_command()) {
            let line: Vec<u8> = command.bytes().collect();
            let (cr, line) = line.split_last().unwrap();
            prop_assert_eq!(*cr, b'\r');
            prop_assert!(line.len() <= 20);
            prop_assert_eq!(Command::parse(line), Ok(command));
            let shown = command.to_string();
            prop_assert_eq!(shown.as_bytes(), line);
        }

        /// Two lines that have lost the CR between them must not become a valid third line.
        #[test]
        fn two_lines_run_together_are_none(a in any_command(), b in any_command()) {
            let joined = a.to_string() + &b.to_string();
            prop_assert!(Command::parse(joined.as_bytes()).is_err());
        }

        /// A line that parses is the line that is written again, up to leading zeros, the sign of
        /// zero and P0.
        #[test]
        fn what_is_read_was_written(line in "[PSTRG@gEFZKIVALstadj?!O0-9+-]{0,6}") {
            if let Ok(command) = Command::parse(line.as_bytes()) {
                let plain = |text: &str| {
                    let head = text.trim_end_matches(|c: char| c.is_ascii_digit());
                    let tail = text[head.len()..].trim_start_matches('0');
                    let tail = if head.len() < text.len() && tail.is_empty() { "0" } else { tail };
                    let plain = (head.to_string() + tail).replace("P0", "PO");
                    plain.replace("G-0", "G+0").replace("@-0", "@+0")
                };
                prop_assert_eq!(plain(&line), plain(&command.to_string()));
            }
        }

        #[test]
        fn nothing_panics(line: Vec<u8>) {
            let _ = Command::parse(&line);
        }
    }

    #[test]
    fn lines_of_the_nano_slave() {
        let tens = |n| Tens::new(n).unwrap();
        for (line, command) in [
            (&b"PO"[..], Command::Program),
            (b"P0", Command::Program),
            (b"S5", Command::StartTens(tens(5))),
            (b"T999", Command::TopTens(tens(999))),
            (b"R0200", Command::Ramp(tens(200))),
            (b"G-2147483648", Command::Go(Distance::new(i32::MIN))),
            (b"G-0", Command::Go(Distance::new(0))),
            (b"@-12", Command::Retarget(Distance::new(-12))),
            (b"g-", Command::Run(Direction::Backward)),
            (b"I1", Command::Zero(AxisId::FIRST)),
            (b"V01", Command::Position(AxisId::FIRST)),
        ] {
            assert_eq!(Command::parse(line), Ok(command), "{line:?}");
        }
    }

    #[test]
    fn bad_lines_are_told_apart() {
        use BadLine::*;
        assert_eq!(Command::parse(b""), Err(Empty));
        for line in [
            &b"P"[..],
            b"PO1",
            b"P00",
            b"po",
            b"S",
            b"S+5",
            b"S5 ",
            b" S5",
            b"G5",
            b"G+",
            b"G+-5",
            b"@5",
            b"@+",
            b"@",
            b"g",
            b"g+1",
            b"E1",
            b"F0",
            b"I",
            b"V",
            b"L",
            b"L+5",
            b"A",
            b"A+1",
            b"??",
            b"!0",
            b"s",
            b"S5.0",
            b"x",
            b"\0",
            b"\xff",
            b"G\xb11",
            b"$pulse-us=",
            b"$pulse-us=x",
            // The internal letters of the lines that begin with `$`.
            b"n",
            b"=",
            b"=5",
            b"r",
        ] {
            assert_eq!(Command::parse(line), Err(Unknown), "{line:?}");
        }
        for line in [
            &b"S0"[..],
            b"S1000",
            b"T0",
            b"R0",
            b"R1000",
            b"t0",
            b"t1000001",
            b"s1000001",
            b"a0",
            b"d0",
            b"a100000001",
            b"j4000000001",
            b"L60001",
            b"d4294967296",
            b"G+2147483648",
            b"G-2147483649",
            b"@-2147483649",
            b"@+2147483648",
            b"I0",
            b"V9",
            b"A9",
            b"A257",
            b"$pulse-us=0",
            b"$max-speed=1000001",
        ] {
            assert_eq!(Command::parse(line), Err(Range), "{line:?}");
        }
        for line in [&b"$$"[..], b"$E", b"$=1", b"$pulse=2", b"$Pulse-us", b"$reset=1", b"$ "] {
            assert_eq!(Command::parse(line), Err(BadLine::Setting), "{line:?}");
        }
        assert!(Command::parse(b"s0").is_ok() && Command::parse(b"A0").is_ok());
        assert!(Command::parse(b"j0").is_ok());
    }
}
