//! The result of a line: its effects, in the order of execution.

use crate::{Coolant, Decimal, Length, Plane, Point, Probe, Spindle, System};

/// The most effects of a block: tool, spindle, coolant, dwell, two parameters, two moves, then
/// spindle, coolant and the end of a program.
const MOST: usize = 11;

/// The effects of a line; an empty line has none.
///
/// ```
/// use stepwright_gcode::{Effect, FeedRate, MoveKind, Reader};
/// let mut reader = Reader::default();
/// let line = b"N20 G1 F300 X1.5 (across) M8\r";
/// let block = line.iter().find_map(|&byte| reader.push(byte)).unwrap()?;
/// assert_eq!((block.line, block.number), (1, Some(20)));
/// let [Effect::Coolant(coolant), Effect::Move(across)] = block.effects().collect::<Vec<_>>()[..]
/// else {
///     panic!("coolant is on before the move");
/// };
/// assert!(coolant.flood);
/// assert_eq!(across.to.to_string(), "X1.5 Y0 Z0");
/// let MoveKind::Feed(FeedRate::PerMinute(rate)) = across.kind else { panic!("not at a rate") };
/// assert_eq!(rate.to_string(), "300");
/// # Ok::<(), stepwright_gcode::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// The line, from 1; CR, LF and CR LF each end one.
    pub line: u32,
    /// N, 0 to 9,999,999.
    pub number: Option<u32>,
    pub(crate) effects: [Option<Effect>; MOST],
}

impl Block {
    /// The effects, in the order of execution.
    pub fn effects(&self) -> impl Iterator<Item = Effect> + '_ {
        self.effects.iter().flatten().copied()
    }

    /// Adds an effect. By the order of execution a block has at most `MOST`.
    pub(crate) fn add(&mut self, effect: Effect) {
        if let Some(free) = self.effects.iter_mut().find(|slot| slot.is_none()) {
            *free = Some(effect);
        }
    }
}

/// One effect of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// T: the present tool is now this one, 0 to 255.
    Tool(u8),
    /// The spindle changes from here on.
    Spindle(Spindle),
    /// The coolant changes from here on.
    Coolant(Coolant),
    /// G4: all axes rest for this many seconds, 0 or more.
    Dwell(Decimal),
    /// A parameter has a new value. A controller keeps it while its power is off, except G92 and the length of
    /// the tool.
    Parameter(Parameter, Point),
    /// The axes move.
    Move(Move),
    /// The program pauses, or ends.
    Stop(Stop),
}

/// A position or an offset with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// The zero of a coordinate system, in machine coordinates.
    System(System),
    /// The machine position that G28 moves to.
    G28,
    /// The machine position that G30 moves to.
    G30,
    /// The offset of G92.
    G92,
    /// The length of the tool, of G43.1: Z alone.
    ToolLength,
}

/// One move of all axes together, in machine coordinates.
///
/// A move along a line has a length above 0; an arc that ends in its plane where it starts, or in the
/// same direction from its centre, is a full circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Move {
    /// The position at its start.
    pub from: Point,
    /// The position at its end.
    pub to: Point,
    /// The path and its speed.
    pub kind: MoveKind,
}

/// The path of a move, and its speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveKind {
    /// A line at the highest speed of the axes.
    Rapid,
    /// A line at a feed rate.
    Feed(FeedRate),
    /// An arc or a helix, of at most one turn.
    Arc(Arc, FeedRate),
    /// A line that a probe ends. The caller must set the place where it ended by
    /// [`Reader::set_position`](crate::Reader::set_position) before the next line.
    Probe(Probe, FeedRate),
}

/// The speed of a move along its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedRate {
    /// G94: a length per minute, above 0.
    PerMinute(Length),
    /// G93: this many such moves per minute, above 0. At 2 the move takes half a minute.
    Inverse(Decimal),
}

/// An arc in a plane; the third axis moves in proportion to the angle.
///
/// The distances of its ends from its centre differ by at most 0.005 mm, or by 0.1 % of the radius
/// and 0.5 mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arc {
    /// The plane.
    pub plane: Plane,
    /// Whether it turns clockwise, seen from the positive end of the third axis.
    pub clockwise: bool,
    /// The machine position of its centre, on the first and the second axis of the plane. It is within a
    /// picometre if the arc was given by a radius, exact otherwise.
    pub centre: [Length; 2],
}

/// A program's pause or end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// M0: a pause until the user resumes.
    Pause,
    /// M1: the same, if the user asked for it.
    OptionalPause,
    /// M2: the end. The next line is the first of another program.
    End,
    /// M30: the end. The same program starts again.
    Rewind,
}
