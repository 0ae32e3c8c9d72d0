//! Lines and arcs at speed, without a stop between them: pieces in, steps out.
//!
//! ```text
//!   line_to, arc ──► joints ──► cells ──► passes ──► pieces in time ──► steps
//!                    what each           speed at    of constant       each axis at
//!                    may be passed at    each node   acceleration      its own times
//! ```
//!
//! A route plans ahead by what it knows, always to a rest at the end of that, so it may run out
//! of pieces at any time. It plans again when enough has been added, from where it stands on,
//! and keeps the plan before if a new one would break the law of speed. Memory is bounded where
//! steps are taken between pieces: what lies ahead of the steps is kept, and with 65,536 cells of
//! it half are made, whatever comes behind.
//!
//! **Changes.** An override, a hold and its end take hold at a time, from the speed there is
//! then: the cell is cut there, and what is ahead planned again.

use std::collections::VecDeque;

use crate::bucket::Bucket;
use crate::cell::{Cell, Scales};
use crate::change::Change;
use crate::chords::Before;
use crate::glide::Glides;
use crate::loose::Loose;
use crate::pace::{PACES, Unplannable};
use crate::passes::Passes;
use crate::piece::Piece;
use crate::shape::{Shape, norm};
use crate::smooth::{self, Smooth};
use crate::stretch::Stretch;

/// What one axis of a [`Route`] can do, in the user's unit and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPace {
    /// Units a step leads.
    pub step: f64,
    /// Unit/s at most, whatever a piece orders.
    pub speed: f64,
    /// Unit/s².
    pub accel: f64,
    /// Unit/s by which the speed may change at once: the motor's start speed. Where the jerk of any axis
    /// is limited, less than `jerk` · 10⁻⁸ s² counts as that.
    pub jump: f64,
    /// The limit of jerk, in unit/s³; `accel` takes at least [`SOONEST`] to reach. Infinite for all
    /// axes: none.
    pub jerk: f64,
}

/// Seconds within which an acceleration comes, at the soonest, where the jerk of any axis is limited.
pub const SOONEST: f64 = 0.001;

/// A step of an axis of a [`Route`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteStep {
    /// Seconds after the start.
    pub time: f64,
    /// The axis, from 0.
    pub axis: usize,
    /// Which way.
    pub forward: bool,
}

/// A path of lines and arcs, passed at speed, of one axis or any number of them; an arc takes two.
///
/// Each axis keeps the law of speed: |v(t) − v(t')| ≤ `jump` + `accel`·|t − t'| for every two
/// times, so also over chords of a curve and over corners divided into tiny ones. With limited jerk
/// it keeps more than that: it stays within half of its `jump` of a speed u with |u'| ≤ `accel` and
/// |u''| ≤ `jerk`.
///
/// ```
/// use stepwright_path::{AxisPace, Route};
/// let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
/// let mut route = Route::new([axis; 2])?;
/// let (mut steps, mut time) = ([0, 0], 0.0);
/// for to in [[30.0, 0.0], [30.0, 20.0], [0.0, 0.0]] {
///     route.line_to(to, 100.0)?;
///     // As far as is final by now; more once more is known.
///     for step in route.by_ref() {
///         steps[step.axis] += if step.forward { 1 } else { -1 };
///         time = step.time;
///     }
/// }
/// route.close();
/// for step in route.by_ref() {
///     steps[step.axis] += if step.forward { 1 } else { -1 };
///     time = step.time;
/// }
/// assert_eq!(steps, [0, 0]);
/// assert!(time > 1.1 && time < 1.2, "{time}");
/// # Ok::<(), stepwright_path::Unplannable>(())
/// ```
#[derive(Clone, Debug)]
pub struct Route<const N: usize> {
    pub(crate) axes: [AxisPace; N],
    pub(crate) deviation: Option<f64>,
    /// Where the last piece ends, along the route and of each axis.
    pub(crate) length: f64,
    pub(crate) place: [f64; N],
    pub(crate) loose: VecDeque<Loose<N>>,
    /// Chords before those, as far as they are seen.
    pub(crate) chords: Before<N>,
    pub(crate) cells: VecDeque<Cell<N>>,
    pub(crate) passes: Passes,
    /// Cells that the plan does not know yet.
    pub(crate) fresh: usize,
    pub(crate) closed: bool,
    pub(crate) scales: Scales,
    /// When the first cell begins, and what the law leaves there.
    pub(crate) time: f64,
    pub(crate) bucket: Bucket<N>,
    /// The first cell in time, while it is being made.
    pub(crate) front: Option<[Piece; 3]>,
    /// Position of each axis in steps, and where along the route its last step was.
    pub(crate) at: [i64; N],
    pub(crate) stepped: [f64; N],
    /// The next step of each axis in the first cell, and where it is, once that is known.
    pub(crate) next: [Option<Option<(f64, RouteStep)>>; N],
    /// What has been handed out.
    pub(crate) now: f64,
    pub(crate) changes: VecDeque<(f64, Change)>,
    /// Cells to the place where it is held.
    pub(crate) halt: Option<usize>,
    /// Where the jerk is limited.
    pub(crate) smooth: Option<Box<Smooth<N>>>,
    /// Where it was when, if that is wanted.
    pub(crate) glides: Option<Glides>,
}

