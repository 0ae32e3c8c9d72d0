//! A route with limited jerk: its speed is a course over many cells, and what is made of it is
//! cut from that course, cell by cell.
//!
//! A plan is tried with the law of jerk ([`Lens`]) before it is taken. Where it fails, corners within
//! the time in which a jump can be hidden have less acceleration, at last none; then what lies there
//! is passed slower, at last at rest, and planned again.

use std::collections::VecDeque;

use crate::cell::Cell;
use crate::kink::{self, Kink};
use crate::lens::Lens;
use crate::piece::{Moment, Piece};
use crate::ramp::{Limits, Sides};
use crate::route::{AxisPace, Route, SLIVER, SOONEST};
use crate::runs::{Ground, Stop};
use crate::trial::{Past, Tried, clip, walk};
use crate::turning::{self, TURN};

/// Of the limits: what is left is for rounding, and for what is between two looks at the law.
const JUMP: f64 = 0.97;
const JERK: f64 = 0.99;

/// Of the acceleration, for turning at a constant speed.
const CURVE: f64 = 0.95;

/// Parts of the limits that a stop is tried with: where turning, or a corner ahead, leaves too little
/// for the fastest, a gentler one may do.
const GENTLER: [f64; 5] = [1.0, 0.85, 0.7, 0.5, 0.35];

/// Rounds in which what breaks the law is passed slower, and at rest.
const SLOWER: usize = 40;
const AT_REST: usize = 100;

/// Of w, in each.
const BY: f64 = 0.85;

/// Rounds in which corners have this part of the acceleration that they had, before they have none.
const GENTLE: usize = 3;
const LESS: f64 = 0.7;

/// Seconds: √(S/J) of a jump S and a jerk J, at least. The law is looked at in moments of a part of it,
/// so that a smaller jump takes longer and longer to plan. With this one an axis is off the place of u by
/// some J·10⁻¹² s³: 1 nm at 10⁶ mm/s³.
const BRIEF: f64 = 1e-4;

/// What a route with limited jerk has besides.
#[derive(Clone, Debug)]
pub(crate) struct Smooth<const N: usize> {
    jerk: [f64; N],
    /// What the law leaves where the first cell begins, and the moment there.
    past: Past<N>,
    pub here: Moment,
    /// From there on, as it was tried.
    pub course: VecDeque<Piece>,
    tried: Tried<N>,
}

/// The limit of jerk of an axis where any has one.
fn jerk(axis: AxisPace) -> f64 {
    axis.jerk.min(axis.accel / SOONEST)
}

/// The axes as they are planned with: where the jerk of any is limited, none has a smaller jump than by
/// [`BRIEF`].
pub(crate) fn planned_with<const N: usize>(axes: [AxisPace; N]) -> [AxisPace; N] {
    let limited = axes.iter().any(|axis| axis.jerk < f64::INFINITY);
    let least = |axis| if limited { jerk(axis) * BRIEF * BRIEF } else { 0.0 };
    axes.map(|axis| AxisPace { jump: axis.jump.max(least(axis)), ..axis })
}

impl<const N: usize> Smooth<N> {
    /// At rest where the route begins; `None` if no axis has a limit.
    pub fn new(axes: &[AxisPace; N]) -> Option<Smooth<N>> {
        let limited = axes.iter().any(|axis| axis.jerk < f64::INFINITY);
        let jerk = axes.map(jerk);
        let past = Past::new(Lens::new(axes, &jerk));
        let here = Moment::at_rest(0.0, 0.0);
        let tried = Tried::default();
        limited.then(|| Smooth { jerk, past, here, course: VecDeque::new(), tried })
    }

    /// At rest for this long.
    pub fn wait(&mut self, time: f64) {
        self.past.wait(time);
        self.tried = Tried::default();
    }

    /// It ends here, at rest.
    pub fn end(&mut self, s: f64) {
        self.here.s = s;
        self.course.clear();
        self.tried = Tried::default();
    }

    /// The moment at the end of its first cell, and its part of the first piece. That ends where
    /// a piece ends, too: the cell is divided there.
    fn first(&self, cell: &Cell<N>) -> Option<Piece> {
        let piece = self.course.front()?;
        let least = cell.shape.length() * SLIVER;
        let end = if piece.to.s >= cell.end - least { cell.end } else { piece.to.s };
        Some(clip(piece, self.here, end))
    }
}

