//! The motion of a motor's shaft, from the edges of its pins alone.

use stepwright::drive::Sequence;

use crate::description::Description;
use crate::edge::{Edge, Pin};

/// The shaft of a motor, which follows the edges of its pins.
///
/// The lines of a step change one after the other. With the named drives of a virtual board, no other row of
/// the table appears between a row and the next.
///
/// ```
/// use stepwright_sim::{Description, Edge, Pin, Shaft};
/// let mut shaft = Shaft::of(&Description::uno(), 0);
/// for (time, pin, level) in [(0, Pin::Direction, true), (9, Pin::Step, true)] {
///     shaft.follow(Edge { time, axis: 0, pin, level });
/// }
/// assert_eq!(shaft.position(), 1);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Shaft {
    position: i64,
    /// The level of DIR.
    forward: bool,
    coils: Option<Followed>,
}

/// The lines to a motor's windings.
#[derive(Clone, Copy, Debug)]
struct Followed {
    sequence: Sequence,
    levels: u8,
    /// The last complete row.
    phase: u8,
}

impl Followed {
    /// Follows a change of a line. Returns the direction of the step once the lines have the next row or the
    /// one before.
    fn follow(&mut self, line: u8, level: bool) -> Option<bool> {
        let bit = 1u8.checked_shl(line.into())?;
        self.levels = if level { self.levels | bit } else { self.levels & !bit };
        for forward in [true, false] {
            let phase = self.sequence.after(self.phase, forward);
            if self.levels == self.sequence.levels(phase) {
                self.phase = phase;
                return Some(forward);
            }
        }
        None
    }
}

impl Shaft {
    /// The shaft of an axis of a board that was just switched on.
    pub fn of(description: &Description, axis: u8) -> Shaft {
        let sequence = description.coils.get(usize::from(axis)).copied().flatten();
        let followed =
            |sequence: Sequence| Followed { sequence, levels: sequence.levels(0), phase: 0 };
        Shaft { coils: sequence.map(followed), ..Shaft::default() }
    }

    /// Follows an edge of the axis' pins. If it makes a step, returns whether forward.
    pub fn follow(&mut self, edge: Edge) -> Option<bool> {
        let forward = match (edge.pin, &mut self.coils) {
            (Pin::Direction, _) => {
                self.forward = edge.level;
                None
            }
            (Pin::Step, None) => edge.level.then_some(self.forward),
            (Pin::Coil(line), Some(coils)) => coils.follow(line, edge.level),
            _ => None,
        }?;
        self.position += if forward { 1 } else { -1 };
        Some(forward)
    }

    /// Steps forward minus steps backward.
    pub fn position(&self) -> i64 {
        self.position
    }
}