/// Cells that a route keeps ahead at most.
const MOST: usize = 65_536;

/// The same with limited jerk, where a plan takes longer.
const MOST_SMOOTH: usize = 8_192;

/// Cells that are new when it is worth while to plan again, at least.
const FRESH: usize = 8;

/// Turns of an arc at most: 62,832 cells.
const TURNS: f64 = 1_000.0;

/// Parts of a cell are at least this part of it.
pub(crate) const SLIVER: f64 = 1e-9;

impl<const N: usize> Route<N> {
    /// From position 0 of all axes, at rest.
    ///
    /// # Errors
    /// [`Unplannable`] if a number of an axis is beyond [`PACES`].
    pub fn new(axes: [AxisPace; N]) -> Result<Route<N>, Unplannable> {
        Route::at(axes, [0.0; N])
    }

    /// From this place, at rest: each axis stands at the position nearest to it.
    ///
    /// # Errors
    /// As for [`new`](Route::new); [`Unplannable::TooLong`] beyond 2³¹ − 1 steps from 0.
    pub fn at(axes: [AxisPace; N], place: [f64; N]) -> Result<Route<N>, Unplannable> {
        for AxisPace { step, speed, accel, jump, jerk } in axes {
            let wrong = [
                (step, Unplannable::Step),
                (speed, Unplannable::Speed),
                (accel, Unplannable::Accel),
                (jump, Unplannable::Jump),
            ];
            if let Some((_, wrong)) = wrong.into_iter().find(|(x, _)| !PACES.contains(x)) {
                return Err(wrong);
            }
            if jerk != f64::INFINITY && !PACES.contains(&jerk) {
                return Err(Unplannable::Jerk);
            }
        }
        let axes = smooth::planned_with(axes);
        let mut route = Route {
            axes,
            deviation: None,
            length: 0.0,
            place,
            loose: VecDeque::new(),
            chords: Before::default(),
            cells: VecDeque::new(),
            passes: Passes::default(),
            fresh: 0,
            closed: false,
            scales: Scales { feed: 1.0, rapid: 1.0 },
            time: 0.0,
            bucket: Bucket::REST,
            front: None,
            at: [0; N],
            stepped: [0.0; N],
            next: [None; N],
            now: 0.0,
            changes: VecDeque::new(),
            halt: None,
            smooth: Smooth::new(&axes).map(Box::new),
            glides: None,
        };
        route.check(&place)?;
        route.at = std::array::from_fn(|n| (place[n] / axes[n].step).round() as i64);
        route.passes.w.push_back(0.0);
        Ok(route)
    }

