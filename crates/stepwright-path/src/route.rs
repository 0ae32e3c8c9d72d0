//! A route: lines and arcs at speed, without a stop between them; pieces in, steps out.
//!
//! ```text
//!   line_to, arc ──► joints ──► cells ──► passes ──► pieces in time ──► steps
//!                    what each           speed at    of constant       each axis at
//!                    may be passed at    each node   acceleration      its own times
//! ```
//!
//! A route always plans to a rest at the end of the known pieces, so it may run out of pieces at any time. When
//! enough pieces have been added it plans again from its present state. It keeps the plan before if a new plan
//! would break the law of speed. Memory is bounded if the caller takes steps between pieces: a route keeps only
//! the cells ahead of the steps, and with 65,536 cells ahead the first half becomes final, whatever follows.
//! With limited jerk at most 8,192 cells are planned at once.
//!
//! **Changes.** An override, a hold and its end take effect at a given time, from the speed at that time: the
//! cell is divided there, and the rest is planned again.

use std::collections::VecDeque;

use crate::bucket::Bucket;
use crate::cell::{Cell, Scales};
use crate::change::Order;
use crate::chords::Before;
use crate::glide::Glides;
use crate::loose::Loose;
use crate::pace::{PACES, Unplannable};
use crate::passes::Passes;
use crate::piece::Piece;
use crate::shape::{Shape, norm};
use crate::smooth::{self, Smooth};
use crate::stretch::Stretch;

/// The limits of one axis of a [`Route`], in the user's unit and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPace {
    /// The length of a step, in units; [`per_unit`](AxisPace::per_unit) takes the steps of a unit.
    pub step: f64,
    /// The highest speed, in unit/s, whatever a piece orders.
    pub speed: f64,
    /// The acceleration, in unit/s².
    pub accel: f64,
    /// The change of the speed that is allowed at once, in unit/s: the start speed of the motor. If the jerk of
    /// any axis is limited, values below `jerk` · 10⁻⁸ s² count as that.
    pub jump: f64,
    /// The limit of jerk, in unit/s³. Reaching `accel` takes at least [`SOONEST`]. If it is infinite for all
    /// axes, jerk is not limited.
    pub jerk: f64,
}

impl AxisPace {
    /// The limits of an axis that makes this many steps per unit, such as 80 steps per mm. Speeds are in units
    /// per second, not per minute; the jerk is not limited.
    ///
    /// ```
    /// use stepwright_path::AxisPace;
    /// let axis = AxisPace::per_unit(80.0, 200.0, 1_000.0, 5.0);
    /// assert_eq!(axis.step, 0.0125);
    /// ```
    pub const fn per_unit(steps: f64, speed: f64, accel: f64, jump: f64) -> AxisPace {
        AxisPace { step: 1.0 / steps, speed, accel, jump, jerk: f64::INFINITY }
    }
}

/// The shortest time in which an axis reaches its acceleration if the jerk of any axis is limited, in s.
pub const SOONEST: f64 = 0.001;

/// A step of an axis of a [`Route`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteStep {
    /// The time after the start, in s.
    pub time: f64,
    /// The axis, from 0.
    pub axis: usize,
    /// The direction.
    pub forward: bool,
}

/// A path of lines and arcs, passed at speed, of any number of axes. An arc takes two axes.
///
/// Each axis keeps the law of speed: |v(t) − v(t')| ≤ `jump` + `accel`·|t − t'| for any two times. The law
/// therefore holds over the chords of a curve, and over a corner divided into tiny corners. With limited jerk
/// each axis keeps a stricter law: its speed stays within half of its `jump` of a speed u with
/// |u'| ≤ `accel` and |u''| ≤ `jerk`.
///
/// ```
/// use stepwright_path::{AxisPace, Route};
/// // 80 steps/mm, 200 mm/s, 1,000 mm/s², and a jump of 5 mm/s.
/// let axis = AxisPace::per_unit(80.0, 200.0, 1_000.0, 5.0);
/// let mut route = Route::new([axis; 2])?;
/// let (mut steps, mut time) = ([0, 0], 0.0);
/// for to in [[30.0, 0.0], [30.0, 20.0], [0.0, 0.0]] {
///     route.line_to(to, 100.0)?;
///     // The steps that are final now. More follow when more pieces are known.
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
    /// The end of the last piece, along the route and of each axis.
    pub(crate) length: f64,
    pub(crate) place: [f64; N],
    pub(crate) loose: VecDeque<Loose<N>>,
    /// The chords before the loose pieces, as far as they matter.
    pub(crate) chords: Before<N>,
    pub(crate) cells: VecDeque<Cell<N>>,
    pub(crate) passes: Passes,
    /// The number of cells added since the last plan.
    pub(crate) fresh: usize,
    pub(crate) closed: bool,
    pub(crate) scales: Scales,
    /// When the first cell begins, and the state of the law there.
    pub(crate) time: f64,
    pub(crate) bucket: Bucket<N>,
    /// The motion over the first cell, while it is being made.
    pub(crate) front: Option<[Piece; 3]>,
    /// The position of each axis in steps, and the place of its last step along the route.
    pub(crate) at: [i64; N],
    pub(crate) stepped: [f64; N],
    /// The next step of each axis in the first cell and its place, once they are known.
    pub(crate) next: [Option<Option<(f64, RouteStep)>>; N],
    /// The time of the last step handed out.
    pub(crate) now: f64,
    pub(crate) changes: VecDeque<Order>,
    /// The number of cells to the place of a hold.
    pub(crate) halt: Option<usize>,
    /// The additional state with limited jerk.
    pub(crate) smooth: Option<Box<Smooth<N>>>,
    /// The recorded motion, if it is wanted.
    pub(crate) glides: Option<Glides>,
}

