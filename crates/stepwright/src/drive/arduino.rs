//! The port and bit of each Arduino pin. Source: the Arduino driver, section 5.

use core::fmt;

/// An Arduino board of the article.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arduino {
    /// ATmega328P.
    Uno,
    /// ATmega2560.
    Mega,
}

/// A pin of a chip: its port and bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortPin {
    /// `'A'` to `'L'`.
    pub port: char,
    /// 0 to 7.
    pub bit: u8,
}

/// A pin that is not wired to a header.
const NONE: u8 = 0xFF;
/// Offset of the analog inputs, which are numbered after the digital pins: A0 is 100.
const A: u8 = 100;

/// A port and the numbers of its pins, from bit 0 on.
type Row = (char, [u8; 8]);

const UNO: &[Row] = &[
    ('B', [8, 9, 10, 11, 12, 13, NONE, NONE]),
    ('C', [A, A + 1, A + 2, A + 3, A + 4, A + 5, NONE, NONE]),
    ('D', [0, 1, 2, 3, 4, 5, 6, 7]),
];

const MEGA: &[Row] = &[
    ('A', [22, 23, 24, 25, 26, 27, 28, 29]),
    ('B', [53, 52, 51, 50, 10, 11, 12, 13]),
    ('C', [37, 36, 35, 34, 33, 32, 31, 30]),
    ('D', [21, 20, 19, 18, NONE, NONE, NONE, 38]),
    ('E', [0, 1, NONE, 5, 2, 3, NONE, NONE]),
    ('F', [A, A + 1, A + 2, A + 3, A + 4, A + 5, A + 6, A + 7]),
    ('G', [41, 40, 39, NONE, NONE, 4, NONE, NONE]),
    ('H', [17, 16, NONE, 6, 7, 8, 9, NONE]),
    ('J', [15, 14, NONE, NONE, NONE, NONE, NONE, NONE]),
    ('K', [A + 8, A + 9, A + 10, A + 11, A + 12, A + 13, A + 14, A + 15]),
    ('L', [49, 48, 47, 46, 45, 44, 43, 42]),
];

/// A pin as it is printed on the board: D13, A0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardPin {
    /// `D13`
    D(u8),
    /// `A0`
    A(u8),
}

impl BoardPin {
    const fn number(self) -> u8 {
        match self {
            BoardPin::D(number) if number < A => number,
            BoardPin::A(number) if number < 16 => A + number,
            _ => NONE,
        }
    }
}

impl fmt::Display for BoardPin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BoardPin::D(number) => write!(f, "D{number}"),
            BoardPin::A(number) => write!(f, "A{number}"),
        }
    }
}

impl Arduino {
    /// The port and bit of a pin; `None` if the board has no such pin.
    ///
    /// ```
    /// use stepwright::drive::{Arduino, BoardPin, PortPin};
    /// let led = BoardPin::D(13);
    /// assert_eq!(Arduino::Uno.pin(led), Some(PortPin { port: 'B', bit: 5 }));
    /// assert_eq!(Arduino::Mega.pin(led), Some(PortPin { port: 'B', bit: 7 }));
    /// assert_eq!(Arduino::Uno.pin(BoardPin::D(22)), None);
    /// ```
    pub fn pin(self, pin: BoardPin) -> Option<PortPin> {
        let table = match self {
            Arduino::Uno => UNO,
            Arduino::Mega => MEGA,
        };
        let number = pin.number();
        if number == NONE {
            return None;
        }
        table.iter().find_map(|(port, pins)| {
            let bit = pins.iter().position(|&other| other == number)?;
            Some(PortPin { port: *port, bit: bit as u8 })
        })
    }

    /// The port of `pins` and their bits on it, so that one write sets them all.
    ///
    /// ```
    /// use stepwright::drive::{Arduino, BoardPin, PinFault};
    /// // The article's example.
    /// let pins = [4, 39, 40, 41].map(BoardPin::D);
    /// assert_eq!(Arduino::Mega.same_port(pins), Ok(('G', [5, 2, 1, 0])));
    /// let mixed = [2, 3, 8, 9].map(BoardPin::D);
    /// assert!(matches!(Arduino::Uno.same_port(mixed), Err(PinFault::TwoPorts { .. })));
    /// ```
    ///
    /// # Errors
    /// [`PinFault`] for a pin that does not exist, that is named twice, or that is on another port
    /// than the first.
    pub fn same_port<const N: usize>(
        self,
        pins: [BoardPin; N],
    ) -> Result<(char, [u8; N]), PinFault> {
        let mut port = None;
        let mut mask = 0u8;
        let mut bits = [0; N];
        for (pin, bit) in pins.into_iter().zip(&mut bits) {
            let found = self.pin(pin).ok_or(PinFault::Absent(pin))?;
            let (first, one) = *port.get_or_insert((found.port, pin));
            if found.port != first {
                return Err(PinFault::TwoPorts { first: (one, first), other: (pin, found.port) });
            }
            if mask >> found.bit & 1 != 0 {
                return Err(PinFault::Twice(pin));
            }
            mask |= 1 << found.bit;
            *bit = found.bit;
        }
        Ok((port.map_or('?', |(port, _)| port), bits))
    }
}