    /// Corners by junction deviation in place of the jump, in units: faster, and with jumps that
    /// exceed what the axes are said to take, so the law of speed is not kept.
    ///
    /// # Errors
    /// [`Unplannable::Deviation`] beyond [`PACES`].
    pub fn with_deviation(mut self, deviation: f64) -> Result<Route<N>, Unplannable> {
        if !PACES.contains(&deviation) {
            return Err(Unplannable::Deviation);
        }
        self.deviation = Some(deviation);
        Ok(self)
    }

    /// Adds a straight line to a place, at most at `feed` units/s along it. To the place where
    /// the route ends already it is nothing.
    ///
    /// # Errors
    /// [`Unplannable::Speed`] beyond [`PACES`], [`Unplannable::TooLong`] beyond 2³¹ − 1 steps
    /// from 0.
    pub fn line_to(&mut self, to: [f64; N], feed: f64) -> Result<(), Unplannable> {
        self.straight(to, feed, false)
    }

    /// Adds a straight line to a place, as fast as the axes can: a rapid. An override of the
    /// ordered speed ([`scale`](Route::scale)) is none of it;
    /// [`scale_rapids`](Route::scale_rapids) is.
    ///
    /// Gives that speed, in units/s.
    ///
    /// # Errors
    /// [`Unplannable::TooLong`] beyond 2³¹ − 1 steps from 0.
    pub fn rapid_to(&mut self, to: [f64; N]) -> Result<f64, Unplannable> {
        let way: [f64; N] = std::array::from_fn(|n| to[n] - self.place[n]);
        let times = way.iter().zip(&self.axes).map(|(way, axis)| way.abs() / axis.speed);
        let time = times.fold(0.0, f64::max);
        let feed = if time > 0.0 { norm(&way) / time } else { 1.0 };
        self.straight(to, feed, true).map(|()| feed)
    }

    fn straight(&mut self, to: [f64; N], feed: f64, rapid: bool) -> Result<(), Unplannable> {
        self.check(&to)?;
        let way: [f64; N] = std::array::from_fn(|n| to[n] - self.place[n]);
        // What is shorter than that has no direction.
        if norm(&way) > 0.0 && norm(&way) > 1e-12 * norm(&to) {
            self.add(Shape::line(self.length, self.place, to), feed, rapid)?;
            self.place = to;
        } else if !PACES.contains(&feed) {
            return Err(Unplannable::Speed);
        }
        Ok(())
    }

    /// Adds an arc of two axes by `sweep` radians around a centre, positive from the first axis
    /// towards the second; 2π is a circle, and there may be several. The others go by `climb`
    /// meanwhile, whose numbers for the two are not used. At most at `feed` units/s along it.
    ///
    /// # Errors
    /// As for [`line_to`](Route::line_to); [`Unplannable::Axes`] if they are not two of the
    /// route's, [`Unplannable::Radius`] where the centre is nearer than a step,
    /// [`Unplannable::Sweep`] if that is 0 or more than 1,000 turns.
    pub fn arc(
        &mut self,
        axes: [usize; 2],
        centre: [f64; 2],
        sweep: f64,
        mut climb: [f64; N],
        feed: f64,
    ) -> Result<(), Unplannable> {
        if axes[0] == axes[1] || axes.iter().any(|axis| *axis >= N) {
            return Err(Unplannable::Axes);
        }
        if !(sweep != 0.0 && sweep.abs() <= TURNS * std::f64::consts::TAU) {
            return Err(Unplannable::Sweep);
        }
        for axis in axes {
            climb[axis] = 0.0;
        }
        let [x, y] = [0, 1].map(|n| self.place[axes[n]] - centre[n]);
        let radius = x.hypot(y);
        if !axes.iter().all(|axis| radius >= self.axes[*axis].step) {
            return Err(Unplannable::Radius);
        }
        let mut to: [f64; N] = std::array::from_fn(|n| self.place[n] + climb[n]);
        for (n, axis) in axes.into_iter().enumerate() {
            to[axis] = centre[n].abs() + radius;
        }
        self.check(&to)?;
        let shape = Shape::arc(self.length, self.place, axes, centre, sweep, climb);
        for axis in axes {
            to[axis] = shape.place(axis, shape.end);
        }
        self.add(shape, feed, false)?;
        self.place = to;
        Ok(())
    }

