//! The pulses that a board was ordered to make: all that is known about the pins of a board at the end of a
//! line.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use stepwright_host::course::Course;
use stepwright_protocol::{Direction, Distance, Order, Travel};

use crate::scope::{LONGEST, ScopeRecord, ScopeSignal, ScopeSource};

/// Ticks per second of a record.
const HZ: u32 = 1_000_000;

/// The most pulses of an axis in a record; a record with more begins later.
const MOST: usize = 50_000;

/// The most travels that are kept.
const KEPT: usize = 64;

const WORDS: &str = "the pulses as they were planned, from the moment of the order: the edges \
                     on this board's pins are not seen by its line";

/// The orders of the axes.
#[derive(Default)]
pub struct PlannedPins(Mutex<Plans>);

#[derive(Default)]
struct Plans {
    axes: u8,
    /// How long STEP stays high, in µs.
    pulse: u64,
    travels: VecDeque<PlannedTravel>,
}

struct PlannedTravel {
    axis: u8,
    forward: bool,
    /// In s since the server began.
    begin: f64,
    until: f64,
    course: Course,
}

impl PlannedTravel {
    /// The pulses between two times, in µs; the last `MOST` of them.
    fn pulses(&self, from: f64, to: f64) -> Vec<u64> {
        let count = self.course.pulses();
        let first = |time: f64| {
            let (mut low, mut high) = (0, count);
            while low < high {
                let middle = low + (high - low) / 2;
                let early = self.begin + self.course.seconds(middle) < time;
                if early { low = middle + 1 } else { high = middle }
            }
            low
        };
        let end = first(to.min(self.until));
        let begin = first(from).max(end.saturating_sub(MOST as u32));
        (begin..end).map(|n| micros(self.begin + self.course.seconds(n))).collect()
    }
}

fn micros(seconds: f64) -> u64 {
    (seconds.max(0.0) * f64::from(HZ)).round() as u64
}

impl PlannedPins {
    fn plans(&self) -> MutexGuard<'_, Plans> {
        // No change can panic half-way.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the number of axes, and how long STEP stays high, in µs.
    pub fn describe(&self, axes: u8, pulse: u32) {
        let mut plans = self.plans();
        (plans.axes, plans.pulse) = (axes, pulse.max(1).into());
    }

    /// Notes that an axis begins this order, at this time in s since the server began.
    pub fn begin(&self, axis: u8, order: &Order, begin: f64) {
        let far = |way| Travel::By(Distance::new(if way { i32::MAX } else { -i32::MAX }));
        let (forward, travel) = match order.travel {
            Travel::By(by) => (by.get() >= 0, order.travel),
            Travel::Endless(way) => {
                let forward = way == Direction::Forward;
                (forward, far(forward))
            }
        };
        self.unplan(axis, begin);
        let Some(course) = Course::of(&Order { travel, ..*order }.into()) else { return };
        let mut plans = self.plans();
        let until = f64::INFINITY;
        plans.travels.push_back(PlannedTravel { axis, forward, begin, until, course });
        if plans.travels.len() > KEPT {
            plans.travels.pop_front();
        }
    }
}