/// Why pins can't drive a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinFault {
    /// The board has no such pin.
    Absent(BoardPin),
    /// A pin that is named twice.
    Twice(BoardPin),
    /// Pins of different ports.
    TwoPorts {
        /// The first pin and its port.
        first: (BoardPin, char),
        /// A pin on another port.
        other: (BoardPin, char),
    },
}

impl fmt::Display for PinFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PinFault::Absent(pin) => write!(f, "this board has no pin {pin}"),
            PinFault::Twice(pin) => write!(f, "pin {pin} is named twice; each line needs its own"),
            PinFault::TwoPorts { first: (one, port), other: (two, other) } => write!(
                f,
                "pins of different ports can't move at once: {one} is on port {port}, {two} on \
                 port {other}; choose pins of one port"
            ),
        }
    }
}

impl core::error::Error for PinFault {}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    /// The article's columns, as they stand there: bit by bit, Uno and Mega.
    #[test]
    fn the_documents_table() {
        let d = BoardPin::D;
        let a = BoardPin::A;
        for (board, pin, port, bit) in [
            (Arduino::Uno, d(0), 'D', 0),
            (Arduino::Uno, d(3), 'D', 3),
            (Arduino::Uno, d(8), 'B', 0),
            (Arduino::Uno, d(11), 'B', 3),
            (Arduino::Uno, d(12), 'B', 4),
            (Arduino::Uno, d(13), 'B', 5),
            (Arduino::Uno, a(5), 'C', 5),
            (Arduino::Mega, d(22), 'A', 0),
            (Arduino::Mega, d(53), 'B', 0),
            (Arduino::Mega, d(12), 'B', 6),
            (Arduino::Mega, d(13), 'B', 7),
            (Arduino::Mega, d(30), 'C', 7),
            (Arduino::Mega, d(38), 'D', 7),
            (Arduino::Mega, d(3), 'E', 5),
            (Arduino::Mega, d(11), 'B', 5),
            (Arduino::Mega, d(8), 'H', 5),
            (Arduino::Mega, d(9), 'H', 6),
            (Arduino::Mega, d(14), 'J', 1),
            (Arduino::Mega, a(15), 'K', 7),
            (Arduino::Mega, d(42), 'L', 7),
        ] {
            assert_eq!(board.pin(pin), Some(PortPin { port, bit }), "{pin} of {board:?}");
        }
    }

    #[test]
    fn every_pin_stands_once() {
        for (table, digital, analog) in [(UNO, 14, 6), (MEGA, 54, 16)] {
            let mut all: std::vec::Vec<u8> =
                table.iter().flat_map(|(_, pins)| *pins).filter(|pin| *pin != NONE).collect();
            all.sort_unstable();
            let expected: std::vec::Vec<u8> = (0..digital).chain(A..A + analog).collect();
            assert_eq!(all, expected);
        }
    }

    #[test]
    fn pins_that_cant_are_refused() {
        let pins = |numbers: [u8; 4]| numbers.map(BoardPin::D);
        assert!(Arduino::Mega.same_port(pins([4, 39, 40, 41])).is_ok());
        assert_eq!(
            Arduino::Uno.same_port(pins([8, 9, 10, 10])),
            Err(PinFault::Twice(BoardPin::D(10)))
        );
        let absent = Arduino::Uno.same_port(pins([8, 9, 10, 39]));
        assert_eq!(absent, Err(PinFault::Absent(BoardPin::D(39))));
        let fault = Arduino::Mega.same_port(pins([12, 13, 10, 9])).unwrap_err();
        let text = std::string::ToString::to_string(&fault);
        assert!(text.contains("D12 is on port B, D9 on port H"), "{text}");
        assert_eq!(Arduino::Mega.pin(BoardPin::D(150)), None);
        assert_eq!(Arduino::Mega.pin(BoardPin::A(16)), None);
    }
}
