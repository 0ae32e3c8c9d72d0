//! What comes of a line: effects, in the order in which they happen.

use crate::{Coolant, Decimal, Length, Plane, Point, Probe, Spindle, System};

/// The most effects of a block: tool, spindle, coolant, dwell, two parameters, two moves, then
/// spindle, coolant and the end of a program.
const MOST: usize = 11;

/// What a line says; an empty line says nothing.
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
    /// What happens, in order.
    pub fn effects(&self) -> impl Iterator<Item = Effect> + '_ {
        self.effects.iter().flatten().copied()
    }

    /// One more. The order of execution has at most `MOST` in a block.
    pub(crate) fn add(&mut self, effect: Effect) {
        if let Some(free) = self.effects.iter_mut().find(|slot| slot.is_none()) {
            *free = Some(effect);
        }
    }
}

/// One thing that a block does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// T: another tool, 0 to 255, is the present one.
    Tool(u8),
    /// The spindle changes from here on.
    Spindle(Spindle),
    /// The coolant changes from here on.
    Coolant(Coolant),
    /// G4: all axes rest for this many seconds, 0 or more.
    Dwell(Decimal),
    /// A parameter has a new value, which a controller keeps when its power goes off (but for
    /// G92 and the length of the tool).
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

/// One move of all axes at once, in machine coordinates.
///
/// A move along a line has a length above 0; an arc that ends in its plane where it starts, or in the
/// same direction from its centre, is a full circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Move {
    /// Where it starts.
    pub from: Point,
    /// Where it ends.
    pub to: Point,
    /// The path, and how fast.
    pub kind: MoveKind,
}

/// The path of a move, and how fast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveKind {
    /// A line, as fast as the axes can.
    Rapid,
    /// A line.
    Feed(FeedRate),
    /// An arc or a helix, by less than a turn or by one.
    Arc(Arc, FeedRate),
    /// A line that a probe ends. Where it did is to be told by
    /// [`Reader::set_position`](crate::Reader::set_position) before the next line.
    Probe(Probe, FeedRate),
}

/// How fast a move goes along its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedRate {
    /// G94: a length each minute, above 0.
    PerMinute(Length),
    /// G93: this part of a minute is one move, above 0: 2 is half a minute.
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
    /// Seen from the positive end of the third axis.
    pub clockwise: bool,
    /// The machine position of its centre, of the plane's first axis and its second; within a
    /// picometre if it was given by a radius, exact otherwise.
    pub centre: [Length; 2],
}

/// A program's pause or end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// M0: until somebody resumes.
    Pause,
    /// M1: the same, if somebody asked for it.
    OptionalPause,
    /// M2: the end; the next line is another program's first.
    End,
    /// M30: the end; the same program again.
    Rewind,
}
