//! The pins of a board: those that a file names, and the defaults.

use stepwright::drive::{Arduino, BoardPin};
use stepwright_cycle::line::MotorPins;
use toml::Spanned;

use crate::file;
use crate::text::{CycleText, FileError};

/// The pins of a motor: STEP, DIR, ENABLE, and the switches at its minimum and maximum.
pub struct Pins {
    named: [Option<Named>; 5],
    /// Whether the file has a virtual switch at its minimum, and at its maximum.
    switches: [bool; 2],
}

/// A named pin, `None` for "none", and its place in the file.
#[derive(Clone)]
struct Named(Option<BoardPin>, std::ops::Range<usize>);

/// The names of the pins in a file.
const NAMES: [&str; 5] = ["step", "dir", "enable", "min", "max"];

/// The pins of the first three motors on a CNC shield: STEP, DIR, switch.
const SHIELD: [[u8; 3]; 3] = [[2, 5, 9], [3, 6, 10], [4, 7, 11]];
/// The ENABLE pin of all motors.
const ENABLE: u8 = 8;

impl Pins {
    /// Reads the pins of a motor of the file.
    pub(crate) fn read(text: &CycleText, motor: &file::Motor) -> Result<Pins, FileError> {
        let switches = [motor.switch_min.is_some(), motor.switch_max.is_some()];
        let mut named = [const { None }; 5];
        if let Some(pins) = &motor.pins {
            let pins = pins.get_ref();
            let all = [&pins.step, &pins.dir, &pins.enable, &pins.min, &pins.max];
            for (named, given) in named.iter_mut().zip(all) {
                *named = given.as_ref().map(|given| read(text, given)).transpose()?;
            }
        }
        Ok(Pins { named, switches })
    }

    /// The codes of the pins on the serial line: of this motor, counted from 0, on this Arduino.
    ///
    /// # Errors
    /// The board has no such pin, or needs a pin that the file does not give.
    pub fn codes(
        &self,
        text: &CycleText,
        motor: usize,
        at: std::ops::Range<usize>,
        board: Arduino,
    ) -> Result<MotorPins, FileError> {
        let mut pins = MotorPins::NONE;
        let shield = SHIELD.get(motor).map(|pins| pins.map(BoardPin::D));
        let [min, max] = self.switches;
        let both = min && max;
        for (which, code) in pins.codes.iter_mut().enumerate() {
            let (pin, place) = match (&self.named[which], shield) {
                (Some(Named(pin, place)), _) => (*pin, place.clone()),
                (None, Some([step, ..])) if which == 0 => (Some(step), at.clone()),
                (None, Some([_, dir, _])) if which == 1 => (Some(dir), at.clone()),
                (None, Some(_)) if which == 2 => (Some(BoardPin::D(ENABLE)), at.clone()),
                // A shield has one switch for each motor.
                (None, Some([.., switch])) if which == 3 && min => (Some(switch), at.clone()),
                (None, Some([.., switch])) if which == 4 && max && !both => {
                    (Some(switch), at.clone())
                }
                (None, _) if which < 2 || which == 4 && max || which == 3 && min => {
                    let name = NAMES[which];
                    let what = format_args!("a board has to know its pin: {name}");
                    return Err(text
                        .blame(at, what)
                        .hint(format!("give the motor pins = {{ {name} = \"D12\" }}")));
                }
                _ => (None, at.clone()),
            };
            if let Some(pin) = pin {
                let found = board.pin(pin).ok_or_else(|| {
                    text.blame(place, format_args!("this board has no pin {pin}"))
                })?;
                *code = (found.port as u8 - b'A') * 8 + found.bit;
            }
        }
        Ok(pins)
    }

    /// The name of a pin for a message.
    pub fn name(which: usize) -> &'static str {
        NAMES.get(which).copied().unwrap_or("pin")
    }
}

/// Reads the name of a pin: `D4`, `A0` or `none`.
fn read(text: &CycleText, given: &Spanned<String>) -> Result<Named, FileError> {
    let name = given.get_ref().trim();
    let number = |digits: &str| digits.parse::<u8>().ok();
    let pin = match (name.strip_prefix(['A', 'a']), name.strip_prefix(['D', 'd'])) {
        _ if name == "none" => None,
        (Some(digits), _) if number(digits).is_some_and(|n| n < 16) => {
            number(digits).map(BoardPin::A)
        }
        (_, Some(digits)) if number(digits).is_some_and(|n| n < 54) => {
            number(digits).map(BoardPin::D)
        }
        _ => {
            let what = format_args!("{name:?} is no pin: D0 to D53, A0 to A15, or none");
            return Err(text.blame(given.span(), what));
        }
    };
    Ok(Named(pin, given.span()))
}
