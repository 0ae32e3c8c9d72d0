//! Position, speed, acceleration and jerk over time, from steps that were kept.

use crate::jerk::jerk;

/// Windows of the acceleration in the time that an axis takes.
const WINDOWS: u64 = 300;

/// Up to this many steps, each is drawn.
const FEW: usize = 80;

/// A step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    pub time: u64,
    pub position: i64,
    /// It is the first after a pause.
    pub first: bool,
    /// It is the last before one.
    pub last: bool,
    /// It is near an end of its motion.
    pub end: bool,
}

/// Ticks as seconds.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub hz: f64,
    /// The ticks at 0 s.
    pub zero: f64,
}

impl Clock {
    fn at(self, mark: &Mark) -> f64 {
        (mark.time as f64 - self.zero) / self.hz
    }

    /// Between two marks.
    fn middle(self, a: &Mark, b: &Mark) -> f64 {
        ((a.time as f64 + b.time as f64) / 2.0 - self.zero) / self.hz
    }

    /// Steps/s from a mark to another.
    fn speed(self, a: &Mark, b: &Mark) -> f64 {
        (b.position - a.position) as f64 * self.hz / (b.time as f64 - a.time as f64)
    }
}

/// Seconds and steps: of few steps each, of many a line through them.
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

/// The speed at the end `a` of a motion, by the intervals from there to `b` and on to `c`:
/// where the acceleration is constant that is what it is. Never the other way.
fn end_speed(clock: Clock, a: &Mark, b: &Mark, c: Option<&Mark>) -> f64 {
    let (near, at) = (clock.speed(a, b), clock.middle(a, b));
    let Some(c) = c else { return near };
    let (far, then) = (clock.speed(b, c), clock.middle(b, c));
    let speed = near + (near - far) * (clock.at(a) - at) / (at - then);
    let (least, most) = if near < 0.0 { (2.0 * near, 0.0) } else { (0.0, 2.0 * near) };
    speed.clamp(least, most)
}

/// Seconds and steps/s.
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

/// Ticks over which speeds are compared, at most.
pub(crate) fn window(marks: &[Mark]) -> u64 {
    match marks {
        [first, .., last] => (last.time - first.time) / WINDOWS,
        _ => 0,
    }
}

/// Seconds and steps/s², 0 at rest.
pub(crate) fn accel(marks: &[Mark], window: u64, clock: Clock) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for motion in marks.chunk_by(|mark, _| !mark.last) {
        let (Some(begin), Some(end)) = (motion.first(), motion.last()) else { continue };
        let changes = changes(motion, window, clock);
        points.push((clock.at(begin), 0.0));
        // At the ends it is what it is beside them.
        points.extend(changes.first().map(|(_, accel)| (clock.at(begin), *accel)));
        points.extend(&changes);
        points.extend(changes.last().map(|(_, accel)| (clock.at(end), *accel)));
        points.push((clock.at(end), 0.0));
    }
    points
}

/// Seconds and steps/s², within a motion.
fn changes(motion: &[Mark], window: u64, clock: Clock) -> Vec<(f64, f64)> {
    let (Some(begin), Some(end)) = (motion.first(), motion.last()) else { return Vec::new() };
    // A short motion among others is looked at more closely.
    let window = window.min((end.time - begin.time) / 24);
    let mut changes = Vec::new();
    for three in windows(motion, window).windows(3) {
        let [a, b, c] = three else { continue };
        let gain = clock.speed(b, c) - clock.speed(a, b);
        changes.push((clock.at(b), gain / (clock.middle(b, c) - clock.middle(a, b))));
    }
    changes
}

/// Seconds and steps/s³, 0 at rest.
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

/// Marks of a motion that lie a window apart, or more; its ends among them.
fn windows(motion: &[Mark], window: u64) -> Vec<Mark> {
    let mut ends: Vec<Mark> = Vec::new();
    for mark in motion {
        if ends.last().is_none_or(|last| mark.time - last.time >= window.max(1)) {
            ends.push(*mark);
        }
    }
    // The end belongs to it, even if that makes the last window longer.
    if let Some(last) = motion.last().filter(|end| ends.last().is_some_and(|l| l.time < end.time)) {
        if ends.len() > 1 {
            ends.pop();
        }
        ends.push(*last);
    }
    ends
}
