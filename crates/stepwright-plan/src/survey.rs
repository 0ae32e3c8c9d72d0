//! One walk over all pulses: what the summary says and what the plot shows.

use stepwright::Run;
use stepwright::profile::Phase;
use stepwright_oracle::{Double, Number};

use crate::law::{Plan, PlannedLaw};
use crate::watch::{Walk, Watch};

/// Up to this many pulses, every one is measured against its ideal. Of a longer
/// travel the first and the last million are, and between them every run at
/// its end: seconds instead of minutes.
const ALL: u32 = 4_000_000;
const EDGE: u32 = 1_000_000;

/// The pulse that is furthest from its ideal.
#[derive(Clone, Copy, Debug)]
pub struct Worst {
    /// How far, in ticks.
    pub ticks: f64,
    /// Which, counted from 1.
    pub step: u32,
    /// How many pulses were measured.
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

/// Plays runs as the engine does, and measures the pulses.
pub(crate) struct Player<'a> {
    law: &'a dyn PlannedLaw,
    /// The last pulse, when it came, and the part of a tick that is carried.
    n: u32,
    time: u64,
    part: u64,
    pub worst: Worst,
}

impl<'a> Player<'a> {
    /// Has made the first pulse.
    pub fn new(law: &'a dyn PlannedLaw) -> Player<'a> {
        let worst = Worst { ticks: 0.0, step: 0, checked: 0 };
        let mut player = Player { law, n: 0, time: 0, part: 0, worst };
        if law.pulses() > 0 {
            player.worst.measure(0, 0, law.ideal(0));
        }
        player
    }

    /// Plays a run; `seen` gets its pulses, unless `next`, which is wanted next,
    /// lies behind it.
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

    /// Plays a run without a look at its single pulses.
    pub fn run(&mut self, run: Run) {
        self.play(run, u32::MAX, |_, _| {});
    }

    /// This many 2⁻¹⁶ ticks later.
    fn pass(&mut self, fine: u64) {
        let due = self.part + fine;
        self.time += due >> 16;
        self.part = due & 0xFFFF;
    }
}

/// A phase as it came out.
#[derive(Clone, Copy, Debug)]
pub struct PhasePart {
    /// Which.
    pub phase: Phase,
    /// Its pulses.
    pub pulses: u32,
    /// Ticks that it takes.
    pub ticks: u64,
}

/// A pulse that the plot shows.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Steps from the first pulse.
    pub n: u32,
    /// When it is emitted, in ticks.
    pub time: u64,
    /// When it should be.
    pub ideal: Double,
}

/// What a walk over a plan finds.
pub struct Survey {
    /// Ticks from the first pulse to the last.
    pub duration: u64,
    /// Largest error of the emitted delays.
    pub worst: Worst,
    /// The phases.
    pub parts: Vec<PhasePart>,
    /// Pulses for the plot: all of a short travel; of a long one close
    /// together where phases meet, further apart between.
    pub samples: Vec<Sample>,
}

impl Survey {
    /// Walks over all pulses; of a long travel that takes seconds.
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

/// The phases' times: their corners are among the samples.
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

/// Which pulse the plot wants next.
struct Marks {
    /// The corners: pulses at which a phase ends, in order.
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

    /// A stride is a fortieth of the way to the nearest corner.
    fn advance(&mut self) {
        let here = self.next;
        let behind = self.corners.partition_point(|&corner| corner <= here);
        let since = here - self.corners[behind.saturating_sub(1)];
        let left = self.corners.get(behind).map_or(0, |corner| corner - here);
        // Growing from the corner behind, shrinking towards the one ahead.
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

    /// Run by run, and partly without a look inside, it finds what the single
    /// delays say.
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
            // What is not looked at hides no larger error.
            assert!(worst <= 1.0 && (worst - survey.worst.ticks).abs() < 0.05, "{worst}");
            assert!(survey.worst.checked == steps || steps > ALL);
            assert!(survey.samples.len() < 3_000);
        }
    }
}
