//! Moves of G-code on a route, in millimetres.
//!
//! An arc whose ends are not equally far from its centre, because their digits are rounded, is
//! divided into quarters from one radius to the other, each around the centre that fits both of
//! its ends: it leads to its exact end, and its direction changes by a part of the difference.

use std::f64::consts::{FRAC_PI_2, TAU};

use stepwright_gcode::{Arc, Decimal, FeedRate, Length, Move, MoveKind, Point};

use crate::arc_fit::ArcFit;
use crate::pace::Unplannable;
use crate::route::Route;

/// Radii that differ by less, in mm, are equal: what a centre that is given by a radius is
/// rounded by.
const EQUAL: f64 = 1e-8;

/// Millimetres of a length of G-code, to the digits of an `f64`.
///
/// ```
/// use stepwright_gcode::Length;
/// assert_eq!(stepwright_path::mm(Length::from_picometres(2_500_000_000).unwrap()), 2.5);
/// ```
pub fn mm(length: Length) -> f64 {
    length.picometres() as f64 / Length::PER_MM as f64
}

/// A length of so many millimetres, to a picometre; `None` beyond 1,000,000 mm, and of what is no number.
///
/// ```
/// use stepwright_path::{length, mm};
/// assert_eq!(length(-0.0125).map(mm), Some(-0.0125));
/// assert_eq!([1e6 + 1.0, f64::NAN, f64::NEG_INFINITY].map(length), [None; 3]);
/// ```
pub fn length(mm: f64) -> Option<Length> {
    let picometres = (mm * Length::PER_MM as f64).round();
    // Not a number becomes 0, and too much the most.
    if picometres.is_nan() { None } else { Length::from_picometres(picometres as i64) }
}

/// X, Y and Z of a place of G-code, in millimetres.
pub fn millimetres(point: Point) -> [f64; 3] {
    point.0.map(mm)
}

/// From the start of a move straight to its end.
fn distance(part: &Move) -> f64 {
    let (from, to) = (millimetres(part.from), millimetres(part.to));
    from.into_iter().zip(to).map(|(from, to)| to - from).fold(0.0, f64::hypot)
}

fn per_second(rate: FeedRate, distance: f64) -> f64 {
    match rate {
        FeedRate::PerMinute(rate) => mm(rate) / 60.0,
        FeedRate::Inverse(moves) => distance * moves.scaled() as f64 / Decimal::SCALE as f64 / 60.0,
    }
}

impl<T> ArcFit<T, 3> {
    /// Adds a move of G-code, as [`Route::travel`] does. A line at a feed rate may wait; all else comes
    /// behind what waits. `tag` makes what goes with it of its ordered speed in mm/s.
    ///
    /// # Errors
    /// As for [`Route::travel`], and it was not added.
    pub fn travel(
        &mut self,
        route: &mut Route<3>,
        part: &Move,
        tag: impl FnOnce(f64) -> T,
    ) -> Result<(), Unplannable> {
        if let MoveKind::Feed(rate) = part.kind {
            let feed = per_second(rate, distance(part));
            return self.line_to(route, millimetres(part.to), feed, tag(feed));
        }
        self.settle(route)?;
        let feed = route.travel(part)?;
        self.pass_on(route, tag(feed));
        Ok(())
    }
}

impl Route<3> {
    /// Adds a move of G-code, in millimetres; X, Y and Z are axes 0 to 2. A probe is a line to its
    /// end. Gives its ordered speed in mm/s.
    ///
    /// The route is to end where the move starts. An arc whose ends are not equally far from its
    /// centre, as G-code tolerates, is made of quarters whose radius goes from one to the other. An
    /// arc whose radius is not above a step is a line.
    ///
    /// # Errors
    /// As for [`line_to`](Route::line_to) and [`arc`](Route::arc).
    pub fn travel(&mut self, part: &Move) -> Result<f64, Unplannable> {
        let (from, to) = (millimetres(part.from), millimetres(part.to));
        match part.kind {
            MoveKind::Rapid => self.rapid_to(to),
            MoveKind::Feed(rate) | MoveKind::Probe(_, rate) => {
                let feed = per_second(rate, distance(part));
                self.line_to(to, feed).map(|()| feed)
            }
            MoveKind::Arc(arc, rate) => self.round(arc, from, to, rate),
        }
    }

    fn round(
        &mut self,
        arc: Arc,
        from: [f64; 3],
        to: [f64; 3],
        rate: FeedRate,
    ) -> Result<f64, Unplannable> {
        let [first, second, third] = arc.plane.axes();
        let centre = arc.centre.map(mm);
        let spoke = |end: [f64; 3]| [end[first] - centre[0], end[second] - centre[1]];
        let ends = [spoke(from), spoke(to)];
        let radii = ends.map(|[x, y]| x.hypot(y));
        let [begin, stop] = ends.map(|[x, y]| y.atan2(x));
        let turn = if arc.clockwise { begin - stop } else { stop - begin }.rem_euclid(TAU);
        let closed = from[first] == to[first] && from[second] == to[second];
        let turn = if closed { TAU } else { turn };
        let sign = if arc.clockwise { -1.0 } else { 1.0 };
        let (rise, radius) = (to[third] - from[third], (radii[0] + radii[1]) / 2.0);
        let feed = per_second(rate, (radius * turn).hypot(rise));
        let least = self.axes.iter().map(|axis| axis.step).fold(0.0, f64::max);
        if !(radii[0].min(radii[1]) > least && turn > 0.0) {
            return self.line_to(to, feed).map(|()| feed);
        }
        let mut climb = [0.0; 3];
        if (radii[1] - radii[0]).abs() <= EQUAL {
            climb[third] = rise;
            return self.arc([first, second], centre, sign * turn, climb, feed).map(|()| feed);
        }
        let parts = (turn / FRAC_PI_2).ceil();
        climb[third] = rise / parts;
        let mut a = [from[first], from[second]];
        for part in 1..=parts as u32 {
            let share = f64::from(part) / parts;
            let b = if share < 1.0 {
                let angle = begin + sign * turn * share;
                let radius = radii[0] + (radii[1] - radii[0]) * share;
                [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
            } else {
                [to[first], to[second]]
            };
            // The point that is as far from both, nearest to the centre.
            let way = [b[0] - a[0], b[1] - a[1]];
            let chord = way[0].hypot(way[1]);
            let ahead = [0, 1].map(|n| centre[n] - (a[n] + b[n]) / 2.0);
            let off = (ahead[0] * way[0] + ahead[1] * way[1]) / chord / chord;
            let fitted = [0, 1].map(|n| centre[n] - off * way[n]);
            let radius = (fitted[0] - a[0]).hypot(fitted[1] - a[1]);
            let sweep = 2.0 * (chord / 2.0 / radius).min(1.0).asin();
            self.arc([first, second], fitted, sign * sweep, climb, feed)?;
            a = b;
        }
        Ok(feed)
    }
}
