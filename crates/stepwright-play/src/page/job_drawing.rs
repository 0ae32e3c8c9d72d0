//! A job as points with times and speeds, for a picture. Nothing is played.
//!
//! ```text
//!   stretches   ╱▔▔▔▔╲__╱▔╲      of the plan: times, speeds, places
//!   points      ×    × × × ×     those that a straight line between others is not near to
//! ```
//!
//! A drawing has a limited number of points and parts; that of a long job is coarser.

use std::time::Instant;

use stepwright_gcode::{Effect, MoveKind, Options, Reader};
use stepwright_keeper::drawing::{PathDrawing, PathLeg, PathMotor};
use stepwright_path::{AxisPace, LaserMove, Stretch};
use stepwright_plan::gcode::{GcodeJob, JobPlan};

use super::facts;
use super::job::{NM, PageJob, WITHIN, long};
use super::thin::{Thin, ThinPoint, Tolerance};
use crate::PlayError;
use crate::gcode::{BOARD, NAMES};

/// The most points of a drawing.
const POINTS: usize = 20_000;

/// The approximate number of parts of a drawing. In a job with more lines a part covers several
/// lines.
const PARTS: usize = 400;

/// The most points of a third of a stretch, before thinning.
const SAMPLES: f64 = 64.0;

/// The axes are at rest between two moves if the gap is at least this long, in s.
const APART: f64 = 1e-9;

/// The number of stretches between two checks of the clock.
const STRIDE: u32 = 1_000;

impl PageJob<'_> {
    /// Reads the job, and draws the motion of its axes, and the power of its laser if it has one.
    ///
    /// # Errors
    /// The first error of the job; drawing takes too long.
    pub fn draw(&self) -> Result<PathDrawing, PlayError> {
        let begun = Instant::now();
        let (plan, kinds) = (self.planned()?, kinds(self.text));
        let mut sketch = Sketch::new(&plan, &self.axes, &kinds);
        let mut job = GcodeJob::on(self.text.bytes(), self.axes, &plan.terms)
            .map_err(|why| PlayError::new(format!("the axes of the machine file: {why}")))?;
        let mut next = STRIDE;
        let failed = |why| PlayError::job(self.name, &why);
        while let Some((line, stretch)) = job.stretch().map_err(failed)? {
            sketch.add(line, &stretch, job.laser_move());
            next -= 1;
            if next == 0 {
                next = STRIDE;
                if begun.elapsed() > WITHIN {
                    return Err(long());
                }
            }
        }
        sketch.rest(u32::MAX, plan.time);
        Ok(sketch.drawing(&plan, &self.axes))
    }
}

/// The kind of each line, by line number. If a line has several moves, the last one counts.
fn kinds(text: &str) -> Vec<&'static str> {
    let (mut reader, mut kinds) = (Reader::new(Options::default()), Vec::new());
    let bytes = text.bytes().map(Some).chain([None]);
    let blocks = bytes.filter_map(|byte| match byte {
        Some(byte) => reader.push(byte),
        None => reader.finish(),
    });
    // There are no errors: the job has been planned.
    for block in blocks.flatten() {
        let kind = block.effects().fold("", |before, effect| match effect {
            Effect::Move(part) => match part.kind {
                MoveKind::Rapid => "rapid",
                MoveKind::Feed(_) => "line",
                MoveKind::Arc(..) => "arc",
                MoveKind::Probe(..) => "probe",
            },
            Effect::Dwell(_) => "rest",
            _ => before,
        });
        kinds.resize(block.line as usize, "");
        kinds.push(kind);
    }
    kinds
}

/// A part of an unfinished drawing.
struct Part {
    kind: &'static str,
    /// The first and the last line, and the number of lines between that move or wait.
    lines: [u32; 2],
    count: usize,
    begin: f64,
    end: f64,
    peak: f64,
    ordered: Option<f64>,
    way: Thin,
}

/// An unfinished drawing.
struct Sketch<'a> {
    kinds: &'a [&'static str],
    /// The number of lines in a part.
    each: usize,
    tolerance: Tolerance,
    parts: Vec<Part>,
    /// The points in the parts that have ended.
    points: usize,
    /// The time and the axes' positions so far.
    now: f64,
    place: [f64; 3],
    /// The S of the laser's full power; infinite without a laser, so that its power is 0.
    most: f64,
}

