//! A travel of one, two or three axes on a fresh chip.

use std::result;

use anyhow::{Context, Result, ensure};
use stepwright::profile::{Path, Ramp};
use stepwright::queue::{Feed, Taken};
use stepwright::{Accel, Order, Rate, Speed, Travel, direct};

use super::{Subject, Way};
use crate::board::HZ;
use crate::chip::Chip;
use crate::edges::{Step, steps_of};
use crate::taps::Visit;

/// One axis's part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub start: u32,
    pub top: u32,
    pub accel: u32,
    pub steps: u32,
}

impl Axis {
    /// From rest to rest.
    pub(super) fn ramps(top: u32, accel: u32, steps: u32) -> Axis {
        Axis { start: 0, top, accel, steps }
    }

    /// All at one speed.
    pub(super) fn constant(speed: u32, steps: u32) -> Axis {
        Axis { start: speed, top: speed, accel: 40_000, steps }
    }

    /// When its pulses should come.
    pub(super) fn ideal(&self, way: Way) -> Result<Ideal> {
        let order = self.order()?;
        let rate = Rate::from_hz(HZ as u32)?;
        Ok(match way {
            Way::Queued => Ideal::Path(order.path(rate)?),
            Way::Direct => Ideal::Times(times(direct::Ramp::of(rate, &order)?)),
        })
    }

    fn order(&self) -> Result<Order> {
        let accel = Ramp::Accel(Accel::from_steps(self.accel)?);
        Ok(Order {
            start: Speed::from_steps(self.start)?,
            top: Speed::from_steps(self.top)?,
            up: accel,
            down: accel,
            jerk: None,
            travel: Travel::By(i32::try_from(self.steps)?),
        })
    }
}

/// When pulses should come, in cycles after the first.
pub(super) enum Ideal {
    /// In closed form.
    Path(Path),
    /// One by one.
    Times(Vec<u64>),
}

impl Ideal {
    /// Of pulse `n`, from 0.
    pub(super) fn time_of(&self, n: u32) -> u64 {
        match self {
            Ideal::Path(path) => path.time_of(n),
            Ideal::Times(times) => {
                let last = times.last().copied().unwrap_or(0);
                times.get(n as usize).copied().unwrap_or(last)
            }
        }
    }
}

/// The pulses of the law that the interrupt computes.
fn times(ramp: direct::Ramp) -> Vec<u64> {
    let mut feed = direct::Direct::IDLE;
    feed.begin(true, 0, 1, ramp);
    let mut time = 0;
    let mut times = Vec::new();
    while let Taken::Run(run) = feed.take() {
        if run.count() == 1 {
            time += run.interval();
            times.push(time >> 16);
        }
    }
    let first = times.first().copied().unwrap_or(0);
    times.iter().map(|time| time - first).collect()
}

/// What a travel is and how it is watched.
#[derive(Clone, Debug)]
pub(super) struct Job {
    pub way: Way,
    pub axes: Vec<Axis>,
    /// The host asks for position and state without a pause.
    pub traffic: bool,
    pub visits: bool,
}

/// What came of it.
pub(super) struct Outcome {
    pub chip: Chip,
    /// Steps of each axis.
    pub steps: Vec<Vec<Step>>,
    /// Late steps, as the board counts them.
    pub late: u32,
}

/// Boot, with all its delays.
const BOOT: u64 = HZ / 10;

impl Job {
    pub(super) fn new(axes: &[Axis], traffic: bool) -> Job {
        Job { way: Way::Queued, axes: axes.to_vec(), traffic, visits: false }
    }

    pub(super) fn by(self, way: Way) -> Job {
        Job { way, ..self }
    }

    pub(super) fn keeping_visits(self) -> Job {
        Job { visits: true, ..self }
    }

