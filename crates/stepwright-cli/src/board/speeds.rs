//! Speed over time, from the steps that were made.
//!
//! Between two steps the speed is that of their distance, at the middle of the
//! time between them. However long a motor moves, this many points are kept: when
//! there are too many, every second one goes.

use stepwright::Rate;
use stepwright_sim::{Edge, Pin};

use crate::plot::Series;

/// Points of an axis: more than a picture has columns.
const MARKS: usize = 4096;

/// A pause is this many times longer than the interval before it. A ramp that
/// begins or ends at rest never grows an interval by more than 2.5 times.
const PAUSE: u64 = 5;

/// Axes that a board may have.
const AXES: usize = 8;

/// The speeds of a board's axes.
pub struct Speeds {
    rate: Rate,
    axes: [Axis; AXES],
}

#[derive(Clone, Default)]
struct Axis {
    backward: bool,
    position: i64,
    /// Steps since the last mark that was kept, and how many make one.
    skipped: u32,
    every: u32,
    marks: Vec<Mark>,
    last: Option<Mark>,
    /// The last interval, in this motion.
    interval: Option<u64>,
}

/// A step.
#[derive(Clone, Copy, Debug)]
struct Mark {
    time: u64,
    position: i64,
    /// It is the first after a pause.
    first: bool,
    /// It is the last before one.
    last: bool,
}

impl Speeds {
    /// Of a board whose timer runs at `rate`.
    pub fn new(rate: Rate) -> Speeds {
        Speeds { rate, axes: Default::default() }
    }

    /// Takes an edge down.
    pub fn edge(&mut self, edge: Edge) {
        let Some(axis) = self.axes.get_mut(usize::from(edge.axis)) else { return };
        match edge.pin {
            Pin::Direction => {
                axis.pause();
                axis.backward = !edge.level;
            }
            Pin::Step if edge.level => axis.step(edge.time),
            _ => {}
        }
    }

    /// The speeds of the axes that have moved.
    pub fn series(&self) -> Vec<Series> {
        let axes = self.axes.iter().enumerate().filter(|(_, axis)| axis.last.is_some());
        let hz = f64::from(self.rate.hz());
        axes.map(|(n, axis)| Series { name: format!("axis {}", n + 1), points: axis.points(hz) })
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
        let mark = Mark { time, position, first, last: false };
        self.last = Some(mark);
        self.skipped += 1;
        if first || self.skipped >= self.every {
            self.keep(mark);
        }
    }

    /// The step before was the last of its motion.
    fn pause(&mut self) {
        self.interval = None;
        if let Some(last) = self.last.filter(|last| !last.last) {
            let last = Mark { last: true, ..last };
            self.last = Some(last);
            match self.marks.last_mut().filter(|mark| mark.time == last.time) {
                Some(mark) => mark.last = true,
                None => self.keep(last),
            }
        }
    }

    fn keep(&mut self, mark: Mark) {
        self.skipped = 0;
        if self.marks.len() >= MARKS {
            let mut odd = false;
            self.marks.retain(|mark| {
                odd = !odd;
                odd || mark.first || mark.last
            });
            self.every = self.every.max(1).saturating_mul(2);
        }
        // Nothing but pauses is left: that is no picture any more.
        if self.marks.len() < 2 * MARKS {
            self.marks.push(mark);
        }
    }

    /// Seconds and steps/s.
    fn points(&self, hz: f64) -> Vec<(f64, f64)> {
        let mut marks = self.marks.clone();
        if let (Some(last), Some(mark)) = (self.last, marks.last()) {
            if mark.time != last.time {
                marks.push(last);
            }
            if let Some(mark) = marks.last_mut() {
                mark.last = true;
            }
        }
        let seconds = |ticks: f64| ticks / hz;
        let mut points = Vec::new();
        let mut speed = 0.0;
        for (n, mark) in marks.iter().enumerate() {
            let time = seconds(mark.time as f64);
            let next = marks.get(n + 1).filter(|_| !mark.last);
            let until = next.map(|next| {
                let steps = next.position.abs_diff(mark.position) as f64;
                let way = if next.position < mark.position { -1.0 } else { 1.0 };
                let ticks = (next.time - mark.time) as f64;
                (seconds(mark.time as f64 + ticks / 2.0), way * steps * hz / ticks)
            });
            if mark.first {
                points.push((time, 0.0));
                points.push((time, until.map_or(0.0, |(_, speed)| speed)));
            }
            match until {
                Some((middle, now)) => {
                    speed = now;
                    points.push((middle, speed));
                }
                None => {
                    points.push((time, speed));
                    points.push((time, 0.0));
                    speed = 0.0;
                }
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(times: impl IntoIterator<Item = u64>) -> Vec<(f64, f64)> {
        let mut speeds = Speeds::new(Rate::MHZ);
        for time in times {
            speeds.edge(Edge { time, axis: 1, pin: Pin::Step, level: true });
            speeds.edge(Edge { time: time + 2, axis: 1, pin: Pin::Step, level: false });
        }
        let series = speeds.series();
        assert!(series.len() == 1 && series[0].name == "axis 2");
        series[0].points.clone()
    }

    #[test]
    fn a_pause_is_a_gap() {
        let ms = |n: u64| n * 1000;
        assert_eq!(
            series([ms(10), ms(11), ms(12), ms(100), ms(102)]),
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
        assert_eq!(series([7]), [(7e-6, 0.0), (7e-6, 0.0), (7e-6, 0.0), (7e-6, 0.0)]);
    }

    #[test]
    fn a_turn_is_a_gap_and_backward_is_negative() {
        let mut speeds = Speeds::new(Rate::MHZ);
        for (time, pin, level) in [
            (0, Pin::Step, true),
            (50, Pin::Step, true),
            (90, Pin::Direction, false),
            (100, Pin::Step, true),
            (150, Pin::Step, true),
        ] {
            speeds.edge(Edge { time, axis: 0, pin, level });
        }
        let points = &speeds.series()[0].points;
        let v = 20_000.0;
        let speeds: Vec<f64> = points.iter().map(|(_, speed)| *speed).collect();
        assert_eq!(speeds, [0.0, v, v, v, 0.0, 0.0, -v, -v, -v, 0.0]);
        assert_eq!((points[4].0, points[5].0), (50e-6, 100e-6));
    }

    #[test]
    fn memory_is_bounded_and_the_speed_stays_true() {
        let points = series((0..1_000_000).map(|n| n * 250));
        assert!(points.len() < 2 * MARKS, "{}", points.len());
        let inner = &points[1..points.len() - 1];
        assert!(inner.iter().all(|(_, v)| *v == 4000.0));
        assert_eq!(points.last().unwrap().0, 249.99975);
        // Motions of a single step: nothing can be thinned.
        let lone = series((0..100_000).map(|n| n * n * n));
        assert!(lone.len() < 20 * MARKS);
    }
}