/// The most cells that a route keeps ahead.
const MOST: usize = 65_536;

/// The same with limited jerk, as planning takes longer. No more cells are planned at once.
pub(crate) const MOST_SMOOTH: usize = 8_192;

/// The least number of new cells for which planning again is worthwhile.
const FRESH: usize = 8;

/// The most turns of an arc: 62,832 cells.
const TURNS: f64 = 1_000.0;

/// A piece that moves each axis by less than this part of a step adds nothing.
const TINY: f64 = 1e-6;

/// The shortest part of a cell, relative to its length.
pub(crate) const SLIVER: f64 = 1e-9;

impl<const N: usize> Route<N> {
    /// A route that begins at position 0 of all axes, at rest.
    ///
    /// # Errors
    /// [`Unplannable`] if a number of an axis is not within [`PACES`].
    pub fn new(axes: [AxisPace; N]) -> Result<Route<N>, Unplannable> {
        Route::at(axes, [0.0; N])
    }

    /// A route that begins at this place, at rest: each axis is at the step nearest to it.
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

    /// Limits corners by junction deviation, in units, in place of the jump. Corners are faster, and exceed the
    /// jumps of the axes: the law of speed is not kept.
    ///
    /// # Errors
    /// [`Unplannable::Deviation`] if it is not within [`PACES`].
    pub fn with_deviation(mut self, deviation: f64) -> Result<Route<N>, Unplannable> {
        if !PACES.contains(&deviation) {
            return Err(Unplannable::Deviation);
        }
        self.deviation = Some(deviation);
        Ok(self)
    }

    /// Adds a straight line to a place, at most at `feed` units/s along it, and no faster than the `speed` of
    /// each axis allows, whatever the feed. A line to the present end of the
    /// route adds nothing, nor does a line of less than a millionth of a step of each axis: the next piece
    /// begins where that line begins.
    ///
    /// # Errors
    /// [`Unplannable::Speed`] if `feed` is not within [`PACES`]; [`Unplannable::TooLong`] beyond 2³¹ − 1
    /// steps from 0.
    pub fn line_to(&mut self, to: [f64; N], feed: f64) -> Result<(), Unplannable> {
        self.straight(to, feed, false)
    }

