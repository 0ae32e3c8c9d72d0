//! A travel of one, two or three axes on a fresh chip.

use anyhow::{Context, Result, ensure};
use stepwright::profile::{Path, Ramp};
use stepwright::{Accel, Order, Rate, Speed, Travel};

use super::Subject;
use crate::board::HZ;
use crate::chip::Chip;
use crate::edges::{Step, steps_of};

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

    /// Its motion in closed form.
    pub(super) fn path(&self) -> Result<Path> {
        let accel = Ramp::Accel(Accel::from_steps(self.accel)?);
        let order = Order {
            start: Speed::from_steps(self.start)?,
            top: Speed::from_steps(self.top)?,
            up: accel,
            down: accel,
            travel: Travel::By(i32::try_from(self.steps)?),
        };
        Ok(order.path(Rate::from_hz(HZ as u32)?)?)
    }
}

/// What a travel is and how it is watched.
#[derive(Clone, Debug)]
pub(super) struct Job {
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
        Job { axes: axes.to_vec(), traffic, visits: false }
    }

    pub(super) fn keeping_visits(self) -> Job {
        Job { visits: true, ..self }
    }

    /// Plays it on a chip that `watch` has prepared; `None` if it takes longer
    /// than it should by half a second and more.
    pub(super) fn run(
        &self,
        subject: &Subject,
        watch: impl FnOnce(&mut Chip),
    ) -> Result<Option<Outcome>> {
        let mut chip = Chip::new(subject.board, &subject.bench);
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
        // Not `ask`: the motion begins before its answer.
        chip.send(b"E\r");
        chip.run_for(4 * 1360);
        watch(&mut chip);
        ensure!(
            chip.run_to(HZ / 10, |chip| chip.has_taken_all() && !chip.edges().is_empty()),
            "nothing moves"
        );
        if self.traffic {
            chip.poll(&["V1", "F"]);
        }
        let (mut end, mut expected) = (0, 0);
        for axis in &self.axes {
            end = end.max(axis.path()?.time_of(axis.steps));
            expected += 2 * axis.steps as usize;
        }
        let end = chip.now() + end + HZ / 2;
        // Two edges a step, and those of DIR.
        while chip.edges().len() < expected + self.axes.len() && chip.now() < end {
            chip.run_for(HZ / 200);
            if chip.edges().len() >= expected && self.is_complete(&chip) {
                break;
            }
        }
        if !self.is_complete(&chip) {
            return Ok(None);
        }
        chip.poll(&[]);
        chip.run_for(HZ / 50);
        let health = chip.ask("?").context("the board has fallen silent")?;
        let late = health.split("late=").nth(1).and_then(|rest| rest.split(' ').next());
        let late = late.and_then(|late| late.parse().ok()).context("no late= in its answer")?;
        let steps = (0..self.axes.len()).map(|n| steps_of(chip.edges(), n as u8)).collect();
        Ok(Some(Outcome { chip, steps, late }))
    }

    fn is_complete(&self, chip: &Chip) -> bool {
        let mut rises = vec![0u32; self.axes.len()];
        for edge in chip.edges().iter().filter(|edge| edge.is_step()) {
            if let Some(count) = rises.get_mut(usize::from(edge.axis)) {
                *count += 1;
            }
        }
        rises.iter().zip(&self.axes).all(|(&count, axis)| count >= axis.steps)
    }
}

/// How far each step lies from its time, in cycles, up to a constant: the
/// board's way from the order to the first step.
pub(super) fn offsets(steps: &[Step], path: &Path) -> Vec<i64> {
    let Some(first) = steps.first() else { return Vec::new() };
    let off = |(n, step): (usize, &Step)| {
        (step.time - first.time) as i64 - path.time_of(n as u32) as i64
    };
    steps.iter().enumerate().map(off).collect()
}

/// The middle one.
pub(super) fn median<T: Copy + Ord>(values: &mut [T]) -> Option<T> {
    values.sort_unstable();
    values.get(values.len() / 2).copied()
}
