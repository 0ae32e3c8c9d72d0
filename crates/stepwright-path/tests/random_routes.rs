//! Random routes, judged only by their steps: lines, arcs, chords, reversals and tiny pieces of unequal axes.
//! Half of them have overrides, holds and cancellations, ordered before they begin or while they are made. The
//! jerk is unlimited or limited. Some begin far away, some have a quick axis that stands.
//!
//! `STEPWRIGHT_ROUTES` sets the number of routes, and `STEPWRIGHT_SMOOTH_ROUTES` the number of those with
//! limited jerk, from seed `STEPWRIGHT_ROUTES_FROM` on.

use std::f64::consts::{PI, TAU};

use crate::jobs::Dice;
use crate::judge::jerk::jerk_broken;
use crate::judge::{self, Axis, jump_needed};
use stepwright_path::{AxisPace, Route};

/// A route that is being made.
struct Made<const N: usize> {
    route: Route<N>,
    axes: [AxisPace; N],
    steps: [Axis; N],
    dice: Dice,
    cancelled: bool,
    /// The number of steps until the next order, and whether that ends a hold.
    next: Option<(u32, bool)>,
    /// An axis that stands.
    still: Option<usize>,
    /// The end of the last piece.
    end: [f64; N],
    /// The time and the positions at the beginning.
    begin: (f64, [i64; N]),
}

impl<const N: usize> Made<N> {
    fn new(seed: u64, smooth: bool) -> Made<N> {
        let mut dice = Dice(seed);
        let mut axes: [AxisPace; N] = std::array::from_fn(|_| AxisPace {
            step: 0.02 + 0.2 * dice.roll(),
            speed: 20.0 + 200.0 * dice.roll(),
            accel: 100.0 * 30f64.powf(dice.roll()),
            jump: 0.5 + 8.0 * dice.roll(),
            jerk: f64::INFINITY,
        });
        if smooth {
            // Each axis reaches its acceleration in 10 ms to 0.3 s.
            for axis in &mut axes {
                axis.jerk = axis.accel / (0.01 * 30f64.powf(dice.roll()));
            }
        }
        let still = (N > 2 && seed % 10 < 2).then_some(N / 2);
        if let Some(axis) = still {
            axes[axis].jerk = f64::INFINITY;
        }
        let mut route = Route::new(axes).unwrap();
        if seed % 10 > 7 {
            // Far from the beginning.
            let mut end = [0.0; N];
            end[0] = 1e6;
            route.line_to(end, 1e6).unwrap();
            route.close();
            while route.pass_over().is_some() {}
        }
        let (end, begin) = (route.end(), (route.time(), route.positions()));
        let steps = [const { Vec::new() }; N];
        let next = (seed % 4 == 1).then_some((0, false));
        Made { route, axes, steps, dice, cancelled: false, next, still, end, begin }
    }

    fn roll(&mut self) -> f64 {
        self.dice.roll()
    }

    /// Takes the steps that are final now.
    fn play(&mut self) {
        self.end = self.route.end();
        loop {
            match self.route.next() {
                Some(step) => {
                    self.steps[step.axis].push((step.time - self.begin.0, step.forward));
                    self.order(1);
                }
                // A route that is held is resumed.
                None if self.next.is_some_and(|next| next.1) => self.order(u32::MAX),
                None => return,
            }
        }
    }

    /// Gives an order after some steps.
    fn order(&mut self, steps: u32) {
        let Some((left, held)) = &mut self.next else { return };
        *left = left.saturating_sub(steps);
        if *left > 0 {
            return;
        }
        let held = *held;
        let at = if self.roll() < 0.5 { self.route.time() } else { 0.0 };
        let hold = !held && self.roll() < 0.5;
        if held {
            self.route.resume(at);
        } else if hold {
            self.route.hold(at);
        } else {
            let scale = 0.05 + 2.2 * self.roll();
            self.route.scale(at, scale).unwrap();
        }
        // A hold ends soon, and often before it is made.
        let most = if hold { 5.0 } else { 800.0 };
        self.next = Some(((most * self.roll()) as u32 + 1, hold));
    }

    fn line(&mut self, mut way: [f64; N], feed: f64) {
        if let Some(axis) = self.still {
            way[axis] = 0.0;
        }
        let from = self.route.end();
        let to = std::array::from_fn(|n| from[n] + way[n]);
        self.route.line_to(to, feed).unwrap();
        self.play();
    }

