//! A story: a board and its events, as a text that can be kept and replayed.
//!
//! ```text
//! board hz=16000000 bits=16 axes=3 cost=125,184,251 byte=1389
//! board uno byte=1389  the virtual Uno
//! > PO                 a line and its CR; \x07 for a byte that is no letter
//! >> G+4               bytes without a CR
//! wait 1500            this many microseconds
//! rest                 F until the answer is R
//! switch 2 low         the level of the pin of a limit switch
//! estop low            the level of the emergency stop; or driver, the drivers' fault
//! reset power          a loss of power; or blink (a short one), button, watchdog
//! ```

use std::fmt;
use std::str::FromStr;

/// Features that some boards lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Can {
    /// `j` and the setting `law`.
    pub jerk: bool,
}

/// A board as seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// Ticks of the step timer per second.
    pub hz: u32,
    /// Whether the counter has 32 bits, else 16.
    pub wide: bool,
    /// The number of connected axes.
    pub axes: u8,
    /// Ticks of a step while 1, 2 or 3 axes move.
    pub cost: [u32; 3],
    /// Ticks of a step with pulses of more than 2 µs.
    pub longer: [u32; 3],
    /// Ticks of a byte on the line. 0: bytes take no time.
    pub byte: u32,
    /// The features of the board.
    pub can: Can,
    /// The most ticks that an edge is off its time alone, and beside other axes.
    pub jitter: (f64, f64),
    /// The most seconds that an interval of a run is off its law.
    pub fit: f64,
    /// The ticks by which widths may be short, in a simulation that reports them so.
    pub slack: u64,
    /// Whether the board needs time to plan and may refuse a ramp for that.
    pub plans: bool,
    /// Whether it is the virtual Uno, with an AVR's queue and an axis whose edges are on a grid.
    pub uno: bool,
}

impl Board {
    /// A virtual board.
    pub fn simulated(hz: u32, wide: bool, axes: u8, cost: [u32; 3], byte: u32) -> Board {
        let ticks = |micros: u64| (micros * u64::from(hz)).div_ceil(1_000_000) as u32;
        let longer = [cost[0].max(ticks(20)), cost[1].max(ticks(40)), cost[2].max(ticks(60))];
        Board {
            longer,
            hz,
            wide,
            axes,
            cost,
            byte,
            can: Can { jerk: true },
            jitter: (1.0, 1.0),
            fit: 0.6e-6,
            slack: 0,
            plans: false,
            uno: false,
        }
    }

    /// The virtual Uno, with this many ticks per byte.
    pub fn uno(byte: u32) -> Board {
        let board = Board::simulated(16_000_000, false, 3, [125, 184, 251], byte);
        // The third axis is on a timer that counts every eighth tick.
        Board { longer: [1_250, 1_700, 4_400], jitter: (9.0, 9.0), plans: true, uno: true, ..board }
    }

    /// Microseconds in ticks, rounded up.
    pub fn ticks(&self, micros: u32) -> u64 {
        self.ticks_wide(micros.into())
    }

    /// Microseconds in ticks, rounded up, for any number.
    pub fn ticks_wide(&self, micros: u64) -> u64 {
        (micros as u128 * u128::from(self.hz)).div_ceil(1_000_000) as u64
    }

    /// The most ticks that an edge may be off its time: pulses of the other axes may delay it.
    pub fn jitter(&self, pulse: u64, moving: usize) -> f64 {
        let others = if moving > 1 { self.jitter.1 + pulse as f64 } else { 0.0 };
        self.jitter.0 + others
    }

    /// The share of time that the steps take, for the sum of speeds, the fastest speed, the number of axes,
    /// and pulses of at most `pulse` µs.
    pub fn load(&self, sum: f64, fastest: f64, axes: usize, pulse: u32) -> f64 {
        let cost = if pulse > 2 { self.longer } else { self.cost };
        let cost = |n: usize| f64::from(cost[n.clamp(1, 3) - 1]);
        // A held pulse and its pause delay each of the other axes.
        let pulses = if pulse > 2 { axes.saturating_sub(1).max(1) } else { 1 };
        let least = cost(1).max(2.0 * (pulses as f64) * self.ticks(pulse) as f64);
        (sum * cost(axes)).max(fastest * least) / f64::from(self.hz)
    }
}

/// An event of a story.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// Bytes on the line, CRs among them.
    Send(Vec<u8>),
    /// A wait in microseconds.
    Wait(u32),
    /// F until the answer is R.
    Rest,
    /// The level of a switch's pin.
    Switch(u8, bool),
    /// The level of a stop input.
    Input(Input, bool),
    /// A reset.
    Reset(Reset),
}

/// A stop input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// The emergency stop.
    Emergency,
    /// The fault of a driver.
    Driver,
}

impl Input {
    /// Both inputs with their words.
    pub const ALL: [(Input, &str); 2] = [(Input::Emergency, "estop"), (Input::Driver, "driver")];
}

/// The cause of a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// A long loss of power: RAM has lost its content.
    Power,
    /// A short loss of power: RAM has kept its content.
    Blink,
    /// A press of the button, or a host that opened the port.
    Button,
    /// The watchdog.
    Watchdog,
}

impl Reset {
    /// Every kind with its word.
    pub const ALL: [(Reset, &str); 4] = [
        (Reset::Power, "power"),
        (Reset::Blink, "blink"),
        (Reset::Button, "button"),
        (Reset::Watchdog, "watchdog"),
    ];
}

