//! How far along the path, when: constant acceleration, a top speed, constant
//! deceleration, and holds on the way.
//!
//! ```text
//!   v        ╱▔▔▔▔▔▔▔╲                ╱▔▔▔▔╲
//!          ╱           ╲            ╱        ╲
//!        ╱               ╲________╱            ╲
//!   t        hold asked ┊         ┊ resumed
//! ```
//!
//! A piece with acceleration a begins at (t₀, s₀) with speed v₀; within it
//!
//! ```text
//!   s(t) = s₀ + v₀·(t − t₀) + a/2·(t − t₀)²
//!   t(s) = t₀ + 2·(s − s₀) / (v₀ + √(v₀² + 2a·(s − s₀)))
//! ```
//!
//! The second form has no difference of large numbers, and a fall is reckoned from
//! its end in the same way: a time is good to some 2⁻⁵⁰ of itself.

/// Why a path can't be planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unplannable {
    /// The speed is not above 0, or no number.
    Speed,
    /// The acceleration is not above 0, or no number.
    Accel,
    /// The path has no length, or an endless one.
    Length,
    /// A step of an axis leads nowhere.
    Step,
    /// An axis makes more than 2³¹ − 1 steps.
    TooLong,
    /// The radius is smaller than a step.
    Radius,
}

impl std::fmt::Display for Unplannable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Unplannable::Speed => "the speed along the path must be above 0",
            Unplannable::Accel => "the acceleration along the path must be above 0",
            Unplannable::Length => "the path leads nowhere: no axis has a step to make",
            Unplannable::Step => "a step must lead somewhere: a distance above 0",
            Unplannable::TooLong => "too long: at most 2147483647 steps of an axis",
            Unplannable::Radius => "the radius is smaller than a step: nothing would move",
        })
    }
}

impl std::error::Error for Unplannable {}

/// Speed and accelerations along a path, in the user's unit and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Unit/s between the ramps.
    pub speed: f64,
    /// Unit/s², up.
    pub accel: f64,
    /// Unit/s², down.
    pub decel: f64,
}

impl Pace {
    /// The same acceleration up and down.
    pub fn new(speed: f64, accel: f64) -> Pace {
        Pace { speed, accel, decel: accel }
    }

    fn check(self) -> Result<(), Unplannable> {
        let good = |x: f64| x > 0.0 && x.is_finite();
        match (good(self.speed), good(self.accel) && good(self.decel)) {
            (false, _) => Err(Unplannable::Speed),
            (_, false) => Err(Unplannable::Accel),
            _ => Ok(()),
        }
    }
}

/// A piece of constant acceleration, from its beginning.
#[derive(Clone, Copy, Debug)]
struct Piece {
    t: f64,
    s: f64,
    v: f64,
    a: f64,
}

impl Piece {
    fn at(&self, t: f64) -> (f64, f64) {
        let dt = t - self.t;
        (self.s + self.v * dt + self.a / 2.0 * dt * dt, self.v + self.a * dt)
    }

    /// When it comes by s, reckoned from the slower end, whose speed is exact:
    /// `next` begins where this ends.
    fn time(&self, s: f64, next: &Piece) -> f64 {
        let (from, way) = if self.a < 0.0 { (next, next.s - s) } else { (self, s - self.s) };
        if way <= 0.0 {
            return from.t;
        }
        let v = (from.v * from.v + 2.0 * self.a.abs() * way).sqrt();
        let time = 2.0 * way / (from.v + v);
        if self.a < 0.0 { from.t - time } else { from.t + time }
    }
}

/// A motion along a path from rest to rest.
#[derive(Clone, Debug)]
pub struct Law {
    pace: Pace,
    length: f64,
    /// In order of time; the last stands at the end.
    pieces: Vec<Piece>,
}

impl Law {
    /// Along `length` units.
    ///
    /// # Errors
    /// [`Unplannable`] if a number is not above 0.
    pub fn new(length: f64, pace: Pace) -> Result<Law, Unplannable> {
        pace.check()?;
        if !(length > 0.0 && length.is_finite()) {
            return Err(Unplannable::Length);
        }
        let mut law = Law { pace, length, pieces: Vec::new() };
        law.go(0.0, 0.0);
        Ok(law)
    }

