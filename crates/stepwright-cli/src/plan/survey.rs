//! One walk over all pulses: what the summary says and what the plot shows.

use stepwright::profile::Phase;

use super::law::{Law, Plan, Row};
use super::real::Real;

/// Up to here every pulse is measured against its ideal; of a longer travel
/// the first and the last million are, and every [`STRIDE`]th between.
const ALL: u32 = 4_000_000;
const EDGE: u32 = 1_000_000;
const STRIDE: u32 = 1009;

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
    /// Nothing measured yet.
    pub const NONE: Worst = Worst { ticks: 0.0, step: 0, checked: 0 };

    /// Measures pulse `step` (from 1) at `time`, unless it is one of those
    /// that are left out of a long travel.
    pub fn measure(&mut self, law: &dyn Law, step: u32, time: u64) {
        let (n, pulses) = (step - 1, law.pulses());
        let inner = n >= EDGE && pulses - step >= EDGE;
        if pulses > ALL && inner && !n.is_multiple_of(STRIDE) {
            return;
        }
        let off = (Real::from(time) - law.ideal(n)).to_f64().abs();
        self.checked += 1;
        if off > self.ticks || self.step == 0 {
            (self.ticks, self.step) = (off, step);
        }
    }
}

/// A phase as it came out.
#[derive(Clone, Copy, Debug)]
pub struct Part {
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
    pub ideal: Real,
}

/// What a walk over a plan finds.
pub struct Survey {
    /// Ticks from the first pulse to the last.
    pub duration: u64,
    /// Largest error of the emitted delays.
    pub worst: Worst,
    /// The phases.
    pub parts: Vec<Part>,
    /// Pulses for the plot: all of a short travel; of a long one close
    /// together where phases meet, further apart between.
    pub samples: Vec<Sample>,
}

impl Survey {
    /// Walks over all pulses.
    pub fn of(plan: &Plan) -> Survey {
        let law = plan.law.as_ref();
        let mut survey =
            Survey { duration: 0, worst: Worst::NONE, parts: Vec::new(), samples: Vec::new() };
        let mut marks = Marks::new(law);
        for row in plan.rows() {
            survey.worst.measure(law, row.step, row.time);
            survey.count(&row);
            let n = row.step - 1;
            if marks.next == n {
                survey.samples.push(Sample { n, time: row.time, ideal: law.ideal(n) });
                marks.advance();
            }
        }
        survey
    }

    fn count(&mut self, row: &Row) {
        self.duration = row.time;
        match self.parts.last_mut() {
            Some(part) if part.phase == row.phase => {
                part.pulses += 1;
                part.ticks += u64::from(row.delay);
            }
            _ => {
                self.parts.push(Part { phase: row.phase, pulses: 1, ticks: row.delay.into() });
            }
        }
    }
}

/// Which pulse the plot wants next.
struct Marks {
    /// The corners: pulses at which a phase ends, in order.
    corners: Vec<u32>,
    next: u32,
}

impl Marks {
    fn new(law: &dyn Law) -> Marks {
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
