//! Moves of G-code on a route, in millimetres.
//!
//! The ends of an arc may differ in their distance from the centre, because their digits are rounded. Such an
//! arc is divided into quarters from one radius to the other, each around the centre that fits both of its
//! ends. It leads exactly to its end, and its direction at each joint changes by a part of the difference.
//!
//! An arc whose radius is at most a step of its axes is made of chords.

use std::f64::consts::FRAC_PI_2;

use stepwright_gcode::{Arc, Decimal, FeedRate, Length, Move, MoveKind, Point};

use crate::arc_fit::ArcFit;
use crate::pace::Unplannable;
use crate::route::Route;
use crate::sweep::ArcSweep;

/// Radii that differ by less than this, in mm, count as equal. A centre that is given by a radius is rounded by
/// as much.
const EQUAL: f64 = 1e-8;

/// The most chords of an arc whose radius is at most a step. They are off the arc by 5 millionths of the
/// radius.
const MOST_CHORDS: f64 = 1_000.0;

/// A length of G-code in mm, with the precision of an `f64`.
///
/// ```
/// use stepwright_gcode::Length;
/// assert_eq!(stepwright_path::mm(Length::from_picometres(2_500_000_000).unwrap()), 2.5);
/// ```
pub fn mm(length: Length) -> f64 {
    length.picometres() as f64 / Length::PER_MM as f64
}

/// The length of a number of mm, to a picometre; `None` beyond 1,000,000 mm, and for NaN.
///
/// ```
/// use stepwright_path::{length, mm};
/// assert_eq!(length(-0.0125).map(mm), Some(-0.0125));
/// assert_eq!([1e6 + 1.0, f64::NAN, f64::NEG_INFINITY].map(length), [None; 3]);
/// ```
pub fn length(mm: f64) -> Option<Length> {
    let picometres = (mm * Length::PER_MM as f64).round();
    // The cast makes 0 of NaN, and saturates.
    if picometres.is_nan() { None } else { Length::from_picometres(picometres as i64) }
}

/// A number of G-code, with the precision of an `f64`.
pub fn decimal(number: Decimal) -> f64 {
    number.scaled() as f64 / Decimal::SCALE as f64
}

/// X, Y and Z of a place of G-code, in millimetres.
pub fn millimetres(point: Point) -> [f64; 3] {
    point.0.map(mm)
}

/// The straight distance between two places.
fn distance(from: [f64; 3], to: [f64; 3]) -> f64 {
    from.into_iter().zip(to).map(|(from, to)| to - from).fold(0.0, f64::hypot)
}

fn per_second(rate: FeedRate, distance: f64) -> f64 {
    match rate {
        FeedRate::PerMinute(rate) => mm(rate) / 60.0,
        FeedRate::Inverse(moves) => distance * decimal(moves) / 60.0,
    }
}

impl<T> ArcFit<T, 3> {
    /// Adds a move of G-code, as [`Route::travel`] does. A line at a feed rate may wait; any other move follows
    /// the lines that wait. `tag` makes the tag of the move from its ordered speed in mm/s.
    ///
    /// # Errors
    /// As for [`Route::travel`]; the move is not added.
    pub fn travel(
        &mut self,
        route: &mut Route<3>,
        part: &Move,
        tag: impl FnOnce(f64) -> T,
    ) -> Result<(), Unplannable> {
        if let MoveKind::Feed(rate) = part.kind {
            let (from, to) = (millimetres(part.from), millimetres(part.to));
            let feed = per_second(rate, distance(from, to));
            return self.line_to(route, to, feed, tag(feed));
        }
        self.settle(route)?;
        let feed = route.travel(part)?;
        self.pass_on(route, tag(feed));
        Ok(())
    }
}