impl ScopeSource for PlannedPins {
    fn record(&self, seconds: f64, now: f64) -> ScopeRecord {
        let plans = self.plans();
        let mut from = (now - seconds.min(LONGEST)).max(0.0);
        let of = |axis: u8, from: f64| {
            let travels = plans.travels.iter().filter(move |travel| travel.axis == axis);
            travels.map(move |travel| (travel, travel.pulses(from, now)))
        };
        // If an axis has made too many pulses, the whole record begins later.
        for axis in 1..=plans.axes {
            let times: Vec<u64> = of(axis, from).flat_map(|(_, pulses)| pulses).collect();
            if let Some(time) = times.len().checked_sub(MOST).and_then(|n| times.get(n)) {
                from = from.max(*time as f64 / f64::from(HZ));
            }
        }
        let (begin, end) = (micros(from), micros(now));
        let mut signals = Vec::new();
        for axis in 1..=plans.axes {
            let mut step = ScopeSignal::new(Some(axis), "step");
            let mut dir = ScopeSignal::new(Some(axis), "dir");
            step.level = Some(false);
            let (mut last, mut turned, mut forward) = (begin, begin, None);
            for (travel, pulses) in of(axis, from) {
                let before = forward.replace(travel.forward);
                if before.is_none() || travel.begin <= from {
                    dir.level = Some(travel.forward);
                } else if before != forward {
                    let time = micros(travel.begin).clamp(turned, end);
                    dir.edges.push(time - turned);
                    turned = time;
                }
                for (n, time) in pulses.iter().enumerate() {
                    let rise = (*time).clamp(last, end);
                    let next = pulses.get(n + 1).map_or(end, |next| next.saturating_sub(1));
                    let fall = (rise + plans.pulse).min(next).clamp(rise, end);
                    step.edges.extend([rise - last, fall - rise]);
                    last = fall;
                }
            }
            signals.extend([step, dir]);
        }
        ScopeRecord { source: "plan".into(), words: WORDS.into(), hz: HZ, begin, end, signals }
    }

    fn unplan(&self, axis: u8, time: f64) {
        for travel in self.plans().travels.iter_mut().filter(|travel| travel.axis == axis) {
            travel.until = travel.until.min(time);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright::{Accel, Speed};
    use stepwright_protocol::Ramp;

    /// The travel has this speed from its first step on.
    fn order(travel: Travel) -> Order {
        let (up, speed) = (Ramp::Accel(Accel::from_steps(1000).unwrap()), Speed::from_steps(100));
        let speed = speed.unwrap();
        Order { start: speed, top: speed, up, down: up, jerk: None, travel }
    }

    fn times(signal: &ScopeSignal) -> Vec<u64> {
        let mut time = 0;
        signal.edges.iter().map(|ticks| (time += ticks, time).1).collect()
    }

    #[test]
    fn pulses_are_those_of_the_law() {
        let pins = PlannedPins::default();
        pins.describe(2, 2);
        pins.begin(2, &order(Travel::By(Distance::new(-3))), 5.0);
        pins.begin(2, &order(Travel::By(Distance::new(9))), 5.5);
        let record = pins.record(1.0, 5.515);
        assert_eq!(
            (record.source.as_ref(), record.begin, record.end),
            ("plan", 4_515_000, 5_515_000)
        );
        let names: Vec<_> = record.signals.iter().map(|signal| signal.name.as_str()).collect();
        assert_eq!(names, ["step1", "dir1", "step2", "dir2"]);
        assert!(record.signals[0].edges.is_empty());
        // One each 10 ms; of the second travel only those that were due.
        let rises: Vec<_> = times(&record.signals[2]).into_iter().step_by(2).collect();
        assert_eq!(rises, [485_000, 495_000, 505_000, 985_000, 995_000]);
        assert_eq!(record.signals[2].edges[1], 2);
        let dir = &record.signals[3];
        assert_eq!((dir.level, dir.edges.as_slice()), (Some(false), &[985_000][..]));
    }

    #[test]
    fn what_was_stopped_has_no_pulses_any_more() {
        let pins = PlannedPins::default();
        pins.describe(1, 2);
        pins.begin(1, &order(Travel::Endless(Direction::Backward)), 1.0);
        pins.unplan(1, 1.095);
        assert_eq!(pins.record(10.0, 9.0).signals[0].edges.len(), 2 * 10);
        // A fast, long run: the record begins later, and is complete from there on.
        let fast = Speed::from_steps(20_000).unwrap();
        let fast = Order { start: fast, top: fast, ..order(Travel::Endless(Direction::Forward)) };
        pins.begin(1, &fast, 10.0);
        let record = pins.record(10.0, 19.0);
        assert_eq!(record.end - record.begin, 2_500_000);
        assert_eq!(record.signals[0].edges.len(), 2 * MOST);
    }
}
