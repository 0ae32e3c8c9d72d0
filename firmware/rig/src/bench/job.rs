//! A travel of one, two or three axes on a fresh chip.

use std::result;

use anyhow::{Context, Result, ensure};
use stepwright::profile::{Path, Ramp};
use stepwright::{Accel, Order, Rate, Speed, Ticks, Travel, late_after};

use super::Subject;
use crate::board::HZ;
use crate::chip::Chip;
use crate::edges::{Step, steps_of};
use crate::probes::IsrSpan;

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

    /// A travel at one speed.
    pub(super) fn constant(speed: u32, steps: u32) -> Axis {
        Axis { start: speed, top: speed, accel: 40_000, steps }
    }

    /// The ideal times of its pulses.
    pub(super) fn ideal(&self) -> Result<Path> {
        let accel = Ramp::Accel(Accel::from_steps(self.accel)?);
        let order = Order {
            start: Speed::from_steps(self.start)?,
            top: Speed::from_steps(self.top)?,
            up: accel,
            down: accel,
            jerk: None,
            travel: Travel::By(i32::try_from(self.steps)?),
        };
        Ok(order.path(CLOCK)?)
    }
}

/// A travel, and how it is observed.
#[derive(Clone, Debug)]
pub(super) struct Job {
    axes: Vec<Axis>,
    traffic: Traffic,
    visits: bool,
    /// The run ends at the first late step.
    on_time: bool,
}

/// The lines that the host sends while the axes move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Traffic {
    /// None.
    Silent,
    /// These queries without a pause, from this many cycles after the first step on: the *phase* of
    /// the traffic relative to the motion.
    Asks(&'static [&'static str], u64),
}

impl Traffic {
    /// Position and state, from the first step on.
    pub(super) const NOW: Traffic = Traffic::Asks(&["V1", "F"], 0);

    /// The same in another phase. Phases are a fifth of the two queries and their answers apart, 13
    /// bytes of 1,360 cycles, and not a whole number of bytes.
    pub(super) fn in_phase(self, phase: usize) -> Traffic {
        match self {
            Traffic::Silent => Traffic::Silent,
            Traffic::Asks(questions, from) => Traffic::Asks(questions, from + 3_571 * phase as u64),
        }
    }
}

/// The result of a travel.
pub(super) struct Outcome {
    pub chip: Chip,
    /// The steps of each axis.
    pub steps: Vec<Vec<Step>>,
    /// The late steps that the board counts.
    pub late: u32,
}

/// The chip's clock.
pub(super) const CLOCK: Rate = match Rate::from_hz(HZ as u32) {
    Ok(clock) => clock,
    Err(_) => panic!("no such clock"),
};

/// Boot, with all its delays.
const BOOT: u64 = HZ / 10;

impl Job {
    pub(super) fn new(axes: &[Axis], traffic: Traffic) -> Job {
        Job { axes: axes.to_vec(), traffic, visits: false, on_time: false }
    }

    pub(super) fn keeping_visits(self) -> Job {
        Job { visits: true, ..self }
    }

    /// Ends at the first step that is late ([`late_after`]).
    pub(super) fn on_time(self) -> Job {
        Job { on_time: true, ..self }
    }

