//! The motion of a file's motors, as points with times and speeds.
//!
//! The file is played on the virtual board as fast as possible, and each step is recorded:
//!
//! ```text
//!   steps     │    │   │  │ │││││││ │  │   │    │     of each motor, to a tick
//!   between   ╱▔▔▔▔ straight on from step to step; a motor that waits stands
//!   points    ×      ×    ×       ×    ×      ×  ×     halved where a straight line is furthest
//! ```
//!
//! The speed along a line or an arc is that of its law. For other moves it is the slope of the
//! path.

use std::collections::BinaryHeap;
use std::time::{Duration, Instant};

use stepwright_cyclefile::{CyclePlan, MOST, Task};
use stepwright_keeper::drawing::{PathDrawing, PathLeg, PathMotor};
use stepwright_path::Law;

use crate::cycle::{CyclePlayer, Onlooker, PlayAhead, PlayPart, PlayText};
use crate::{PlayError, PlayFormat, PlayVoice};

/// The most steps of a drawing.
const STEPS: usize = 2_000_000;

/// The longest time to compute a drawing.
const WITHIN: Duration = Duration::from_secs(10);

/// The approximate number of points of a drawing, and the least of each leg.
const POINTS: usize = 4_000;
const LEAST: usize = 8;

/// Two points of a leg are at least this fraction of its duration apart: 1/4096.
const FINEST: f64 = 4_096.0;

/// Where a gap between two points is divided. The exact middle of a way there and back may lie on a
/// straight line.
const MIDDLE: f64 = 0.48;

/// The longest duration of a cycle in seconds.
const LIMIT: u32 = 3_600;

/// A slope is taken over this many seconds on each side.
const SLOPE: f64 = 0.004;

/// A motor stands between two steps if their interval is this many times the next or the last one.
const WAITS: f64 = 3.0;

/// The time of a step in s, and the motor's position from then on.
type Step = (f64, f64);

/// The recorded motion of all motors.
struct Seen {
    hz: f64,
    begun: Instant,
    /// The distance of a step of each motor.
    ways: Vec<f64>,
    steps: Vec<Vec<Step>>,
    count: usize,
    legs: Vec<Leg>,
}

/// A recorded part of the motion.
#[derive(Clone)]
struct Leg {
    kind: &'static str,
    at: usize,
    begin: f64,
    /// The start of the next leg.
    end: f64,
    /// The law of a path, and the time of its start.
    law: Option<(Law, f64)>,
}

impl Onlooker for Seen {
    fn part(&mut self, part: PlayPart) {
        let begin = part.begin as f64 / self.hz;
        let law = part.path.map(|(path, lead)| (path.now(), begin + f64::from(lead) / self.hz));
        self.end(begin);
        let end = f64::INFINITY;
        self.legs.push(Leg { kind: part.kind, at: part.at.start, begin, end, law });
    }

    fn at(&mut self, ticks: u64, positions: &[i64; MOST]) {
        let now = ticks as f64 / self.hz;
        let mut leap = false;
        for ((steps, place), way) in self.steps.iter_mut().zip(positions).zip(&self.ways) {
            let place = *place as f64;
            let last = steps.last().map_or(place, |(_, last)| *last);
            if place != last {
                steps.push((now, place));
                self.count += 1;
                leap |= (place - last).abs() > 1.5 * way;
            }
        }
        // The position was set without a motion, as at the end of a homing: a new leg begins.
        if leap && let Some(leg) = self.legs.last().cloned() {
            self.end(now - 0.5 / self.hz);
            self.legs.push(Leg { begin: now, ..leg });
        }
    }

    fn may(&mut self, _: u64) -> Result<PlayAhead, PlayError> {
        let long = |what: String| {
            Err(PlayError::new(what).hint("`stepwright cycle FILE --xy FILE.svg` draws any file"))
        };
        if self.count > STEPS {
            return long(format!("too long to draw here: more than {STEPS} steps"));
        }
        if self.begun.elapsed() > WITHIN {
            return long(format!("too long to draw here: more than {} s", WITHIN.as_secs()));
        }
        Ok(PlayAhead::On(u64::MAX))
    }
}

