//! Checks a course against the law of jerk ([`Lens`]). Only the parts that differ from the course before are
//! checked again.
//!
//! ```text
//!   course before  ├──┼──┼──┼──┼──┼──┼──┼──┼──┼──┤     · marks: the state of the law there
//!                     ·        ·        ·        ·
//!   course now     ├──┼──┼──┼─┼─┼─┼──┼──┼──┼──┼──┤
//!                  the same │ checked  │ the same
//! ```
//!
//! Parts before the first difference are not checked. After the last difference the check goes on until the
//! law's set contains the set at a mark of the course before: a course that keeps the law from the smaller
//! set keeps it from the larger one.

use std::collections::VecDeque;

use crate::cell::Cell;
use crate::lens::Lens;
use crate::piece::{Moment, Piece};
use crate::route::SLIVER;
use crate::shape::Shape;

/// The number of parts from one mark to the next.
const EVERY: usize = 8;

/// The relative difference below which speeds and times count as equal.
const SAME: f64 = 1e-9;

/// Calls `with` for each cell and each part of a course within the cell.
pub(crate) fn walk<const N: usize>(
    cells: &VecDeque<Cell<N>>,
    course: impl IntoIterator<Item = Piece>,
    mut here: Moment,
    mut with: impl FnMut(usize, &Piece),
) {
    let mut course = course.into_iter().peekable();
    for (n, cell) in cells.iter().enumerate() {
        let least = cell.shape.length() * SLIVER;
        while let Some(piece) = course.peek() {
            let last = piece.to.s >= cell.end - least;
            let end = if last { cell.end } else { piece.to.s };
            let part = clip(piece, here, end);
            with(n, &part);
            here = part.to;
            if piece.to.s <= cell.end + least {
                course.next();
                if let Some(next) = course.peek() {
                    here = Moment { s: here.s, ..next.from };
                }
            }
            if last {
                break;
            }
        }
    }
}

/// The part of a piece from one of its moments to the place `end`.
pub(crate) fn clip(piece: &Piece, from: Moment, end: f64) -> Piece {
    let mut to = if end >= piece.to.s { piece.to } else { piece.at(piece.time(end)) };
    to.s = end;
    to.t = to.t.max(from.t);
    Piece { from, to, jerk: piece.jerk }
}

/// Follows a part. Returns false if the law is broken; the set is then the largest possible at that speed.
fn follow<const N: usize>(lens: &mut Lens<N>, shape: &Shape<N>, part: &Piece) -> bool {
    let kept = lens.follow(shape, part).is_ok();
    if !kept {
        lens.forget(&shape.direction(part.to.s).map(|way| way * part.to.v));
    }
    kept
}

/// The state of the law where the route is now.
#[derive(Clone, Debug)]
pub(crate) struct Past<const N: usize> {
    /// The state at some place, and the parts made since.
    lens: Lens<N>,
    behind: Vec<(Shape<N>, Piece)>,
}

impl<const N: usize> Past<N> {
    pub fn new(lens: Lens<N>) -> Past<N> {
        Past { lens, behind: Vec::new() }
    }

    fn catch_up(&mut self) {
        for (shape, part) in self.behind.drain(..) {
            // These parts were checked before.
            follow(&mut self.lens, &shape, &part);
        }
    }

    /// The state of the law for a plan from here on.
    pub fn here(&mut self) -> Lens<N> {
        self.catch_up();
        self.lens.planned()
    }

    /// Notes a rest of this time, in s.
    pub fn wait(&mut self, time: f64) {
        self.catch_up();
        self.lens.wait(time);
    }

    /// Notes that this part of a checked course was made.
    pub fn pass(&mut self, shape: &Shape<N>, part: &Piece, tried: &mut Tried<N>) {
        self.behind.push((*shape, *part));
        if let Some(lens) = tried.pass(part.to.s) {
            // A plan has a smaller set than the one that is made.
            self.lens = lens.made();
            self.behind.clear();
        } else if self.behind.len() > 4 * EVERY {
            self.catch_up();
        }
    }
}

/// A checked course.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tried<const N: usize> {
    /// The parts from where the route is now, and the number of parts before.
    parts: VecDeque<Piece>,
    gone: usize,
    /// The states of the law before the parts with these numbers, and the numbers of parts that break it.
    marks: VecDeque<(usize, Lens<N>)>,
    broken: VecDeque<usize>,
}

