//! Following a route while it is made: its progress, and continuing with the pieces known so far.

use crate::loose::AHEAD;
use crate::route::Route;

/// The rounding of places beyond half a step, in steps.
const NEAR: f64 = 1e-6;

impl<const N: usize> Route<N> {
    /// Sets the position at which each axis stands, if no other position is nearer to its place. A place in the
    /// middle between two positions may have either. A route that continues where another one ended takes the
    /// [`positions`](Route::positions) of that one. To be called before the first piece.
    pub fn standing_at(mut self, position: [i64; N]) -> Route<N> {
        for (axis, known) in position.into_iter().enumerate() {
            let place = self.place[axis] / self.axes[axis].step;
            if (place - known as f64).abs() <= 0.5 + NEAR {
                self.at[axis] = known;
            }
        }
        self
    }

    /// The place along the route at `time`, in units, and the speed, in units/s. It is known for the part that
    /// is being made: an earlier time counts as the beginning of that part, a later one as its end.
    pub fn along(&self, time: f64) -> (f64, f64) {
        if let Some(pieces) = &self.front {
            let piece = pieces.iter().find(|piece| piece.to.t >= time).unwrap_or(&pieces[2]);
            let here = piece.at(time.max(piece.from.t));
            return (here.s, here.v);
        }
        let speed = match &self.smooth {
            Some(smooth) => smooth.here.v,
            None => self.passes.w.front().map_or(0.0, |w| w.sqrt()),
        };
        match (self.cells.front(), self.loose.front()) {
            (Some(cell), _) => (cell.begin, speed),
            (None, Some(loose)) => (loose.shape.begin, 0.0),
            (None, None) => (self.length, 0.0),
        }
    }

    /// Makes the next part final with the pieces known so far, even if later pieces could make it faster. This
    /// is for a machine that moves on while its sender is late. Without it no more steps follow until enough
    /// pieces are added, or the route is closed. At the last piece this closes the route.
    ///
    /// The plan ends at rest at the end of the route, so the machine can always brake in time. Returns false if
    /// nothing is left to make final.
    pub fn go_on(&mut self) -> bool {
        if self.cells.len() <= AHEAD {
            // Otherwise the route would brake for the end of these cells.
            self.settle_seen();
        }
        if self.cells.is_empty() {
            self.close();
        }
        if self.cells.is_empty() {
            return false;
        }
        if self.fresh > 0 {
            self.plan();
        }
        self.passes.sure = self.passes.sure.max(1);
        true
    }
}

#[cfg(test)]
mod tests {
    use crate::{AxisPace, Route};

    const AXIS: AxisPace =
        AxisPace { step: 0.01, speed: 100.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

    /// A sender gives one short chord at a time, each when no more steps are final. The route moves on from
    /// chord to chord, and reaches its end.
    #[test]
    fn a_late_sender_is_waited_for_at_speed() {
        let mut route = Route::new([AXIS; 2]).unwrap();
        let (mut at, mut fastest) = ([0i64; 2], 0.0f64);
        for n in 1..=400 {
            route.line_to([0.1 * f64::from(n), 0.0], 50.0).unwrap();
            // Forty chords are 4 mm. Braking from 50 mm/s takes 1.25 mm.
            if n >= 40 {
                while route.length() - route.along(route.time()).0 > 3.0 {
                    match route.next() {
                        Some(step) => at[step.axis] += if step.forward { 1 } else { -1 },
                        None => assert!(route.go_on()),
                    }
                }
                fastest = fastest.max(route.along(route.time()).1);
                // It never rests while there are pieces ahead.
                assert!(n < 60 || route.along(route.time()).1 > 49.0, "{n}");
            }
        }
        while !route.is_over() {
            match route.next() {
                Some(step) => at[step.axis] += if step.forward { 1 } else { -1 },
                None => _ = route.go_on(),
            }
        }
        assert_eq!(at, [4_000, 0]);
        assert!((49.9..50.1).contains(&fastest), "{fastest}");
        assert!(!route.go_on() && route.along(route.time()) == (40.0, 0.0));
    }

    /// Rough chords become cells late. If the sender is late, they become cells by the chords known so far, and
    /// the route does not rest at the end of the cells before.
    #[test]
    fn a_late_sender_of_rough_chords_is_waited_for_at_speed() {
        let mut route = Route::new([AXIS; 2]).unwrap();
        let add = |route: &mut Route<2>, chords: std::ops::Range<u32>| {
            for n in chords {
                let to = [0.1 * f64::from(n), 0.001 * f64::from(n % 2)];
                route.line_to(to, 50.0).unwrap();
            }
        };
        add(&mut route, 1..7);
        let mut times = Vec::new();
        while route.along(route.time()).0 < 0.25 {
            match route.next() {
                Some(step) => times.extend((step.axis == 0).then_some(step.time)),
                None => assert!(route.go_on()),
            }
        }
        add(&mut route, 7..40);
        route.close();
        times.extend(route.filter(|step| step.axis == 0).map(|step| step.time));
        assert_eq!(times.len(), 390);
        // From rest to rest a step takes √(2·0.01/1000): 4.5 ms.
        let gaps = times[20..380].windows(2).map(|two| two[1] - two[0]);
        let longest = gaps.fold(0.0, f64::max);
        assert!(longest < 0.002, "{longest}");
    }

    /// Half steps are common where places have three digits after the point.
    #[test]
    fn one_route_after_another_adds_up() {
        let (mut place, mut at) = ([0.0f64; 2], [0i64; 2]);
        for n in 0..400 {
            let mut route = Route::at([AXIS; 2], place).unwrap().standing_at(at);
            let turn = f64::from(n % 40) / 40.0 * std::f64::consts::TAU;
            place = [(30.0 * turn.cos()).round() / 200.0, (41.0 * turn.sin()).round() / 200.0];
            route.line_to(place, 50.0).unwrap();
            route.close();
            for step in route.by_ref() {
                at[step.axis] += if step.forward { 1 } else { -1 };
            }
            assert_eq!(route.positions(), at);
            for axis in 0..2 {
                assert!((place[axis] / 0.01 - at[axis] as f64).abs() < 0.500_001, "{n}: {at:?}");
            }
        }
    }

    #[test]
    fn how_far_and_how_fast_is_told() {
        let mut route = Route::new([AXIS; 2]).unwrap();
        route.line_to([30.0, 40.0], 50.0).unwrap();
        route.close();
        assert_eq!((route.length(), route.along(0.0)), (50.0, (0.0, 0.0)));
        let mut steps = 0;
        while route.next().is_some_and(|step| step.time < 0.5) {
            steps += 1;
        }
        // 1250 mm/s² along it (1000/0.8): 50 mm/s after 0.04 s and 1 mm.
        let (s, v) = route.along(0.5);
        assert!((s - 24.0).abs() < 1e-9 && v == 50.0, "{s} {v}");
        assert!((steps - 3_360i32).abs() < 3, "{steps}");
    }
}
