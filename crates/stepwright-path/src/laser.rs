//! The power of a laser along a move of G-code, by the rules of grbl's laser mode.

use stepwright_gcode::{Move, MoveKind, Spindle, SpindleMode};

use crate::decimal;

/// The order to a laser along a move. M3 orders a constant power, M4 a power in proportion to the speed.
///
/// The laser burns only along arcs and lines at a feed rate. It is off on rapids and probing moves. The caller
/// decides what it does while the axes rest.
///
/// ```
/// use stepwright_gcode::{Effect, Reader};
/// use stepwright_path::LaserMove;
/// let (mut reader, mut spindle, mut moves) = (Reader::default(), Default::default(), Vec::new());
/// for byte in *b"M4 S500 G1 F3000 X9\nG0 X0\n" {
///     let Some(block) = reader.push(byte) else { continue };
///     for effect in block?.effects() {
///         match effect {
///             Effect::Spindle(ordered) => spindle = ordered,
///             Effect::Move(part) => moves.push(LaserMove::new(&part, spindle, 50.0)),
///             _ => {}
///         }
///     }
/// }
/// // At half of its 50 mm/s half of S; nothing on the way back.
/// assert_eq!((moves[0].s(25.0), moves[1].s(25.0)), (250.0, 0.0));
/// # Ok::<(), stepwright_gcode::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaserMove {
    mode: SpindleMode,
    s: f64,
    /// The ordered speed, in mm/s.
    feed: f64,
}

impl LaserMove {
    /// The order for a move, from the M3, M4, M5 and S before it, and the ordered speed in mm/s that
    /// [`travel`](crate::Route::travel) returns.
    pub fn new(part: &Move, ordered: Spindle, feed: f64) -> LaserMove {
        let burns = matches!(part.kind, MoveKind::Feed(_) | MoveKind::Arc(..));
        let mode = if burns { ordered.mode } else { SpindleMode::Off };
        LaserMove { mode, s: decimal(ordered.speed), feed }
    }

    /// The rule of its power; off on moves on which the laser does not burn.
    pub fn mode(&self) -> SpindleMode {
        self.mode
    }

    /// The ordered S; 0 on moves on which the laser does not burn.
    pub fn ordered(&self) -> f64 {
        if self.mode == SpindleMode::Off { 0.0 } else { self.s }
    }

    /// Whether the laser burns while the axes move.
    pub fn is_on(&self) -> bool {
        self.ordered() > 0.0
    }

    /// S while the axes move at `speed` mm/s along the path. With M4, an override that makes the move faster
    /// than its feed rate makes S higher than ordered.
    pub fn s(&self, speed: f64) -> f64 {
        match self.mode {
            SpindleMode::Off => 0.0,
            SpindleMode::Clockwise => self.s,
            SpindleMode::CounterClockwise if self.feed > 0.0 => self.s * speed / self.feed,
            SpindleMode::CounterClockwise => 0.0,
        }
    }
}
