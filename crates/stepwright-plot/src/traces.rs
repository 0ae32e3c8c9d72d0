//! Position, speed and acceleration over time, from recorded steps.
//!
//! Between two steps the speed is their distance divided by their interval, at the middle of that
//! interval. The acceleration is the change of the mean speed from one time window to the next;
//! from step to step, it would show the ticks of the timer as noise. The number of points is
//! limited however long a motor moves: if there are too many, every second one is dropped.

use crate::AxisSeries;
use crate::slopes::{self, Clock, Mark};

/// The most points of an axis: more than a picture has columns.
const MARKS: usize = 4096;

/// A pause is at least this many times longer than the interval before it. A ramp that begins or
/// ends at rest never grows an interval by more than 2.5 times.
const PAUSE: u64 = 5;

/// The number of steps at either end of a motion that are always kept: its first and last speed
/// follow from two intervals.
const ENDS: usize = 3;

/// The most axes of a board.
const AXES: usize = 8;

/// The recorded steps of a board's axes, for a plot.
pub struct Traces {
    /// Ticks per second.
    hz: u32,
    axes: [Axis; AXES],
}

#[derive(Clone, Default)]
struct Axis {
    backward: bool,
    position: i64,
    /// The steps since the last kept mark, and the number of steps per mark.
    skipped: u32,
    every: u32,
    marks: Vec<Mark>,
    last: Option<Mark>,
    /// The steps before `last`, the latest first.
    before: [Option<Mark>; ENDS - 1],
    /// The number of steps of this motion.
    made: usize,
    /// The last interval, in this motion.
    interval: Option<u64>,
}

impl Traces {
    /// The empty traces of a board whose timer has this many ticks per second.
    pub fn new(hz: u32) -> Traces {
        Traces { hz, axes: Default::default() }
    }

    /// Sets the direction of an axis, which may be the same as before.
    pub fn direction(&mut self, axis: u8, forward: bool) {
        let Some(axis) = self.axes.get_mut(usize::from(axis)) else { return };
        axis.pause();
        axis.backward = !forward;
    }

    /// Records a step of an axis in its direction, at this tick.
    pub fn pulse(&mut self, axis: u8, time: u64) {
        if let Some(axis) = self.axes.get_mut(usize::from(axis)) {
            axis.step(time);
        }
    }

    /// Records a step of an axis in this direction, at this tick.
    pub fn step(&mut self, axis: u8, time: u64, forward: bool) {
        let known = self.axes.get(usize::from(axis)).map(|axis| !axis.backward);
        if known.is_some_and(|known| known != forward) {
            self.direction(axis, forward);
        }
        self.pulse(axis, time);
    }

    /// The tick of the first step.
    pub fn first(&self) -> u64 {
        let first = self.axes.iter().filter_map(|axis| Some(axis.marks.first()?.time)).min();
        first.unwrap_or(0)
    }

    /// The motions of the axes that have moved. Times count from `zero` ticks.
    pub fn series(&self, zero: u64) -> Vec<AxisSeries> {
        let axes = self.axes.iter().enumerate().filter(|(_, axis)| axis.last.is_some());
        let clock = Clock { hz: f64::from(self.hz), zero: zero as f64 };
        axes.map(|(n, axis)| {
            let marks = axis.all_marks();
            let window = slopes::window(&marks);
            AxisSeries {
                name: format!("axis {}", n + 1),
                position: slopes::position(&marks, clock),
                speed: slopes::speed(&marks, clock),
                accel: slopes::accel(&marks, window, clock),
                jerk: slopes::jerks(&marks, window, clock),
                window: window as f64 / clock.hz,
            }
        })
        .collect()
    }
}

impl Axis {
    fn step(&mut self, time: u64) {
        let position = self.position + if self.backward { -1 } else { 1 };
        let interval = self.last.map(|last| time - last.time);
        if let (Some(now), Some(before)) = (interval, self.interval)
            && now > PAUSE.saturating_mul(before)
        {
            self.pause();
        }
        let first = self.last.is_none_or(|last| last.last);
        self.interval = interval.filter(|_| !first);
        self.position = position;
        self.made = if first { 1 } else { self.made.saturating_add(1) };
        let mark = Mark { time, position, first, last: false, end: self.made <= ENDS };
        self.before.rotate_right(1);
        self.before[0] = self.last.filter(|_| !first);
        if first {
            self.before = [None; ENDS - 1];
        }
        self.last = Some(mark);
        self.skipped += 1;
        if mark.end || self.skipped >= self.every {
            self.keep(mark);
        }
    }