    /// Plays it on a chip that `watch` has prepared; the inner
    /// error if nothing moves, or an axis falls behind by 10 ms and more.
    pub(super) fn run(
        &self,
        subject: &Subject,
        watch: impl FnOnce(&mut Chip),
    ) -> Result<result::Result<Outcome, String>> {
        let mut chip = self.told(subject)?;
        // Not `ask`: the motion begins before its answer.
        chip.send(b"E\r");
        chip.run_for(4 * 1360);
        watch(&mut chip);
        if !chip.run_to(HZ / 10, |chip| chip.has_taken_all() && !chip.edges().is_empty()) {
            let answer = chip.take_said();
            // Not even the bench build lets a pulse and its pause be cut short.
            let answer = String::from_utf8_lossy(&answer);
            return Ok(Err(format!("nothing moves: E was answered {answer:?}")));
        }
        if self.traffic {
            chip.poll(&["V1", "F"]);
        }
        let mut progress = Progress::new(self.way, &self.axes, chip.now())?;
        while !progress.is_complete() {
            chip.run_for(HZ / 200);
            if let Some(fault) = progress.fault(&chip) {
                return Ok(Err(fault));
            }
        }
        chip.poll(&[]);
        chip.run_for(HZ / 50);
        let Some(health) = chip.ask("?") else {
            return Ok(Err("the board has fallen silent".into()));
        };
        let late = health.split("late=").nth(1).and_then(|rest| rest.split(' ').next());
        let late = late.and_then(|late| late.parse().ok()).context("no late= in its answer")?;
        let steps = (0..self.axes.len()).map(|n| steps_of(chip.edges(), n as u8)).collect();
        Ok(Ok(Outcome { chip, steps, late }))
    }

    /// What the first axis does in the first 100 ms, however late: its steps,
    /// and the stays in the step interrupt.
    pub(super) fn begin(&self, subject: &Subject) -> Result<(Vec<Step>, Vec<Visit>)> {
        let mut chip = self.told(subject)?;
        chip.keep_visits();
        chip.send(b"E\r");
        chip.run_for(HZ / 10);
        Ok((steps_of(chip.edges(), 0), chip.take_visits()))
    }

    /// A chip that knows the travel, and lacks only the `E`.
    pub(super) fn told(&self, subject: &Subject) -> Result<Chip> {
        let mut chip = Chip::new(subject.board, &subject.builds(self.way).bench);
        chip.run_for(BOOT);
        chip.ask("");
        let mut say = |line: &str| -> Result<()> {
            let answer = chip.ask(line);
            ensure!(answer.as_deref() == Some("Y"), "{line:?} was answered {answer:?}");
            Ok(())
        };
        say("PO")?;
        for (n, axis) in self.axes.iter().enumerate() {
            let Axis { start, top, accel, steps } = axis;
            say(&format!("A{}", n + 1))?;
            for line in [format!("s{start}"), format!("t{top}"), format!("a{accel}")] {
                say(&line)?;
            }
            say(&format!("d{accel}"))?;
            say(&format!("G+{steps}"))?;
        }
        if self.visits {
            chip.keep_visits();
        }
        chip.take_edges();
        Ok(chip)
    }
}

/// How far the axes have come.
struct Progress {
    axes: Vec<(Ideal, u32)>,
    /// The first step's cycle, or the beginning, and the steps so far.
    made: Vec<(u64, u32)>,
    /// Edges that have been looked at.
    seen: usize,
}

impl Progress {
    fn new(way: Way, axes: &[Axis], now: u64) -> Result<Progress> {
        let paths: Result<Vec<_>> =
            axes.iter().map(|axis| Ok((axis.ideal(way)?, axis.steps))).collect();
        Ok(Progress { axes: paths?, made: vec![(now, 0); axes.len()], seen: 0 })
    }

    fn is_complete(&self) -> bool {
        self.axes.iter().zip(&self.made).all(|(axis, made)| made.1 >= axis.1)
    }

    /// Which axis is 10 ms behind its path: it has stalled, or can't follow.
    fn fault(&mut self, chip: &Chip) -> Option<String> {
        for edge in chip.edges()[self.seen..].iter().filter(|edge| edge.is_step()) {
            if let Some((first, count)) = self.made.get_mut(usize::from(edge.axis)) {
                if *count == 0 {
                    *first = edge.time;
                }
                *count += 1;
            }
        }
        self.seen = chip.edges().len();
        let behind = |((path, steps), (first, count)): (&(Ideal, u32), &(u64, u32))| {
            count < steps && chip.now() > first + path.time_of(*count) + HZ / 100
        };
        let axis = self.axes.iter().zip(&self.made).position(behind)?;
        Some(format!("axis {} is 10 ms behind after {} steps", axis + 1, self.made[axis].1))
    }
}

/// How far each step lies from its time, in cycles, up to a constant: the
/// board's way from the order to the first step.
pub(super) fn offsets(steps: &[Step], path: &Ideal) -> Vec<i64> {
    let Some(first) = steps.first() else { return Vec::new() };
    let off =
        |(n, step): (usize, &Step)| (step.time - first.time) as i64 - path.time_of(n as u32) as i64;
    steps.iter().enumerate().map(off).collect()
}

/// The middle one.
pub(super) fn median<T: Copy + Ord>(values: &mut [T]) -> Option<T> {
    values.sort_unstable();
    values.get(values.len() / 2).copied()
}