impl<const N: usize> Route<N> {
    /// What is known of the cells.
    pub(crate) fn ground<'a>(
        &self,
        cells: &'a VecDeque<Cell<N>>,
        jerk: &[f64; N],
    ) -> Ground<'a, N> {
        let count = cells.len();
        let top = |cell: &Cell<N>| cell.top.min(CURVE * cell.turning());
        let mut tops: Vec<f64> = cells.iter().map(top).collect();
        let mut caps = vec![0.0; count + 1];
        caps[0] = f64::INFINITY;
        for n in 1..count {
            caps[n] = (JUMP * JUMP * cells[n].cap).min(tops[n - 1]).min(tops[n]);
        }
        turning::bound(cells, (&mut caps, &mut tops), &self.axes, jerk);
        caps[count] = 0.0;
        let limits = cells.iter().map(|cell| {
            let (_, tilt) = cell.shape.bounds(cell.begin, cell.end);
            let part = if cell.turns() { JERK * TURN } else { JERK };
            let each = jerk.iter().zip(&tilt).map(|(jerk, tilt)| part * jerk / tilt);
            Limits { accel: cell.slope(0.0), jerk: each.fold(f64::INFINITY, f64::min) }
        });
        let limits = limits.collect();
        let kinks = if self.deviation.is_some() {
            vec![[0.0; 2]; count + 1]
        } else {
            kink::kinks(cells, &caps, &self.axes, jerk)
        };
        Ground { cells, caps, tops, limits, kinks }
    }

    /// Plans all cells from the moment at which the first begins. False, and nothing changes, if
    /// that is not possible within the law.
    pub(crate) fn plan_smooth(&mut self) -> bool {
        if self.cells.is_empty() {
            return true;
        }
        let Some(mut smooth) = self.smooth.take() else { return false };
        smooth.here.t = self.time;
        let lens = smooth.past.here();
        let planned = self.planned(&smooth, &lens);
        let done = planned.is_some();
        match planned {
            Some((course, tried, sure)) => {
                smooth.course = course.into();
                smooth.tried = tried;
                self.passes.sure = sure;
            }
            None => self.keep(&mut smooth),
        }
        self.fresh = 0;
        self.smooth = Some(smooth);
        done
    }

    fn planned(&self, smooth: &Smooth<N>, lens: &Lens<N>) -> Option<(Vec<Piece>, Tried<N>, usize)> {
        let mut ground = self.ground(&self.cells, &smooth.jerk);
        let mut tried: Option<Tried<N>> = None;
        for round in 0..SLOWER + AT_REST {
            let course = ground.courses(smooth.here)?;
            let before = tried.as_ref().unwrap_or(&smooth.tried);
            let (now, broken) = self.tried(smooth, before, lens, &course);
            if broken.is_empty() {
                let sure = self.sure(smooth, &course, &ground);
                return Some((course, now, sure));
            }
            tried = Some(now);
            if gentler(&mut ground.kinks, &broken, round) {
                continue;
            }
            let mut slower = false;
            let by = if round < SLOWER { BY } else { 0.0 };
            let mut done = 0;
            for (from, to) in broken {
                for n in from.max(done)..to {
                    if n > 0 {
                        slower |= ground.caps[n] > 0.0;
                        ground.caps[n] *= by;
                    }
                    if round < SLOWER {
                        ground.tops[n] *= by;
                        slower = true;
                    }
                }
                if to < self.cells.len() && to >= done {
                    slower |= ground.caps[to] > 0.0;
                    ground.caps[to] *= by;
                }
                done = done.max(to);
            }
            if !slower {
                return None;
            }
        }
        None
    }

    /// Tries a course, as far as it differs from the one before; nodes from which and to which the
    /// law is broken.
    fn tried(
        &self,
        smooth: &Smooth<N>,
        before: &Tried<N>,
        lens: &Lens<N>,
        course: &[Piece],
    ) -> (Tried<N>, Vec<(usize, usize)>) {
        if self.deviation.is_some() {
            return Default::default();
        }
        let hidden = self.hidden(&smooth.jerk);
        before.again(lens.clone(), &self.cells, (course, smooth.here), hidden)
    }

    /// Seconds in which a jump may be hidden.
    fn hidden(&self, jerk: &[f64; N]) -> f64 {
        let each = self.axes.iter().zip(jerk).map(|(axis, jerk)| 2.0 * (axis.jump / jerk).sqrt());
        each.fold(0.0, f64::max)
    }

    /// Whether what is before the end of a cell, which is come to with an acceleration, is known
    /// without what is behind: where there is none, and at a corner.
    fn parts(&self, n: usize, a: f64) -> bool {
        a.abs() <= STILL * self.cells[n].slope(0.0) || turning::is_corner(&self.cells, n + 1)
    }

    /// Cells from the first on whose course is final, whatever follows: up to a node that is passed
    /// as fast as it may be, without acceleration or at a corner, before anything brakes for the end.
    ///
    /// What follows changes how fast a curve may be passed that is not over yet, so a stop must be
    /// possible before that.
    fn sure(&self, smooth: &Smooth<N>, course: &[Piece], ground: &Ground<N>) -> usize {
        let count = self.cells.len();
        let firm = turning::firm(&self.cells);
        let firm = self.cells.get(firm).map_or(f64::INFINITY, |cell| cell.begin);
        let hidden = self.hidden(&smooth.jerk);
        let caps = &ground.caps;
        let mut back = caps.clone();
        let mut free = 0;
        for n in (1..count).rev() {
            let rise = self.cells[n].least_rise(back[n + 1]);
            if rise < back[n] {
                back[n] = rise;
            } else {
                free = free.max(n);
            }
        }
        // Behind that something brakes for the end, and what is passed slower for the law's sake may
        // be so because of that: as far again before it.
        let end = ground.place(count);
        let far = end - 2.0 * (end - ground.place(free));
        let mut sure = 0;
        walk(&self.cells, course.iter().copied(), smooth.here, |n, part| {
            let end = part.to;
            let there = n < free && end.s >= self.cells[n].end;
            if there && self.parts(n, end.a) && end.v * end.v >= caps[n + 1] * NEAR {
                let limits = ground.limits(n + 1, count);
                let stop = end.s + limits.way(end.v, 0.0) + end.v * hidden;
                if stop <= firm && end.s <= far {
                    sure = n + 1;
                }
            }
        });
        sure
    }

    /// Goes on by the plan before, up to the next corner or node where that has no acceleration:
    /// from there it is planned again. Where that is here and now, at rest, each cell is passed from rest to
    /// rest.
    fn keep(&mut self, smooth: &mut Smooth<N>) {
        let mut sure = 0;
        let mut known = false;
        walk(&self.cells, smooth.course.iter().copied(), smooth.here, |n, part| {
            known |= n < sure;
            if !known && part.to.s >= self.cells[n].end {
                sure = n + 1;
                known = self.parts(n, part.to.a);
            }
        });
        if sure == 0 {
            self.rest_to_rest(smooth);
            sure = self.cells.len();
        }
        self.passes.sure = sure;
    }

    /// A course with a rest at each node.
    fn rest_to_rest(&self, smooth: &mut Smooth<N>) {
        let ground = self.ground(&self.cells, &smooth.jerk);
        let mut here = smooth.here;
        smooth.course.clear();
        smooth.tried = Tried::default();
        for (n, cell) in self.cells.iter().enumerate() {
            let w = ground.tops[n];
            // What turning leaves at the highest speed.
            let accel = ground.limits[n].accel.min(cell.slope(w));
            let limits = Limits { accel, ..ground.limits[n] };
            let begin = Moment::at_rest(here.t, cell.begin);
            let course = Sides::both(limits).over(begin, Moment::at_rest(0.0, cell.end), w.sqrt());
            let course = course.unwrap_or_default();
            here = course.last().map_or(begin, |piece| piece.to);
            smooth.course.extend(course);
        }
    }

    /// The first cell in time.
    pub(crate) fn enter_smooth(&mut self) -> Option<[Piece; 3]> {
        let smooth = self.smooth.as_ref()?;
        let cell = self.cells.front()?;
        let part = smooth.first(cell)?;
        if part.to.s < cell.end {
            // A piece of the course ends within it.
            let behind = cell.part(part.to.s, cell.end);
            let cell = self.cells.front_mut()?;
            (cell.end, cell.last) = (behind.begin, behind.first);
            self.cells.insert(1, behind);
            self.passes.sure += 1;
            self.halt = self.halt.map(|cells| cells + 1);
        }
        let still = |at| Piece { from: at, to: at, jerk: 0.0 };
        let level = part.jerk == 0.0 && part.from.a == 0.0;
        // A constant speed is in the middle.
        let first = if level { still(part.from) } else { part };
        let middle = if level { part } else { still(part.to) };
        Some([first, middle, still(part.to)])
    }

    /// Leaves the first cell behind, or a part of it that ends now.
    pub(crate) fn leave_smooth(&mut self, part: &Piece, cell: &Cell<N>) {
        let Some(smooth) = &mut self.smooth else { return };
        if self.deviation.is_none() {
            smooth.past.pass(&cell.shape, part, &mut smooth.tried);
        }
        smooth.here = part.to;
        let least = cell.shape.length() * SLIVER;
        while smooth.course.front().is_some_and(|piece| piece.to.s <= part.to.s + least) {
            smooth.course.pop_front();
            if let Some(next) = smooth.course.front() {
                smooth.here = Moment { s: part.to.s, ..next.from };
            }
        }
    }

    /// The fastest stop from here that the law allows, and the cells to its end; `None` if it allows
    /// none that begins now. The cell in which it ends is divided.
    pub(crate) fn brake_smooth(&mut self) -> Option<usize> {
        let lens = self.smooth.as_mut()?.past.here();
        let smooth = self.smooth.as_ref()?;
        let ground = self.ground(&self.cells, &smooth.jerk);
        let here = Moment { t: self.time, ..smooth.here };
        let mut found = None;
        for part in GENTLER {
            match ground.stop(here, part) {
                Stop::Found(course, cell) => {
                    let (tried, broken) = self.tried(smooth, &smooth.tried, &lens, &course);
                    if broken.is_empty() {
                        found = Some((course, cell, tried));
                        break;
                    }
                }
                Stop::TooFast => {}
                Stop::Beyond if part < 1.0 => break,
                Stop::Beyond => {
                    // Where the plan does nothing but brake, it stands at its end anyway.
                    let mut ahead = smooth.course.iter().filter(|piece| piece.to.t > piece.from.t);
                    if !ahead.all(|piece| piece.to.v < piece.from.v) {
                        break;
                    }
                    let end = smooth.course.back()?.to.s;
                    let beyond = |cell: &Cell<N>| cell.end > end + cell.shape.length() * SLIVER;
                    let last = self.cells.iter().position(beyond);
                    return Some(last.unwrap_or(self.cells.len()));
                }
            }
        }
        let (course, cell, tried) = found?;
        let end = course.last().map_or(here, |piece| piece.to);
        let known = self.cells.get(cell)?;
        let least = known.shape.length() * SLIVER;
        let mut count = cell + 1;
        if end.s <= known.begin + least {
            count = cell;
        } else if end.s < known.end - least {
            let behind = known.part(end.s, known.end);
            let known = self.cells.get_mut(cell)?;
            (known.end, known.last) = (behind.begin, behind.first);
            self.cells.insert(cell + 1, behind);
        }
        let smooth = self.smooth.as_mut()?;
        (smooth.course, smooth.tried) = (course.into(), tried);
        Some(count)
    }
}

/// Less acceleration at the corners before what breaks the law, but not at the one ahead of it, which comes
/// later; false if they have none.
fn gentler(kinks: &mut [Kink], spans: &[(usize, usize)], round: usize) -> bool {
    let by = if round < GENTLE { LESS } else { 0.0 };
    let (mut done, mut bent) = (0, false);
    for &(from, to) in spans {
        for kink in kinks.iter_mut().take(to).skip(from.max(done)) {
            bent |= *kink != [0.0; 2];
            *kink = kink.map(|accel| by * accel);
        }
        done = done.max(to);
    }
    bent
}

/// Of the acceleration, which is none.
const STILL: f64 = 1e-6;

/// As fast as it may be, but for rounding.
const NEAR: f64 = 1.0 - 1e-6;