    /// Ends a motion: the step before was its last.
    fn pause(&mut self) {
        self.interval = None;
        if let Some(last) = self.last.filter(|last| !last.last) {
            let last = Mark { last: true, end: true, ..last };
            self.last = Some(last);
            let mut marks = std::mem::take(&mut self.marks);
            self.close(&mut marks);
            self.marks = marks;
        }
    }

    /// Adds the last steps of a motion to its marks.
    fn close(&self, marks: &mut Vec<Mark>) {
        let before = self.before.iter().rev().flatten().copied();
        let Some(last) = self.last else { return };
        for step in before.chain([Mark { last: true, ..last }]) {
            let step = Mark { end: true, ..step };
            let place = marks.partition_point(|mark| mark.time < step.time);
            let room = marks.len() < 2 * MARKS;
            match marks.get_mut(place).filter(|mark| mark.time == step.time) {
                Some(mark) => (mark.end, mark.last) = (true, step.last),
                None if room => marks.insert(place, step),
                None => {}
            }
        }
    }

    fn keep(&mut self, mark: Mark) {
        self.skipped = 0;
        if self.marks.len() >= MARKS {
            let mut odd = false;
            self.marks.retain(|mark| {
                odd = !odd;
                odd || mark.end
            });
            self.every = self.every.max(1).saturating_mul(2);
        }
        // If only pauses are left, further marks are dropped.
        if self.marks.len() < 2 * MARKS {
            self.marks.push(mark);
        }
    }

