//! One walk over all pulses, for the summary and the plot.

use stepwright::Run;
use stepwright::profile::Phase;
use stepwright_oracle::{Double, Number};

use crate::law::{Plan, PlannedLaw};
use crate::watch::{Walk, Watch};

/// Up to this many pulses, every pulse is measured against its ideal. Of a longer travel, the first and the
/// last million pulses are measured, and between them only the end of every run. That takes seconds instead of
/// minutes.
const ALL: u32 = 4_000_000;
const EDGE: u32 = 1_000_000;

/// The pulse that is furthest from its ideal.
#[derive(Clone, Copy, Debug)]
pub struct Worst {
    /// The distance in ticks.
    pub ticks: f64,
    /// The number of the pulse, counted from 1.
    pub step: u32,
    /// The number of pulses measured.
    pub checked: u32,
}

impl Worst {
    /// Measures pulse `n`, counted from 0.
    fn measure(&mut self, n: u32, time: u64, ideal: Double) {
        let off = (Double::whole(time) - ideal).to_f64().abs();
        self.checked += 1;
        if off > self.ticks || self.step == 0 {
            (self.ticks, self.step) = (off, n + 1);
        }
    }
}

/// Plays runs as the engine does and measures the pulses.
pub(crate) struct Player<'a> {
    law: &'a dyn PlannedLaw,
    /// The last pulse, its time, and the carried part of a tick.
    n: u32,
    time: u64,
    part: u64,
    pub worst: Worst,
}

impl<'a> Player<'a> {
    /// A player after the first pulse.
    pub fn new(law: &'a dyn PlannedLaw) -> Player<'a> {
        let worst = Worst { ticks: 0.0, step: 0, checked: 0 };
        let mut player = Player { law, n: 0, time: 0, part: 0, worst };
        if law.pulses() > 0 {
            player.worst.measure(0, 0, law.ideal(0));
        }
        player
    }

    /// Plays a run. Calls `seen` for each pulse, unless the next wanted pulse `next` lies after the run.
    fn play(&mut self, run: Run, next: u32, mut seen: impl FnMut(u32, u64)) {
        let end = self.n.saturating_add(run.count().into());
        let inner = self.n >= EDGE && end < self.law.pulses().saturating_sub(EDGE);
        if self.law.pulses() > ALL && inner && end < next {
            self.n = end;
            self.pass(run.duration());
        } else {
            let mut interval = run.interval();
            for _ in 0..run.count() {
                self.n += 1;
                self.pass(interval);
                interval = interval.wrapping_add_signed(run.add().into());
                seen(self.n, self.time);
                if self.n != end {
                    self.worst.measure(self.n, self.time, self.law.ideal(self.n));
                }
            }
        }
        self.worst.measure(self.n, self.time, self.law.ideal(self.n));
    }

    /// Plays a run without reporting single pulses.
    pub fn run(&mut self, run: Run) {
        self.play(run, u32::MAX, |_, _| {});
    }

    /// Advances the time by this many 2⁻¹⁶ ticks.
    fn pass(&mut self, fine: u64) {
        let due = self.part + fine;
        self.time += due >> 16;
        self.part = due & 0xFFFF;
    }
}

/// A phase as emitted.
#[derive(Clone, Copy, Debug)]
pub struct PhasePart {
    /// The phase.
    pub phase: Phase,
    /// Its pulses.
    pub pulses: u32,
    /// Its duration in ticks.
    pub ticks: u64,
}

/// A pulse for the plot.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The number of steps after the first pulse.
    pub n: u32,
    /// The time at which it is emitted, in ticks.
    pub time: u64,
    /// Its ideal time in ticks.
    pub ideal: Double,
}

/// The result of a walk over a plan.
pub struct Survey {
    /// Ticks from the first pulse to the last.
    pub duration: u64,
    /// Largest error of the emitted delays.
    pub worst: Worst,
    /// The phases.
    pub parts: Vec<PhasePart>,
    /// Pulses for the plot: all pulses of a short travel. Those of a long travel are close together near
    /// the ends of phases, and further apart between.
    pub samples: Vec<Sample>,
}

impl Survey {
    /// Walks over all pulses. This takes seconds for a long travel.
    pub fn of(plan: &Plan, watch: Watch<'_>) -> Survey {
        let law = plan.law.as_ref();
        let mut player = Player::new(law);
        let mut marks = Marks::new(law);
        let mut samples = Vec::new();
        let mut sample = |marks: &mut Marks, n, time| {
            if marks.next == n {
                samples.push(Sample { n, time, ideal: law.ideal(n) });
                marks.advance();
            }
        };
        if law.pulses() > 0 {
            sample(&mut marks, 0, 0);
        }
        let mut work = Walk::new("planned", law.pulses(), watch);
        for run in law.stretches() {
            player.play(run, marks.next, |n, time| sample(&mut marks, n, time));
            work.at(player.n);
        }
        let parts = parts(law, &samples);
        Survey { duration: player.time, worst: player.worst, parts, samples }
    }
}