    /// Adds a piece of a random kind.
    fn piece(&mut self) {
        let feed = 5.0 + 200.0 * self.roll();
        let kind = self.roll();
        let way = |made: &mut Self, length: f64| {
            std::array::from_fn(|_| length * (2.0 * made.dice.roll() - 1.0))
        };
        if kind < 0.25 {
            let length = 0.1 * 200f64.powf(self.roll());
            let way = way(self, length);
            self.line(way, feed);
            if self.roll() < 0.3 {
                self.line(way.map(|way| -way), feed);
            }
        } else if kind < 0.45 {
            // Along one axis, while the others stand.
            let axis = (self.roll() * N as f64) as usize;
            let length = 10.0 * self.roll() - 5.0;
            self.line(std::array::from_fn(|n| if n == axis { length } else { 0.0 }), feed);
        } else if kind < 0.6 {
            // Chords of a curve in two axes, of unequal lengths, or with rounded places.
            let (radius, mut angle) = (0.5 + 20.0 * self.roll(), TAU * self.roll());
            let (chord, uneven) = (0.05 + self.roll(), self.roll());
            let grid = if self.roll() < 0.5 { 1e-3 * 20f64.powf(self.roll()) } else { 1e-9 };
            let sign = if self.roll() < 0.5 { 1.0 } else { -1.0 };
            for _ in 0..(20.0 * self.roll()) as usize + 2 {
                let chord = chord * (1.0 - uneven * self.roll() * 0.9);
                angle += sign * chord / radius;
                let mut way = [0.0; N];
                let round = |way: f64| (way / grid).round() * grid;
                (way[0], way[N - 1]) = (round(chord * angle.cos()), round(chord * angle.sin()));
                self.line(way, feed);
            }
        } else if kind < 0.8 && N > 1 {
            let radius = 0.3 + 10.0 * self.roll();
            let (phase, sweep) = (TAU * self.roll(), 3.0 * PI * (2.0 * self.roll() - 1.0));
            let end = self.route.end();
            let centre = [end[0] - radius * phase.cos(), end[N - 1] - radius * phase.sin()];
            let mut climb = if self.roll() < 0.5 { [0.0; N] } else { way(self, 3.0) };
            if let Some(axis) = self.still {
                climb[axis] = 0.0;
            }
            self.route.arc([0, N - 1], centre, sweep, climb, feed).unwrap();
            self.play();
        } else {
            for _ in 0..(20.0 * self.roll()) as usize + 1 {
                let length = 0.001 * 300f64.powf(self.roll());
                let way = way(self, length);
                self.line(way, feed);
            }
        }
        if self.roll() < 0.02 {
            self.route.close();
            self.play();
            if self.next.is_some() {
                // Here the route is over.
                self.route.cancel(self.route.time());
            }
        }
    }

    /// Overrides, holds and their ends at random times.
    fn disturb(&mut self) {
        let mut time = self.begin.0;
        for _ in 0..(6.0 * self.roll()) as usize + 1 {
            time += self.roll() * self.roll();
            if self.roll() < 0.6 {
                let scale = 0.05 + 2.2 * self.roll();
                self.route.scale(time, scale).unwrap();
            } else {
                self.route.hold(time);
                time += 0.5 * self.roll() * self.roll();
                self.route.resume(time);
            }
        }
        self.cancelled = self.roll() < 0.2;
        if self.cancelled {
            self.route.cancel(time + self.dice.roll());
        }
    }

    fn judge(&mut self, seed: u64) {
        self.route.close();
        self.play();
        assert!(self.route.is_over(), "{seed}: not at its end");
        let (end, time) = (self.route.end(), self.route.time() - self.begin.0);
        assert!(
            self.cancelled || end == self.end,
            "{seed}: it ends at {end:?}, not {:?}",
            self.end
        );
        for (n, steps) in self.steps.iter().enumerate() {
            let AxisPace { step, accel, jump, speed, jerk } = self.axes[n];
            let at: i64 = steps.iter().map(|(_, forward)| if *forward { 1 } else { -1 }).sum();
            let off = ((at + self.begin.1[n]) as f64 - end[n] / step).abs();
            // A cancelled route may end at a turn within a quarter of a step.
            let most = if self.cancelled { 0.750_01 } else { 0.500_01 };
            assert!(off <= most, "{seed}: axis {n} ends at {at}, off by {off}");
            let speeds = judge::speeds(steps, step, time);
            let most = speeds.iter().map(|(_, v)| v.abs()).fold(0.0, f64::max);
            assert!(most <= speed * 1.000_01, "{seed}: axis {n} at {most}, not {speed}");
            let (needed, when) = jump_needed(steps, step, accel, time);
            assert!(
                needed <= jump * 1.000_1,
                "{seed}: axis {n} of {N} needs {needed}, not {jump}, at {when} of {time}"
            );
            if jerk < f64::INFINITY {
                let broken = jerk_broken(steps, step, [jump, accel, jerk], time);
                assert!(
                    broken.is_none(),
                    "{seed}: axis {n} of {N} breaks the law of jerk at {broken:?} of {time}"
                );
            }
        }
    }
}

fn try_one<const N: usize>(seed: u64, smooth: bool) {
    let mut made: Made<N> = Made::new(seed, smooth);
    if seed % 4 == 3 {
        made.disturb();
    }
    for _ in 0..(8.0 * made.roll()) as usize + 1 {
        made.piece();
    }
    made.judge(seed);
}

/// Tries the number of routes in this variable, or else `count`.
fn try_all(variable: &str, count: u64, smooth: bool) {
    let number = |name: &str, else_: u64| {
        std::env::var(name).map_or(else_, |text| text.parse().expect("a number"))
    };
    let from = number("STEPWRIGHT_ROUTES_FROM", 0);
    for seed in from..from + number(variable, count) {
        match seed % 3 {
            0 => try_one::<2>(seed, smooth),
            1 => try_one::<3>(seed, smooth),
            _ => try_one::<6>(seed, smooth),
        }
    }
}

#[test]
fn random_routes_keep_the_law_and_end_where_they_should() {
    try_all("STEPWRIGHT_ROUTES", 10_000, false);
}

#[test]
fn random_routes_keep_the_law_of_jerk() {
    try_all("STEPWRIGHT_SMOOTH_ROUTES", 200, true);
}

/// An arc takes two axes; lines, corners and chords take one or many.
#[test]
fn a_route_has_any_number_of_axes() {
    for seed in 0..500 {
        try_one::<1>(seed, seed % 20 == 0);
        try_one::<9>(seed, seed % 50 == 0);
    }
}
