//! `--drive`: the pins of a motor's driver, and their signals.

use std::str::FromStr;

use clap::ValueEnum;
use stepwright::drive::sequence::*;
use stepwright::drive::{Arduino, BoardPin, PinFault, Sequence, Shield};
use stepwright_play::timed::{SignalLevel, TimedWiring, WiredSignal};
use stepwright_timed::line::Wire;

use crate::failure::Failure;

/// How the motor is wired.
#[derive(clap::Args)]
#[command(next_help_heading = "Drive")]
pub struct WiringArgs {
    /// What drives the motor: shield, lower-shield, second-shield; unipolar:PINS,
    /// unipolar-wave:PINS, unipolar-half:PINS (four pins of one port: D4,D39,D40,D41);
    /// bridge, bridge-wave, bridge-half, with --port :PINS; l6219, l6219-half, l6219-quarter,
    /// with --port and six :PINS; or pattern:ROW,ROW,…/OUTPUTS, port bits in binary, with
    /// --port and @PORT behind them. Without it a board drives the motor shield
    #[arg(long, value_name = "DRIVE")]
    drive: Option<DriveArg>,
    /// The Arduino whose pins these are
    #[arg(long, value_enum, default_value_t = BoardArg::Uno)]
    board: BoardArg,
    /// The row of the motor's pattern to begin at
    #[arg(long, value_name = "N", default_value_t = 0)]
    phase: u8,
}

/// A board with the Arduino driver's pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BoardArg {
    /// Arduino Uno
    Uno,
    /// Arduino Mega
    Mega,
}

