//! An arc of G-code, in millimetres: by how much it turns, how long it is, where it leads.

use std::f64::consts::{FRAC_PI_2, TAU};

use stepwright_gcode::{Arc, Move, Point};

use crate::moves::{millimetres, mm};

/// The way of an arc of G-code. Where its ends are not equally far from its centre, the radius goes from one to the
/// other in proportion to the angle.
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
    /// That of a move along this arc.
    pub fn of(part: &Move, arc: Arc) -> ArcSweep {
        let [first, second, _] = arc.plane.axes();
        let spoke = |end: Point| {
            let away = |axis: usize, n: usize| {
                i128::from(end.0[axis].picometres() - arc.centre[n].picometres())
            };
            [away(first, 0), away(second, 1)]
        };
        let ([x, y], [u, v]) = (spoke(part.from), spoke(part.to));
        // In whole numbers: ends on one spoke are that whatever its direction.
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

    /// Radians, above 0. It is 2π where both ends are in the same direction from the centre.
    pub fn turn(&self) -> f64 {
        self.turn
    }

    /// How far its start and its end are from the centre.
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }

    /// How long it is, with what the third axis moves.
    pub fn length(&self) -> f64 {
        let third = self.arc.plane.axes()[2];
        let [start, end] = self.radii;
        let round = (start + end) / 2.0 * self.turn;
        round.hypot(end - start).hypot(self.to[third] - self.from[third])
    }

    fn sign(&self) -> f64 {
        if self.arc.clockwise { -1.0 } else { 1.0 }
    }

    /// The distance from the centre at a part of its way, from 0 to 1.
    fn radius(&self, share: f64) -> f64 {
        self.radii[0] + (self.radii[1] - self.radii[0]) * share
    }

    /// Where it is at a part of its way, from 0 to 1: there, its end to the last digit.
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

    /// The axis and its coordinate, of the four sides of its circle that it passes.
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
