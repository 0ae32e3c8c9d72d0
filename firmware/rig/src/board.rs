//! The wiring of the boards that the firmware supports.

use std::fmt;
use std::str::FromStr;

use stepwright::drive::{Arduino, BoardPin};

use crate::elf::Image;

/// The axes of a CNC shield.
pub const AXES: usize = 3;

/// Cycles per second.
pub const HZ: u64 = 16_000_000;

/// A pin of a chip: port B … L and bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin(pub char, pub u8);

/// A timer that may be a step timer, with its compare match A unless another one is requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepTimer {
    /// The number in its name.
    pub number: u8,
    /// The interrupt of its compare match.
    pub vector: u8,
    /// The low byte of its compare register, which is written last.
    pub compare: u16,
    /// The match: 0 for A.
    pub channel: usize,
    /// The bits of its counter.
    pub bits: u32,
    /// The cycles per count, as a power of two.
    pub prescaler: u32,
}

/// The compare match `channel` of a timer of 16 bits that counts every cycle.
const fn wide(number: u8, vector: u8, compare: u16, channel: usize) -> StepTimer {
    let (vector, compare) = (vector + channel as u8, compare + 2 * channel as u16);
    StepTimer { number, vector, compare, channel, bits: 16, prescaler: 0 }
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
    /// The simulator's name of the chip.
    pub fn chip(self) -> &'static str {
        match self {
            Board::Uno => "atmega328p",
            Board::Mega => "atmega2560",
        }
    }

    /// The bytes of its flash, including the boot loader's.
    pub fn flash(self) -> usize {
        match self {
            Board::Uno => 0x8000,
            Board::Mega => 0x4_0000,
        }
    }

    /// The pins of its headers by their names there, without those of the serial line.
    pub fn pins(self) -> Vec<(BoardPin, Pin)> {
        let digital = (2..54).map(BoardPin::D);
        let named = digital.chain((0..16).map(BoardPin::A));
        named.filter_map(|name| Some((name, self.pin(name)?))).collect()
    }

    /// The pin with this name; `None` if the board has none.
    pub fn pin(self, name: BoardPin) -> Option<Pin> {
        let arduino = match self {
            Board::Uno => Arduino::Uno,
            Board::Mega => Arduino::Mega,
        };
        arduino.pin(name).map(|pin| Pin(pin.port, pin.bit))
    }

    /// The name in file names and on the command line.
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

    /// The emergency stop and the fault of a driver: A0, A1.
    pub fn stoppers(self) -> [Pin; 2] {
        match self {
            Board::Uno => [Pin('C', 0), Pin('C', 1)],
            Board::Mega => [Pin('F', 0), Pin('F', 1)],
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

    /// The 16-bit timers, any of which can be the step timer, with their match A.
    pub fn timers(self) -> &'static [StepTimer] {
        const UNO: [StepTimer; 1] = [wide(1, 11, 0x88, 0)];
        const MEGA: [StepTimer; 4] = [
            wide(1, 17, 0x88, 0),
            wide(3, 32, 0x98, 0),
            wide(4, 42, 0xA8, 0),
            wide(5, 47, 0x128, 0),
        ];
        match self {
            Board::Uno => &UNO,
            Board::Mega => &MEGA,
        }
    }

    /// The timers whose interrupt `image` handles; timer 1 if it handles none, like the master.
    pub(crate) fn timers_of(self, image: &Image) -> Vec<StepTimer> {
        let handled = |timer: &&StepTimer| image.defines(&format!("__vector_{}", timer.vector));
        let timers: Vec<_> = self.timers().iter().filter(handled).copied().collect();
        if timers.is_empty() { vec![self.timers()[0]] } else { timers }
    }

    /// Every compare match that `image` uses for steps: those timers, and the channels of the
    /// second and third axis, if they have one.
    pub(crate) fn channels_of(self, image: &Image) -> Vec<StepTimer> {
        let mut channels = self.timers_of(image);
        let first = channels[0];
        let beside = match self {
            Board::Uno => [
                wide(1, 11, 0x88, 1),
                StepTimer {
                    number: 2,
                    vector: 7,
                    compare: 0xB3,
                    channel: 0,
                    bits: 8,
                    prescaler: 3,
                },
            ],
            Board::Mega => [1, 2].map(|n| wide(first.number, first.vector, first.compare, n)),
        };
        let handled = |timer: &StepTimer| image.defines(&format!("__vector_{}", timer.vector));
        channels.extend(beside.into_iter().filter(handled));
        channels
    }

    /// The timer that `image` uses for steps: the first of those.
    pub fn step_timer(self, image: &Image) -> StepTimer {
        self.timers_of(image)[0]
    }

    /// The cycles of RETI: one more if an address has three bytes.
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
