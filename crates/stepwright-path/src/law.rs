//! The place on a path over time: a ramp, a top speed, a ramp, and changes on the way.
//!
//! ```text
//!   v        ╱▔▔▔▔▔▔▔╲                ╱▔▔▔╲_____
//!          ╱           ╲            ╱           ╲
//!        ╱               ╲________╱              ╲
//!   t        pause asked ┊         ┊ resumed ┊ slower
//! ```
//!
//! Each change begins with the present speed and acceleration, so both stay within the limits. With a limited
//! jerk the acceleration does not jump either. Braking that has begun continues to rest; changes that are asked
//! for meanwhile take effect there. Changes take effect in the order of their times: a change for an earlier
//! time than the last takes effect together with it.

use crate::course;
use crate::pace::{Pace, Unplannable};
use crate::piece::{Moment, Piece};

/// The smallest and the largest override of the speed.
pub const SCALES: std::ops::RangeInclusive<f64> = 0.1..=2.0;

/// A motion along a path from rest to rest.
///
/// ```
/// use stepwright_path::{Law, Pace};
/// let mut law = Law::new(100.0, Pace::new(10.0, 10.0))?;
/// assert_eq!(law.end(), Some(11.0));
/// law.scale(2.0, 0.5)?; // from 2 s on at half the speed
/// assert_eq!((law.speed(2.0), law.speed(2.5), law.speed(3.0)), (10.0, 5.0, 5.0));
/// # Ok::<(), stepwright_path::Unplannable>(())
/// ```
#[derive(Clone, Debug)]
pub struct Law {
    pace: Pace,
    /// The highest speed along the path that the axes allow.
    most: f64,
    scale: f64,
    length: f64,
    /// The pieces in the order of time; the last one ends at rest.
    pieces: Vec<Piece>,
    /// The time and place at which the last ordered braking ends.
    rest: Option<(f64, f64)>,
    paused: bool,
    finished: bool,
    /// The time at which the last change took effect.
    changed: f64,
}

/// A stop beyond the end by at most this part of the path counts as the stop at the end.
const TOUCH: f64 = 1e-11;

impl Law {
    /// A motion along `length` units.
    ///
    /// # Errors
    /// [`Unplannable`] if a number is not above 0.
    pub fn new(length: f64, pace: Pace) -> Result<Law, Unplannable> {
        pace.check()?;
        if !(length > 0.0 && length.is_finite()) {
            return Err(Unplannable::Length);
        }
        let mut law = Law {
            pace,
            most: f64::INFINITY,
            scale: 1.0,
            length,
            pieces: Vec::new(),
            rest: None,
            paused: false,
            finished: false,
            changed: 0.0,
        };
        law.go(Moment::default());
        Ok(law)
    }

    /// Limits the speed for all overrides.
    pub(crate) fn limit(&mut self, most: f64) {
        self.most = most;
    }

    /// The present highest speed.
    fn top(&self) -> f64 {
        (self.pace.speed * self.scale).min(self.most)
    }

    /// Appends a course from a moment to rest at the end.
    fn go(&mut self, from: Moment) {
        if from.s < self.length || from.v > 0.0 {
            self.pieces.extend(course::go(from, self.length, self.top(), &self.pace));
        }
    }

    /// Drops the plan from `t` on.
    fn forget(&mut self, t: f64) -> Moment {
        let at = self.state(t);
        self.pieces.retain(|piece| piece.from.t < t);
        if let Some(last) = self.pieces.last_mut().filter(|last| last.to.t > t) {
            *last = last.until(t);
        }
        at
    }

    /// When a change asked for at `at` takes effect.
    pub(crate) fn moment(&self, at: f64) -> f64 {
        self.changed.max(at)
    }

    fn change(&mut self, at: f64) -> f64 {
        self.changed = self.moment(at);
        self.changed
    }

    /// The time and place of the rest, if the path brakes or is paused at `at`.
    pub(crate) fn standing(&self, at: f64) -> Option<(f64, f64)> {
        self.rest.filter(|(t, _)| self.paused || at < *t)
    }

    /// Whether the path is over at this time.
    pub(crate) fn is_over(&self, at: f64) -> bool {
        self.end().is_some_and(|end| at >= end)
    }

    /// Brakes as soon as possible. Returns the time and place of the rest.
    fn brake(&mut self, at: f64) -> (f64, f64) {
        let stop = course::stop(self.state(at), &self.pace);
        let there = stop.last().map_or(self.state(at), |piece| piece.to);
        let rest = if there.s >= self.length * (1.0 - TOUCH) {
            // The path is braking for its end already, and as hard.
            (self.last(), self.length)
        } else {
            self.forget(at);
            self.pieces.extend(stop);
            (there.t, there.s)
        };
        self.rest = Some(rest);
        rest
    }

