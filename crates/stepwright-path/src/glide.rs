//! The motion of a route over time, while its steps are made: for outputs that follow its speed.
//!
//! ```text
//!   steps    ┃ ┃  ┃   ┃    ┃         ┃    ┃   ┃
//!   glides   ├──────┼──────┼─────────┼──────┼─────►  time
//!             moves         stands    moves
//! ```
//!
//! A change of the route takes effect after the last step, so the motion before that step is final.

use std::collections::VecDeque;

use crate::piece::Piece;
use crate::route::Route;

/// The difference below which two times count as equal, in s.
const SAME: f64 = 1e-9;

/// An interval of time in which a route moves with a constant jerk, or rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glide {
    /// The times of its beginning and its end, in s after the start.
    pub times: [f64; 2],
    /// A place along the route, in units, between the end of the interval and the end of its move.
    pub within: f64,
    /// `None` at rest.
    piece: Option<Piece>,
}

impl Glide {
    /// Whether the route rests.
    pub fn is_rest(&self) -> bool {
        self.piece.is_none()
    }

    /// The speed along the route at this time, which must be within the interval, in units/s.
    pub fn speed(&self, time: f64) -> f64 {
        self.piece.map_or(0.0, |piece| piece.at(time.max(piece.from.t)).v.max(0.0))
    }

    /// The time between its ends at which the speed is lowest or highest, if there is one.
    pub fn turn(&self) -> Option<f64> {
        let piece = self.piece.filter(|piece| piece.jerk != 0.0)?;
        let time = piece.from.t - piece.from.a / piece.jerk;
        (self.times[0]..self.times[1]).contains(&time).then_some(time)
    }
}

/// The recorded motion that was not taken yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Glides {
    /// The pieces passed, each with the end of its cell along the route.
    passed: VecDeque<(f64, Piece)>,
    /// The time up to which the motion was taken.
    taken: f64,
}

impl<const N: usize> Route<N> {
    /// Records the motion for [`glide`](Route::glide): a few intervals of constant jerk per cell, until they
    /// are taken. To be called before the first piece.
    pub fn with_glides(mut self) -> Route<N> {
        self.glides = Some(Glides::default());
        self
    }

    /// Returns the next interval, from the end of the last one up to `until` s at most, without a gap. `None`
    /// if all before `until` was taken, or is not known before the next step.
    pub fn glide(&mut self, until: f64) -> Option<Glide> {
        let idle = self.is_held() || self.is_over();
        let glides = self.glides.as_mut()?;
        loop {
            let from = glides.taken;
            let (passed, within, piece, known) = match (glides.passed.front(), &self.front) {
                (Some((within, piece)), _) => (true, *within, *piece, until),
                (None, Some(pieces)) => {
                    let piece = pieces.iter().find(|piece| piece.to.t > from)?;
                    (false, self.cells.front()?.end, *piece, until.min(self.now))
                }
                (None, None) if idle && until > from && until < f64::INFINITY => {
                    glides.taken = until;
                    let within = self.length;
                    return Some(Glide { times: [from, until], within, piece: None });
                }
                (None, None) => return None,
            };
            let begin = piece.from.t.min(until);
            if begin > from + SAME {
                glides.taken = begin;
                return Some(Glide { times: [from, begin], within, piece: None });
            }
            let to = piece.to.t.min(known);
            if passed && to == piece.to.t {
                glides.passed.pop_front();
            } else if to <= from {
                return None;
            }
            if to > from {
                glides.taken = to;
                return Some(Glide { times: [from, to], within, piece: Some(piece) });
            }
        }
    }

    /// Records the motion over the first cell up to this time.
    pub(crate) fn take_down(&mut self, until: f64) {
        let (Some(glides), Some(pieces)) = (&mut self.glides, &self.front) else { return };
        let Some(cell) = self.cells.front() else { return };
        let lasts = |piece: &&Piece| piece.from.t < piece.to.t && piece.from.t < until;
        let parts = pieces.iter().filter(lasts).map(|piece| (cell.end, piece.until(until)));
        glides.passed.extend(parts);
    }
}

#[cfg(test)]
mod tests {
    use crate::{AxisPace, Glide, Route};

    fn route(jerk: f64) -> Route<2> {
        let axis = AxisPace { step: 0.01, speed: 100.0, accel: 1_000.0, jump: 5.0, jerk };
        let mut route = Route::new([axis; 2]).unwrap().with_glides();
        route.line_to([20.0, 5.0], 60.0).unwrap();
        route.arc([0, 1], [20.0, 10.0], 4.0, [0.0; 2], 50.0).unwrap();
        route.line_to([0.0, 0.0], 80.0).unwrap();
        route.close();
        route
    }

    /// The distance by its speeds, by Simpson's rule: exact, as the speed is a parabola.
    fn way(glide: &Glide) -> f64 {
        let [from, to] = glide.times;
        let speed = |part: f64| glide.speed(from + (to - from) * part);
        (to - from) * (speed(0.0) + 4.0 * speed(0.5) + speed(1.0)) / 6.0
    }

    /// At whatever times it is asked, the speeds add up to the whole route in all of its time, with a hold and
    /// a dwell. Nothing is returned before it is final.
    #[test]
    fn all_of_its_time_is_told_once() {
        for (jerk, stride) in
            [(f64::INFINITY, 1), (f64::INFINITY, 37), (20_000.0, 1), (9_000.0, 90)]
        {
            let mut route = route(jerk);
            let (mut gone, mut now, mut stood, mut steps) = (0.0, 0.0, 0.0, 0);
            let mut take = |route: &mut Route<2>, until: f64| {
                while let Some(glide) = route.glide(until) {
                    assert_eq!(glide.times[0], now);
                    now = glide.times[1];
                    assert!(now <= until && gone <= glide.within + 1e-9);
                    gone += way(&glide);
                    stood += if glide.is_rest() { now - glide.times[0] } else { 0.0 };
                    if let Some(turn) = glide.turn() {
                        assert!((glide.times[0]..now).contains(&turn), "{glide:?}");
                    }
                }
                gone
            };
            let mut last = 0.0;
            loop {
                while let Some(step) = route.next() {
                    last = step.time;
                    steps += 1;
                    if steps == 1_500 {
                        route.hold(last);
                    }
                    if steps % stride == 0 {
                        let gone = take(&mut route, last);
                        let (here, _) = route.along(last);
                        assert!((gone - here).abs() < 1e-6, "{gone} {here}");
                    }
                }
                if !route.is_held() {
                    break;
                }
                let at = route.time() + 0.5;
                take(&mut route, at - 0.2);
                route.resume(at);
            }
            assert!(route.dwell(0.25));
            let (length, end) = (route.length(), route.time());
            let gone = take(&mut route, end);
            assert!((gone - length).abs() < 1e-6, "{gone} {length}");
            assert!(now == end && end > last && (stood - 0.75).abs() < 1e-6, "{now} {end} {stood}");
            assert_eq!(route.glide(end), None);
        }
    }
}
