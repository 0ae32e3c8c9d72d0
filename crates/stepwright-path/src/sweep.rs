//! An arc of G-code, in mm: its angle, its length and its places.

use std::f64::consts::{FRAC_PI_2, TAU};

use stepwright_gcode::{Arc, Move, Point};

use crate::moves::{millimetres, mm};

/// The path of an arc of G-code. If its ends differ in their distance from the centre, the radius changes from
/// one to the other in proportion to the angle.
///
/// ```
/// use stepwright_gcode::{Effect, MoveKind, Reader};
/// use stepwright_path::ArcSweep;
/// let mut reader = Reader::default();
/// let block = b"G3 F600 X20 I10\n".iter().find_map(|&byte| reader.push(byte)).unwrap()?;
/// let Some(Effect::Move(half)) = block.effects().next() else { panic!("no move") };
/// let MoveKind::Arc(arc, _) = half.kind else { panic!("no arc") };
/// let sweep = ArcSweep::of(&half, arc);
/// assert!((sweep.length() - 10.0 * std::f64::consts::PI).abs() < 1e-9);
/// // Its lowest place.
/// let (_, least) = sweep.sides().find(|(axis, _)| *axis == 1).unwrap();
/// assert!((least + 10.0).abs() < 1e-9);
/// # Ok::<(), stepwright_gcode::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcSweep {
    arc: Arc,
    from: [f64; 3],
    to: [f64; 3],
    centre: [f64; 2],
    radii: [f64; 2],
    /// The angle of its start.
    begin: f64,
    turn: f64,
}

impl ArcSweep {
    /// The path of a move along this arc.
    pub fn of(part: &Move, arc: Arc) -> ArcSweep {
        let [first, second, _] = arc.plane.axes();
        let spoke = |end: Point| {
            let away = |axis: usize, n: usize| {
                i128::from(end.0[axis].picometres() - arc.centre[n].picometres())
            };
            [away(first, 0), away(second, 1)]
        };
        let ([x, y], [u, v]) = (spoke(part.from), spoke(part.to));
        // In integers: ends in the same direction from the centre are so exactly, whatever the direction.
        let angle = ((x * v - y * u) as f64).atan2((x * u + y * v) as f64);
        let angle = if arc.clockwise { -angle } else { angle };
        let centre = arc.centre.map(mm);
        let (from, to) = (millimetres(part.from), millimetres(part.to));
        let radius = |end: [f64; 3]| (end[first] - centre[0]).hypot(end[second] - centre[1]);
        ArcSweep {
            arc,
            from,
            to,
            centre,
            radii: [radius(from), radius(to)],
            begin: (from[second] - centre[1]).atan2(from[first] - centre[0]),
            turn: if angle > 0.0 { angle } else { angle + TAU },
        }
    }

    /// The angle by which it turns, in radians, above 0. It is 2π if both ends are in the same direction from
    /// the centre.
    pub fn turn(&self) -> f64 {
        self.turn
    }

    /// The distances of its start and its end from the centre, in mm.
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// Its length in mm, with the motion of the third axis.
    pub fn length(&self) -> f64 {
        let third = self.arc.plane.axes()[2];
        let [start, end] = self.radii;
        let round = (start + end) / 2.0 * self.turn;
        round.hypot(end - start).hypot(self.to[third] - self.from[third])
    }

    fn sign(&self) -> f64 {
        if self.arc.clockwise { -1.0 } else { 1.0 }
    }

    /// The distance from the centre at a part of the path, from 0 to 1.
    fn radius(&self, share: f64) -> f64 {
        self.radii[0] + (self.radii[1] - self.radii[0]) * share
    }

    /// The place at a part of the path, from 0 to 1. At 1 it is exactly the end.
    pub fn place(&self, share: f64) -> [f64; 3] {
        if share >= 1.0 {
            return self.to;
        }
        let [first, second, third] = self.arc.plane.axes();
        let (angle, radius) = (self.begin + self.sign() * self.turn * share, self.radius(share));
        let mut place = [0.0; 3];
        place[first] = self.centre[0] + radius * angle.cos();
        place[second] = self.centre[1] + radius * angle.sin();
        place[third] = self.from[third] + (self.to[third] - self.from[third]) * share;
        place
    }

    /// The sides of its circle that it passes, of four: the axis, and its coordinate there.
    pub fn sides(&self) -> impl Iterator<Item = (usize, f64)> {
        let (sweep, [first, second, _]) = (*self, self.arc.plane.axes());
        (0..4_u8).filter_map(move |side| {
            let ahead = sweep.sign() * (f64::from(side) * FRAC_PI_2 - sweep.begin);
            let share = ahead.rem_euclid(TAU) / sweep.turn;
            let reach = sweep.radius(share);
            let reach = if side < 2 { reach } else { -reach };
            let (n, axis) = if side % 2 == 0 { (0, first) } else { (1, second) };
            (share < 1.0).then_some((axis, sweep.centre[n] + reach))
        })
    }
}
