//! A G-code job: its distances and extents, its time, and its steps.
//!
//! ```text
//!   bytes ──► Reader ──► JobSurvey     distances, extents: no axis need be known
//!                 └────► GcodeJob ──► steps, through a `Route`
//!                         └────► JobPlan    the time, the corners that cost most
//! ```
//!
//! Positions are exact in `stepwright-gcode`; lengths and extents of arcs are computed here in
//! floating point.
//!
//! ```
//! use stepwright_plan::gcode::JobSurvey;
//! let job = "G0 X10\nG3 F600 X-10 I-10\n";
//! let survey = JobSurvey::of(job.bytes())?;
//! assert_eq!((survey.rapids.count, survey.arcs.count), (1, 1));
//! assert!((survey.arcs.distance - 31.4159).abs() < 1e-4);
//! assert_eq!(survey.extents.0[1], Some([0.0, 10.0]));
//! # Ok::<(), stepwright_gcode::Error>(())
//! ```

use stepwright_gcode::{Block, Effect, Error, FeedRate, Move, MoveKind, Options, Reader};
use stepwright_path::{ArcSweep, decimal, millimetres, mm};

use crate::sheet::{Cell, Sheet};

pub use job::{GcodeJob, JobError, JobTerms};
pub use laser::{PowerChange, WITHIN as POWER_WITHIN};
pub use plan::{BoardRefusal, Corner, JobPlan, LaserPlan, Peak};

mod job;
mod laser;
mod plan;

/// The distances, extents and rates of a job in millimetres, from a machine at its zero without offsets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobSurvey {
    /// The lines read.
    pub lines: u32,
    /// Rapid moves.
    pub rapids: MoveSum,
    /// Lines at a feed rate.
    pub feeds: MoveSum,
    /// Arcs.
    pub arcs: MoveSum,
    /// Probing moves, at their full length.
    pub probes: MoveSum,
    /// Dwells, in s.
    pub dwell: f64,
    /// The ends of moves in machine coordinates. The start of the first move is included only if it cuts.
    pub extents: Extents,
    /// The starts and ends of moves at a feed rate: where the job cuts.
    pub cut: Extents,
    /// The slowest and the fastest feed rate, in mm/min.
    pub rates: Option<[f64; 2]>,
}

/// The sum of moves of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MoveSum {
    /// The number of moves.
    pub count: u32,
    /// Their length in mm.
    pub distance: f64,
}

/// The least and the greatest coordinate of X, Y and Z in mm; none without moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extents(pub [Option<[f64; 2]>; 3]);

impl JobSurvey {
    /// Reads a job. The first error ends it.
    pub fn of(job: impl IntoIterator<Item = u8>) -> Result<JobSurvey, Error> {
        let mut survey = JobSurvey::default();
        let mut reader = Reader::new(Options::default());
        for byte in job {
            if let Some(block) = reader.push(byte) {
                survey.add(&block?);
            }
        }
        if let Some(block) = reader.finish() {
            survey.add(&block?);
        }
        Ok(survey)
    }

    /// Adds a block.
    pub fn add(&mut self, block: &Block) {
        self.lines = block.line;
        for effect in block.effects() {
            match effect {
                Effect::Dwell(seconds) => {
                    self.dwell += decimal(seconds);
                }
                Effect::Move(part) => self.travel(&part),
                _ => {}
            }
        }
    }

    fn travel(&mut self, part: &Move) {
        let (from, to) = (millimetres(part.from), millimetres(part.to));
        let way: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
        let mut distance = way.into_iter().fold(0.0, f64::hypot);
        self.extents.cover(to);
        let (kind, rate) = match part.kind {
            MoveKind::Rapid => (&mut self.rapids, None),
            MoveKind::Feed(rate) => (&mut self.feeds, Some(rate)),
            MoveKind::Probe(_, rate) => (&mut self.probes, Some(rate)),
            MoveKind::Arc(arc, rate) => {
                let sweep = ArcSweep::of(part, arc);
                distance = sweep.length();
                for axis_end in sweep.sides() {
                    self.extents.cover_axis(axis_end);
                    self.cut.cover_axis(axis_end);
                }
                (&mut self.arcs, Some(rate))
            }
        };
        kind.count += 1;
        kind.distance += distance;
        let Some(rate) = rate else { return };
        self.extents.cover(from);
        self.cut.cover(from);
        self.cut.cover(to);
        let rate = match rate {
            FeedRate::PerMinute(rate) => mm(rate),
            FeedRate::Inverse(moves) => distance * decimal(moves),
        };
        let [slowest, fastest] = self.rates.unwrap_or([rate; 2]);
        self.rates = Some([slowest.min(rate), fastest.max(rate)]);
    }

