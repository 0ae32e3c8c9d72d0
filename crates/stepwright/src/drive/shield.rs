//! The Arduino motor shield (L298): its pins on each board.
//!
//! ```text
//!              enable A, B   brake A, B   direction A, B
//!   first      D3  D11       D9  D8       D12  D13
//!   second     D3  D11       cut          D9   D8
//! ```
//!
//! Source: the Arduino driver, section 3. Enables are high while the shield drives the motor;
//! brakes stay low. A second shield on top of the first has its D12 and D13 cut and connected to D9
//! and D8. On both shields the brake lines are cut, which frees these pins; the enables are the
//! same pins.

use super::arduino::{Arduino, BoardPin, PinFault, PortPin};
use super::sequence::{SHIELD, Sequence};

/// The pins of a motor shield, by the numbers on the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shield {
    /// The enables of bridges A and B.
    pub enable: [BoardPin; 2],
    /// The brakes of bridges A and B, unless they are cut.
    pub brake: Option<[BoardPin; 2]>,
    /// The directions of windings A and B.
    pub direction: [BoardPin; 2],
}

impl Shield {
    /// The shield as it is sold.
    pub const FIRST: Shield = Shield {
        enable: [BoardPin::D(3), BoardPin::D(11)],
        brake: Some([BoardPin::D(9), BoardPin::D(8)]),
        direction: [BoardPin::D(12), BoardPin::D(13)],
    };

    /// The lower one of two shields: its brake lines are cut too.
    pub const LOWER: Shield = Shield { brake: None, ..Shield::FIRST };

    /// The second of two shields, with D12 and D13 cut and connected to D9 and D8.
    pub const SECOND: Shield =
        Shield { brake: None, direction: [BoardPin::D(9), BoardPin::D(8)], ..Shield::FIRST };

    /// The port of the direction pins, and the table on its bits with their mask.
    ///
    /// # Errors
    /// [`PinFault`] if the board does not have the pins.
    pub fn coils(&self, board: Arduino) -> Result<(char, Sequence, u8), PinFault> {
        let (port, bits) = board.same_port(self.direction)?;
        let mask = bits.iter().fold(0, |mask, bit| mask | 1 << bit);
        Ok((port, SHIELD.on_bits(&bits), mask))
    }

    /// The pins to set before the shield drives the motor, with their levels. The enables come
    /// first; to switch off, invert them.
    pub fn power(&self, board: Arduino) -> impl Iterator<Item = (PortPin, bool)> {
        let enables = self.enable.map(|pin| (pin, true));
        let brakes = self.brake.into_iter().flatten().map(|pin| (pin, false));
        let all = enables.into_iter().chain(brakes);
        all.filter_map(move |(pin, level)| Some((board.pin(pin)?, level)))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// The article's port bits: Uno PB4/PB5, PD3, PB3; Mega PB6/PB7, PE5, PB5.
    #[test]
    fn the_documents_port_bits() {
        let (port, sequence, mask) = Shield::FIRST.coils(Arduino::Uno).unwrap();
        assert_eq!((port, mask), ('B', 0b0011_0000));
        assert_eq!([0, 1, 2, 3].map(|phase| sequence.levels(phase) >> 4), [0, 1, 3, 2]);
        let (port, sequence, mask) = Shield::FIRST.coils(Arduino::Mega).unwrap();
        assert_eq!((port, mask), ('B', 0b1100_0000));
        assert_eq!([0, 1, 2, 3].map(|phase| sequence.levels(phase) >> 6), [0, 1, 3, 2]);

        let pin = |port, bit| PortPin { port, bit };
        let power = |shield: Shield, board| shield.power(board).collect::<Vec<_>>();
        assert_eq!(
            power(Shield::FIRST, Arduino::Uno),
            [(pin('D', 3), true), (pin('B', 3), true), (pin('B', 1), false), (pin('B', 0), false)]
        );
        assert_eq!(
            power(Shield::SECOND, Arduino::Mega),
            [(pin('E', 5), true), (pin('B', 5), true)]
        );
    }

    #[test]
    fn two_shields_have_no_line_in_common() {
        for board in [Arduino::Uno, Arduino::Mega] {
            let (one, _, first) = Shield::LOWER.coils(board).unwrap();
            let (two, _, second) = Shield::SECOND.coils(board).unwrap();
            assert!(one != two || first & second == 0);
        }
    }
}