    /// The marks, including that of the last step.
    fn all_marks(&self) -> Vec<Mark> {
        let mut marks = self.marks.clone();
        self.close(&mut marks);
        marks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn traced(times: impl IntoIterator<Item = u64>) -> AxisSeries {
        let mut traces = Traces::new(1_000_000);
        for time in times {
            traces.pulse(1, time);
        }
        let mut series = traces.series(0);
        assert!(series.len() == 1 && series[0].name == "axis 2");
        series.remove(0)
    }

    fn speeds(times: impl IntoIterator<Item = u64>) -> Vec<(f64, f64)> {
        traced(times).speed
    }

    #[test]
    fn a_pause_is_a_gap() {
        let ms = |n: u64| n * 1000;
        assert_eq!(
            speeds([ms(10), ms(11), ms(12), ms(100), ms(102)]),
            [
                (0.01, 0.0),
                (0.01, 1000.0),
                (0.0105, 1000.0),
                (0.0115, 1000.0),
                (0.012, 1000.0),
                (0.012, 0.0),
                (0.1, 0.0),
                (0.1, 500.0),
                (0.101, 500.0),
                (0.102, 500.0),
                (0.102, 0.0),
            ]
        );
        assert_eq!(speeds([7]), [(7e-6, 0.0), (7e-6, 0.0), (7e-6, 0.0), (7e-6, 0.0)]);
    }

    #[test]
    fn a_turn_is_a_gap_and_backward_is_negative() {
        let mut traces = Traces::new(1_000_000);
        traces.pulse(0, 0);
        traces.pulse(0, 50);
        traces.direction(0, false);
        traces.pulse(0, 100);
        traces.pulse(0, 150);
        // The same motion, with a direction for each step.
        let mut coils = Traces::new(1_000_000);
        for (time, forward) in [(0, true), (50, true), (100, false), (150, false)] {
            coils.step(0, time, forward);
        }
        let points = &traces.series(0)[0].speed;
        assert_eq!(&coils.series(0)[0].speed, points);
        let v = 20_000.0;
        let speeds: Vec<f64> = points.iter().map(|(_, speed)| *speed).collect();
        assert_eq!(speeds, [0.0, v, v, v, 0.0, 0.0, -v, -v, -v, 0.0]);
        assert_eq!((points[4].0, points[5].0), (50e-6, 100e-6));
    }

    /// From rest with 2500 steps/s² to 1000 steps/s, a cruise, and back, in whole µs: the
    /// acceleration is within 3 %, although one tick is 25 % of the change of an interval.
    #[test]
    fn the_acceleration_is_that_of_the_ramps() {
        let up = |n: f64| (2.0 * n / 2500.0).sqrt();
        let times = (0..=1000u32).map(|n| {
            let n = f64::from(n);
            let s = match n {
                n if n < 200.0 => up(n),
                n if n <= 800.0 => 0.4 + (n - 200.0) / 1000.0,
                n => 1.4 - up(1000.0 - n),
            };
            (s * 1e6).round() as u64
        });
        let AxisSeries { position, accel, .. } = traced(times);
        assert_eq!(position.last(), Some(&(1.4, 1001.0)));
        assert_eq!((position[0], position[1]), ((0.0, 0.0), (0.0, 1.0)));
        let within = |from: f64, to: f64, accel: f64, points: &[(f64, f64)]| {
            let points: Vec<_> = points.iter().filter(|(t, _)| from < *t && *t < to).collect();
            assert!(points.len() > 40, "{points:?}");
            let off = points.iter().map(|(_, a)| (a - accel).abs()).fold(0.0, f64::max);
            assert!(off < 2500.0 * 0.03, "{off} from {from}");
        };
        within(0.02, 0.38, 2500.0, &accel);
        within(0.42, 0.98, 0.0, &accel);
        within(1.02, 1.38, -2500.0, &accel);
        assert_eq!((accel[0], accel[accel.len() - 1]), ((0.0, 0.0), (1.4, 0.0)));
        // One step has no acceleration, two intervals have one.
        assert_eq!(traced([7]).accel, [(7e-6, 0.0), (7e-6, 0.0)]);
        let two = traced([0, 100, 180]).accel; // 10,000 and 12,500 steps/s, 90 µs apart
        assert_eq!(two.len(), 5);
        assert!((two[1].1 * 90e-6 - 2500.0).abs() < 1e-6 && two[1].1 == two[3].1, "{two:?}");
    }

    #[test]
    fn times_count_from_where_one_likes() {
        let mut traces = Traces::new(1_000_000);
        for (axis, time) in [(1, 2000), (0, 3000), (1, 4000)] {
            traces.pulse(axis, time);
        }
        assert_eq!(traces.first(), 2000);
        let series = traces.series(2000);
        assert_eq!(series[0].position, [(0.001, 0.0), (0.001, 1.0)]);
        // A few steps are all drawn.
        let each = [(0.0, 0.0), (0.0, 1.0), (0.002, 1.0), (0.002, 2.0)];
        assert_eq!(series[1].position, each);
    }

    /// A ramp begins and ends at the start speed, for any number of steps.
    #[test]
    fn the_start_speed_is_the_true_one() {
        for (start, accel, steps) in [(50.0, 2500.0, 400), (50.0, 20_000.0, 40), (0.0, 8000.0, 9)] {
            for steps in [steps, 300_000] {
                let time = |n: f64| ((start * start + 2.0 * accel * n).sqrt() - start) / accel;
                let half = f64::from(steps / 2);
                let times = (0..=2 * (steps / 2)).map(|n| match f64::from(n) {
                    n if n <= half => time(n),
                    n => 2.0 * time(half) - time(2.0 * half - n),
                });
                let points = speeds(times.map(|s| (s * 1e6).round() as u64));
                let ends = [points[1].1, points[points.len() - 2].1];
                assert!(ends.iter().all(|v| (v - start).abs() < 3.0), "{start} {steps}: {ends:?}");
            }
        }
    }

    #[test]
    fn memory_is_bounded_and_the_speed_stays_true() {
        let points = speeds((0..1_000_000).map(|n| n * 250));
        assert!(points.len() < 2 * MARKS, "{}", points.len());
        let inner = &points[1..points.len() - 1];
        assert!(inner.iter().all(|(_, v)| *v == 4000.0));
        assert_eq!(points.last().unwrap().0, 249.99975);
        // Motions of a single step can't be thinned.
        let lone = speeds((0..100_000).map(|n| n * n * n));
        assert!(lone.len() < 20 * MARKS);
    }
}