    /// No piece follows for now: the route comes to rest where it ends, and goes on from there
    /// if one is added later.
    pub fn close(&mut self) {
        self.settle_all();
        self.closed = true;
    }

    /// Whether nothing of it is left.
    pub fn is_over(&self) -> bool {
        self.cells.is_empty() && self.loose.is_empty()
    }

    /// Seconds from the start to the end of what has been made; pauses included.
    pub fn time(&self) -> f64 {
        self.time.max(self.now)
    }

    /// Where the route ends, by the pieces so far.
    pub fn end(&self) -> [f64; N] {
        self.place
    }

    /// Where each axis is in steps, as far as steps were handed out.
    pub fn positions(&self) -> [i64; N] {
        self.at
    }

    /// Units along the route from its start to its end, by the pieces so far.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Stands for this many seconds where the route ends; what is added later begins behind
    /// that. False, and nothing happens, unless it [is over](Route::is_over): close it and take
    /// its steps before. Less than 0, or no finite number, is 0.
    pub fn dwell(&mut self, seconds: f64) -> bool {
        if !self.is_over() {
            return false;
        }
        let wait = if seconds.is_finite() { seconds.max(0.0) } else { 0.0 };
        self.stand_for(wait);
        true
    }

    /// Passes over the next part of the route without its steps. `None` when nothing is final, as
    /// with the steps. The times are those of the steps: so long a job takes.
    pub fn pass_over(&mut self) -> Option<Stretch<N>> {
        loop {
            let due = self.enter()?;
            if !self.disturb(due) {
                let stretch = self.stretch();
                self.pass();
                return stretch;
            }
        }
    }

    /// The first cell in time, as it is passed.
    fn stretch(&self) -> Option<Stretch<N>> {
        let (pieces, cell) = (self.front.as_ref()?, self.cells.front()?);
        let place = |s| std::array::from_fn(|axis| cell.shape.place(axis, s));
        let [a, b, c] = pieces;
        Some(Stretch {
            way: [cell.begin, cell.end],
            times: [a.from.t, b.from.t, c.from.t, c.to.t],
            speeds: [a.from.v, b.from.v, c.to.v],
            ways: pieces.map(|piece| piece.to.s - piece.from.s),
            feed: cell.ordered(),
            places: [place(cell.begin), place(cell.end)],
            directions: [cell.first, cell.last],
        })
    }

    pub(crate) fn check(&self, place: &[f64; N]) -> Result<(), Unplannable> {
        let near =
            |(place, axis): (&f64, &AxisPace)| (place / axis.step).abs() <= f64::from(i32::MAX);
        let known = place.iter().zip(&self.axes).all(near);
        if known { Ok(()) } else { Err(Unplannable::TooLong) }
    }

    /// The first cell in time: when it ends.
    pub(crate) fn enter(&mut self) -> Option<f64> {
        if self.front.is_none() {
            while self.halt == Some(0) {
                self.stand()?;
            }
            if self.passes.sure == 0 || self.cells.is_empty() {
                self.replan()?;
            }
            let cell = self.cells.front()?;
            self.front = Some(if self.smooth.is_some() {
                self.enter_smooth()?
            } else {
                let (w, trip_to) = (self.passes.w[0], self.passes.w[1]);
                cell.pieces(&cell.trip(w, trip_to), self.time)
            });
            self.next = [None; N];
        }
        self.front.map(|pieces| pieces[2].to.t)
    }

    /// Plans as far as is known; `None` if nothing of that is final.
    fn replan(&mut self) -> Option<()> {
        let count = self.cells.len();
        // A plan with limited jerk takes longer.
        let (most, part) =
            if self.smooth.is_some() { (MOST_SMOOTH, count / 4 * 3) } else { (MOST, count / 2) };
        let (full, enough) = (count >= most, self.fresh >= FRESH.max(part));
        if self.cells.is_empty() || !(enough || self.closed || full) {
            return None;
        }
        let planned = self.plan() || self.smooth.is_none();
        if !planned {
            // By what was planned before.
        } else if self.closed {
            self.passes.sure = self.cells.len();
        } else if full {
            self.passes.sure = self.passes.sure.max(self.cells.len() / 2);
        }
        (self.passes.sure > 0).then_some(())
    }