impl<'a> Sketch<'a> {
    fn new(plan: &JobPlan, axes: &[AxisPace; 3], kinds: &'a [&'static str]) -> Sketch<'a> {
        // The span includes the start, 0.
        let spans = plan.survey.extents.0.into_iter().flatten();
        let span = spans.map(|[from, to]| to.max(0.0) - from.min(0.0)).fold(0.0, f64::max);
        let speeds = plan.peaks.iter().zip(axes).map(|(peak, axis)| peak.rate * axis.step);
        let speed = speeds.fold(0.0, f64::max) / 100.0;
        let tolerance = Tolerance { place: span / 4_000.0, speed, power: 0.01 };
        let most = plan.laser.map_or(f64::INFINITY, |laser| laser.most);
        let each = kinds.iter().filter(|kind| !kind.is_empty()).count().div_ceil(PARTS).max(1);
        let (parts, place) = (Vec::new(), [0.0; 3]);
        Sketch { kinds, each, tolerance, parts, points: 0, now: 0.0, place, most }
    }

    /// Adds a stretch of a move of this line, with the laser's power along it.
    fn add(&mut self, line: u32, stretch: &Stretch<3>, along: LaserMove) {
        self.rest(line, stretch.times[0]);
        let kind = self.kinds.get(line as usize).copied().unwrap_or_default();
        self.enter(kind, line);
        let [first, middle, last] = stretch.speeds;
        let most = self.most;
        let power = |speed| (along.s(speed) / most).min(1.0);
        self.put(stretch.times[0], first, stretch.places[0], power(first));
        let all: f64 = stretch.ways.iter().sum();
        let bend = (0..3).map(|n| stretch.directions[1][n] - stretch.directions[0][n]);
        let bend = bend.fold(0.0, f64::hypot);
        let mut gone = 0.0;
        for (n, [from, to]) in
            [[first, middle], [middle; 2], [middle, last]].into_iter().enumerate()
        {
            let (begin, time) = (stretch.times[n], stretch.times[n + 1] - stretch.times[n]);
            // The distance of a parabola in time, and of an arc, from their chords.
            let off = (to - from).abs() * time + bend * stretch.ways[n];
            let samples = (off / (8.0 * self.tolerance.place)).sqrt().clamp(1.0, SAMPLES).ceil();
            for sample in (1..=samples as u32).filter(|_| time > 0.0) {
                let part = f64::from(sample) / samples;
                let speed = from + (to - from) * part;
                let way = gone + (from + speed) / 2.0 * time * part;
                let share = if all > 0.0 { (way / all).min(1.0) } else { 1.0 };
                self.put(begin + time * part, speed, place(stretch, share), power(speed));
            }
            gone += stretch.ways[n];
        }
        (self.now, self.place) = (stretch.end(), stretch.places[1]);
        if let Some(part) = self.parts.last_mut() {
            part.end = stretch.end();
            let paced = self.each == 1 && ["line", "arc", "probe"].contains(&kind);
            part.ordered = paced.then_some(stretch.feed);
        }
    }

    /// Adds a rest until this time, before a move of this line.
    fn rest(&mut self, line: u32, until: f64) {
        if until - self.now < APART {
            return;
        }
        let after = self.parts.last().map_or(0, |part| part.lines[1] as usize + 1);
        let ahead = self.kinds.iter().enumerate().skip(after);
        let mut ahead = ahead.take_while(|(n, _)| *n <= line as usize);
        let dwell = ahead.find(|(_, kind)| **kind == "rest").map_or(after.max(1), |(n, _)| n);
        self.enter("rest", dwell as u32);
        for time in [self.now, until] {
            self.put(time, 0.0, self.place, 0.0);
        }
        self.now = until;
        if let Some(part) = self.parts.last_mut() {
            part.end = until;
        }
    }

    /// Continues the current part with this line, or begins a new part.
    fn enter(&mut self, kind: &'static str, line: u32) {
        if let Some(part) = self.parts.last_mut() {
            let same = part.lines[1] == line && (part.kind == kind || self.each > 1);
            if same || part.count < self.each {
                part.count += usize::from(!same);
                part.lines[1] = line;
                return;
            }
        }
        self.close();
        // The lines of a part may be of several kinds.
        let kind = if self.each > 1 { "lines" } else { kind };
        let way = Thin::new(self.tolerance);
        let (begin, lines) = (self.now, [line; 2]);
        let (count, peak, ordered) = (1, 0.0, None);
        self.parts.push(Part { kind, lines, count, begin, end: begin, peak, ordered, way });
    }

    fn put(&mut self, time: f64, speed: f64, place: [f64; 3], power: f64) {
        if let Some(part) = self.parts.last_mut() {
            part.peak = part.peak.max(speed);
            part.way.put(ThinPoint { time, speed, place, power });
        }
    }

    /// Ends the current part. If there are too many points, thins all parts.
    fn close(&mut self) {
        let Some(part) = self.parts.last_mut() else { return };
        part.way.end();
        self.points += part.way.points.len();
        if self.points <= POINTS {
            return;
        }
        // Thins to half the limit, so that not every further part needs thinning.
        while self.points > POINTS / 2 && self.tolerance.speed < f64::MAX {
            self.tolerance = self.tolerance.wider();
            self.parts.iter_mut().for_each(|part| part.way.again(self.tolerance));
            self.points = self.parts.iter().map(|part| part.way.points.len()).sum();
        }
    }

    fn drawing(mut self, plan: &JobPlan, axes: &[AxisPace; 3]) -> PathDrawing {
        if self.parts.is_empty() {
            // Nothing moves: a rest at the start.
            self.enter("rest", 1);
            self.put(0.0, 0.0, self.place, 0.0);
        }
        self.close();
        let motors = NAMES.iter().zip(axes);
        let mut drawing = PathDrawing {
            kind: "gcode",
            unit: "nm".to_owned(),
            motors: motors
                .map(|(name, axis)| PathMotor { name: (*name).to_owned(), step: axis.step * NM })
                .collect(),
            seconds: plan.time,
            places: vec![Vec::new(); NAMES.len()],
            facts: facts::of(plan),
            refused: plan.refused.map(|refused| refused.words(BOARD)),
            powers: plan.laser.map(|_| Vec::new()),
            ..PathDrawing::default()
        };
        for part in &self.parts {
            let first = drawing.times.len();
            for point in &part.way.points {
                drawing.times.push(micros(point.time));
                drawing.speeds.push((point.speed * NM).round());
                drawing.powers.iter_mut().for_each(|all| all.push(tenth_percent(point.power)));
                for (all, place) in drawing.places.iter_mut().zip(point.place) {
                    all.push((place * NM).round());
                }
            }
            let peak = (part.peak * NM).round();
            drawing.peak = drawing.peak.max(peak);
            drawing.legs.push(PathLeg {
                kind: part.kind,
                line: part.lines[0] as usize,
                to_line: part.lines[1] as usize,
                begin: micros(part.begin),
                end: micros(part.end),
                peak,
                ordered: part.ordered.map(|speed| speed * NM),
                first,
                last: drawing.times.len() - 1,
            });
        }
        drawing
    }
}

/// The axes' positions after this share of a stretch: on the cubic with the stretch's positions and
/// directions at both ends. The cubic of a straight stretch is a straight line.
fn place(stretch: &Stretch<3>, share: f64) -> [f64; 3] {
    let ([from, to], [first, last]) = (stretch.places, stretch.directions);
    let way = stretch.way[1] - stretch.way[0];
    let (s, rest) = (share, 1.0 - share);
    std::array::from_fn(|n| {
        let ends = from[n] * (1.0 + 2.0 * s) * rest * rest + to[n] * (3.0 - 2.0 * s) * s * s;
        ends + way * s * rest * (first[n] * rest - last[n] * s)
    })
}

/// Rounds to a tenth of a percent of full power.
fn tenth_percent(power: f64) -> f64 {
    (power * 1e3).round() / 1e3
}

/// Rounds to a µs.
fn micros(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}