    /// The survey as a sheet: moves and distances as facts, extents as a table.
    pub fn sheet(&self, title: impl Into<String>) -> Sheet {
        let mut sheet = Sheet::new(title);
        sheet.fact("lines", "lines", self.lines, "");
        let kinds = [
            ("rapids", "rapid_mm", "rapid moves", self.rapids),
            ("feeds", "feed_mm", "lines at a feed rate", self.feeds),
            ("arcs", "arc_mm", "arcs", self.arcs),
            ("probes", "probe_mm", "probes", self.probes),
        ];
        for (count, distance, name, part) in kinds {
            sheet.fact(count, name, part.count, "");
            sheet.fact(distance, "  their length", Cell::fixed(part.distance, 3), "mm");
        }
        sheet.fact("dwell_s", "dwells", Cell::fixed(self.dwell, 3), "s");
        if let Some([slowest, fastest]) = self.rates {
            sheet.fact("slowest_mm_min", "slowest feed rate", Cell::digits(slowest, 7), "mm/min");
            sheet.fact("fastest_mm_min", "fastest feed rate", Cell::digits(fastest, 7), "mm/min");
        }
        sheet.columns = vec![
            ("axis", "axis"),
            ("from", "from, mm"),
            ("to", "to, mm"),
            ("cut_from", "cuts from"),
            ("cut_to", "to"),
        ];
        for (axis, (all, cut)) in ["X", "Y", "Z"].iter().zip(self.extents.0.iter().zip(self.cut.0))
        {
            let Some(all) = all else { continue };
            let cell = |end: f64| Cell::fixed(end, 3);
            let cut = [0, 1].map(|end| Cell::from(cut.map(|cut| cell(cut[end]))));
            let mut row = vec![Cell::from(*axis), cell(all[0]), cell(all[1])];
            row.extend(cut);
            sheet.rows.push(row);
        }
        sheet.notes = vec![
            "Machine coordinates: the machine begins at its zero, without offsets.".to_owned(),
        ];
        sheet
    }
}

impl Extents {
    fn cover(&mut self, point: [f64; 3]) {
        for (axis, at) in point.into_iter().enumerate() {
            self.cover_axis((axis, at));
        }
    }

    fn cover_axis(&mut self, (axis, at): (usize, f64)) {
        let [least, most] = self.0[axis].unwrap_or([at; 2]);
        self.0[axis] = Some([least.min(at), most.max(at)]);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn survey(job: &str) -> JobSurvey {
        JobSurvey::of(job.bytes()).unwrap()
    }

    #[track_caller]
    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    }

    #[track_caller]
    fn covers(found: Extents, expected: [[f64; 2]; 3]) {
        for (found, expected) in found.0.into_iter().zip(expected) {
            let found = found.unwrap();
            near(found[0], expected[0]);
            near(found[1], expected[1]);
        }
    }

    #[test]
    fn lengths_are_those_of_the_paths() {
        let found = survey("G0 X3 Y4\nG1 F60 Z-2\nX0 Y0 Z10\nG4 P1.5\nG4 P.25\nG38.2 Z7\n");
        near(found.rapids.distance, 5.0);
        near(found.feeds.distance, 2.0 + 13.0);
        near(found.probes.distance, 3.0);
        near(found.dwell, 1.75);
        let counts = [found.rapids, found.feeds, found.arcs, found.probes].map(|part| part.count);
        assert_eq!((counts, found.lines), ([1, 2, 0, 1], 6));
    }

    #[test]
    fn arcs_have_their_length() {
        for (job, expected) in [
            ("G2 F1 X2 I1", PI),
            ("G2 F1 X1 Y1 R1", PI / 2.0),
            ("G2 F1 X1 Y1 R-1", 1.5 * PI),
            ("G3 F1 X0 I1", 2.0 * PI),
            ("G19 G3 F1 Y0 X3 J-4", (8.0 * PI).hypot(3.0)),
        ] {
            near(survey(job).arcs.distance, expected);
        }
    }

    #[test]
    fn extents_have_the_bulge_of_arcs() {
        let found = survey("G0 X5\nG2 F1 X15 I5");
        covers(found.extents, [[5.0, 15.0], [0.0, 5.0], [0.0, 0.0]]);
        covers(found.cut, [[5.0, 15.0], [0.0, 5.0], [0.0, 0.0]]);
        // Three quarters, beyond the ends below and to the left; a full circle; another plane.
        covers(survey("G0 X1\nG2 F1 X0 Y1 I-1").extents, [[-1.0, 1.0], [-1.0, 1.0], [0.0, 0.0]]);
        covers(survey("G3 F1 X0 I-2").cut, [[-4.0, 0.0], [-2.0, 2.0], [0.0, 0.0]]);
        covers(survey("G18 G2 F1 Z2 K1").cut, [[0.0, 1.0], [0.0, 0.0], [0.0, 2.0]]);
        // From a radius of 400 mm to 400.4 mm: 400.1, .2 and .3 on its sides.
        let uneven = survey("G0 X400\nG3 F1 X400.4 I-400").cut;
        covers(uneven, [[-400.2, 400.4], [-400.3, 400.1], [0.0, 0.0]]);
        // A quarter arc stays within its ends.
        covers(survey("G3 F1 X1 Y1 J1").cut, [[0.0, 1.0], [0.0, 1.0], [0.0, 0.0]]);
    }

    #[test]
    fn a_place_that_is_cut_is_within_the_extents() {
        let found = survey("G1 X10 F100");
        covers(found.extents, [[0.0, 10.0], [0.0, 0.0], [0.0, 0.0]]);
        assert_eq!(found.extents, found.cut);
        covers(survey("G0 X10").extents, [[10.0, 10.0], [0.0, 0.0], [0.0, 0.0]]);
    }

    #[test]
    fn rapid_moves_do_not_cut() {
        let found = survey("G0 Z5\nX10\nG1 F100 Z-1\nF300 X20\nG0 Z5\nX-3");
        covers(found.extents, [[-3.0, 20.0], [0.0, 0.0], [-1.0, 5.0]]);
        covers(found.cut, [[10.0, 20.0], [0.0, 0.0], [-1.0, 5.0]]);
        assert_eq!(found.rates, Some([100.0, 300.0]));
        // Two moves of 10 mm a minute.
        assert_eq!(survey("G93 G1 F2 X10").rates, Some([20.0, 20.0]));
    }

    #[test]
    fn the_first_error_ends_it() {
        let error = JobSurvey::of(*b"G0 X1\nG1 X2\nG5\n").unwrap_err();
        assert_eq!((error.line, error.column, error.fault.number()), (2, 1, 22));
    }
}
