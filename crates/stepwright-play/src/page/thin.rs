//! Thins the points of a motion to as few as a picture needs.
//!
//! ```text
//!   from ●───────────╳──────     a straight line from the last point that was kept leads past
//!          ╲   cone ╱            all that were not, within the tolerance: the cone of its slopes
//!           ╲______╱             becomes narrower, and a point outside keeps the one before
//! ```
//!
//! It takes one pass, a few divisions a point, and no memory except the kept points.

/// The axes' positions at a time, in mm and s, their speed along the path, and the power of a laser
/// from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThinPoint {
    pub time: f64,
    pub speed: f64,
    pub place: [f64; 3],
    pub power: f64,
}

impl ThinPoint {
    fn values(&self) -> [f64; 5] {
        let [x, y, z] = self.place;
        [x, y, z, self.speed, self.power]
    }
}

/// The largest distance of a straight line between two points from the points between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// mm.
    pub place: f64,
    /// mm/s.
    pub speed: f64,
    /// A fraction of full power.
    pub power: f64,
}

impl Tolerance {
    /// A tolerance twice as wide; 1.4 times for positions, where errors are seen first.
    pub fn wider(self) -> Tolerance {
        Tolerance { place: self.place * 1.4, speed: self.speed * 2.0, power: self.power * 2.0 }
    }

    fn values(&self) -> [f64; 5] {
        [self.place, self.place, self.place, self.speed, self.power]
    }
}

/// The kept points, in the order of time.
#[derive(Clone, Debug)]
pub struct Thin {
    tolerance: Tolerance,
    pub points: Vec<ThinPoint>,
    /// The last point, if it is not kept yet.
    last: Option<ThinPoint>,
    /// The possible slopes from the last kept point.
    cone: [[f64; 2]; 5],
}

const OPEN: [[f64; 2]; 5] = [[f64::NEG_INFINITY, f64::INFINITY]; 5];

impl Thin {
    /// No points.
    pub fn new(tolerance: Tolerance) -> Thin {
        Thin { tolerance, points: Vec::new(), last: None, cone: OPEN }
    }

    /// Adds a point. A point that is not later than the one before is ignored, unless the laser's
    /// power jumps there: then both are kept.
    pub fn put(&mut self, point: ThinPoint) {
        let Some(from) = self.points.last().copied() else { return self.points.push(point) };
        let before = self.last.unwrap_or(from);
        if point.time <= before.time {
            // A smaller difference is a rounding error, or not visible.
            if (point.power - before.power).abs() > self.tolerance.power {
                self.end();
                self.points.push(ThinPoint { time: before.time, ..point });
            }
            return;
        }
        let slopes = |from: &ThinPoint, off: f64| {
            let (to, from) = (point.values(), (from.values(), from.time));
            let wide = self.tolerance.values();
            let slope = |n: usize| (to[n] + off * wide[n] - from.0[n]) / (point.time - from.1);
            [0, 1, 2, 3, 4].map(slope)
        };
        let straight = slopes(&from, 0.0);
        let inside = straight.iter().zip(&self.cone).all(|(s, [low, high])| low <= s && s <= high);
        match self.last.filter(|_| !inside) {
            Some(last) => {
                let [low, high] = [-1.0, 1.0].map(|off| slopes(&last, off));
                self.cone = [0, 1, 2, 3, 4].map(|n| [low[n], high[n]]);
                self.points.push(last);
            }
            None => {
                let [low, high] = [-1.0, 1.0].map(|off| slopes(&from, off));
                let narrowed =
                    |n: usize| [self.cone[n][0].max(low[n]), self.cone[n][1].min(high[n])];
                self.cone = [0, 1, 2, 3, 4].map(narrowed);
            }
        }
        self.last = Some(point);
    }

    /// Keeps the last point.
    pub fn end(&mut self) {
        self.points.extend(self.last.take());
        self.cone = OPEN;
    }