/// Reads a file of motor cycles with this name, and draws the motion of its motors. The voice may
/// interrupt it.
///
/// # Errors
/// A mistake in the file; a cycle that is refused or cancelled; too many steps.
pub fn draw_cycles(
    name: &str,
    text: &str,
    voice: &dyn PlayVoice,
) -> Result<PathDrawing, PlayError> {
    let text = PlayText::named(name, text);
    let mut plan = stepwright_cyclefile::read(&text)?;
    let hz = f64::from(plan.rate.hz());
    let mut stages = std::mem::take(&mut plan.stages);
    let begins = |n: usize| vec![(0.0, plan.positions[n] as f64)];
    let ordered: Vec<_> = stages.iter().map(|stage| (stage.at.start, speed(&stage.task))).collect();
    let steps = (0..plan.names.len()).map(begins).collect();
    let ways = plan.motors.iter().map(|motor| motor.distance.into()).collect();
    let mut seen = Seen { hz, begun: Instant::now(), ways, steps, count: 0, legs: Vec::new() };
    let seconds = {
        let session = CyclePlayer::new(&plan, &text, (), PlayFormat::Silent, voice, None, LIMIT);
        let mut session = session.before(&mut seen);
        session.play(&mut stages)?;
        session.seconds()
    };
    seen.end(seconds);
    Ok(seen.drawing(&plan, &text, seconds, &ordered))
}

fn speed(task: &Task) -> Option<f64> {
    match task {
        Task::Line(_, pace) | Task::Arc(_, _, _, pace) => Some(pace.speed),
        Task::Path(path) => Some(path.speed),
        Task::Moves | Task::Home(_) => None,
    }
}

/// The motors' positions at a time, and their speed along the path.
#[derive(Clone, Debug)]
struct Point {
    time: f64,
    speed: f64,
    places: Vec<f64>,
}

/// The gap between two points, and the error of a straight line between them.
struct Gap {
    error: f64,
    from: usize,
    to: usize,
    middle: Point,
}

impl PartialEq for Gap {
    fn eq(&self, other: &Gap) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Gap {}

impl PartialOrd for Gap {
    fn partial_cmp(&self, other: &Gap) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Gap {
    fn cmp(&self, other: &Gap) -> std::cmp::Ordering {
        self.error.total_cmp(&other.error)
    }
}

impl Seen {
    /// Ends the current leg.
    fn end(&mut self, end: f64) {
        if let Some(leg) = self.legs.last_mut() {
            leg.end = end;
        }
    }

    /// The position of a motor at a time of a leg.
    fn place(&self, motor: usize, time: f64, leg: &Leg) -> f64 {
        let steps = &self.steps[motor];
        let next = steps.partition_point(|(at, _)| *at <= time);
        let Some(&(last, from)) = next.checked_sub(1).and_then(|n| steps.get(n)) else {
            return steps.first().map_or(0.0, |(_, place)| *place);
        };
        let Some(&(at, to)) = steps.get(next).filter(|(at, _)| *at <= leg.end) else { return from };
        let before = next.checked_sub(2).map_or(f64::INFINITY, |n| last - steps[n].0);
        let after = steps.get(next + 1).map_or(f64::INFINITY, |(then, _)| then - at);
        let moves = (at - last.max(leg.begin)).min(WAITS * before.min(after));
        from + (to - from) * ((time - (at - moves)) / moves).max(0.0)
    }

    /// The speed of the motors along their path at a time of a leg.
    fn slope(&self, time: f64, leg: &Leg) -> f64 {
        let (from, to) = ((time - SLOPE).max(leg.begin), (time + SLOPE).min(leg.end));
        if to <= from {
            return 0.0;
        }
        let way = |n: usize| self.place(n, to, leg) - self.place(n, from, leg);
        (0..self.steps.len()).map(|n| way(n).powi(2)).sum::<f64>().sqrt() / (to - from)
    }

    /// The point of a leg at a time.
    fn point(&self, leg: &Leg, time: f64) -> Point {
        let speed = match &leg.law {
            Some((law, begin)) => law.speed((time - begin).max(0.0)),
            None => self.slope(time, leg),
        };
        let places = (0..self.steps.len()).map(|n| self.place(n, time, leg)).collect();
        Point { time, speed, places }
    }

