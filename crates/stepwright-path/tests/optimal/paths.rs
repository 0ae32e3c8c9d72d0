//! Random paths of lines, arcs, smooth joints and chords of curves, of two and three unequal axes; or only of
//! lines with corners.

use std::f64::consts::TAU;

use stepwright_path::{AxisPace, Route};

use super::{Piece, Shape};
use crate::jobs::Dice;

/// The pieces of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kinds {
    All,
    Lines,
}

/// A path, and its axes.
pub struct Path<const N: usize> {
    pub axes: [AxisPace; N],
    pub pieces: Vec<Piece<N>>,
}

impl<const N: usize> Path<N> {
    pub fn random(seed: u64, kinds: Kinds) -> Path<N> {
        let mut dice = Dice(seed);
        let axes = std::array::from_fn(|_| {
            let accel = 300.0 * 7f64.powf(dice.roll());
            AxisPace {
                step: 0.0125,
                speed: 100.0 + 150.0 * dice.roll(),
                accel,
                jump: 2.0 + 6.0 * dice.roll(),
                // The axis reaches its acceleration in 20 to 150 ms.
                jerk: accel / (0.02 + 0.13 * dice.roll()),
            }
        });
        let mut path = Path { axes, pieces: vec![] };
        while path.pieces.iter().map(|piece| piece.shape.length()).sum::<f64>() < 120.0 {
            path.add(&mut dice, kinds);
        }
        path
    }

    fn add(&mut self, dice: &mut Dice, kinds: Kinds) {
        let feed = 20.0 + 130.0 * dice.roll();
        let (kind, angle) = (dice.roll(), TAU * dice.roll());
        let kind = if kinds == Kinds::Lines { 0.0 } else { kind };
        let mut line = |angle: f64, length, chord| {
            let mut t = [0.0; N];
            (t[0], t[1]) = (angle.cos(), angle.sin());
            self.pieces.push(Piece { shape: Shape::Line { t, length }, feed, chord });
        };
        let (radius, sign) = (2.0 + 13.0 * dice.roll(), if dice.roll() < 0.5 { 1.0 } else { -1.0 });
        let sweep = sign * (0.5 + 2.5 * dice.roll());
        if kind < 0.35 {
            // A line in any direction.
            let mut t: [f64; N] = std::array::from_fn(|_| 2.0 * dice.roll() - 1.0);
            let norm = t.iter().map(|t| t * t).sum::<f64>().sqrt();
            t = t.map(|t| t / norm);
            let length = 2.0 + 18.0 * dice.roll();
            self.pieces.push(Piece { shape: Shape::Line { t, length }, feed, chord: false });
        } else if kind < 0.6 {
            // A line, an arc that touches it, and a line.
            line(angle, 1.0 + 9.0 * dice.roll(), false);
            let from = angle - sign * TAU / 4.0;
            let shape = Shape::Arc { radius, from, sweep };
            self.pieces.push(Piece { shape, feed, chord: false });
            let mut t = [0.0; N];
            (t[0], t[1]) = ((angle + sweep).cos(), (angle + sweep).sin());
            let shape = Shape::Line { t, length: 1.0 + 9.0 * dice.roll() };
            self.pieces.push(Piece { shape, feed, chord: false });
        } else if kind < 0.75 {
            let shape = Shape::Arc { radius, from: angle, sweep };
            self.pieces.push(Piece { shape, feed, chord: false });
        } else {
            // A line, chords of a curve that touches it, and a line.
            line(angle, 1.0 + 9.0 * dice.roll(), false);
            let count = (sweep.abs() * radius / (0.1 + 0.4 * dice.roll())).ceil();
            let turn = sweep / count;
            let chord = 2.0 * radius * (turn.abs() / 2.0).sin();
            for n in 0..count as u32 {
                line(angle + turn * (f64::from(n) + 0.5), chord, true);
            }
            line(angle + sweep, 1.0 + 9.0 * dice.roll(), true);
        }
    }

    /// The axes with limited jerk, or without.
    pub fn axes(&self, smooth: bool) -> [AxisPace; N] {
        let jerk = |axis: AxisPace| if smooth { axis.jerk } else { f64::INFINITY };
        self.axes.map(|axis| AxisPace { jerk: jerk(axis), ..axis })
    }

    /// The time of its steps, from the start to the end, in s.
    pub fn executed(&self, smooth: bool) -> f64 {
        let mut route = Route::new(self.axes(smooth)).unwrap();
        self.add_to(&mut route);
        route.close();
        assert!(route.by_ref().count() > 0 && route.is_over());
        route.time()
    }

    /// Adds all pieces at once.
    pub fn add_to(&self, route: &mut Route<N>) {
        for piece in &self.pieces {
            let place = route.end();
            match piece.shape {
                Shape::Line { t, length } => {
                    let to = std::array::from_fn(|axis| place[axis] + t[axis] * length);
                    route.line_to(to, piece.feed).unwrap();
                }
                Shape::Arc { radius, from, sweep } => {
                    let centre = [place[0] - radius * from.cos(), place[1] - radius * from.sin()];
                    route.arc([0, 1], centre, sweep, [0.0; N], piece.feed).unwrap();
                }
            }
        }
    }
}
