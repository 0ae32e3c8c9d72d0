//! The words of a block, each in its modal group or under its letter, at most once.

use crate::modal::{MotionMode, Plane, Probe, SpindleMode, System};
use crate::{Decimal, Fault, Stop};

/// A value and its column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At<T> {
    pub it: T,
    pub column: u16,
}

/// A fault and its column.
pub(crate) type Refused = (Fault, u16);

impl<T> At<T> {
    /// A fault in this column.
    pub fn fault(&self, fault: Fault) -> Refused {
        (fault, self.column)
    }
}

/// A code or nothing.
pub(crate) type Slot<T> = Option<At<T>>;

/// The words of a block.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Words {
    pub action: Slot<Action>,
    pub motion: Slot<MotionMode>,
    pub plane: Slot<Plane>,
    /// Whether distances are incremental.
    pub distance: Slot<bool>,
    /// Whether F is inverse time.
    pub feed_mode: Slot<bool>,
    /// Whether lengths are inches.
    pub units: Slot<bool>,
    /// Whether the length of the tool is set, not cancelled.
    pub tool_length: Slot<bool>,
    pub system: Slot<System>,
    pub stop: Slot<Stop>,
    pub spindle: Slot<SpindleMode>,
    pub coolant: Slot<CoolantCode>,
    /// Whether the path continues over corners (G64), with a tolerance or without, or not (G61).
    pub path_control: Slot<bool>,
    // Groups with only one code in the dialect, which changes nothing.
    arc_distance: Slot<()>,
    cutter: Slot<()>,
    values: [Slot<Decimal>; LETTERS.len()],
}

/// Group 0: codes that act once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// G4.
    Dwell,
    /// G10.
    SetSystem,
    /// G28, G30.
    Return(Home),
    /// G28.1, G30.1.
    Keep(Home),
    /// G53.
    Machine,
    /// G92.
    SetOffset,
    /// G92.1.
    ClearOffset,
}

/// A position that the machine returns to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Home {
    G28,
    G30,
}

/// M7, M8, M9.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CoolantCode {
    Mist,
    Flood,
    Off,
}

/// Letters of words with a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Letter {
    F,
    I,
    J,
    K,
    L,
    N,
    P,
    R,
    S,
    T,
    X,
    Y,
    Z,
}

use Letter::*;

const LETTERS: [Letter; 13] = [F, I, J, K, L, N, P, R, S, T, X, Y, Z];

impl Letter {
    /// The letter as a character.
    pub const fn name(self) -> char {
        match self {
            F => 'F',
            I => 'I',
            J => 'J',
            K => 'K',
            L => 'L',
            N => 'N',
            P => 'P',
            R => 'R',
            S => 'S',
            T => 'T',
            X => 'X',
            Y => 'Y',
            Z => 'Z',
        }
    }
}

/// The axis words.
pub(crate) const AXES: [Letter; 3] = [X, Y, Z];
/// The offsets of an arc's centre.
pub(crate) const OFFSETS: [Letter; 3] = [I, J, K];

impl Words {
    /// Adds a word. Its letter is in upper case.
    pub fn add(&mut self, letter: u8, value: Decimal, column: u16) -> Result<(), Refused> {
        match letter {
            b'G' => self.g(value, column),
            b'M' => self.m(value, column),
            _ => {
                let name = char::from(letter);
                match LETTERS.iter().find(|letter| letter.name() == name) {
                    None => Err(Fault::Word(name)),
                    Some(&letter) => {
                        set(&mut self.values[letter as usize], value, column, Fault::Twice(name))
                    }
                }
            }
        }
        .map_err(|fault| (fault, column))
    }