impl<const N: usize> Tried<N> {
    /// Notes that the course was made up to this place. Returns the state of the law there, if it is known.
    fn pass(&mut self, s: f64) -> Option<Lens<N>> {
        let mut end = None;
        while self.parts.front().is_some_and(|part| part.to.s <= s) {
            end = self.parts.pop_front().map(|part| part.to.s);
            self.gone += 1;
        }
        while self.broken.front().is_some_and(|part| *part < self.gone) {
            self.broken.pop_front();
        }
        let mut left = None;
        while self.marks.front().is_some_and(|mark| mark.0 <= self.gone) {
            left = self.marks.pop_front();
        }
        left.filter(|(part, _)| *part == self.gone && end == Some(s)).map(|(_, lens)| lens)
    }

    /// Checks a course that begins at `here` with the state `lens`. Returns the checked course, and a range of
    /// cells for each part that breaks the law: from the first cell passed within the time `hidden` before
    /// that part to the cell of the part.
    pub fn again(
        &self,
        lens: Lens<N>,
        cells: &VecDeque<Cell<N>>,
        (course, here): (&[Piece], Moment),
        hidden: f64,
    ) -> (Tried<N>, Vec<(usize, usize)>) {
        let mut now = Tried::default();
        let mut spans = Vec::new();
        let mut begun = Vec::with_capacity(cells.len());
        let mut before = Before { tried: self, part: 0, mark: 0 };
        // The parts since the last mark, as long as the course is the same as before.
        let mut same = Some(Vec::with_capacity(EVERY));
        let (mut lens, mut since) = (lens, 0);
        walk(cells, course.iter().copied(), here, |n, part| {
            if n >= begun.len() {
                begun.resize(n + 1, part.from.t);
            }
            now.parts.push_back(*part);
            let next = now.parts.len();
            let kept;
            if let Some(parts) = same.as_mut().filter(|_| before.has(part)) {
                kept = !before.breaks();
                before.part += 1;
                if let Some(mark) = before.mark() {
                    lens.clone_from(mark);
                    now.marks.push_back((next, mark.clone()));
                    parts.clear();
                } else {
                    parts.push((n, *part));
                }
            } else {
                for (n, part) in same.take().into_iter().flatten() {
                    follow(&mut lens, &cells[n].shape, &part);
                }
                kept = follow(&mut lens, &cells[n].shape, part);
                since += 1;
                before.seek(part);
                if before.has(part) {
                    before.part += 1;
                    let breaks = before.breaks_later();
                    // With a larger set a part may keep the law that broke it with a smaller set.
                    let enough = |mark: &&Lens<N>| {
                        kept && lens.contains(mark) && (!breaks || mark.contains(&lens))
                    };
                    if let Some(mark) = before.mark().filter(enough) {
                        lens.clone_from(mark);
                        since = EVERY;
                        same = Some(Vec::with_capacity(EVERY));
                    }
                }
                if since >= EVERY {
                    now.marks.push_back((next, lens.clone()));
                    since = 0;
                }
            }
            if !kept {
                now.broken.push_back(next - 1);
                let since = begun.iter().rposition(|t| *t < part.from.t - hidden);
                spans.push((since.map_or(0, |n| n + 1).min(n), n + 1));
            }
        });
        (now, spans)
    }
}

/// A place in the course before.
struct Before<'a, const N: usize> {
    tried: &'a Tried<N>,
    /// The numbers of parts and of marks before the place.
    part: usize,
    mark: usize,
}

