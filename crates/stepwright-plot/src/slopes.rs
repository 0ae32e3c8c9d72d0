//! Position, speed, acceleration and jerk over time, from recorded steps.

use crate::jerk::jerk;

/// The number of windows of the acceleration in the time of an axis' motion.
const WINDOWS: u64 = 300;

/// Up to this many steps, each is drawn.
const FEW: usize = 80;

/// A step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    pub time: u64,
    pub position: i64,
    /// Whether it is the first step after a pause.
    pub first: bool,
    /// Whether it is the last step before a pause.
    pub last: bool,
    /// Whether it is near an end of its motion.
    pub end: bool,
}

/// Converts ticks to seconds.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub hz: f64,
    /// The tick at 0 s.
    pub zero: f64,
}

impl Clock {
    fn at(self, mark: &Mark) -> f64 {
        (mark.time as f64 - self.zero) / self.hz
    }

    /// The middle of the time between two marks.
    fn middle(self, a: &Mark, b: &Mark) -> f64 {
        ((a.time as f64 + b.time as f64) / 2.0 - self.zero) / self.hz
    }

    /// The mean speed between two marks, in steps/s.
    fn speed(self, a: &Mark, b: &Mark) -> f64 {
        (b.position - a.position) as f64 * self.hz / (b.time as f64 - a.time as f64)
    }
}

/// Seconds and steps: each step if there are few, otherwise a line through the marks.
pub(crate) fn position(marks: &[Mark], clock: Clock) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    let mut before = 0.0;
    for mark in marks {
        let (time, position) = (clock.at(mark), mark.position as f64);
        if marks.len() <= FEW || mark.first {
            points.push((time, before));
        }
        points.push((time, position));
        before = position;
    }
    points
}

/// The speed at the end `a` of a motion, from the intervals from there to `b` and on to `c`. It is
/// exact for a constant acceleration, and never of the other sign.
fn end_speed(clock: Clock, a: &Mark, b: &Mark, c: Option<&Mark>) -> f64 {
    let (near, at) = (clock.speed(a, b), clock.middle(a, b));
    let Some(c) = c else { return near };
    let (far, then) = (clock.speed(b, c), clock.middle(b, c));
    let speed = near + (near - far) * (clock.at(a) - at) / (at - then);
    let (least, most) = if near < 0.0 { (2.0 * near, 0.0) } else { (0.0, 2.0 * near) };
    speed.clamp(least, most)
}

/// The speed: seconds and steps/s.
pub(crate) fn speed(marks: &[Mark], clock: Clock) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    let mut speed = 0.0;
    for (n, mark) in marks.iter().enumerate() {
        let time = clock.at(mark);
        let next = marks.get(n + 1).filter(|_| !mark.last);
        let until = next.map(|next| (clock.middle(mark, next), clock.speed(mark, next)));
        if mark.first {
            points.push((time, 0.0));
            let (second, third) = (marks.get(n + 1), marks.get(n + 2));
            let third = third.filter(|_| second.is_some_and(|second| !second.last));
            let start = until.zip(second).map(|(_, second)| end_speed(clock, mark, second, third));
            points.push((time, start.unwrap_or(0.0)));
        }
        match until {
            Some((middle, now)) => {
                speed = now;
                points.push((middle, speed));
            }
            None => {
                let before = |steps: usize| n.checked_sub(steps).and_then(|n| marks.get(n));
                let second = before(1).filter(|_| !mark.first);
                let third = second.filter(|second| !second.first).and(before(2));
                let end = second.map_or(speed, |second| end_speed(clock, mark, second, third));
                points.push((time, end));
                points.push((time, 0.0));
                speed = 0.0;
            }
        }
    }
    points
}

/// The longest time over which speeds are compared, in ticks.
pub(crate) fn window(marks: &[Mark]) -> u64 {
    match marks {
        [first, .., last] => (last.time - first.time) / WINDOWS,
        _ => 0,
    }
}

/// The acceleration: seconds and steps/s², 0 at rest.
pub(crate) fn accel(marks: &[Mark], window: u64, clock: Clock) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for motion in marks.chunk_by(|mark, _| !mark.last) {
        let (Some(begin), Some(end)) = (motion.first(), motion.last()) else { continue };
        let changes = changes(motion, window, clock);
        points.push((clock.at(begin), 0.0));
        // At the ends, takes the acceleration beside them.
        points.extend(changes.first().map(|(_, accel)| (clock.at(begin), *accel)));
        points.extend(&changes);
        points.extend(changes.last().map(|(_, accel)| (clock.at(end), *accel)));
        points.push((clock.at(end), 0.0));
    }
    points
}

/// The acceleration within a motion: seconds and steps/s².
fn changes(motion: &[Mark], window: u64, clock: Clock) -> Vec<(f64, f64)> {
    let (Some(begin), Some(end)) = (motion.first(), motion.last()) else { return Vec::new() };
    // A short motion among others gets a smaller window.
    let window = window.min((end.time - begin.time) / 24);
    let mut changes = Vec::new();
    for three in windows(motion, window).windows(3) {
        let [a, b, c] = three else { continue };
        let gain = clock.speed(b, c) - clock.speed(a, b);
        changes.push((clock.at(b), gain / (clock.middle(b, c) - clock.middle(a, b))));
    }
    changes
}

/// The jerk: seconds and steps/s³, 0 at rest.
pub(crate) fn jerks(marks: &[Mark], window: u64, clock: Clock) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for motion in marks.chunk_by(|mark, _| !mark.last) {
        let (Some(begin), Some(end)) = (motion.first(), motion.last()) else { continue };
        points.push((clock.at(begin), 0.0));
        points.extend(jerk(&changes(motion, window, clock)));
        points.push((clock.at(end), 0.0));
    }
    points
}

/// The marks of a motion that are at least a window apart, including its ends.
fn windows(motion: &[Mark], window: u64) -> Vec<Mark> {
    let mut ends: Vec<Mark> = Vec::new();
    for mark in motion {
        if ends.last().is_none_or(|last| mark.time - last.time >= window.max(1)) {
            ends.push(*mark);
        }
    }
    // The end is included, even if that makes the last window longer.
    if let Some(last) = motion.last().filter(|end| ends.last().is_some_and(|l| l.time < end.time)) {
        if ends.len() > 1 {
            ends.pop();
        }
        ends.push(*last);
    }
    ends
}