    /// Thins the kept points again, with another tolerance.
    pub fn again(&mut self, tolerance: Tolerance) {
        let mut fewer = Thin::new(tolerance);
        self.points.iter().for_each(|point| fewer.put(*point));
        fewer.end();
        *self = fewer;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value between two points.
    fn between(points: &[ThinPoint], time: f64) -> [f64; 5] {
        let next = points.partition_point(|point| point.time < time).clamp(1, points.len() - 1);
        let (a, b) = (&points[next - 1], &points[next]);
        let part = (time - a.time) / (b.time - a.time);
        let (a, b) = (a.values(), b.values());
        [0, 1, 2, 3, 4].map(|n| a[n] + (b[n] - a[n]) * part)
    }

    #[test]
    fn what_is_left_out_is_near_a_line_between_others() {
        let all: Vec<_> = (0..5_000)
            .map(|n| {
                let time = f64::from(n) * 0.01;
                let corner = (time * 0.3).fract() * 20.0;
                let place = [40.0 * time.sin(), corner, 5.0 * (time * time / 9.0).cos()];
                let power = 0.5 + 0.5 * (3.0 * time).cos();
                ThinPoint { time, speed: 30.0 + 25.0 * (2.0 * time).sin(), place, power }
            })
            .collect();
        let mut before = all.len();
        let mut tolerance = Tolerance { place: 0.02, speed: 0.5, power: 0.01 };
        for _ in 0..6 {
            let mut thin = Thin::new(tolerance);
            all.iter().for_each(|point| thin.put(*point));
            thin.end();
            for point in &all {
                let (kept, right) = (between(&thin.points, point.time), point.values());
                for (n, most) in tolerance.values().into_iter().enumerate() {
                    assert!((kept[n] - right[n]).abs() <= most * 1.000_001, "{n}: {point:?}");
                }
            }
            assert!(thin.points.len() < before, "{tolerance:?}");
            assert_eq!((thin.points[0], thin.points.last()), (all[0], all.last()));
            (before, tolerance) = (thin.points.len(), tolerance.wider());
        }
    }

    #[test]
    fn a_straight_line_has_two_points_and_a_stand_keeps_both_ends() {
        let mut thin = Thin::new(NEAR);
        for n in 0..=100 {
            let time = f64::from(n);
            thin.put(ThinPoint { time, speed: 5.0, place: [time, 2.0 * time, 0.0], power: 0.0 });
        }
        let stands = ThinPoint { speed: 0.0, place: [100.0, 200.0, 0.0], ..ThinPoint::default() };
        // Not later than the point before: ignored.
        thin.put(ThinPoint { time: 100.0, place: [0.0; 3], ..stands });
        thin.put(ThinPoint { time: 100.5, ..stands });
        thin.put(ThinPoint { time: 190.0, ..stands });
        thin.end();
        let times: Vec<_> = thin.points.iter().map(|point| point.time).collect();
        assert_eq!(times, [0.0, 100.0, 100.5, 190.0]);
    }

    const NEAR: Tolerance = Tolerance { place: 0.01, speed: 0.1, power: 0.01 };

    #[test]
    fn a_power_jumps_where_it_does() {
        let mut thin = Thin::new(NEAR);
        for line in 0..3 {
            let power = f64::from(line) / 2.0;
            for n in 0..=10 {
                let time = f64::from(10 * line + n);
                thin.put(ThinPoint { time, speed: 5.0, place: [time, 0.0, 0.0], power });
            }
        }
        thin.end();
        let jumps = [(0.0, 0.0), (10.0, 0.0), (10.0, 0.5), (20.0, 0.5), (20.0, 1.0), (30.0, 1.0)];
        let kept = |thin: &Thin| thin.points.iter().map(|p| (p.time, p.power)).collect::<Vec<_>>();
        assert_eq!(kept(&thin), jumps);
        // A power that differs in its last digit is no jump.
        thin.put(ThinPoint {
            time: 30.0,
            speed: 5.0,
            place: [30.0, 0.0, 0.0],
            power: 1.0 - f64::EPSILON,
        });
        assert_eq!(kept(&thin), jumps);
        thin.again(NEAR.wider());
        assert_eq!(kept(&thin), jumps);
    }
}
