//! What is soldered where: the boards that the firmware is for.

use std::fmt;
use std::str::FromStr;

use crate::elf::Image;

/// Axes of a CNC shield.
pub const AXES: usize = 3;

/// Cycles per second.
pub const HZ: u64 = 16_000_000;

/// A pin of a chip: port B … L and bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin(pub char, pub u8);

/// A timer of 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTimer {
    /// As in its name.
    pub number: u8,
    /// The interrupt of its compare match A.
    pub vector: u8,
    /// The low byte of its compare register A, which is written last.
    pub compare: u16,
}

/// A board with its chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Board {
    /// Arduino Uno, and the Nano, which differs in its size only.
    Uno,
    /// Arduino Mega 2560.
    Mega,
}

impl Board {
    /// The chip, as the simulator calls it.
    pub fn chip(self) -> &'static str {
        match self {
            Board::Uno => "atmega328p",
            Board::Mega => "atmega2560",
        }
    }

    /// As in file names and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Board::Uno => "uno",
            Board::Mega => "mega",
        }
    }

    /// STEP of each axis: D2, D3, D4.
    pub fn step(self) -> [Pin; AXES] {
        match self {
            Board::Uno => [Pin('D', 2), Pin('D', 3), Pin('D', 4)],
            Board::Mega => [Pin('E', 4), Pin('E', 5), Pin('G', 5)],
        }
    }

    /// DIR of each axis: D5, D6, D7.
    pub fn direction(self) -> [Pin; AXES] {
        match self {
            Board::Uno => [Pin('D', 5), Pin('D', 6), Pin('D', 7)],
            Board::Mega => [Pin('E', 3), Pin('H', 3), Pin('H', 4)],
        }
    }

    /// ENABLE of all drivers, low to enable: D8.
    pub fn enable(self) -> Pin {
        match self {
            Board::Uno => Pin('B', 0),
            Board::Mega => Pin('H', 5),
        }
    }

    /// The emergency stop and the fault of a driver, on boards that have these inputs: A0, A1.
    pub fn stoppers(self) -> Option<[Pin; 2]> {
        match self {
            Board::Uno => None,
            Board::Mega => Some([Pin('F', 0), Pin('F', 1)]),
        }
    }

    /// The limit switch of each axis, to ground: D9, D10, D11.
    pub fn switch(self) -> [Pin; AXES] {
        match self {
            Board::Uno => [Pin('B', 1), Pin('B', 2), Pin('B', 3)],
            Board::Mega => [Pin('H', 6), Pin('B', 4), Pin('B', 5)],
        }
    }

    /// The LED: D13.
    pub fn led(self) -> Pin {
        match self {
            Board::Uno => Pin('B', 5),
            Board::Mega => Pin('B', 7),
        }
    }

    /// The timers of 16 bits: any of them can be the step timer.
    pub fn timers(self) -> &'static [StepTimer] {
        match self {
            Board::Uno => &[StepTimer { number: 1, vector: 11, compare: 0x88 }],
            Board::Mega => &[
                StepTimer { number: 1, vector: 17, compare: 0x88 },
                StepTimer { number: 3, vector: 32, compare: 0x98 },
                StepTimer { number: 4, vector: 42, compare: 0xA8 },
                StepTimer { number: 5, vector: 47, compare: 0x128 },
            ],
        }
    }

    /// The timers whose interrupt `image` handles; timer 1 where it handles none,
    /// as the master does.
    pub(crate) fn timers_of(self, image: &Image) -> Vec<StepTimer> {
        let handled = |timer: &&StepTimer| image.defines(&format!("__vector_{}", timer.vector));
        let timers: Vec<_> = self.timers().iter().filter(handled).copied().collect();
        if timers.is_empty() { vec![self.timers()[0]] } else { timers }
    }

    /// The timer that `image` steps by: the first of those.
    pub fn step_timer(self, image: &Image) -> StepTimer {
        self.timers_of(image)[0]
    }

    /// Cycles that the chip takes for RETI: one more where an address has
    /// three bytes.
    pub fn reti(self) -> u64 {
        match self {
            Board::Uno => 4,
            Board::Mega => 5,
        }
    }
}

impl fmt::Display for Board {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Board {
    type Err = String;

    fn from_str(name: &str) -> Result<Board, String> {
        match name {
            "uno" | "nano" => Ok(Board::Uno),
            "mega" => Ok(Board::Mega),
            _ => Err(format!("no board is called {name}: uno, nano or mega")),
        }
    }
}
