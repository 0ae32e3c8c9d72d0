//! A route with limited jerk: its speed is a course over many cells. The moves are cut from the course, cell
//! by cell.
//!
//! Each plan is checked against the law of jerk ([`Lens`]) before it is used. Where it breaks the law, the
//! corners before that place get less acceleration, in the end none, if they are within the time in which a
//! jump can be hidden. If that does not help, the place is passed slower, in the end at rest. Each time the
//! route is planned again.

use std::collections::VecDeque;

use crate::cell::Cell;
use crate::kink::{self, Kink};
use crate::lens::Lens;
use crate::piece::{Moment, Piece};
use crate::ramp::{Limits, Sides};
use crate::route::{AxisPace, MOST_SMOOTH, Route, SLIVER, SOONEST};
use crate::runs::{Ground, Stop};
use crate::trial::{Past, Tried, clip, walk};
use crate::turning::{self, TURN};

/// The part of the jump and the jerk that a plan uses. The rest is for rounding, and for the time between
/// two samples of the law.
const JUMP: f64 = 0.97;
const JERK: f64 = 0.99;

/// The part of the acceleration that turning at a constant speed uses.
const CURVE: f64 = 0.95;

/// The parts of the limits with which a stop is tried. Where turning or a corner ahead leaves too little for
/// the fastest stop, a gentler one may be possible.
const GENTLER: [f64; 5] = [1.0, 0.85, 0.7, 0.5, 0.35];

/// The number of rounds in which places that break the law are passed slower, and then at rest.
const SLOWER: usize = 40;
const AT_REST: usize = 100;

/// The factor of w in each of these rounds.
const BY: f64 = 0.85;

/// The number of rounds in which corners get this factor of acceleration, before they get none.
const GENTLE: usize = 3;
const LESS: f64 = 0.7;

/// The least √(S/J) of a jump S and a jerk J, in s. The law is sampled at a fraction of this time, so a
/// smaller jump would take ever longer to plan. At this value the position of an axis deviates from that of u
/// by some J·10⁻¹² s³: 1 nm at 10⁶ mm/s³.
const BRIEF: f64 = 1e-4;

/// The additional state of a route with limited jerk.
#[derive(Clone, Debug)]
pub(crate) struct Smooth<const N: usize> {
    jerk: [f64; N],
    /// The state of the law at the beginning of the first cell, and the moment there.
    past: Past<N>,
    pub here: Moment,
    /// The course from there on, as it was checked.
    pub course: VecDeque<Piece>,
    tried: Tried<N>,
}

/// The jerk of an axis, if any axis of the route has a limit.
fn jerk(axis: AxisPace) -> f64 {
    axis.jerk.min(axis.accel / SOONEST)
}

/// The axes as the planner uses them: if the jerk of any axis is limited, no jump is smaller than [`BRIEF`]
/// allows.
pub(crate) fn planned_with<const N: usize>(axes: [AxisPace; N]) -> [AxisPace; N] {
    let limited = axes.iter().any(|axis| axis.jerk < f64::INFINITY);
    let least = |axis| if limited { jerk(axis) * BRIEF * BRIEF } else { 0.0 };
    axes.map(|axis| AxisPace { jump: axis.jump.max(least(axis)), ..axis })
}

impl<const N: usize> Smooth<N> {
    /// The state at rest at the beginning of the route; `None` if no axis has a limit of jerk.
    pub fn new(axes: &[AxisPace; N]) -> Option<Smooth<N>> {
        let limited = axes.iter().any(|axis| axis.jerk < f64::INFINITY);
        let jerk = axes.map(jerk);
        let past = Past::new(Lens::new(axes, &jerk));
        let here = Moment::at_rest(0.0, 0.0);
        let tried = Tried::default();
        limited.then(|| Smooth { jerk, past, here, course: VecDeque::new(), tried })
    }

    /// Notes that the route rests for this time, in s.
    pub fn wait(&mut self, time: f64) {
        self.past.wait(time);
        self.tried = Tried::default();
    }

    /// Notes that the route ends here, at rest.
    pub fn end(&mut self, s: f64) {
        self.here.s = s;
        self.course.clear();
        self.tried = Tried::default();
    }

    /// The part of the first piece within the first cell. It ends where the cell or the piece ends; in the
    /// second case the cell is divided there.
    fn first(&self, cell: &Cell<N>) -> Option<Piece> {
        let piece = self.course.front()?;
        let least = cell.shape.length() * SLIVER;
        let end = if piece.to.s >= cell.end - least { cell.end } else { piece.to.s };
        Some(clip(piece, self.here, end))
    }
}

impl<const N: usize> Route<N> {
    /// The limits of these cells and their nodes.
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

