//! The modes that stay in force from block to block.

use crate::{Decimal, Length};

/// The modal state: it applies to blocks without words of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modal {
    /// The motion that axis words cause.
    pub motion: MotionMode,
    /// The plane of arcs.
    pub plane: Plane,
    /// Whether lengths are inches (G20), not millimetres (G21).
    pub inches: bool,
    /// Whether axis words are distances (G91), not positions (G90).
    pub incremental: bool,
    /// Whether F is moves per minute (G93), not length per minute (G94).
    pub inverse_time: bool,
    /// The coordinate system of positions.
    pub system: System,
    /// The feed rate in length per minute; `None` until F is given, and under G93.
    pub feed: Option<Length>,
    /// The spindle, or the laser.
    pub spindle: Spindle,
    /// Coolant.
    pub coolant: Coolant,
    /// The tool, 0 to 255.
    pub tool: u8,
    /// The largest distance of the path from its lines: P of G64; 0 for G61, and for G64 without P.
    pub tolerance: Length,
}

/// The motion that axis words cause.
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
    /// G80: none.
    Off,
}

/// What ends a probing move, and whether it must happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probe {
    /// Whether the contact of the probe closes (G38.2, G38.3), not opens (G38.4, G38.5).
    pub toward: bool,
    /// Whether it is an error if that does not happen (G38.2, G38.4).
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
    /// The numbers of its first, second and third axis: 0 is X.
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

/// The state of the spindle, or of the laser: a signal that holds from its place on the path on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spindle {
    /// Whether and how it turns.
    pub mode: SpindleMode,
    /// S: revolutions per minute, or the power of the laser in its own unit.
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

/// The coolants that flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coolant {
    /// M7.
    pub mist: bool,
    /// M8.
    pub flood: bool,
}