    /// Continues from rest, not before `at`, unless the path is paused or finished.
    fn go_on(&mut self, at: f64) {
        let Some((t, s)) = self.rest else { return };
        self.pieces.retain(|piece| piece.from.t < t);
        if self.paused || self.finished {
            return;
        }
        let from = at.max(t);
        if from > t {
            self.pieces.push(Piece::still(s, t, from));
        }
        self.go(Moment::at_rest(from, s));
    }

    /// Brakes from `at` on, and rests until it is resumed.
    pub fn pause(&mut self, at: f64) {
        let at = self.change(at);
        if self.paused || self.is_over(at) {
            return;
        }
        if self.standing(at).is_none() {
            self.brake(at);
        }
        self.paused = true;
        self.go_on(at);
    }

    /// Continues at `at`, or after braking to rest, whichever is later.
    pub fn resume(&mut self, at: f64) {
        let at = self.change(at);
        if std::mem::take(&mut self.paused) {
            self.go_on(at);
        }
    }

    /// Brakes from `at` on, and drops the rest of the path.
    pub fn finish(&mut self, at: f64) {
        let at = self.change(at);
        if self.is_over(at) {
            return;
        }
        if self.standing(at).is_none() {
            self.brake(at);
        }
        (self.finished, self.paused) = (true, false);
        self.go_on(at);
        self.length = self.rest.map_or(self.length, |(_, s)| s);
    }

    /// Scales the ordered speed by this factor from `at` on, within [`SCALES`] and the speeds of the axes.
    /// Accelerations and jerk stay as they are.
    ///
    /// # Errors
    /// [`Unplannable::Scale`] if the factor is NaN; [`Unplannable::Over`] if the path is over.
    pub fn scale(&mut self, at: f64, scale: f64) -> Result<(), Unplannable> {
        if scale.is_nan() {
            return Err(Unplannable::Scale);
        }
        let at = self.change(at);
        if self.is_over(at) {
            return Err(Unplannable::Over);
        }
        self.scale = scale.clamp(*SCALES.start(), *SCALES.end());
        self.again(at);
        Ok(())
    }

    /// Plans the rest of the path again.
    fn again(&mut self, at: f64) {
        if self.standing(at).is_some() {
            self.go_on(at);
        } else if self.stop_from(at) < self.length * (1.0 - TOUCH) {
            let from = self.forget(at);
            self.go(from);
        }
        // Otherwise the path is braking for its end already.
    }

    /// The place where a stop from `at` on ends.
    pub(crate) fn stop_from(&self, at: f64) -> f64 {
        let from = self.state(at);
        course::stop(from, &self.pace).last().map_or(from.s, |piece| piece.to.s)
    }

    /// Moves the end along the same way. The path must be able to stop there.
    pub(crate) fn stretch(&mut self, at: f64, length: f64, most: f64) {
        let at = self.change(at);
        let from = self.forget(at);
        (self.length, self.most) = (length, most);
        self.go(from);
    }

    /// Brakes from `at` on, to take another way from there. Returns the place of the rest.
    pub(crate) fn corner(&mut self, at: f64) -> f64 {
        let at = self.change(at);
        match self.standing(at) {
            Some((_, s)) => s,
            None => self.brake(at).1,
        }
    }

    /// Continues after the corner to a new end at `length`.
    pub(crate) fn lead(&mut self, length: f64, most: f64) {
        (self.length, self.most) = (length, most);
        self.go_on(self.changed);
    }

    fn state(&self, t: f64) -> Moment {
        let after = self.pieces.partition_point(|piece| piece.from.t <= t);
        match self.pieces.get(after.saturating_sub(1)) {
            // Before the first piece, if braking took no time.
            Some(piece) => piece.at(t.max(piece.from.t)),
            None => Moment::at_rest(t, self.rest.map_or(0.0, |rest| rest.1)),
        }
    }