impl<const N: usize> Before<'_, N> {
    /// Moves to the part that ends where this one ends, or after it.
    fn seek(&mut self, part: &Piece) {
        let parts = &self.tried.parts;
        while parts.get(self.part).is_some_and(|known| known.to.s < part.to.s) {
            self.part += 1;
        }
    }

    /// Whether the next part equals this one.
    fn has(&self, part: &Piece) -> bool {
        let Some(known) = self.tried.parts.get(self.part) else { return false };
        let near = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs();
        let (from, to) = (known.from, known.to);
        (from.s, to.s, known.jerk) == (part.from.s, part.to.s, part.jerk)
            && near(from.v, part.from.v)
            && near(to.v, part.to.v)
            && near(to.t - from.t, part.to.t - part.from.t)
    }

    /// Whether the next part broke the law.
    fn breaks(&self) -> bool {
        self.tried.broken.binary_search(&(self.tried.gone + self.part)).is_ok()
    }

    /// Whether the next or a later part broke the law.
    fn breaks_later(&self) -> bool {
        self.tried.broken.back().is_some_and(|part| *part >= self.tried.gone + self.part)
    }

    /// The state of the law before the next part, if there is a mark.
    fn mark(&mut self) -> Option<&Lens<N>> {
        let number = self.tried.gone + self.part;
        let marks = &self.tried.marks;
        while marks.get(self.mark).is_some_and(|mark| mark.0 < number) {
            self.mark += 1;
        }
        marks.get(self.mark).filter(|mark| mark.0 == number).map(|mark| &mark.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AxisPace, Route};

    const AXIS: AxisPace =
        AxisPace { step: 0.0125, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: 10_000.0 };

    /// Waves of chords, whose speed is limited everywhere.
    fn route() -> Route<2> {
        let mut route = Route::new([AXIS; 2]).unwrap();
        for n in 1..=3_000 {
            let x = 0.1 * f64::from(n);
            let to = [x, (3.0 + (x / 50.0).sin()) * (x / 2.0).sin()];
            route.line_to(to, 100.0).unwrap();
        }
        route.close();
        route
    }

    /// A course over the route from rest, with the w that `tops` makes from the limit of each cell.
    fn course(route: &Route<2>, tops: impl Fn(usize, f64) -> f64) -> Vec<Piece> {
        let mut ground = route.ground(&route.cells, &[AXIS.jerk; 2]);
        for n in 0..route.cells.len() {
            ground.tops[n] = tops(n, ground.tops[n]);
            ground.caps[n + 1] = ground.caps[n + 1].min(ground.tops[n]);
            ground.caps[n] = ground.caps[n].min(ground.tops[n]);
        }
        ground.courses(Moment::at_rest(0.0, 0.0)).unwrap()
    }

    /// A check beside a course before finds the same as a check from the start: for courses that are equal up
    /// to a place, after one, or everywhere, and that broke the law at other places.
    #[test]
    fn what_is_not_tried_again_is_as_before() {
        let route = route();
        let cells = &route.cells;
        // The jump is smaller than the one that the course was planned for.
        let axis = AxisPace { jump: 3.0, ..AXIS };
        let lens = Lens::new(&[axis; 2], &[axis.jerk; 2]);
        let again = |before: &Tried<2>, course: &[Piece]| {
            before.again(lens.clone(), cells, (course, Moment::at_rest(0.0, 0.0)), 0.05)
        };
        let slow = |from: usize, to: usize, by: f64| {
            move |n: usize, top: f64| if (from..to).contains(&n) { top * by } else { top }
        };
        let most = |_, top: f64| top;
        let mut broken = 0;
        // The law is broken a little after the difference.
        let near = (100..2_900).step_by(300).flat_map(|n| {
            let here = course(&route, slow(n, n + 12, 0.2));
            [(course(&route, most), here.clone()), (here, course(&route, most))]
        });
        let far = [
            (course(&route, most), course(&route, most)),
            (course(&route, most), course(&route, slow(1_000, 1_200, 0.5))),
            (course(&route, slow(1_000, 1_200, 0.5)), course(&route, most)),
            (course(&route, slow(0, 100, 0.2)), course(&route, slow(2_900, 3_000, 0.2))),
            (course(&route, slow(0, 3_000, 0.1)), course(&route, slow(1_500, 1_510, 0.3))),
        ];
        for (first, then) in near.chain(far) {
            let (known, spans) = again(&Tried::default(), &first);
            let (new, found) = again(&Tried::default(), &then);
            let (both, same) = again(&known, &then);
            assert_eq!(found, same);
            assert_eq!((new.parts.len(), &new.broken), (both.parts.len(), &both.broken));
            broken += spans.len() + found.len();
        }
        assert!(broken > 20, "{broken}");
    }

    /// The state of the law where the route is now comes from the plan's marks.
    #[test]
    fn what_was_made_is_known_from_the_plan() {
        let mut route = route();
        let lens = Lens::new(&[AXIS; 2], &[AXIS.jerk; 2]);
        let mut past = Past::new(lens);
        let course = course(&route, |_, top: f64| top / 16.0);
        let at_rest = Moment::at_rest(0.0, 0.0);
        let (mut tried, broken) =
            Tried::default().again(past.here(), &route.cells, (&course, at_rest), 0.05);
        assert_eq!(broken, []);
        let cells = std::mem::take(&mut route.cells);
        let mut parts = Vec::new();
        walk(&cells, course, at_rest, |n, part| parts.push((n, *part)));
        let mut known = 0;
        for (made, (n, part)) in parts.iter().enumerate() {
            past.pass(&cells[*n].shape, part, &mut tried);
            known += usize::from(past.behind.is_empty());
            if made % 100 == 50 {
                let mut lens = past.clone().here();
                let ahead = parts[made + 1..].iter().take(100);
                assert!(ahead.clone().all(|(n, part)| follow(&mut lens, &cells[*n].shape, part)));
            }
        }
        assert!(known > 300 && tried.parts.is_empty() && tried.marks.is_empty(), "{known}");
    }
}