    /// Adds a rapid: a straight line to a place at the highest speed of the axes. Overrides of the ordered
    /// speed ([`scale`](Route::scale)) do not apply to rapids; those of [`scale_rapids`](Route::scale_rapids)
    /// do.
    ///
    /// Returns the speed along the line, in units/s.
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
        // A shorter line has no direction, by rounding.
        if norm(&way) > 1e-12 * norm(&to) && !self.is_tiny(&way) {
            self.add(Shape::line(self.length, self.place, to), feed, rapid)?;
            self.place = to;
        } else if !PACES.contains(&feed) {
            return Err(Unplannable::Speed);
        }
        Ok(())
    }

    /// Adds an arc of two axes by `sweep` radians around a centre, positive from the first axis towards the
    /// second. 2π is a full circle; several turns are allowed. The other axes move by `climb` meanwhile; the
    /// numbers of `climb` for the two axes are not used. The speed along the arc is at most `feed` units/s. As
    /// with a line, an arc of less than a millionth of a step adds nothing.
    ///
    /// # Errors
    /// As for [`line_to`](Route::line_to); [`Unplannable::Axes`] unless `axes` are two axes of the route;
    /// [`Unplannable::Radius`] if the centre is nearer than a step; [`Unplannable::Sweep`] if the sweep is 0 or
    /// more than 1,000 turns.
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
        let mut way = climb;
        (way[axes[0]], way[axes[1]]) = (radius * sweep, radius * sweep);
        if self.is_tiny(&way) {
            return if PACES.contains(&feed) { Ok(()) } else { Err(Unplannable::Speed) };
        }
        let shape = Shape::arc(self.length, self.place, axes, centre, sweep, climb);
        for axis in axes {
            to[axis] = shape.place(axis, shape.end);
        }
        self.add(shape, feed, false)?;
        self.place = to;
        Ok(())
    }

    /// Whether a piece is too short to be one, by its distance on each axis, or by rounding along the route.
    fn is_tiny(&self, way: &[f64; N]) -> bool {
        let tiny = |(way, axis): (&f64, &AxisPace)| way.abs() < TINY * axis.step;
        way.iter().zip(&self.axes).all(tiny) || self.length + norm(way) <= self.length
    }

    /// Says that no piece follows for now: the route comes to rest at its end. Before that the last pieces make
    /// no steps: a short route that is never closed makes none. It continues from there if a
    /// piece is added later.
    pub fn close(&mut self) {
        self.settle_all();
        self.closed = true;
    }

    /// Whether all of the route has been made.
    pub fn is_over(&self) -> bool {
        self.cells.is_empty() && self.loose.is_empty()
    }

    /// The time from the start to the end of the part that has been made, in s, pauses included.
    pub fn time(&self) -> f64 {
        self.time.max(self.now)
    }

    /// The end of the last piece.
    pub fn end(&self) -> [f64; N] {
        self.place
    }

    /// The position of each axis in steps, by the steps handed out.
    pub fn positions(&self) -> [i64; N] {
        self.at
    }

    /// The length of all pieces, in units.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Rests for this many seconds at the end of the route. Pieces that are added later begin after that.
    /// Returns false and does nothing unless the route [is over](Route::is_over): close it and take its steps
    /// before. A negative or not finite number counts as 0.
    pub fn dwell(&mut self, seconds: f64) -> bool {
        if !self.is_over() {
            return false;
        }
        let wait = if seconds.is_finite() { seconds.max(0.0) } else { 0.0 };
        self.stand_for(wait);
        true
    }

    /// Passes the next part of the route without making steps; `None` if nothing is final, as with the steps.
    /// The times are exactly those of the steps: this tells how long a job takes.
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

    /// The first cell, with its times.
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
            rapid: cell.rapid,
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

    /// Enters the first cell if necessary, and returns the time of its end.
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

    /// Plans all known pieces; `None` if nothing of the plan is final.
    fn replan(&mut self) -> Option<()> {
        let count = self.cells.len();
        // With limited jerk planning takes longer.
        let (most, part) =
            if self.smooth.is_some() { (MOST_SMOOTH, count / 4 * 3) } else { (MOST, count / 2) };
        let (full, enough) = (count >= most, self.fresh >= FRESH.max(part));
        if self.cells.is_empty() || !(enough || self.closed || full) {
            return None;
        }
        let planned = self.plan() || self.smooth.is_none();
        let all = self.smooth.is_none() || count <= most;
        if !planned {
            // The plan before continues.
        } else if self.closed && all {
            self.passes.sure = count;
        } else if full {
            let known = if all { count } else { most };
            self.passes.sure = self.passes.sure.max(known / 2);
        }
        (self.passes.sure > 0).then_some(())
    }

    /// Plans. If no plan keeps the law, the plan before stays, and new cells are passed from rest to rest.
    /// Returns whether there is a new plan.
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

    /// Rests for this long, in s.
    pub(crate) fn stand_for(&mut self, wait: f64) {
        self.time += wait;
        match &mut self.smooth {
            Some(smooth) => smooth.wait(wait),
            None => self.bucket.wait(wait, &self.axes),
        }
    }

    /// Removes the first cell, which has been made.
    fn leave(&mut self) {
        let (Some(pieces), Some(cell)) = (self.front.take(), self.cells.pop_front()) else {
            return;
        };
        let end = pieces[2].to;
        if self.smooth.is_some() {
            // By rounding, a part at constant speed may take no time.
            let level = pieces[0].from == pieces[0].to;
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

    /// Removes the first cell without making its steps.
    pub(crate) fn pass(&mut self) {
        if let Some(cell) = self.cells.front() {
            for (axis, at) in self.at.iter_mut().enumerate() {
                let place = cell.shape.place(axis, cell.end) / self.axes[axis].step;
                // Up to half a step away the position is the same.
                if (place - *at as f64).abs() > 0.5 + 1e-6 {
                    *at = place.round() as i64;
                }
            }
        }
        self.leave();
    }

    /// The next step within the first cell, and its place.
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

/// The steps of all axes in the order of their times. After `None` more steps may follow, once pieces are
/// added, or the route is closed or resumed.
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