    /// Plans; if the law can't be kept, what was planned stays, and what is new is passed from
    /// rest to rest. Whether it was planned.
    pub(crate) fn plan(&mut self) -> bool {
        if self.smooth.is_some() {
            return self.plan_smooth();
        }
        let strict = self.deviation.is_none();
        self.fresh = 0;
        let planned = self.passes.plan(&self.cells, &self.bucket, &self.axes, strict).is_some();
        if !planned {
            self.passes.w.resize(self.cells.len() + 1, 0.0);
            self.passes.sure = self.passes.sure.min(1);
        }
        planned
    }

    /// It stands for this long.
    pub(crate) fn stand_for(&mut self, wait: f64) {
        self.time += wait;
        match &mut self.smooth {
            Some(smooth) => smooth.wait(wait),
            None => self.bucket.wait(wait, &self.axes),
        }
    }

    /// Leaves the first cell behind.
    fn leave(&mut self) {
        let (Some(pieces), Some(cell)) = (self.front.take(), self.cells.pop_front()) else {
            return;
        };
        let end = pieces[2].to;
        if self.smooth.is_some() {
            let level = pieces[1].to.t > pieces[1].from.t;
            self.leave_smooth(&pieces[usize::from(level)], &cell);
        } else {
            self.bucket.wait(end.t - self.time, &self.axes);
            self.bucket.meet(end.v, &cell.last, 0, &self.axes);
            self.passes.w.pop_front();
        }
        self.time = end.t;
        self.passes.sure = self.passes.sure.saturating_sub(1);
        self.halt = self.halt.map(|cells| cells.saturating_sub(1));
    }

    /// Leaves the first cell behind without its steps.
    pub(crate) fn pass(&mut self) {
        if let Some(cell) = self.cells.front() {
            for (axis, at) in self.at.iter_mut().enumerate() {
                let place = cell.shape.place(axis, cell.end) / self.axes[axis].step;
                // Half a step away it is where it was.
                if (place - *at as f64).abs() > 0.5 + 1e-6 {
                    *at = place.round() as i64;
                }
            }
        }
        self.leave();
    }

    /// The next step within the first cell, and where it is.
    fn soonest(&mut self) -> Option<(f64, RouteStep)> {
        let (pieces, cell) = (self.front.as_ref()?, self.cells.front()?);
        let mut soonest: Option<(f64, RouteStep)> = None;
        for axis in 0..N {
            let next = self.next[axis].get_or_insert_with(|| {
                let from = self.stepped[axis].max(cell.begin);
                let size = self.axes[axis].step;
                let (s, forward) = cell.shape.step(axis, self.at[axis], size, from, cell.end)?;
                let piece = pieces.iter().find(|piece| piece.to.s >= s).unwrap_or(&pieces[2]);
                Some((s, RouteStep { time: piece.time(s), axis, forward }))
            });
            if let Some((s, step)) = *next
                && soonest.is_none_or(|known| step.time < known.1.time)
            {
                soonest = Some((s, step));
            }
        }
        soonest
    }
}

/// The steps of all axes in the order of their times. After `None` there are more once more of
/// the route is known, it is closed, or resumed.
impl<const N: usize> Iterator for Route<N> {
    type Item = RouteStep;

    fn next(&mut self) -> Option<RouteStep> {
        loop {
            let due = self.enter()?;
            let step = self.soonest();
            if self.disturb(step.map_or(due, |(_, step)| step.time)) {
                continue;
            }
            let Some((s, step)) = step else {
                self.take_down(due);
                self.leave();
                continue;
            };
            let axis = step.axis;
            self.at[axis] += if step.forward { 1 } else { -1 };
            (self.stepped[axis], self.next[axis]) = (s, None);
            self.now = step.time;
            return Some(step);
        }
    }
}
