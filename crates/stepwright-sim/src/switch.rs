//! Limit switches on a virtual machine: `1:-300`.

#[cfg(feature = "std")]
use std::str::FromStr;

#[cfg(feature = "std")]
use crate::AXES;
use stepwright::Rate;
use stepwright_protocol::AxisId;

/// A switch to ground that the carriage of an axis closes at a position and beyond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switch {
    /// The axis.
    pub axis: AxisId,
    /// Closed from here on, away from 0: in steps from the shaft's position at power-up.
    pub at: i64,
}

impl Switch {
    /// Whether the switch is closed with the shaft at this position.
    pub fn is_closed(&self, shaft: i64) -> bool {
        if self.at < 0 { shaft <= self.at } else { shaft >= self.at }
    }
}

/// The time between two samples of the switches, in µs.
const LOOK: u32 = 100;

/// A virtual board whose shafts move switches.
pub trait Switched {
    /// Ticks since the board was switched on.
    fn now(&self) -> u64;

    /// Lets the board's time pass.
    fn run_until(&mut self, time: u64);

    /// The position of the shaft of an axis, in steps from power-up.
    fn shaft(&mut self, axis: u8) -> i64;

    /// Sets the level of the pin of an axis' switch.
    fn set_switch(&mut self, axis: u8, high: bool);
}

/// Lets the time of a board pass to `time`, and updates its switches every 100 µs of a timer of this rate.
pub fn run_switched<B: Switched + ?Sized>(
    board: &mut B,
    switches: &[Switch],
    rate: Rate,
    time: u64,
) {
    if !switches.is_empty() {
        let look = u64::from(rate.micros(LOOK));
        while board.now().saturating_add(look) < time {
            board.run_until(board.now() + look);
            set(board, switches);
        }
    }
    board.run_until(time);
    set(board, switches);
}

fn set<B: Switched + ?Sized>(board: &mut B, switches: &[Switch]) {
    for switch in switches {
        let axis = switch.axis.index() as u8;
        let closed = switch.is_closed(board.shaft(axis));
        // A closed switch is low: it connects to ground, and the pin is pulled up.
        board.set_switch(axis, !closed);
    }
}

#[cfg(feature = "std")]
impl FromStr for Switch {
    type Err = String;

    fn from_str(text: &str) -> Result<Switch, String> {
        let wrong = || "an axis and a place in steps, not 0, like 1:-300".to_owned();
        let (axis, at) = text.split_once(':').ok_or_else(wrong)?;
        let axis = axis.parse().ok().and_then(AxisId::numbered).ok_or_else(wrong)?;
        if axis.index() >= AXES {
            return Err(format!("a virtual board has axes 1 to {AXES}"));
        }
        let at = at.parse().ok().filter(|at| *at != 0).ok_or_else(wrong)?;
        Ok(Switch { axis, at })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shaft that makes one step per ms, on a timer of 1 MHz.
    #[derive(Default)]
    struct Carriage {
        now: u64,
        highs: Vec<(u64, bool)>,
    }

    impl Switched for Carriage {
        fn now(&self) -> u64 {
            self.now
        }

        fn run_until(&mut self, time: u64) {
            self.now = time;
        }

        fn shaft(&mut self, _: u8) -> i64 {
            (self.now / 1_000) as i64
        }

        fn set_switch(&mut self, axis: u8, high: bool) {
            assert_eq!(axis, 1);
            if self.highs.last().is_none_or(|(_, last)| *last != high) {
                self.highs.push((self.now, high));
            }
        }
    }

    #[test]
    fn it_closes_within_a_look() {
        let (mut board, rate) = (Carriage::default(), Rate::from_hz(1_000_000).unwrap());
        let switch: Switch = "2:5".parse().unwrap();
        run_switched(&mut board, &[switch], rate, 4_950);
        run_switched(&mut board, &[switch], rate, 9_000);
        assert_eq!(board.highs, [(100, true), (5_050, false)]);
        assert_eq!(board.now, 9_000);
        let mut board = Carriage::default();
        run_switched(&mut board, &[], rate, 9_000);
        assert_eq!((board.now, board.highs.len()), (9_000, 0));
    }

    #[test]
    fn closed_at_its_place_and_beyond() {
        let behind: Switch = "1:-300".parse().unwrap();
        assert_eq!(
            [-301, -300, -299, 0].map(|at| behind.is_closed(at)),
            [true, true, false, false]
        );
        let ahead: Switch = "3:+20".parse().unwrap();
        assert_eq!([0, 19, 20, 21].map(|at| ahead.is_closed(at)), [false, false, true, true]);
        for wrong in ["", "1", "1:", "1:0", "0:5", "4:5", "x:5", "1:5mm"] {
            assert!(wrong.parse::<Switch>().is_err(), "{wrong}");
        }
    }
}
