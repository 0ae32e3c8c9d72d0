//! What a laser does along a move of G-code, by the rule of grbl's laser mode.

use stepwright_gcode::{Move, MoveKind, Spindle, SpindleMode};

use crate::decimal;

/// The order of a laser along a move: M3 is a constant power, M4 one in proportion to the speed.
///
/// It burns along lines at a feed rate and arcs alone: on a rapid move and on a probing one it is
/// off. Where the axes stand it is for who asks to say so.
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
    /// mm/s.
    feed: f64,
}

impl LaserMove {
    /// Of a move, by what M3, M4, M5 and S ordered before it, and its ordered speed in mm/s, as
    /// [`travel`](crate::Route::travel) gives it.
    pub fn new(part: &Move, ordered: Spindle, feed: f64) -> LaserMove {
        let burns = matches!(part.kind, MoveKind::Feed(_) | MoveKind::Arc(..));
        let mode = if burns { ordered.mode } else { SpindleMode::Off };
        LaserMove { mode, s: decimal(ordered.speed), feed }
    }

    /// By which rule: off on moves on which it does not burn.
    pub fn mode(&self) -> SpindleMode {
        self.mode
    }

    /// S as it is ordered; 0 on moves on which it does not burn.
    pub fn ordered(&self) -> f64 {
        if self.mode == SpindleMode::Off { 0.0 } else { self.s }
    }

    /// Whether it burns while the axes move.
    pub fn is_on(&self) -> bool {
        self.ordered() > 0.0
    }

    /// S while the axes move by `speed` mm/s along the path: above what was ordered where an override
    /// makes M4 faster than its feed rate.
    pub fn s(&self, speed: f64) -> f64 {
        match self.mode {
            SpindleMode::Off => 0.0,
            SpindleMode::Clockwise => self.s,
            SpindleMode::CounterClockwise if self.feed > 0.0 => self.s * speed / self.feed,
            SpindleMode::CounterClockwise => 0.0,
        }
    }
}