    /// Plays it on a chip that `watch` has prepared. The inner error: nothing moves, an axis falls
    /// behind by 10 ms or more, or a step is late that must be on time.
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
            // Even the bench build refuses an interval shorter than a pulse and its pause.
            let answer = String::from_utf8_lossy(&answer);
            return Ok(Err(format!("nothing moves: E was answered {answer:?}")));
        }
        let mut progress = Progress::new(self, chip.now())?;
        if let Traffic::Asks(questions, phase) = self.traffic {
            let first = chip.edges().first().map_or(chip.now(), |edge| edge.time);
            chip.run_until(first + phase);
            chip.poll(questions);
        }
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

    /// The first axis in the first 100 ms, however late: its steps, and the stays in the step
    /// interrupt.
    pub(super) fn begin(&self, subject: &Subject) -> Result<(Vec<Step>, Vec<IsrSpan>)> {
        let mut chip = self.told(subject)?;
        chip.keep_visits();
        chip.send(b"E\r");
        chip.run_for(HZ / 200);
        if let Traffic::Asks(questions, _) = self.traffic {
            chip.poll(questions);
        }
        chip.run_for(HZ / 10);
        Ok((steps_of(chip.edges(), 0), chip.take_visits()))
    }

    /// A chip that has been told the travel, except the `E`.
    pub(super) fn told(&self, subject: &Subject) -> Result<Chip> {
        let mut chip = Chip::new(subject.board, &subject.queued.bench);
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

/// The progress of the axes.
struct Progress {
    axes: Vec<Course>,
    /// The number of edges examined.
    seen: usize,
    on_time: bool,
}

/// An axis in motion.
struct Course {
    path: Path,
    /// The number of steps of the travel.
    steps: u32,
    /// The cycle of the first step, or of the beginning, and the steps so far.
    first: u64,
    made: u32,
    /// The time of the next step, relative to the first, and its distance from the previous step;
    /// after the last step, those of the last.
    due: u64,
    interval: u64,
    /// The least lateness of a step relative to the first: its latency counts as none.
    least: i64,
    /// The first late step.
    late: Option<String>,
}

impl Progress {
    fn new(job: &Job, now: u64) -> Result<Progress> {
        let course = |axis: &Axis| -> Result<Course> {
            let (path, steps) = (axis.ideal()?, axis.steps);
            let (first, made, due, interval, least) = (now, 0, 0, 0, 0);
            Ok(Course { path, steps, first, made, due, interval, least, late: None })
        };
        let axes: Result<Vec<_>> = job.axes.iter().map(course).collect();
        Ok(Progress { axes: axes?, seen: 0, on_time: job.on_time })
    }

    fn is_complete(&self) -> bool {
        self.axes.iter().all(|axis| axis.made >= axis.steps)
    }

    /// The axis that is 10 ms behind its path: it has stalled, or can't follow. Or the step that is
    /// late, if none may be.
    fn fault(&mut self, chip: &Chip) -> Option<String> {
        for edge in chip.edges()[self.seen..].iter().filter(|edge| edge.is_step()) {
            if let Some(axis) = self.axes.get_mut(usize::from(edge.axis)) {
                axis.step(edge.time);
            }
        }
        self.seen = chip.edges().len();
        for (axis, number) in self.axes.iter().zip(1..) {
            if let Some(late) = axis.late.as_ref().filter(|_| self.on_time) {
                return Some(format!("{late} of axis {number}"));
            }
            let due = axis.first + axis.due + HZ / 100;
            if axis.made < axis.steps && chip.now() > due {
                return Some(format!("axis {number} is 10 ms behind after {} steps", axis.made));
            }
        }
        None
    }
}

impl Course {
    /// Its next step came at `time`.
    fn step(&mut self, time: u64) {
        let (n, due) = (self.made, self.due);
        self.made += 1;
        if n == 0 {
            self.first = time;
        }
        let off = (time - self.first) as i64 - due as i64;
        self.least = self.least.min(off);
        if self.made < self.steps {
            self.due = self.path.time_of(self.made);
            self.interval = self.due - due;
        }
        let interval = Ticks::try_from(self.interval).unwrap_or(Ticks::MAX);
        let late = off - self.least;
        if late > i64::from(late_after(interval, CLOCK)) && self.late.is_none() {
            self.late = Some(format!("step {n} is {late} of {interval} cycles late"));
        }
    }
}

/// The distance of each step from its time, in cycles, up to a constant: the board's time from the
/// order to the first step.
pub(super) fn offsets(steps: &[Step], path: &Path) -> Vec<i64> {
    let Some(first) = steps.first() else { return Vec::new() };
    let off =
        |(n, step): (usize, &Step)| (step.time - first.time) as i64 - path.time_of(n as u32) as i64;
    steps.iter().enumerate().map(off).collect()
}

/// The median.
pub(super) fn median<T: Copy + Ord>(values: &mut [T]) -> Option<T> {
    values.sort_unstable();
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a step that comes this many cycles late counts as late, at 16,000 cycles a step.
    fn is_late(by: u64) -> bool {
        let job = Job::new(&[Axis::constant(1_000, 10)], Traffic::Silent);
        let mut progress = Progress::new(&job, 0).unwrap();
        let axis = &mut progress.axes[0];
        // The first step has a latency of its own, which the second lacks.
        for time in [100, 16_050, 32_050 + by] {
            axis.step(time);
        }
        axis.late.is_some()
    }

    #[test]
    fn a_step_is_late_by_half_an_interval_and_a_microsecond() {
        assert!(!is_late(0) && !is_late(8_016) && is_late(8_017));
    }
}
