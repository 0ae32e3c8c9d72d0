//! Jobs for a laser, judged by their text and by the place of each step along the path.

use std::f64::consts::PI;
use std::fmt::Write;

use stepwright_path::{AxisPace, RouteStep};
use stepwright_plan::gcode::{GcodeJob, PowerChange};

/// mm per step.
const STEP: f64 = 0.0125;

/// The limits of the axes.
pub const AXES: [AxisPace; 3] = {
    let x = AxisPace { step: STEP, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
    [x, AxisPace { speed: 150.0, accel: 700.0, ..x }, x]
};

/// S at full power.
const FULL: f64 = 1_000.0;

/// How far a power may be off while it changes.
const WITHIN: f64 = 1.0 / 255.0;

/// The duration of a hold in s, at least.
const HELD: f64 = 0.5;

/// The tool of a move, with F in mm/min.
#[derive(Clone, Copy, Debug)]
pub enum Tool {
    M3 { s: u32, f: u32 },
    M4 { s: u32, f: u32 },
    M5 { f: u32 },
    Rapid,
}

/// A part of a job; places are in steps.
#[derive(Clone, Copy, Debug)]
pub enum Job {
    Line {
        x: i32,
        y: i32,
        tool: Tool,
    },
    /// Half of a circle towards a higher X.
    Half {
        radius: i32,
        clockwise: bool,
        tool: Tool,
    },
    /// A dwell in ms.
    Dwell(u32),
}

/// A step according to the text: its place along the path, and whether it is forward.
type Mark = (f64, bool);

/// A part of the path.
#[derive(Clone, Debug)]
struct Leg {
    from: f64,
    to: f64,
    tool: Tool,
}

/// A job after its run.
#[derive(Clone, Debug)]
pub struct Run {
    pub steps: Vec<RouteStep>,
    pub power: Vec<PowerChange>,
    legs: Vec<Leg>,
    marks: [Vec<Mark>; 2],
    /// The places of the dwells along the path, and their times.
    dwells: Vec<(f64, f64)>,
    /// The times at which holds ended.
    resumed: Vec<f64>,
    end: f64,
}

/// A place in steps as mm, exact.
fn mm(steps: i32) -> String {
    let sign = if steps < 0 { "-" } else { "" };
    let fine = i64::from(steps.abs()) * 125;
    format!("{sign}{}.{:04}", fine / 10_000, fine % 10_000)
}

fn hypot(x: i32, y: i32) -> f64 {
    f64::from(x).hypot(f64::from(y)) * STEP
}

/// Runs the job. Holds it after the steps `holds`, and asks for the power every `stride` steps.
pub fn run(job: &[Job], axes: [AxisPace; 3], holds: &[usize], stride: usize) -> Run {
    let (mut text, mut at, mut way) = (String::new(), [0, 0], 0.0);
    let (mut legs, mut marks, mut dwells) = (Vec::new(), [Vec::new(), Vec::new()], Vec::new());
    for (n, part) in job.iter().enumerate() {
        let (code, tool, to) = match *part {
            Job::Dwell(ms) => {
                dwells.push((way, f64::from(ms) / 1e3));
                _ = writeln!(text, "G4 P{}.{:03}", ms / 1_000, ms % 1_000);
                continue;
            }
            Job::Line { x, y, tool } => {
                let length = hypot(x - at[0], y - at[1]);
                for (axis, to) in [x, y].into_iter().enumerate() {
                    let count = (to - at[axis]).abs();
                    marks[axis].extend((0..count).map(|n| {
                        let share = (f64::from(n) + 0.5) / f64::from(count);
                        (way + length * share, to > at[axis])
                    }));
                }
                legs.push(Leg { from: way, to: way + length, tool });
                way += length;
                (if matches!(tool, Tool::Rapid) { "G0" } else { "G1" }.to_owned(), tool, [x, y])
            }
            Job::Half { radius, clockwise, tool } => {
                let tool = if let Tool::Rapid = tool { Tool::M5 { f: 900 } } else { tool };
                let r = f64::from(radius);
                let half = |n: i32| f64::from(n) + 0.5;
                let along = |angle: f64| way + angle * r * STEP;
                marks[0].extend((0..2 * radius).map(|n| (along((1.0 - half(n) / r).acos()), true)));
                let side = |n: i32| (half(n) / r).asin();
                marks[1].extend((0..radius).map(|n| (along(side(n)), clockwise)));
                let back = (0..radius).rev().map(|n| (along(PI - side(n)), !clockwise));
                marks[1].extend(back);
                let length = PI * r * STEP;
                legs.push(Leg { from: way, to: way + length, tool });
                way += length;
                let code = if clockwise { "G2" } else { "G3" };
                (format!("{code} I{}", mm(radius)), tool, [at[0] + 2 * radius, at[1]])
            }
        };
        let order = match tool {
            Tool::M3 { s, f } => format!("M3 S{s} F{f}"),
            Tool::M4 { s, f } => format!("M4 S{s} F{f}"),
            Tool::M5 { f } => format!("M5 F{f}"),
            Tool::Rapid => String::new(),
        };
        let between = if n % 2 == 0 { " " } else { "\n" };
        _ = writeln!(text, "{order}{between}{code} X{} Y{}", mm(to[0]), mm(to[1]));
        at = to;
    }
    let mut job = GcodeJob::new(text.into_bytes(), axes).unwrap().with_laser(FULL);
    let (mut steps, mut power, mut resumed) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        while let Some(step) = job.step().unwrap() {
            steps.push(step);
            if steps.len() % stride == 0 {
                power.extend(std::iter::from_fn(|| job.power(step.time)));
            }
            if holds.contains(&steps.len()) {
                job.hold_at(step.time);
            }
        }
        if !job.is_held() {
            break;
        }
        let at = job.time() + HELD;
        resumed.push(at);
        job.resume_at(at);
    }
    let end = job.time();
    power.extend(std::iter::from_fn(|| job.power(end + 1.0)));
    Run { steps, power, legs, marks, dwells, resumed, end }
}