    /// From rest at (t, s) to rest at the end.
    fn go(&mut self, t: f64, s: f64) {
        let Pace { speed, accel, decel } = self.pace;
        let way = self.length - s;
        // Where the ramps meet, if the way is too short for the speed.
        let peak = (2.0 * way * accel * decel / (accel + decel)).max(0.0).sqrt().min(speed);
        let (up, down) = (peak * peak / 2.0 / accel, peak * peak / 2.0 / decel);
        let level = (way - up - down).max(0.0);
        let t1 = t + peak / accel;
        let t2 = t1 + if level > 0.0 { level / peak } else { 0.0 };
        let t3 = t2 + peak / decel;
        self.pieces.extend([
            Piece { t, s, v: 0.0, a: accel },
            Piece { t: t1, s: s + up, v: peak, a: 0.0 },
            Piece { t: t2, s: self.length - down, v: peak, a: -decel },
            Piece { t: t3, s: self.length, v: 0.0, a: 0.0 },
        ]);
    }

    /// Brakes from `at` on, stands, and goes on at `until`, or when it has come
    /// to rest, whichever is later. Without `until` it stands for good, and the
    /// rest of the path is not made. Nothing before `at` is changed; a path that
    /// is over by then is left as it is.
    pub fn hold(&mut self, at: f64, until: Option<f64>) {
        let at = at.max(0.0);
        if at >= self.duration() {
            return;
        }
        let (s, v) = self.state(at);
        let decel = self.pace.decel;
        // No further than the end: the fall there is as steep.
        let stop = (s + v * v / 2.0 / decel).min(self.length);
        let rest = at + v / decel;
        self.pieces.retain(|piece| piece.t < at);
        self.pieces.push(Piece { t: at, s, v, a: -decel });
        self.pieces.push(Piece { t: rest, s: stop, v: 0.0, a: 0.0 });
        if let Some(until) = until.filter(|_| stop < self.length) {
            self.go(until.max(rest), stop);
        }
    }

    fn piece(&self, t: f64) -> Option<&Piece> {
        let after = self.pieces.partition_point(|piece| piece.t <= t);
        self.pieces.get(after.saturating_sub(1))
    }

    fn state(&self, t: f64) -> (f64, f64) {
        self.piece(t).map_or((0.0, 0.0), |piece| piece.at(t))
    }

    /// How far it has come `t` seconds after its start.
    pub fn place(&self, t: f64) -> f64 {
        self.state(t.max(0.0)).0.clamp(0.0, self.length)
    }

    /// How fast it is then.
    pub fn speed(&self, t: f64) -> f64 {
        self.state(t.max(0.0)).1.max(0.0)
    }

    /// When it comes by a place; `None` if it never gets there.
    pub fn time(&self, s: f64) -> Option<f64> {
        // The first piece that ends beyond it.
        let after = self.pieces.partition_point(|piece| piece.s < s);
        if after == self.pieces.len() {
            // No further than rounding beyond the end.
            let last = self.pieces.last()?;
            return (s - last.s <= self.length * 1e-12).then_some(last.t);
        }
        let next = self.pieces.get(after)?;
        match after.checked_sub(1).and_then(|before| self.pieces.get(before)) {
            Some(piece) => Some(piece.time(s, next)),
            None => Some(next.t),
        }
    }

    /// Seconds from rest to rest, holds included.
    pub fn duration(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.t)
    }

    /// The length of the path.
    pub fn length(&self) -> f64 {
        self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trapezoid_by_hand() {
        // 10 up in 1 s over 5, 10 down over 5, 90 level in 9 s.
        let law = Law::new(100.0, Pace::new(10.0, 10.0)).unwrap();
        assert_eq!(law.duration(), 11.0);
        assert_eq!((law.place(1.0), law.place(5.5), law.time(50.0)), (5.0, 50.0, Some(5.5)));
        // Too short for the speed: 2 s, and 10 at the top.
        let law = Law::new(10.0, Pace::new(100.0, 10.0)).unwrap();
        assert!((law.duration() - 2.0).abs() < 1e-12 && (law.speed(1.0) - 10.0).abs() < 1e-9);
    }

    #[test]
    fn a_hold_brakes_stands_and_goes_on() {
        let mut law = Law::new(100.0, Pace::new(10.0, 10.0)).unwrap();
        law.hold(5.5, Some(20.0));
        // 50, and 5 of braking.
        assert_eq!((law.place(6.5), law.speed(6.5), law.place(19.0)), (55.0, 0.0, 55.0));
        assert_eq!((law.place(21.0), law.speed(21.0)), (60.0, 10.0));
        assert_eq!(law.time(55.0), Some(6.5));
        assert!((law.duration() - (20.0 + 5.5)).abs() < 1e-12);
        let mut law = Law::new(100.0, Pace::new(10.0, 10.0)).unwrap();
        law.hold(5.5, None);
        assert_eq!((law.time(54.9).is_some(), law.time(55.1), law.duration()), (true, None, 6.5));
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (length, speed, accel) in [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, f64::NAN)] {
            assert!(Law::new(length, Pace::new(speed, accel)).is_err());
        }
    }
}