/// A board and its events.
#[derive(Clone, Debug, PartialEq)]
pub struct Story {
    /// The board.
    pub board: Board,
    /// The events in their order.
    pub acts: Vec<Act>,
    /// The number of damaged bytes. The text has these bytes as they came.
    pub noise: u32,
}

impl fmt::Display for Act {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Act::Send(bytes) => match bytes.strip_suffix(b"\r") {
                Some(line) => write!(f, "> {}", line.escape_ascii()),
                None => write!(f, ">> {}", bytes.escape_ascii()),
            },
            Act::Wait(micros) => write!(f, "wait {micros}"),
            Act::Rest => f.write_str("rest"),
            Act::Switch(axis, high) => {
                write!(f, "switch {} {}", axis + 1, if *high { "high" } else { "low" })
            }
            Act::Input(input, high) => {
                let word = Input::ALL.iter().find(|(known, _)| known == input);
                let level = if *high { "high" } else { "low" };
                write!(f, "{} {level}", word.map_or("", |(_, word)| word))
            }
            Act::Reset(reset) => {
                let word = Reset::ALL.iter().find(|(known, _)| known == reset);
                write!(f, "reset {}", word.map_or("", |(_, word)| word))
            }
        }
    }
}

impl fmt::Display for Story {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Board { hz, wide, axes, cost: [one, two, three], byte, .. } = self.board;
        let bits = if wide { 32 } else { 16 };
        if self.board.uno {
            writeln!(f, "board uno byte={byte}")?;
        } else {
            writeln!(
                f,
                "board hz={hz} bits={bits} axes={axes} cost={one},{two},{three} byte={byte}"
            )?;
        }
        self.acts.iter().try_for_each(|act| writeln!(f, "{act}"))
    }
}

impl FromStr for Story {
    type Err = String;

    fn from_str(text: &str) -> Result<Story, String> {
        let mut lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
        let first = lines.next().and_then(|line| line.strip_prefix("board ")).ok_or("no board")?;
        let board = board(first)?;
        let acts = lines.map(|line| act(line).ok_or(format!("not an act: {line}")));
        Ok(Story { board, acts: acts.collect::<Result<_, _>>()?, noise: 0 })
    }
}

fn board(text: &str) -> Result<Board, String> {
    let word = |name: &str| {
        let word = text.split(' ').find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
        word.ok_or(format!("the board has no {name}"))
    };
    let number = |name: &str| -> Result<u32, String> {
        word(name)?.parse().map_err(|_| format!("{name} is no number"))
    };
    if text.starts_with("uno ") {
        return Ok(Board::uno(number("byte")?));
    }
    let costs: Vec<u32> = word("cost")?.split(',').filter_map(|cost| cost.parse().ok()).collect();
    let cost = costs.try_into().map_err(|_| "cost takes three numbers")?;
    let axes = u8::try_from(number("axes")?).ok().filter(|axes| (1..=3).contains(axes));
    let axes = axes.ok_or("1 to 3 axes")?;
    Ok(Board::simulated(number("hz")?, number("bits")? == 32, axes, cost, number("byte")?))
}

fn act(line: &str) -> Option<Act> {
    if let Some(text) = line.strip_prefix(">>") {
        return unescape(text.strip_prefix(' ')?).map(Act::Send);
    }
    if let Some(text) = line.strip_prefix('>') {
        let mut bytes = unescape(text.strip_prefix(' ')?)?;
        bytes.push(b'\r');
        return Some(Act::Send(bytes));
    }
    let words: Vec<_> = line.split(' ').collect();
    Some(match words[..] {
        ["wait", micros] => Act::Wait(micros.parse().ok()?),
        ["rest"] => Act::Rest,
        ["switch", axis, level] => {
            Act::Switch(axis.parse::<u8>().ok()?.checked_sub(1)?, level == "high")
        }
        ["reset", word] => Act::Reset(Reset::ALL.iter().find(|(_, known)| *known == word)?.0),
        [word, level] => {
            Act::Input(Input::ALL.iter().find(|(_, known)| *known == word)?.0, level == "high")
        }
        _ => return None,
    })
}

/// Reverses `escape_ascii`.
fn unescape(text: &str) -> Option<Vec<u8>> {
    let (mut bytes, mut rest) = (Vec::new(), text.bytes());
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'\\' => match rest.next()? {
                b'r' => b'\r',
                b'n' => b'\n',
                b't' => b'\t',
                b'x' => {
                    let digits = [rest.next()?, rest.next()?];
                    u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
                }
                other => other,
            },
            byte => byte,
        });
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_story_is_its_text() {
        let board = Board::simulated(123_456, true, 2, [7, 8, 9], 10);
        let every: Vec<u8> = (0..=255).collect();
        let acts = vec![
            Act::Send(b"PO\r".into()),
            Act::Send(every),
            Act::Send(b"\r".into()),
            Act::Wait(5),
            Act::Rest,
            Act::Switch(2, false),
            Act::Input(Input::Driver, false),
            Act::Reset(Reset::Blink),
        ];
        let story = Story { board, acts, noise: 0 };
        assert_eq!(story.to_string().parse(), Ok(story.clone()));
        let story = Story { board: Board::uno(1389), ..story };
        assert_eq!(story.to_string().parse(), Ok(story));
    }

    #[test]
    fn a_bad_story_says_where() {
        assert_eq!("".parse::<Story>().unwrap_err(), "no board");
        let text = "board hz=5 bits=16 axes=1 cost=1,2,3 byte=0\njump";
        assert_eq!(text.parse::<Story>().unwrap_err(), "not an act: jump");
    }
}
