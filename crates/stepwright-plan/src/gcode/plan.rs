//! The time of a job and its way, before it starts.
//!
//! A job is planned as it will run, without its steps. Each stretch is a rise, a constant speed and a fall.
//! The cost of a corner is the extra time of the way down to it and up from it, compared with the speeds on
//! either side.
//!
//! ```text
//!    ▔▔▔▔╲             ╱▔▔▔▔▔
//!     V₁  ╲           ╱   V₂        cost = (T₁ − L₁/V₁) + (T₂ − L₂/V₂)
//!          ╲_________╱
//!        T₁, L₁ │ T₂, L₂
//! ```

use std::collections::BinaryHeap;

use stepwright::Board;
use stepwright_gcode::Length;
use stepwright_path::{AxisPace, LaserMove, Stretch, Unplannable, mm};

use super::{GcodeJob, JobError, JobSurvey, JobTerms};
use crate::sheet::{Cell, Sheet};
use crate::tidy::unsigned_zero;

/// The number of corners kept.
const CORNERS: usize = 10;

/// A constant speed for less than this time, in s, is part of the way down or up.
const LEVEL: f64 = 0.001;

/// Stretches from one call of a watch to the next.
const STRIDE: u32 = 10_000;

/// A place where a job slows down and speeds up again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The line of the move that ends there.
    pub line: u32,
    /// The place in mm, to a millionth.
    pub place: [f64; 3],
    /// The speed there in mm/s; 0 if the job rests.
    pub speed: f64,
    /// The lost time in s.
    pub cost: f64,
}

/// Where a board can't follow the job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardRefusal {
    /// The line in which the axis is fastest.
    pub line: u32,
    /// The axis, counted from 0.
    pub axis: usize,
    /// Steps/s of the axis there.
    pub wanted: f64,
    /// Steps/s of the axis that the board can do beside the others.
    pub most: f64,
}

/// The highest speed of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Steps/s.
    pub rate: f64,
    /// The first line with this speed.
    pub line: u32,
}

/// The use of a laser along a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserPlan {
    /// S at full power.
    pub most: f64,
    /// Seconds with the laser on; it is never on at rest.
    pub time: f64,
    /// mm with the laser on.
    pub way: f64,
    /// The highest S while it is on; above `most` it is full power.
    pub highest: f64,
}

/// A planned job with its time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobPlan {
    /// The settings of the job.
    pub terms: JobTerms,
    /// Distances and extents.
    pub survey: JobSurvey,
    /// Seconds from the start to the end.
    pub time: f64,
    /// Of this time, s at the ordered speed,
    pub at_feed: f64,
    /// s at the limits of the axes (speed, or acceleration in a curve),
    pub at_axes: f64,
    /// and s speeding up and braking. The rest are dwells.
    pub ramps: f64,
    /// The highest speed of each axis.
    pub peaks: [Peak; 3],
    /// The corners that cost most, the most expensive first.
    pub corners: Vec<Corner>,
    /// Where the board would refuse the job.
    pub refused: Option<BoardRefusal>,
    /// The use of the laser, if the job has one instead of a spindle.
    pub laser: Option<LaserPlan>,
}

/// Ordered by cost; equal costs by line.
#[derive(Debug)]
struct Ranked(Corner);

impl Ranked {
    /// The corner, its place without the rounding noise of a sine.
    fn corner(self) -> Corner {
        let place = self.0.place.map(|at| unsigned_zero((at * 1e6).round() / 1e6));
        Corner { place, ..self.0 }
    }
}

impl Ord for Ranked {
    fn cmp(&self, other: &Ranked) -> std::cmp::Ordering {
        // To 1 ns: everything below is rounding.
        let cost = |ranked: &Ranked| (ranked.0.cost * 1e9).round();
        cost(other).total_cmp(&cost(self)).then(self.0.line.cmp(&other.0.line))
    }
}

impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Ranked) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ranked {
    fn eq(&self, other: &Ranked) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ranked {}

/// The way down to a corner, or up from it.
#[derive(Debug, Default)]
struct Slope {
    time: f64,
    way: f64,
    /// The speed at its beginning.
    top: f64,
}

impl Slope {
    /// The extra time, compared with the speed `top`.
    fn loss(&self, top: f64) -> f64 {
        if top > 0.0 { self.time - self.way / top } else { 0.0 }
    }
}

/// The corners that cost most.
#[derive(Debug, Default)]
struct Corners {
    kept: BinaryHeap<Ranked>,
    slope: Slope,
    rises: bool,
    /// The corner from which the speed rises; none after a start or a constant speed.
    low: Option<Corner>,
}

impl Corners {
    /// Adds a time at constant acceleration that begins in this line and at this place.
    fn go(&mut self, line: u32, place: [f64; 3], [from, to]: [f64; 2], time: f64, way: f64) {
        if time <= 0.0 {
            return;
        }
        if from == to && time >= LEVEL {
            // The speed is at a top, or low for a reason that is no corner.
            self.top(from);
        } else if to > from && !self.rises {
            let cost = self.slope.loss(self.slope.top);
            self.low = (cost > 0.0).then_some(Corner { line, place, speed: from, cost });
            (self.slope, self.rises) = (Slope { time, way, top: from }, true);
        } else if to < from && self.rises {
            self.top(from);
            self.slope = Slope { time, way, top: from };
        } else {
            if to < from && self.slope.time == 0.0 {
                self.slope.top = from;
            }
            self.slope.time += time;
            self.slope.way += way;
        }
    }

    /// Handles a top with this speed: the corner before it is complete.
    fn top(&mut self, speed: f64) {
        if self.rises
            && let Some(low) = self.low.take()
        {
            let cost = low.cost + self.slope.loss(speed);
            self.kept.push(Ranked(Corner { cost, ..low }));
            if self.kept.len() > CORNERS {
                self.kept.pop();
            }
        }
        (self.slope, self.rises, self.low) =
            (Slope { top: speed, ..Slope::default() }, false, None);
    }
}

impl JobPlan {
    /// Plans a job of these axes for this board. Calls `watch` from time to time with the number of lines
    /// read and the seconds planned.
    ///
    /// # Errors
    /// [`JobError`]: the first error of the job. Errors of the axes have line 0.
    pub fn of<const N: usize>(
        bytes: impl IntoIterator<Item = u8>,
        axes: [AxisPace; 3],
        board: &Board<N>,
        watch: impl FnMut(u32, f64),
    ) -> Result<JobPlan, JobError> {
        JobPlan::on(bytes, axes, &JobTerms::default(), board, watch)
    }

    /// Plans a job with these settings.
    ///
    /// # Errors
    /// As for [`of`](JobPlan::of).
    pub fn on<const N: usize>(
        bytes: impl IntoIterator<Item = u8>,
        axes: [AxisPace; 3],
        terms: &JobTerms,
        board: &Board<N>,
        mut watch: impl FnMut(u32, f64),
    ) -> Result<JobPlan, JobError> {
        let wrong = |why: Unplannable| JobError::Move(0, why);
        let mut job = GcodeJob::on(bytes, axes, terms).map_err(wrong)?;
        let mut plan = JobPlan { terms: *terms, ..JobPlan::default() };
        let mut corners = Corners::default();
        let unlit = |most| LaserPlan { most, time: 0.0, way: 0.0, highest: 0.0 };
        plan.laser = terms.laser.map(unlit);
        let mut before = 0;
        let mut next = STRIDE;
        while let Some((line, stretch)) = job.stretch()? {
            plan.add(line, &stretch, &axes);
            plan.burn(&stretch, job.laser_move());
            let [a, b, c] = stretch.speeds;
            for (n, speeds) in [[a, b], [b, b], [b, c]].into_iter().enumerate() {
                let time = stretch.times[n + 1] - stretch.times[n];
                // A corner is at the end of the move before.
                let line = if n == 0 { before } else { line };
                let place = stretch.places[n / 2];
                corners.go(line, place, speeds, time, stretch.ways[n]);
            }
            before = line;
            next -= 1;
            if next == 0 {
                next = STRIDE;
                watch(line, stretch.end());
            }
        }
        plan.time = job.time();
        plan.refused = plan.refused_by(board);
        plan.survey = job.survey().clone();
        plan.corners = corners.kept.into_sorted_vec().into_iter().map(Ranked::corner).collect();
        Ok(plan)
    }

    fn add(&mut self, line: u32, stretch: &Stretch<3>, axes: &[AxisPace; 3]) {
        let [begin, level, fall, end] = stretch.times;
        self.ramps += (level - begin) + (end - fall);
        let top = stretch.speeds[1];
        let at_feed = !stretch.rapid && top >= stretch.feed * (1.0 - 1e-9);
        *(if at_feed { &mut self.at_feed } else { &mut self.at_axes }) += fall - level;
        let speed = top.max(stretch.speeds[0]).max(stretch.speeds[2]);
        let [first, last] = stretch.directions;
        let rates: [f64; 3] = std::array::from_fn(|axis| {
            speed * first[axis].abs().max(last[axis].abs()) / axes[axis].step
        });
        for (peak, rate) in self.peaks.iter_mut().zip(rates) {
            // An axis often reaches the same speed in many lines, except for rounding.
            if rate > peak.rate * (1.0 + 1e-9) {
                *peak = Peak { rate, line };
            }
        }
    }

    fn burn(&mut self, stretch: &Stretch<3>, along: LaserMove) {
        if let Some(laser) = self.laser.as_mut().filter(|_| along.is_on()) {
            laser.time += stretch.end() - stretch.times[0];
            laser.way += stretch.way[1] - stretch.way[0];
            laser.highest = laser.highest.max(along.ordered());
        }
    }

    /// The least µs between two steps of each axis, for a board that is told them before. `None` for an
    /// axis without steps.
    ///
    /// A little less than at the peak: within a part of an arc an axis may be 0.13 % faster than at both of
    /// its ends, and a step is rounded to a tick. For an axis slower than ten steps a second it is 0.1 s: the
    /// job begins later by this time, and a timer can count it.
    pub fn delays(&self) -> [Option<u32>; 3] {
        self.peaks.map(|peak| {
            let delay = (1e6 / (peak.rate * 1.002) - 0.1).clamp(1.0, 1e5);
            (peak.rate > 0.0).then_some(delay as u32)
        })
    }

    /// What the board would refuse of these [`peaks`](JobPlan::peaks) if it is told the
    /// [`delays`](JobPlan::delays): all steps together may take up to all of its time.
    pub fn refused_by<const N: usize>(&self, board: &Board<N>) -> Option<BoardRefusal> {
        let delays = self.delays();
        let moving = delays.iter().flatten().count();
        let cost = f64::from(board.step_cost(moving));
        let shortest = board.cost.shortest.get(moving.saturating_sub(1)).copied().unwrap_or(0);
        let shortest = f64::from(shortest.max(board.timing.min_interval));
        let ticks = |delay: u32| f64::from(board.rate.micros(delay));
        let load = |delay: Option<u32>| delay.map_or(0.0, |delay| cost / ticks(delay));
        let all: f64 = delays.into_iter().map(load).sum();
        let over =
            |axis: &usize| all > 1.0 || delays[*axis].is_some_and(|delay| ticks(delay) < shortest);
        let fast = |a: &usize, b: &usize| self.peaks[*a].rate.total_cmp(&self.peaks[*b].rate);
        let axis = (0..3).filter(over).max_by(fast)?;
        let room = (1.0 - (all - load(delays[axis]))).max(0.0);
        let most = f64::from(board.rate.hz()) * (room / cost).min(1.0 / shortest);
        let Peak { rate: wanted, line } = self.peaks[axis];
        Some(BoardRefusal { line, axis, wanted, most })
    }

    /// The plan as a sheet: the time and distances as facts, extents and corners as tables. `board` is the
    /// name of the board.
    pub fn sheet(&self, title: impl Into<String>, board: &str) -> Sheet {
        let mut sheet = self.survey.sheet(title);
        let facts = std::mem::take(&mut sheet.facts);
        let seconds = |value: f64| Cell::fixed(value, 3);
        sheet.fact("seconds", "time", Cell::fixed(self.time, 6), "s");
        sheet.fact("at_feed_s", "  at the ordered speed", seconds(self.at_feed), "s");
        sheet.fact("at_axes_s", "  at what the axes can do", seconds(self.at_axes), "s");
        sheet.fact("ramps_s", "  speeding up and braking", seconds(self.ramps), "s");
        if self.terms.tolerance > Length::ZERO {
            let tolerance = Cell::digits(mm(self.terms.tolerance), 9);
            sheet.fact("tolerance_mm", "off its lines, at most", tolerance, "mm");
        }
        if let Some(laser) = self.laser {
            sheet.fact("laser_on_s", "laser on", seconds(laser.time), "s");
            sheet.fact("laser_on_mm", "  its way", Cell::fixed(laser.way, 3), "mm");
            if laser.highest > laser.most {
                sheet.notes.push(format!(
                    "It burns with up to S{}: from S{} on that is full power.",
                    laser.highest, laser.most,
                ));
            }
        }
        sheet.facts.extend(facts);
        let names =
            ["peak_x", "peak_y", "peak_z"].into_iter().zip(["fastest X", "fastest Y", "fastest Z"]);
        for ((key, name), peak) in names.zip(self.peaks) {
            sheet.fact(key, name, Cell::fixed(peak.rate, 0), "steps/s");
        }
        let taken = if self.refused.is_some() { "refused" } else { "can do it" };
        sheet.fact("board", "the board", taken, "");
        if let Some(refused) = self.refused {
            sheet.notes.push(refused.words(board));
        }
        let mut corners = Sheet::new("Corners that cost most");
        corners.columns = vec![
            ("line", "line"),
            ("x", "X, mm"),
            ("y", "Y, mm"),
            ("z", "Z, mm"),
            ("speed_mm_s", "passed at, mm/s"),
            ("cost_s", "costs, s"),
        ];
        let row = |corner: &Corner| {
            let place = corner.place.map(|at| Cell::fixed(at, 3));
            let (speed, cost) = (Cell::fixed(corner.speed, 2), Cell::fixed(corner.cost, 3));
            [Cell::from(corner.line)].into_iter().chain(place).chain([speed, cost]).collect()
        };
        corners.rows = self.corners.iter().map(row).collect();
        sheet.parts.push(("corners", corners));
        sheet
    }
}

impl BoardRefusal {
    /// The refusal in words.
    pub fn words(&self, board: &str) -> String {
        let axis = ["X", "Y", "Z"].get(self.axis).copied().unwrap_or("?");
        format!(
            "{board} would refuse it: in line {} {axis} comes to {:.0} steps/s, and beside the \
             others it can do {:.0}.",
            self.line,
            self.wanted.ceil(),
            self.most.floor(),
        )
    }
}