#[derive(Clone, Debug)]
enum DriveArg {
    Shield(&'static str, Shield),
    Pins(String, Sequence, Vec<BoardPin>),
    Lines(&'static str, Sequence, &'static [&'static str]),
    Pattern(Sequence, u8, Option<char>),
}

const BRIDGE: &[&str] = &["In1", "In2", "In3", "In4"];
const L6219: &[&str] = &["PHASE1", "PHASE2", "I01", "I11", "I02", "I12"];

impl FromStr for DriveArg {
    type Err = String;

    fn from_str(text: &str) -> Result<DriveArg, String> {
        let (name, rest) = text.split_once(':').map_or((text, None), |(n, r)| (n, Some(r)));
        let unipolar = |steps, sequence| {
            let names = rest.ok_or("name four pins, like unipolar:D8,D9,D10,D11")?;
            let name = format!("unipolar driver, {steps}");
            Ok(DriveArg::Pins(name, sequence, pins(names, 4)?))
        };
        let drive = match name {
            "unipolar" => return unipolar("full steps", UNIPOLAR_FULL),
            "unipolar-wave" => return unipolar("one phase on", UNIPOLAR_WAVE),
            "unipolar-half" => return unipolar("half steps", UNIPOLAR_HALF),
            "pattern" => return pattern(rest.unwrap_or("")),
            "shield" => DriveArg::Shield("motor shield", Shield::FIRST),
            "lower-shield" => DriveArg::Shield("lower of two motor shields", Shield::LOWER),
            "second-shield" => DriveArg::Shield("second motor shield", Shield::SECOND),
            "bridge" => DriveArg::Lines("bridges, full steps", BRIDGE_FULL, BRIDGE),
            "bridge-wave" => DriveArg::Lines("bridges, one winding on", BRIDGE_WAVE, BRIDGE),
            "bridge-half" => DriveArg::Lines("bridges, half steps", BRIDGE_HALF, BRIDGE),
            "l6219" => DriveArg::Lines("L6219, full steps", L6219_FULL, L6219),
            "l6219-half" => DriveArg::Lines("L6219, half steps", L6219_HALF, L6219),
            "l6219-quarter" => DriveArg::Lines("L6219, quarter steps", L6219_QUARTER, L6219),
            _ => {
                return Err("there is shield, lower-shield, second-shield, unipolar[-wave|-half]:\
                            PINS, bridge[-wave|-half], l6219[-half|-quarter], pattern:ROWS/OUTPUTS"
                    .into());
            }
        };
        match (drive, rest) {
            (DriveArg::Lines(name, sequence, lines), Some(names)) => {
                Ok(DriveArg::Pins(name.to_owned(), sequence, pins(names, lines.len())?))
            }
            (_, Some(_)) => Err(format!("{name} takes no pins")),
            (drive, None) => Ok(drive),
        }
    }
}

/// `D4,D39,D40,D41`
fn pins(text: &str, count: usize) -> Result<Vec<BoardPin>, String> {
    let pin = |text: &str| {
        let text = text.trim();
        let number = |digits: &str| digits.parse().map_err(|_| format!("{text} is no pin"));
        match text.strip_prefix(['A', 'a']) {
            Some(digits) => number(digits).map(BoardPin::A),
            None => number(text.strip_prefix(['D', 'd']).unwrap_or(text)).map(BoardPin::D),
        }
    };
    let pins = text.split(',').map(pin).collect::<Result<Vec<_>, _>>()?;
    if pins.len() == count {
        Ok(pins)
    } else {
        Err(format!("{count} pins are needed, not {}", pins.len()))
    }
}

/// `00110000,01100000,11000000,10010000/11110000`
fn pattern(text: &str) -> Result<DriveArg, String> {
    let bits = |text: &str| {
        let digits = text.trim().replace('_', "");
        let digits = digits.strip_prefix(['B', 'b']).unwrap_or(&digits);
        u8::from_str_radix(digits, 2).map_err(|_| format!("{text:?} is no byte in binary"))
    };
    let (text, port) = text.split_once('@').map_or((text, None), |(t, p)| (t, Some(p)));
    let port = match port.map(|port| port.trim().chars().collect::<Vec<_>>()).as_deref() {
        None => None,
        Some([letter]) if letter.is_ascii_alphabetic() => Some(letter.to_ascii_uppercase()),
        Some(_) => return Err("a port is a letter, like @B".into()),
    };
    let (rows, outputs) = text.split_once('/').map_or((text, None), |(r, o)| (r, Some(o)));
    let rows = rows.split(',').map(bits).collect::<Result<Vec<_>, _>>()?;
    let mask = match outputs {
        Some(outputs) => bits(outputs)?,
        None => rows.iter().fold(0, |all, row| all | row),
    };
    let sequence = Sequence::new(&rows, mask).map_err(|error| error.to_string())?;
    Ok(DriveArg::Pattern(sequence, mask, port))
}

/// The port of all these pins, and their bits there.
fn same_port(board: Arduino, pins: &[BoardPin]) -> Result<(char, Vec<u8>), PinFault> {
    fn of<const N: usize>(
        board: Arduino,
        pins: [BoardPin; N],
    ) -> Result<(char, Vec<u8>), PinFault> {
        board.same_port(pins).map(|(port, bits)| (port, bits.to_vec()))
    }
    match *pins {
        [a, b, c, d, e, f] => of(board, [a, b, c, d, e, f]),
        [a, b, c, d, ..] => of(board, [a, b, c, d]),
        [a, ..] => of(board, [a]),
        [] => of(board, []),
    }
}

impl WiringArgs {
    /// The wiring on `board`, or else on the Arduino of the option.
    pub fn wiring(&self, board: Option<Arduino>) -> Result<TimedWiring, Failure> {
        let board = board.unwrap_or(match self.board {
            BoardArg::Uno => Arduino::Uno,
            BoardArg::Mega => Arduino::Mega,
        });
        let phase = self.phase;
        let wire = |port: char, mask, sequence, shield| {
            Some(Wire { port: port as u8, mask, sequence, shield, phase })
        };
        let refused = |error: PinFault| {
            // The core's message is "what is wrong; what to do".
            let text = error.to_string();
            match text.split_once("; ") {
                Some((wrong, todo)) => Failure::new(wrong).hint(todo),
                None => Failure::new(text).hint("is --board right?"),
            }
        };
        let signal = |name: String, what| WiredSignal { name, what };
        let (name, sequence, signals, wire) = match &self.drive {
            None => {
                let (port, on_port, mask) = Shield::FIRST.coils(board).map_err(refused)?;
                (None, SHIELD, Vec::new(), wire(port, mask, on_port, true))
            }
            Some(DriveArg::Shield(name, shield)) => {
                let (port, on_port, mask) = shield.coils(board).map_err(refused)?;
                let [a, b] = shield.direction;
                let mut signals = vec![
                    signal(a.to_string(), SignalLevel::Line(0)),
                    signal(b.to_string(), SignalLevel::Line(1)),
                ];
                for pin in shield.enable {
                    signals.push(signal(format!("{pin} en"), SignalLevel::Enable));
                }
                for pin in shield.brake.into_iter().flatten() {
                    signals.push(signal(format!("{pin} br"), SignalLevel::Low));
                }
                let name = format!("{name}, directions on port {port}");
                (Some(name), SHIELD, signals, wire(port, mask, on_port, true))
            }
            Some(DriveArg::Pins(name, sequence, pins)) => {
                let (port, bits) = same_port(board, pins).map_err(refused)?;
                let names = pins.iter().zip(&bits);
                let signals =
                    names.map(|(pin, bit)| signal(pin.to_string(), SignalLevel::Line(*bit)));
                let on_port = sequence.on_bits(&bits);
                let mask = bits.iter().fold(0, |mask, bit| mask | 1 << bit);
                let name = format!("{name}, on port {port}");
                (Some(name), on_port, signals.collect(), wire(port, mask, on_port, false))
            }
            Some(DriveArg::Lines(name, sequence, lines)) => {
                let named = (0..).zip(*lines);
                let signals =
                    named.map(|(bit, line)| signal((*line).into(), SignalLevel::Line(bit)));
                (Some((*name).to_owned()), *sequence, signals.collect(), None)
            }
            Some(DriveArg::Pattern(sequence, mask, port)) => {
                let bits = (0..8).rev().filter(|bit| mask >> bit & 1 != 0);
                let signals = bits.map(|bit| signal(format!("bit {bit}"), SignalLevel::Line(bit)));
                let wire = port.and_then(|port| wire(port, *mask, *sequence, false));
                (Some("a pattern of one's own".to_owned()), *sequence, signals.collect(), wire)
            }
        };
        if self.phase >= sequence.len() {
            let last = sequence.len() - 1;
            return Err(Failure::new(format!("--phase {}: there is none", self.phase))
                .hint(format!("this drive has phases 0 to {last}")));
        }
        Ok(TimedWiring { name, sequence, phase, signals, wire })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_are_read() {
        for good in [
            "shield",
            "second-shield",
            "unipolar:D4,D39,D40,D41",
            "unipolar-half: 8, d9,D10,11",
            "unipolar-wave:A0,A1,A2,A3",
            "bridge-half",
            "l6219-quarter",
            "pattern:B00110000,01100000,1100_0000,10010000/11110000",
            "pattern:01,10@c",
            "l6219:D8,D9,D10,D11,D12,D13",
            "bridge-half:A0,A1,A2,A3",
        ] {
            assert!(good.parse::<DriveArg>().is_ok(), "{good}");
        }
        for bad in [
            "",
            "servo",
            "unipolar",
            "unipolar:D4",
            "unipolar:D4,D5,D6,X",
            "shield:D4",
            "l6219:D8,D9,D10,D11",
            "pattern:01,10@",
            "pattern:01,10@BC",
            "pattern:",
            "pattern:1,2",
            "pattern:1,10,100",
            "pattern:0001,0010,0100,1000/0111",
        ] {
            assert!(bad.parse::<DriveArg>().is_err(), "{bad}");
        }
    }
}