    fn drawing(
        &self,
        plan: &CyclePlan,
        text: &PlayText,
        seconds: f64,
        ordered: &[(usize, Option<f64>)],
    ) -> PathDrawing {
        let spans = self.steps.iter().map(|steps| {
            let places = steps.iter().map(|(_, place)| *place);
            let (low, high) = places.fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p), b.max(p)));
            high - low
        });
        let span = spans.fold(0.0, f64::max);
        let most = (POINTS / self.legs.len().max(1)).max(LEAST);
        let motors = plan.names.iter().zip(&plan.motors);
        let mut drawing = PathDrawing {
            kind: "cycles",
            unit: plan.unit.clone(),
            motors: motors
                .map(|(name, motor)| PathMotor { name: name.clone(), step: motor.distance.into() })
                .collect(),
            seconds,
            places: vec![Vec::new(); plan.names.len()],
            ..PathDrawing::default()
        };
        for leg in &self.legs {
            let points = self.points(leg, span, most);
            let peak = points.iter().map(|point| point.speed).fold(0.0, f64::max);
            let first = drawing.times.len();
            for point in points {
                drawing.times.push(micros(point.time));
                drawing.speeds.push(rounded(point.speed));
                for (all, place) in drawing.places.iter_mut().zip(point.places) {
                    all.push(tenths(place));
                }
            }
            drawing.peak = drawing.peak.max(rounded(peak));
            let line = text.line(leg.at);
            drawing.legs.push(PathLeg {
                kind: leg.kind,
                line,
                to_line: line,
                begin: micros(leg.begin),
                end: micros(leg.end),
                peak: rounded(peak),
                ordered: match leg.kind {
                    "rest" => None,
                    _ => ordered.iter().find(|(at, _)| *at == leg.at).and_then(|(_, speed)| *speed),
                },
                first,
                last: drawing.times.len() - 1,
            });
        }
        drawing
    }

    /// The points of a leg in the order of time, most of them where it bends most.
    fn points(&self, leg: &Leg, span: f64, most: usize) -> Vec<Point> {
        let long = leg.end - leg.begin;
        let samples = (0..=LEAST).map(|n| leg.begin + long * n as f64 / LEAST as f64);
        let mut points: Vec<_> = samples.map(|time| self.point(leg, time)).collect();
        let top = match &leg.law {
            Some((law, _)) => law.peak(),
            None => points.iter().map(|point| point.speed).fold(0.0, f64::max),
        };
        let gap = |points: &[Point], from: usize, to: usize| {
            let (a, b) = (&points[from], &points[to]);
            let middle = self.point(leg, a.time + (b.time - a.time) * MIDDLE);
            let off = |a: f64, b: f64, middle: f64| (a + (b - a) * MIDDLE - middle).abs();
            let places = (a.places.iter().zip(&b.places)).zip(&middle.places);
            let way = places.map(|((a, b), middle)| off(*a, *b, *middle)).fold(0.0, f64::max);
            // A gap with a jump of the speed would be divided without end.
            let short = b.time - a.time < long / FINEST;
            let parts = |off: f64, all: f64, parts: f64| match all > 0.0 && !short {
                true => off / all * parts,
                false => 0.0,
            };
            let speed = off(a.speed, b.speed, middle.speed);
            let error = parts(way, span, 2_000.0).max(parts(speed, top, 100.0));
            Gap { error, from, to, middle }
        };
        let mut gaps: BinaryHeap<_> = (1..points.len()).map(|n| gap(&points, n - 1, n)).collect();
        while let Some(widest) = gaps.pop().filter(|gap| gap.error > 1.0 && points.len() < most) {
            let middle = points.len();
            points.push(widest.middle);
            gaps.push(gap(&points, widest.from, middle));
            gaps.push(gap(&points, middle, widest.to));
        }
        points.sort_by(|a, b| a.time.total_cmp(&b.time));
        points
    }
}

/// Rounds seconds to a µs.
fn micros(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

/// Rounds a position to a tenth of the file's unit.
fn tenths(place: f64) -> f64 {
    (place * 10.0).round() / 10.0
}

/// Rounds a speed to six digits.
fn rounded(speed: f64) -> f64 {
    if speed <= 0.0 {
        return 0.0;
    }
    let unit = 10f64.powf(speed.log10().floor() - 5.0);
    (speed / unit).round() * unit
}