    fn g(&mut self, value: Decimal, column: u16) -> Result<(), Fault> {
        let probe = |toward, must| MotionMode::Probe(Probe { toward, must });
        macro_rules! set {
            ($slot:ident, $code:expr) => {
                set(&mut self.$slot, $code, column, Fault::Group)
            };
        }
        match value.tenths() {
            Some(0) => set!(motion, MotionMode::Rapid),
            Some(10) => set!(motion, MotionMode::Feed),
            Some(20) => set!(motion, MotionMode::Clockwise),
            Some(30) => set!(motion, MotionMode::CounterClockwise),
            Some(40) => set!(action, Action::Dwell),
            Some(100) => set!(action, Action::SetSystem),
            Some(170) => set!(plane, Plane::Xy),
            Some(180) => set!(plane, Plane::Zx),
            Some(190) => set!(plane, Plane::Yz),
            Some(200) => set!(units, true),
            Some(210) => set!(units, false),
            Some(280) => set!(action, Action::Return(Home::G28)),
            Some(281) => set!(action, Action::Keep(Home::G28)),
            Some(300) => set!(action, Action::Return(Home::G30)),
            Some(301) => set!(action, Action::Keep(Home::G30)),
            Some(382) => set!(motion, probe(true, true)),
            Some(383) => set!(motion, probe(true, false)),
            Some(384) => set!(motion, probe(false, true)),
            Some(385) => set!(motion, probe(false, false)),
            Some(400) => set!(cutter, ()),
            Some(431) => set!(tool_length, true),
            Some(490) => set!(tool_length, false),
            Some(530) => set!(action, Action::Machine),
            Some(540) => set!(system, System::G54),
            Some(550) => set!(system, System::G55),
            Some(560) => set!(system, System::G56),
            Some(570) => set!(system, System::G57),
            Some(580) => set!(system, System::G58),
            Some(590) => set!(system, System::G59),
            Some(591..=593) => Err(Fault::NoSystem),
            Some(610) => set!(path_control, false),
            Some(640) => set!(path_control, true),
            Some(800) => set!(motion, MotionMode::Off),
            Some(900) => set!(distance, false),
            Some(910) => set!(distance, true),
            Some(911) => set!(arc_distance, ()),
            Some(920) => set!(action, Action::SetOffset),
            Some(921) => set!(action, Action::ClearOffset),
            Some(930) => set!(feed_mode, true),
            Some(940) => set!(feed_mode, false),
            _ => Err(Fault::GCode),
        }
    }

    fn m(&mut self, value: Decimal, column: u16) -> Result<(), Fault> {
        macro_rules! set {
            ($slot:ident, $code:expr) => {
                set(&mut self.$slot, $code, column, Fault::Group)
            };
        }
        match value.whole() {
            Some(0) => set!(stop, Stop::Pause),
            Some(1) => set!(stop, Stop::OptionalPause),
            Some(2) => set!(stop, Stop::End),
            Some(3) => set!(spindle, SpindleMode::Clockwise),
            Some(4) => set!(spindle, SpindleMode::CounterClockwise),
            Some(5) => set!(spindle, SpindleMode::Off),
            Some(7) => set!(coolant, CoolantCode::Mist),
            Some(8) => set!(coolant, CoolantCode::Flood),
            Some(9) => set!(coolant, CoolantCode::Off),
            Some(30) => set!(stop, Stop::Rewind),
            Some(_) => Err(Fault::MCode),
            None => Err(Fault::Fraction('M')),
        }
    }

    /// Takes the value of a letter, which counts as used from then on. Values that no code takes are refused at
    /// the end.
    pub fn take(&mut self, letter: Letter) -> Slot<Decimal> {
        self.values[letter as usize].take()
    }

    /// The column of a letter that is not used yet, if the block has it.
    pub fn column(&self, letter: Letter) -> Option<u16> {
        Some(self.values[letter as usize]?.column)
    }

    /// The first such column of several letters.
    pub fn any(&self, letters: [Letter; 3]) -> Option<u16> {
        letters.iter().filter_map(|&letter| self.column(letter)).min()
    }

    /// The first word in the line that is not used.
    pub fn unused(&self) -> Option<Refused> {
        let words = LETTERS.into_iter().zip(self.values);
        let unused = words.filter_map(|(letter, word)| Some((letter, word?.column)));
        let (letter, column) = unused.min_by_key(|&(_, column)| column)?;
        Some((Fault::Unused(letter.name()), column))
    }
}

/// Puts a code in its slot.
fn set<T>(slot: &mut Slot<T>, it: T, column: u16, taken: Fault) -> Result<(), Fault> {
    if slot.is_some() {
        return Err(taken);
    }
    *slot = Some(At { it, column });
    Ok(())
}