    /// When the last piece ends.
    fn last(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.to.t)
    }

    /// The place on the path at time `t`, in s after the start.
    pub fn place(&self, t: f64) -> f64 {
        self.state(t.max(0.0)).s.clamp(0.0, self.length)
    }

    /// The speed at time `t`.
    pub fn speed(&self, t: f64) -> f64 {
        let at = self.state(t.max(0.0));
        if t >= self.last() { 0.0 } else { at.v.max(0.0) }
    }

    /// The highest speed of the present plan.
    pub fn peak(&self) -> f64 {
        // A piece ends at each maximum of the speed, as the acceleration is 0 there.
        self.pieces.iter().map(|piece| piece.from.v.max(piece.to.v)).fold(0.0, f64::max)
    }

    /// When the path passes a place; `None` if the present plan does not reach it.
    pub fn time(&self, s: f64) -> Option<f64> {
        // The first piece that ends at the place or beyond it.
        let after = self.pieces.partition_point(|piece| piece.to.s < s);
        match self.pieces.get(after) {
            Some(piece) => Some(piece.time(s)),
            // Beyond the end only by rounding.
            None => (s <= self.length && self.arrives()).then(|| self.last()),
        }
    }

    /// Whether the present plan reaches the end.
    fn arrives(&self) -> bool {
        self.pieces.last().is_some_and(|piece| piece.to.s >= self.length * (1.0 - TOUCH))
    }

    /// Whether the rest of the path was dropped.
    pub(crate) fn is_finished(&self) -> bool {
        self.finished
    }

    #[cfg(test)]
    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The time from the start to rest at the end, in s, pauses included; `None` while the path is paused.
    pub fn end(&self) -> Option<f64> {
        (!self.paused).then(|| self.last())
    }

    /// The length of the path; after [`finish`](Law::finish) the length up to the rest.
    pub fn length(&self) -> f64 {
        self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace::new(10.0, 10.0);

    #[test]
    fn a_trapezoid_by_hand() {
        // 10 up in 1 s over 5, 10 down over 5, 90 level in 9 s.
        let law = Law::new(100.0, PACE).unwrap();
        assert_eq!(law.end(), Some(11.0));
        assert_eq!((law.place(1.0), law.place(5.5), law.time(50.0)), (5.0, 50.0, Some(5.5)));
        // Too short for the speed: 2 s, and 10 at the top.
        let law = Law::new(10.0, Pace::new(100.0, 10.0)).unwrap();
        assert!((law.end().unwrap() - 2.0).abs() < 1e-12 && (law.speed(1.0) - 10.0).abs() < 1e-9);
    }

    #[test]
    fn an_s_curve_by_hand() {
        // A/J = 0.5 s and Δv/A = 1 s: a ramp takes 1.5 s at a mean of 5.
        let law = Law::new(100.0, PACE.with_jerk(20.0)).unwrap();
        assert!((law.end().unwrap() - (1.5 + 8.5 + 1.5)).abs() < 1e-12);
        assert!((law.place(1.5) - 7.5).abs() < 1e-12 && (law.speed(1.5) - 10.0).abs() < 1e-12);
        // Half of the jerk's part: J·t³/6.
        assert!((law.place(0.5) - 20.0 * 0.125 / 6.0).abs() < 1e-12);
        assert!((law.time(20.0 * 0.125 / 6.0).unwrap() - 0.5).abs() < 1e-12);
        // Too short for the acceleration: four times ∛(L/2J).
        let law = Law::new(1.0, PACE.with_jerk(20.0)).unwrap();
        assert!((law.end().unwrap() - 4.0 * (1.0f64 / 40.0).cbrt()).abs() < 1e-12);
    }

    #[test]
    fn a_pause_brakes_stands_and_goes_on() {
        let mut law = Law::new(100.0, PACE).unwrap();
        law.pause(5.5);
        assert_eq!((law.end(), law.time(55.1)), (None, None));
        law.resume(20.0);
        // 50, and 5 of braking.
        assert_eq!((law.place(6.5), law.speed(6.5), law.place(19.0)), (55.0, 0.0, 55.0));
        assert_eq!((law.place(21.0), law.speed(21.0)), (60.0, 10.0));
        assert_eq!(law.time(55.0), Some(6.5));
        assert!((law.end().unwrap() - (20.0 + 5.5)).abs() < 1e-12);
        let mut law = Law::new(100.0, PACE).unwrap();
        law.finish(5.5);
        assert_eq!((law.time(54.9).is_some(), law.time(55.1), law.end()), (true, None, Some(6.5)));
    }

    #[test]
    fn what_is_asked_while_it_brakes_takes_hold_at_rest() {
        let mut law = Law::new(100.0, PACE).unwrap();
        law.pause(5.5);
        law.resume(5.6);
        law.scale(5.7, 0.5).unwrap();
        assert_eq!((law.place(6.5), law.speed(6.5)), (55.0, 0.0));
        // 5 in 0.5 s over 1.25, and back: 45 are 9.5 s.
        assert_eq!((law.speed(8.0), law.end()), (5.0, Some(6.5 + 9.5)));
    }

    #[test]
    fn an_override_stays_within_its_limits() {
        let mut law = Law::new(100.0, PACE).unwrap();
        law.limit(15.0);
        law.scale(2.0, 9.0).unwrap();
        assert_eq!(law.speed(3.0), 15.0);
        law.scale(3.0, 0.0).unwrap();
        assert_eq!(law.speed(5.0), 1.0);
        assert_eq!(law.scale(6.0, f64::NAN), Err(Unplannable::Scale));
        assert_eq!(law.scale(600.0, 1.0), Err(Unplannable::Over));
        // In its last fall it goes on to its end.
        let mut law = Law::new(100.0, PACE).unwrap();
        for at in [10.1, 10.5, 10.99] {
            law.scale(at, 0.1).unwrap();
        }
        assert_eq!(law.end(), Some(11.0));
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (length, speed, accel) in [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, f64::NAN)] {
            assert!(Law::new(length, Pace::new(speed, accel)).is_err());
        }
        for jerk in [0.0, -1.0, f64::NAN] {
            assert_eq!(Law::new(1.0, PACE.with_jerk(jerk)).unwrap_err(), Unplannable::Jerk);
        }
    }
}