/// The times of the phases. Their ends are among the samples.
fn parts(law: &dyn PlannedLaw, samples: &[Sample]) -> Vec<PhasePart> {
    let (mut pulses, mut ticks) = (0u32, 0u64);
    let mut parts = Vec::new();
    for span in law.spans() {
        pulses += span.pulses;
        let at = samples.partition_point(|sample| sample.n < pulses - 1);
        let end = samples.get(at).map_or(ticks, |sample| sample.time);
        parts.push(PhasePart { phase: span.phase, pulses: span.pulses, ticks: end - ticks });
        ticks = end;
    }
    parts
}

/// The next pulse for the plot.
struct Marks {
    /// The corners: the pulses at which a phase ends, in order.
    corners: Vec<u32>,
    next: u32,
}

impl Marks {
    fn new(law: &dyn PlannedLaw) -> Marks {
        let ends = law.spans().into_iter().scan(0u32, |end, span| {
            *end += span.pulses;
            Some(*end - 1)
        });
        let corners = std::iter::once(0).chain(ends).collect();
        Marks { corners, next: 0 }
    }

    /// Advances by a fortieth of the distance to the nearest corner.
    fn advance(&mut self) {
        let here = self.next;
        let behind = self.corners.partition_point(|&corner| corner <= here);
        let since = here - self.corners[behind.saturating_sub(1)];
        let left = self.corners.get(behind).map_or(0, |corner| corner - here);
        // The stride grows from the corner before, and shrinks towards the corner ahead.
        let stride = (since.min(left) / 40).clamp(1, left.max(1));
        self.next = here.saturating_add(stride);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::constant::ConstantLaw;
    use crate::watch::UNWATCHED;
    use stepwright::profile::RampSteps;
    use stepwright::{Rate, Speed};

    fn plan(steps: u32, ramp: u16) -> Plan {
        let (start, top) = (Speed::from_steps(50).unwrap(), Speed::from_steps(9_000).unwrap());
        let law = RampSteps::new(Rate::MHZ, start, top, ramp).unwrap();
        let (path, delays) = (law.path(steps).unwrap(), law.delays(steps).unwrap());
        let law = Box::new(ConstantLaw::new(path, delays, Rate::MHZ, start, top));
        Plan {
            name: "ramp",
            rate: Rate::MHZ,
            steps_per_turn: 200,
            values: Vec::new(),
            note: None,
            law,
        }
    }

    /// A walk run by run, which partly skips single pulses, gives the same results as the single delays.
    #[test]
    fn a_walk_over_runs_meets_the_delays() {
        for (steps, ramp) in [(0, 1), (1, 1), (2, 1), (7, 3), (900, 200), (5_000_000, 60_000)] {
            let plan = plan(steps, ramp);
            let survey = Survey::of(&plan, UNWATCHED);
            let mut samples = survey.samples.iter().peekable();
            let (mut parts, mut worst) = (Vec::<PhasePart>::new(), 0.0f64);
            let mut end = 0;
            for row in plan.rows() {
                end = row.time;
                let (n, ideal) = (row.step - 1, plan.law.ideal(row.step - 1));
                worst = worst.max((Double::whole(row.time) - ideal).to_f64().abs());
                if let Some(sample) = samples.next_if(|sample| sample.n == n) {
                    assert_eq!(sample.time, row.time);
                }
                match parts.last_mut() {
                    Some(part) if part.phase == row.phase => {
                        part.pulses += 1;
                        part.ticks += u64::from(row.delay);
                    }
                    _ => parts.push(PhasePart {
                        phase: row.phase,
                        pulses: 1,
                        ticks: row.delay.into(),
                    }),
                }
            }
            assert!(samples.next().is_none());
            assert_eq!(survey.duration, end);
            let flat = |parts: &[PhasePart]| -> Vec<_> {
                parts.iter().map(|part| (part.phase, part.pulses, part.ticks)).collect()
            };
            assert_eq!(flat(&survey.parts), flat(&parts));
            // The pulses that are not measured hide no larger error.
            assert!(worst <= 1.0 && (worst - survey.worst.ticks).abs() < 0.05, "{worst}");
            assert!(survey.worst.checked == steps || steps > ALL);
            assert!(survey.samples.len() < 3_000);
        }
    }
}