impl Route<3> {
    /// Adds a move of G-code, in mm; X, Y and Z are axes 0 to 2. A probe is a line to its end. Returns the
    /// ordered speed of the move, in mm/s.
    ///
    /// The route must end where the move starts. An arc whose ends differ in their distance from the centre, as
    /// G-code tolerates, is made of quarters whose radius changes from one to the other. An arc whose radius is
    /// at most a step of its axes is made of chords, a quarter of a step off the arc.
    ///
    /// # Errors
    /// As for [`line_to`](Route::line_to) and [`arc`](Route::arc).
    pub fn travel(&mut self, part: &Move) -> Result<f64, Unplannable> {
        let (from, to) = (millimetres(part.from), millimetres(part.to));
        match part.kind {
            MoveKind::Rapid => self.rapid_to(to),
            MoveKind::Feed(rate) | MoveKind::Probe(_, rate) => {
                let feed = per_second(rate, distance(from, to));
                self.line_to(to, feed).map(|()| feed)
            }
            MoveKind::Arc(arc, rate) => self.round(&ArcSweep::of(part, arc), arc, rate),
        }
    }

    fn round(&mut self, sweep: &ArcSweep, arc: Arc, rate: FeedRate) -> Result<f64, Unplannable> {
        let [first, second, third] = arc.plane.axes();
        let steps = [first, second].map(|axis| self.axes[axis].step);
        let [start, end] = sweep.radii();
        if start.min(end) <= steps[0].max(steps[1]) {
            return self.chords(sweep, steps[0].min(steps[1]), rate);
        }
        let feed = per_second(rate, sweep.length());
        let (centre, sign) = (arc.centre.map(mm), if arc.clockwise { -1.0 } else { 1.0 });
        let rise = sweep.place(1.0)[third] - sweep.place(0.0)[third];
        let mut climb = [0.0; 3];
        if (end - start).abs() <= EQUAL {
            climb[third] = rise;
            let turn = sign * sweep.turn();
            return self.arc([first, second], centre, turn, climb, feed).map(|()| feed);
        }
        let parts = (sweep.turn() / FRAC_PI_2).ceil();
        climb[third] = rise / parts;
        let mut from = sweep.place(0.0);
        for part in 1..=parts as u32 {
            let to = sweep.place(f64::from(part) / parts);
            let [a, b] = [from, to].map(|end| [end[first], end[second]]);
            // The point at the same distance from both ends that is nearest to the centre.
            let way = [b[0] - a[0], b[1] - a[1]];
            let chord = way[0].hypot(way[1]);
            let ahead = [0, 1].map(|n| centre[n] - (a[n] + b[n]) / 2.0);
            let off = (ahead[0] * way[0] + ahead[1] * way[1]) / chord / chord;
            let fitted = [0, 1].map(|n| centre[n] - off * way[n]);
            let radius = (fitted[0] - a[0]).hypot(fitted[1] - a[1]);
            if radius > steps[0].max(steps[1]) {
                let turn = 2.0 * (chord / 2.0 / radius).min(1.0).asin();
                self.arc([first, second], fitted, sign * turn, climb, feed)?;
            } else {
                // The quarter leads outwards more than around, and is only some steps long.
                self.line_to(to, feed)?;
            }
            from = to;
        }
        Ok(feed)
    }

    /// Adds an arc as chords, a quarter of a step off the arc.
    fn chords(&mut self, sweep: &ArcSweep, step: f64, rate: FeedRate) -> Result<f64, Unplannable> {
        let [start, end] = sweep.radii();
        // A chord is off the arc by radius · (1 − cos(angle / 2)).
        let half = (1.0 - step / 4.0 / start.max(end)).max(0.0).acos();
        let parts = (sweep.turn() / (2.0 * half).min(FRAC_PI_2)).min(MOST_CHORDS).ceil();
        let places = (1..=parts as u32).map(|part| sweep.place(f64::from(part) / parts));
        let mut from = sweep.place(0.0);
        let lengths = places.clone().map(|to| distance(std::mem::replace(&mut from, to), to));
        let feed = per_second(rate, lengths.sum());
        for to in places {
            self.line_to(to, feed)?;
        }
        Ok(feed)
    }
}