    /// Plans the cells to rest, [`MOST_SMOOTH`] at most, beginning at the moment of the first. Returns false if
    /// no plan keeps the law; the plan before stays then.
    pub(crate) fn plan_smooth(&mut self) -> bool {
        if self.cells.is_empty() {
            return true;
        }
        let Some(mut smooth) = self.smooth.take() else { return false };
        let behind = self.cells.split_off(self.cells.len().min(MOST_SMOOTH));
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
        self.fresh = behind.len();
        self.cells.extend(behind);
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

    /// Checks a course as far as it differs from the one before. Returns the result, and pairs of nodes between
    /// which the law is broken.
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

    /// The time in which a jump may be hidden, in s.
    fn hidden(&self, jerk: &[f64; N]) -> f64 {
        let each = self.axes.iter().zip(jerk).map(|(axis, jerk)| 2.0 * (axis.jump / jerk).sqrt());
        each.fold(0.0, f64::max)
    }

    /// Whether the end of cell `n`, reached with the acceleration `a`, separates the course before from what
    /// follows: at a corner, and without acceleration.
    fn parts(&self, n: usize, a: f64) -> bool {
        a.abs() <= STILL * self.cells[n].slope(0.0) || turning::is_corner(&self.cells, n + 1)
    }

    /// The number of cells from the first on whose course is final, whatever pieces are added. They end at a
    /// node that is passed at its highest speed, without acceleration or at a corner, before the route begins
    /// to brake for its end.
    ///
    /// Pieces to come may change the speed limit of a curve that has not ended yet, so a stop must be possible
    /// before that curve.
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
        // After this place the route brakes for its end. Braking may lower the speed before it, for the law's
        // sake: by as long a distance again.
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

    /// Continues with the plan before, up to the next corner or node without acceleration: the route is planned
    /// again from there. If there is no such node because the route is at rest here, each cell is passed from
    /// rest to rest.
    fn keep(&mut self, smooth: &mut Smooth<N>) {
        let mut sure = 0;
        let mut known = false;
        walk(&self.cells, smooth.course.iter().copied(), smooth.here, |n, part| {
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

    /// Makes a course with a rest at each node.
    fn rest_to_rest(&self, smooth: &mut Smooth<N>) {
        let ground = self.ground(&self.cells, &smooth.jerk);
        let mut here = smooth.here;
        smooth.course.clear();
        smooth.tried = Tried::default();
        for (n, cell) in self.cells.iter().enumerate() {
            let w = ground.tops[n];
            // The acceleration that turning leaves at the highest speed.
            let accel = ground.limits[n].accel.min(cell.slope(w));
            let limits = Limits { accel, ..ground.limits[n] };
            let begin = Moment::at_rest(here.t, cell.begin);
            let course = Sides::both(limits).over(begin, Moment::at_rest(0.0, cell.end), w.sqrt());
            let course = course.unwrap_or_default();
            here = course.last().map_or(begin, |piece| piece.to);
            smooth.course.extend(course);
        }
    }

    /// The course of the first cell, as speeding up, constant speed and slowing down.
    pub(crate) fn enter_smooth(&mut self) -> Option<[Piece; 3]> {
        let smooth = self.smooth.as_ref()?;
        let cell = self.cells.front()?;
        let part = smooth.first(cell)?;
        if part.to.s < cell.end {
            // A piece of the course ends within the cell.
            let behind = cell.part(part.to.s, cell.end);
            let cell = self.cells.front_mut()?;
            (cell.end, cell.last) = (behind.begin, behind.first);
            self.cells.insert(1, behind);
            self.passes.sure += 1;
            self.halt = self.halt.map(|cells| cells + 1);
        }
        let still = |at| Piece { from: at, to: at, jerk: 0.0 };
        let level = part.jerk == 0.0 && part.from.a == 0.0;
        // A constant speed is the middle part.
        let first = if level { still(part.from) } else { part };
        let middle = if level { part } else { still(part.to) };
        Some([first, middle, still(part.to)])
    }

    /// Removes the first cell, or the part of it that ends now.
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

    /// Plans the fastest stop from here that the law allows. Returns the number of cells up to its end; the
    /// cell in which it ends is divided. `None` if the law allows no stop that begins now.
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
                    // If the present plan only brakes, it comes to rest at its end anyway.
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

/// Lowers the acceleration at the corners before places that break the law. The corner right after such a
/// place keeps it. Returns false if these corners have no acceleration.
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

/// The part of the acceleration that counts as none.
const STILL: f64 = 1e-6;

/// The part of w that counts as the highest speed.
const NEAR: f64 = 1.0 - 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    /// An arc of many turns is added at once. No more of its cells are planned at once than of any other path.
    #[test]
    fn a_part_of_a_long_arc_is_planned_ahead() {
        let axis =
            AxisPace { step: 0.0125, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: 10_000.0 };
        let mut route = Route::new([axis; 2]).unwrap();
        let turns = 200.0;
        route.arc([0, 1], [2.0, 0.0], turns * std::f64::consts::TAU, [0.0; 2], 30.0).unwrap();
        route.close();
        assert!(route.enter().is_some() && route.cells.len() > MOST_SMOOTH + 1_000);
        let end = route.smooth.as_ref().and_then(|smooth| smooth.course.back()).unwrap().to;
        let place = route.cells[MOST_SMOOTH - 1].end;
        assert!(end.v == 0.0 && (end.s - place).abs() < 1e-6, "{} {place}", end.s);
        while route.pass_over().is_some() {}
        // It does not brake where a plan ended.
        let time = route.length() / 30.0;
        assert!(route.is_over() && route.time() < time + 0.12, "{} {time}", route.time());
    }
}
