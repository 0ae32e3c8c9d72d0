//! The modes that hold from block to block.

use crate::{Decimal, Length};

/// What a block without a word of its own does: the modal state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modal {
    /// How axis words move.
    pub motion: MotionMode,
    /// The plane of arcs.
    pub plane: Plane,
    /// Lengths are inches (G20), not millimetres (G21).
    pub inches: bool,
    /// Axis words are distances (G91), not positions (G90).
    pub incremental: bool,
    /// F is moves a minute (G93), not length a minute (G94).
    pub inverse_time: bool,
    /// The coordinate system of positions.
    pub system: System,
    /// The feed rate in length a minute; none until F is given, and none under G93.
    pub feed: Option<Length>,
    /// The spindle, or the laser.
    pub spindle: Spindle,
    /// Coolant.
    pub coolant: Coolant,
    /// The tool, 0 to 255.
    pub tool: u8,
    /// How far the path may be off its lines: P of G64; 0 of G61, and of G64 without a P.
    pub tolerance: Length,
}

/// How axis words move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionMode {
    /// G0.
    #[default]
    Rapid,
    /// G1.
    Feed,
    /// G2.
    Clockwise,
    /// G3.
    CounterClockwise,
    /// G38.2 to G38.5.
    Probe(Probe),
    /// G80: not at all.
    Off,
}

/// What ends a probing move, and whether it must.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probe {
    /// The probe's contact closes (G38.2, G38.3), not opens (G38.4, G38.5).
    pub toward: bool,
    /// It is an error if that does not happen (G38.2, G38.4).
    pub must: bool,
}

/// The plane of arcs. Seen from the positive end of the third axis, its first axis turns
/// counter-clockwise into its second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// G17: X, then Y.
    #[default]
    Xy,
    /// G18: Z, then X.
    Zx,
    /// G19: Y, then Z.
    Yz,
}

impl Plane {
    /// The numbers of its first and its second axis, and of the third: 0 is X.
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Plane::Xy => [0, 1, 2],
            Plane::Zx => [2, 0, 1],
            Plane::Yz => [1, 2, 0],
        }
    }
}

/// A coordinate system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum System {
    /// The first.
    #[default]
    G54,
    /// The second.
    G55,
    /// The third.
    G56,
    /// The fourth.
    G57,
    /// The fifth.
    G58,
    /// The sixth.
    G59,
}

impl System {
    /// All, in order.
    pub const ALL: [System; 6] =
        [System::G54, System::G55, System::G56, System::G57, System::G58, System::G59];
}

/// What the spindle does, or the laser: a signal that holds from here on along the path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spindle {
    /// Whether and how it turns.
    pub mode: SpindleMode,
    /// S: revolutions a minute, or the laser's power in a unit of its own.
    pub speed: Decimal,
}

/// Whether and how the spindle turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpindleMode {
    /// M5.
    #[default]
    Off,
    /// M3; a laser's power is constant.
    Clockwise,
    /// M4; a laser's power is in proportion to the speed along the path.
    CounterClockwise,
}

/// Which coolant flows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coolant {
    /// M7.
    pub mist: bool,
    /// M8.
    pub flood: bool,
}