impl Run {
    /// The powers between two times, each with its duration.
    fn powers(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
        let first = self.power.partition_point(|change| change.time <= from);
        let before = first.checked_sub(1).map_or(0.0, |n| self.power[n].power);
        let inner = self.power[first..].iter().take_while(move |change| change.time < to);
        let starts =
            std::iter::once((from, before)).chain(inner.map(|change| (change.time, change.power)));
        let ends = self.power[first..].iter().map(move |change| change.time.min(to)).chain([to]);
        starts.zip(ends).map(|((from, power), to)| (power, to - from))
    }

    /// The time without power between two times.
    fn dark(&self, from: f64, to: f64) -> f64 {
        self.powers(from, to).filter(|(power, _)| *power == 0.0).map(|(_, time)| time).sum()
    }

    /// Panics unless the laser burns what the text orders.
    pub fn judge(&self) {
        assert!(self.power.windows(2).all(|pair| pair[0].time <= pair[1].time));
        assert!(self.power.iter().all(|change| (0.0..=1.0).contains(&change.power)));
        let mut all: Vec<(f64, f64)> = Vec::new();
        for (axis, marks) in self.marks.iter().enumerate() {
            let steps: Vec<_> = self.steps.iter().filter(|step| step.axis == axis).collect();
            let ways = |forward: &mut dyn Iterator<Item = bool>| forward.collect::<Vec<_>>();
            let expected = ways(&mut marks.iter().map(|mark| mark.1));
            assert_eq!(ways(&mut steps.iter().map(|step| step.forward)), expected);
            let known: Vec<(f64, f64)> =
                marks.iter().zip(steps).map(|(mark, step)| (mark.0, step.time)).collect();
            for pair in known.windows(2) {
                self.judge_between(pair[0], pair[1]);
            }
            all.extend(known);
        }
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        let last = all.last().map_or(0.0, |mark| mark.1);
        // The job ends without power: not before its last step and not after its end.
        let dark = self.power.last().map_or(0.0, |change| change.power);
        let off = self.power.last().map_or(last, |change| change.time);
        assert!(dark == 0.0 && off <= self.end + 1e-9, "{dark} {off} {}", self.end);
        let before = |time: f64| all[..all.partition_point(|mark| mark.1 < time)].last();
        for &at in &self.resumed {
            let last = before(at).map_or(0.0, |mark| mark.1);
            let dark = self.dark(last, at);
            assert!(dark >= HELD - 1e-9 && self.dark(at - HELD + 1e-9, at) > HELD - 1e-8);
        }
        // Several dwells at one place count as one.
        for &(place, _) in &self.dwells {
            let time: f64 = self.dwells.iter().filter(|other| other.0 == place).map(|d| d.1).sum();
            let next = all.iter().find(|mark| mark.0 > place).map_or(self.end, |mark| mark.1);
            let last = all.iter().rfind(|mark| mark.0 < place).map_or(0.0, |mark| mark.1);
            assert!(self.dark(last, next) >= time - 1e-9, "a dwell of {time} s");
        }
    }

    /// Judges the power between two steps of an axis.
    fn judge_between(&self, (from, begin): (f64, f64), (to, end): (f64, f64)) {
        let legs = || self.legs.iter().filter(|leg| leg.from < to && leg.to > from);
        let constant = |leg: &Leg| matches!(leg.tool, Tool::M3 { .. });
        let burnt: f64 = self.powers(begin, end).map(|(power, time)| power * time).sum();
        let by_way: f64 =
            legs().map(|leg| leg.burns() * (leg.to.min(to) - leg.from.max(from))).sum();
        let dark = self.dark(begin, end);
        let slack = (end - begin - dark) * WITHIN + 1e-9;
        if !legs().any(constant) {
            assert!((burnt - by_way).abs() <= slack, "{burnt}, not {by_way}, at {begin}: {end}");
            // The power is 0 all the time.
            let burns = legs().any(|leg| leg.burns() > 0.0);
            assert!(burns || self.powers(begin, end).all(|(power, _)| power == 0.0), "at {begin}");
            return;
        }
        let most = legs().map(Leg::constant).fold(0.0, f64::max);
        assert!(burnt <= by_way + most * (end - begin - dark) + slack, "too much at {begin}");
        if legs().all(constant) && legs().count() == 1 {
            let rests = self.resumed.iter().any(|at| (begin..end).contains(at));
            let good = |power: f64| power == most || (power == 0.0 && rests);
            assert!(self.powers(begin, end).all(|(power, _)| good(power)), "{most} at {begin}");
        }
    }
}

impl Leg {
    /// The full-power time that M4 burns per mm, in s.
    fn burns(&self) -> f64 {
        match self.tool {
            Tool::M4 { s, f } => f64::from(s) / FULL * 60.0 / f64::from(f),
            _ => 0.0,
        }
    }

    /// The power of M3.
    fn constant(&self) -> f64 {
        match self.tool {
            Tool::M3 { s, .. } => (f64::from(s) / FULL).min(1.0),
            _ => 0.0,
        }
    }
}
