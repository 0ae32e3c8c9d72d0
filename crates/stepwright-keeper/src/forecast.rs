//! The expected course of an axis under an order, from the closed form of its law.

use stepwright_host::course::Course;
use stepwright_protocol::{Direction, Distance, Order, Travel};

use crate::report::PlannedCurve;

/// The number of points of a ramp.
const RAMP: u32 = 80;

/// How far ahead an endless run is predicted, in s.
const LONG: f64 = 3600.0;

/// The curve of an axis that starts at position `from` at time `begin`; `None` if the law has no closed form
/// here.
pub fn of(axis: u8, from: i64, order: &Order, begin: f64) -> Option<PlannedCurve> {
    let (endless, sign) = match order.travel {
        Travel::By(distance) => (false, f64::from(distance.get().signum())),
        Travel::Endless(Direction::Forward) => (true, 1.0),
        Travel::Endless(Direction::Backward) => (true, -1.0),
    };
    // An endless run begins like a very long travel.
    let far = Travel::By(Distance::new(i32::MAX));
    let course =
        Course::of(&Order { travel: if endless { far } else { order.travel }, ..*order }.into())?;
    let mut pulses = chosen(&course, endless);
    pulses.dedup();
    let (mut seconds, mut position, mut speed) = (Vec::new(), Vec::new(), Vec::new());
    let mut point = |time: f64, steps: f64, rate: f64| {
        seconds.push(time);
        position.push(from as f64 + sign * steps);
        speed.push(sign * rate);
    };
    point(0.0, 0.0, 0.0);
    for pair in pulses.windows(2) {
        let [before, after] = [pair[0], pair[1]];
        let (begin, end) = (course.seconds(before), course.seconds(after));
        if end > begin {
            // Pulse 0 is the first step: between two pulses the axis is one step further.
            let steps = f64::from(before) / 2.0 + f64::from(after) / 2.0 + 1.0;
            point((begin + end) / 2.0, steps, f64::from(after - before) / (end - begin));
        }
    }
    let last = pulses.last().copied().unwrap_or(0);
    let (end, steps) = (course.seconds(last), f64::from(last) + 1.0);
    if endless {
        let rate = f64::from(order.top.millisteps()) / 1000.0;
        point(end, steps, rate);
        point(end + LONG, steps + LONG * rate, rate);
    } else if course.pulses() > 0 {
        point(end, steps, 0.0);
    }
    Some(PlannedCurve { axis, begin, seconds, position, speed })
}

/// The pulses between which speeds are given: close together where the speed changes.
fn chosen(course: &Course, endless: bool) -> Vec<u32> {
    let last = course.pulses().saturating_sub(1);
    let peak = f64::from(course.peak()) / 1000.0;
    // At the peak speed, except for rounding.
    let is_fast = |n: u32| {
        let next = last.min(n.saturating_add(8)).max(1);
        let before = next.saturating_sub(8);
        let time = course.seconds(next) - course.seconds(before);
        f64::from(next - before) >= 0.99 * peak * time
    };
    let up = first(0, last, is_fast);
    let down = if endless { last } else { first(up, last, |n| !is_fast(n)) };
    let between = |from: u32, to: u32| {
        let (begin, end) = (course.seconds(from), course.seconds(to));
        (0..=RAMP).map(move |k| {
            let time = begin + (end - begin) * f64::from(k) / f64::from(RAMP);
            first(from, to, |n| course.seconds(n) >= time)
        })
    };
    // A little of the constant speed belongs to each ramp, so that a ramp ends at an even speed.
    let (risen, falls) = (course.seconds(up) * 1.05, course.seconds(last) - course.seconds(down));
    let risen = first(up, down, |n| course.seconds(n) >= risen);
    let rise = between(0, risen);
    if endless {
        return rise.collect();
    }
    let falls = course.seconds(last) - falls * 1.05;
    rise.chain(between(first(risen, down, |n| course.seconds(n) >= falls), last)).collect()
}

/// The first number from `from` on for which `holds` is true, or `to`.
fn first(from: u32, to: u32, holds: impl Fn(u32) -> bool) -> u32 {
    let (mut low, mut high) = (from, to);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright::{Accel, Speed};
    use stepwright_protocol::Ramp;

    fn order(travel: Travel) -> Order {
        let accel = Ramp::Accel(Accel::from_steps(2000).unwrap());
        let top = Speed::from_steps(1000).unwrap();
        Order { start: Speed::ZERO, top, up: accel, down: accel, jerk: None, travel }
    }

    #[test]
    fn a_travel_is_told_as_the_formulas_of_school_have_it() {
        let curve = of(1, 100, &order(Travel::By(Distance::new(-4000))), 7.0).unwrap();
        assert!(curve.seconds.len() < 200, "{}", curve.seconds.len());
        assert!(curve.seconds.is_sorted());
        assert_eq!(curve.position.last(), Some(&(100.0 - 4000.0)));
        for (time, (at, speed)) in curve.seconds.iter().zip(curve.position.iter().zip(&curve.speed))
        {
            // Up in 0.5 s and 250 steps, 3500 steps at constant speed, down again: 4.5 s.
            let (way, rate) = match time {
                t if *t < 0.5 => (1000.0 * t * t, 2000.0 * t),
                t if *t < 4.0 => (250.0 + 1000.0 * (t - 0.5), 1000.0),
                t => (4000.0 - 1000.0 * (4.5 - t) * (4.5 - t), 2000.0 * (4.5 - t)),
            };
            // The law begins with its first pulse, 32 ms after the formulas.
            assert!((100.0 - at - way).abs() < 40.0, "{time}: {at} {way}");
            assert!((-speed - rate).abs() < 90.0, "{time}: {speed} {rate}");
        }
    }

    #[test]
    fn a_run_goes_on_at_its_top_speed() {
        let curve = of(1, 0, &order(Travel::Endless(Direction::Forward)), 0.0).unwrap();
        let (end, at) = (curve.seconds.last().unwrap(), curve.position.last().unwrap());
        assert!(*end > 3600.0 && curve.speed.last() == Some(&1000.0));
        assert!((at - 1000.0 * end).abs() < 400.0, "{at} {end}");
        let ramp = curve.seconds.iter().zip(&curve.speed).find(|(_, speed)| **speed > 500.0);
        assert!((ramp.unwrap().0 - 0.25).abs() < 0.05);
    }

    #[test]
    fn the_shortest_travels_have_curves() {
        for steps in [0, 1, 2, 3] {
            let curve = of(1, 5, &order(Travel::By(Distance::new(steps))), 0.0).unwrap();
            assert_eq!(curve.position.last(), Some(&(5.0 + f64::from(steps))));
        }
    }
}
