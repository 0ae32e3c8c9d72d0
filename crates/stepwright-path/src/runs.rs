//! The speed over cells with limited jerk: courses from each binding node to the next.
//!
//! ```text
//!   v    ╱▔▔▔▔▔╲          ╱▔▔╲              the acceleration is 0 at a binding node, B, and at
//!       ╱       ╲        ╱    ╲    ╱▔╲      rest; at a corner, C, it jumps; between them it
//!      ╱         ╲__B___╱      ╲C╱    ╲     continues over all other joints
//!    rest  · · ·  · · ·   · · ·  ·  · rest
//! ```
//!
//! A node *binds* if the speed there is fixed. At first two nodes bind, the beginning and the end.
//! [`Sides::over`](crate::ramp::Sides::over) gives the fastest course between two nodes. If the course exceeds
//! the limit of a node, the node with the largest excess binds too, at its limit. A backward and a forward pass
//! over all binding nodes lower the speeds that cannot be reached or left within the limits. This ends when all
//! courses are within their limits, or all nodes bind.

use std::collections::VecDeque;

use crate::beyond::Beyond;
use crate::cell::Cell;
use crate::course::{join, reach, reached};
use crate::kink::Kink;
use crate::piece::{Moment, Piece};
use crate::ramp::{Limits, root};
use crate::span::{Bind, Span, divided};

/// The relative rounding error of w.
pub(crate) const ROUNDED: f64 = 1e-9;

/// If turning leaves less than this part of the acceleration on a straight line, a node binds instead.
const LEAST: f64 = 0.4;

/// The parts of the acceleration at corners that are tried if all of it would make another node bind.
const PARTS: [f64; 3] = [0.75, 0.5, 0.25];

/// The most rounds to find the limits along a stop.
const STOPS: usize = 16;

/// The limits of the cells and of the nodes between them.
pub(crate) struct Ground<'a, const N: usize> {
    pub cells: &'a VecDeque<Cell<N>>,
    /// The largest w at each node, and within each cell.
    pub caps: Vec<f64>,
    pub tops: Vec<f64>,
    /// The limits along each cell, without turning.
    pub limits: Vec<Limits>,
    /// The accelerations with which each node may be reached and left, if it binds.
    pub kinks: Vec<Kink>,
}

/// The result of a search for a course between two binding nodes.
enum Bound {
    None(Vec<Piece>),
    Node(Bind),
    /// The acceleration over a cell must be lowered to this one.
    Accel(usize, f64),
}

/// The result of planning a stop.
pub(crate) enum Stop {
    /// The stop, and the cell in which it ends.
    Found(Vec<Piece>, usize),
    /// The stop would be faster on its way than the axes allow.
    TooFast,
    /// The stop would end after the last cell.
    Beyond,
}

impl<const N: usize> Ground<'_, N> {
    /// The least limits of all cells from one node to another.
    pub fn limits(&self, from: usize, to: usize) -> Limits {
        let none = Limits { accel: f64::INFINITY, jerk: f64::INFINITY };
        self.limits[from..to.max(from + 1).min(self.limits.len())].iter().fold(none, |all, cell| {
            Limits { accel: all.accel.min(cell.accel), jerk: all.jerk.min(cell.jerk) }
        })
    }

    pub fn place(&self, node: usize) -> f64 {
        match self.cells.get(node) {
            Some(cell) => cell.begin,
            None => self.cells.back().map_or(0.0, |cell| cell.end),
        }
    }

    /// The course from a moment to rest at the end. `None` if no course leads there within the limits.
    pub fn courses(&mut self, from: Moment) -> Option<Vec<Piece>> {
        let full = self.limits.clone();
        let courses = self.bound_courses(from, &full);
        self.limits = full;
        courses
    }

    /// The same, lowering the accelerations where courses exceed them. Where another node comes to bind,
    /// its cells get the full accelerations back, as the courses there are slower.
    fn bound_courses(&mut self, from: Moment, full: &[Limits]) -> Option<Vec<Piece>> {
        let count = self.cells.len();
        let mut pieces = Vec::new();
        let (mut begin, mut at) = (from, 0);
        if from.a != 0.0 || from.v * from.v > self.caps[0].min(self.tops[0]) * (1.0 + ROUNDED) {
            (pieces, at) = self.fall(from)?;
            begin = pieces.last().map_or(from, |piece| piece.to);
        }
        let mut binds = vec![
            Bind { node: at, s: begin.s, v: begin.v },
            Bind { node: count, s: self.place(count), v: 0.0 },
        ];
        let mut known: Vec<Option<Vec<Piece>>> = vec![None];
        loop {
            while let Err(n) = self.pass(&mut binds, &mut known, begin) {
                // With fewer cells between two binding nodes the limits may be higher.
                let (from, to) = (binds[n].node, binds[n + 1].node);
                let node = from + (to - from) / 2;
                if node == from {
                    return None;
                }
                binds.insert(n + 1, self.bind(node, f64::INFINITY));
                known.insert(n + 1, None);
            }
            let mut more = false;
            let (mut next, mut courses) = (Vec::with_capacity(binds.len()), Vec::new());
            for (n, pair) in binds.windows(2).enumerate() {
                next.push(pair[0]);
                let mut course = known[n].take();
                if course.is_none() {
                    let begin = (n == 0 && begin.a != 0.0).then_some(begin);
                    match self.course(pair[0], pair[1], begin) {
                        Bound::None(found) => course = Some(found),
                        Bound::Node(bind) => {
                            let cells = pair[0].node..pair[1].node;
                            self.limits[cells.clone()].copy_from_slice(&full[cells]);
                            next.push(bind);
                            courses.push(None);
                            more = true;
                        }
                        Bound::Accel(cell, accel) => {
                            self.limits[cell].accel = accel;
                            more = true;
                        }
                    }
                }
                courses.push(course);
            }
            next.extend(binds.last());
            (binds, known) = (next, courses);
            if !more {
                break;
            }
        }
        let mut time = begin.t;
        for piece in known.into_iter().flatten().flatten() {
            let Piece { mut from, mut to, jerk } = piece;
            let long = to.t - from.t;
            (from.t, to.t) = (time, time + long);
            time += long;
            pieces.push(Piece { from, to, jerk });
        }
        Some(pieces)
    }

    /// Lowers the speeds of binding nodes that cannot be reached or left. Forgets the courses from and to
    /// them. The error is the number of a node that cannot be lowered.
    fn pass(
        &self,
        binds: &mut [Bind],
        known: &mut [Option<Vec<Piece>>],
        begin: Moment,
    ) -> Result<(), usize> {
        for n in (1..binds.len().saturating_sub(1)).rev() {
            if known[n].is_some() {
                continue;
            }
            let [here, there] = [binds[n], binds[n + 1]];
            let limits = self.limits(here.node, there.node);
            if here.v > there.v && limits.way(here.v, there.v) > there.s - here.s {
                binds[n].v = limits.rise(there.v, there.s - here.s);
                (known[n - 1], known[n]) = (None, None);
            }
        }
        for n in 0..binds.len() - 1 {
            if known[n].is_some() {
                continue;
            }
            let [here, there] = [binds[n], binds[n + 1]];
            let limits = self.limits(here.node, there.node);
            let way = there.s - here.s;
            let v = if n == 0 && begin.a != 0.0 {
                arrive(begin, there.s, there.v, &limits.with(begin.a)).ok_or(n)?
            } else if n == 0 && here.v > there.v {
                // The speed at the beginning is given.
                if limits.way(here.v, there.v) > way * (1.0 + ROUNDED) {
                    return Err(n);
                }
                there.v
            } else if there.v > here.v && limits.way(here.v, there.v) > way {
                limits.rise(here.v, way)
            } else {
                there.v
            };
            if v < there.v {
                if n + 2 == binds.len() {
                    return Err(n);
                }
                binds[n + 1].v = v;
                (known[n], known[n + 1]) = (None, None);
            }
        }
        Ok(())
    }

    /// The course from one binding node to the next, or what binds in between. At its ends it has as much
    /// acceleration as the corners allow without making another node bind.
    fn course(&self, from: Bind, to: Bind, begin: Option<Moment>) -> Bound {
        let none = |found: &Bound| matches!(found, Bound::None(_));
        let kinks = [self.kinks[from.node][1], self.kinks[to.node][0]];
        if kinks == [0.0; 2] {
            return self.bound(from, to, begin, kinks);
        }
        let part = |part: f64| self.bound(from, to, begin, kinks.map(|accel| part * accel));
        let most = part(1.0);
        if none(&most) {
            return most;
        }
        let least = part(0.0);
        if !none(&least) {
            return least;
        }
        PARTS.into_iter().map(part).find(none).unwrap_or(least)
    }

    /// The same with these accelerations at both ends, or less if the distance is too short.
    fn bound(&self, from: Bind, to: Bind, begin: Option<Moment>, kinks: Kink) -> Bound {
        let span = Span { from, to, begin, kinks };
        let cells = self.cells(&span);
        let mut top = self.tops[cells.clone()].iter().copied().fold(0.0, f64::max).sqrt();
        loop {
            let pieces = self.fastest(&span, top);
            match self.beyond(cells.clone(), &pieces, top) {
                Some(Beyond::Top(most)) => top = most,
                Some(Beyond::Node(node, v)) => return Bound::Node(self.bind(node, v)),
                Some(Beyond::Accel(cell, accel)) => {
                    let node = if cell > from.node { cell } else { cell + 1 };
                    let splits = node > from.node && node < to.node;
                    if splits && (begin.is_some() || accel < LEAST * self.cells[cell].slope(0.0)) {
                        return Bound::Node(self.bind(node, speed(&pieces, self.place(node))));
                    }
                    if begin.is_none() {
                        return Bound::Accel(cell, accel);
                    }
                    // Kept as it is: the check against the law decides.
                    return Bound::None(pieces);
                }
                None => return Bound::None(pieces),
            }
        }
    }

    fn bind(&self, node: usize, v: f64) -> Bind {
        Bind { node, s: self.place(node), v: v.min(self.caps[node].sqrt()) }
    }

    /// Whether these pieces are nowhere faster than the axes allow, up to the cell in which they end. The
    /// ordered speed may be exceeded.
    fn allowed(&self, pieces: &[Piece], last: usize) -> bool {
        let Some(first) = pieces.first() else { return true };
        if pieces.iter().any(|piece| piece.to.v < 0.0) {
            return false;
        }
        let mut here = first.from.v;
        let mut n = 0;
        self.cells.iter().take(last + 1).all(|cell| {
            let begin = here;
            let mut most = here;
            while n + 1 < pieces.len() && pieces[n].to.s < cell.end {
                most = most.max(pieces[n].to.v);
                n += 1;
            }
            let piece = &pieces[n];
            here =
                if cell.end >= piece.to.s { piece.to.v } else { piece.at(piece.time(cell.end)).v };
            most = most.max(here);
            let joint = cell.begin <= first.from.s || begin * begin <= cell.cap * (1.0 + ROUNDED);
            joint && most * most <= cell.most * (1.0 + ROUNDED)
        })
    }

    /// The limits along the first cells that turning leaves, at the highest speed from this moment on.
    fn falling(&self, from: Moment, cells: usize) -> Limits {
        let all = self.limits(0, cells);
        let v = from.v + from.a.max(0.0).powi(2) / 2.0 / all.jerk;
        let slopes = self.cells.iter().take(cells).map(|cell| cell.slope(v * v));
        Limits { accel: slopes.fold(all.accel, f64::min), ..all }.with(from.a)
    }

    /// Ends a positive acceleration by the jerk of the cells on the way. `None` if the last cell ends before.
    fn ease(&self, from: Moment) -> Option<Piece> {
        let mut last = 1;
        loop {
            let jerk = self.limits(0, last).jerk;
            let to = Moment { a: 0.0, ..from.after(-jerk, from.a / jerk) };
            let cell = self.cells.iter().position(|cell| cell.end > to.s)?;
            if cell < last {
                return Some(Piece { from, to, jerk: -jerk });
            }
            last = cell + 1;
        }
    }

    /// A stop with a part of the limits: the fastest one with `part` 1.
    pub fn stop(&self, from: Moment, part: f64) -> Stop {
        let mut first = None;
        if from.a > 0.0 {
            first = self.ease(from);
            if first.is_none() {
                return Stop::Beyond;
            }
        }
        let begin = first.map_or(from, |piece| piece.to);
        let mut pieces = Vec::new();
        let mut known = f64::INFINITY;
        for _ in 0..STOPS {
            let limits = self.slowing(begin, &pieces);
            pieces.clear();
            pieces.extend(first);
            let limits =
                Limits { accel: part * limits.accel, jerk: part * limits.jerk }.with(begin.a);
            pieces.extend(divided(join(begin, &reach(begin, 0.0, &limits.pace()), 0.0)));
            let end = pieces.last().map_or(from, |piece| piece.to);
            let Some(cell) = self.cells.iter().position(|cell| cell.end > end.s) else {
                return Stop::Beyond;
            };
            // Done once the limits are those of the stop's own way.
            if (end.s - known).abs() <= ROUNDED * (end.s - from.s) {
                let allowed = self.allowed(&pieces, cell);
                return if allowed { Stop::Found(pieces, cell) } else { Stop::TooFast };
            }
            known = end.s;
        }
        Stop::TooFast
    }

    /// The limits that turning leaves to a stop, at the speeds of the stop before. Turning counts as on a
    /// circle, as the stop is checked against the law afterwards.
    fn slowing(&self, from: Moment, pieces: &[Piece]) -> Limits {
        let end = pieces.last().map_or(from.s, |piece| piece.to.s);
        let cells = self.cells.iter().take_while(|cell| cell.begin <= end).count().max(1);
        let all = self.limits(0, cells);
        let slope = |cell: &Cell<N>| {
            let v = if cell.begin > from.s { speed(pieces, cell.begin) } else { from.v };
            cell.tangent(v * v)
        };
        let each = self.cells.iter().take(cells).map(slope);
        Limits { accel: each.fold(all.accel, f64::min), ..all }
    }

    /// Slows down from a speed or acceleration beyond the present limits. Returns the pieces, and the cell in
    /// which the limits are reached.
    fn fall(&self, from: Moment) -> Option<(Vec<Piece>, usize)> {
        let least = from.v + from.a.max(0.0).powi(2) / 2.0 / self.limits(0, 1).jerk;
        let top = self.tops[0];
        if least * least <= top * (1.0 + ROUNDED) {
            return Some((Vec::new(), 0));
        }
        let mut v = top.sqrt();
        let mut last = 1;
        for _ in 0..64 {
            let limits = self.falling(from, last);
            let pieces = divided(join(from, &reach(from, v, &limits.pace()), v));
            let end = pieces.last().map_or(from, |piece| piece.to);
            let cell = self.cells.iter().position(|cell| cell.end > end.s)?;
            let tops = self.tops[..=cell].iter();
            let slower = tops.chain(&self.caps[1..=cell]).copied().fold(v * v, f64::min).sqrt();
            if slower >= v && last > cell {
                return self.allowed(&pieces, cell).then_some((pieces, cell));
            }
            (v, last) = (slower.min(v), last.max(cell + 1));
        }
        None
    }
}

/// The speed of a course at a place.
fn speed(pieces: &[Piece], s: f64) -> f64 {
    let piece = pieces.iter().find(|piece| piece.to.s >= s).or(pieces.last());
    piece.map_or(0.0, |piece| piece.at(piece.time(s)).v)
}

/// The highest speed, at most `v`, that can be reached without acceleration at place `s`.
fn arrive(from: Moment, s: f64, v: f64, limits: &Limits) -> Option<f64> {
    if from.v + from.a.min(0.0) * -from.a.min(0.0) / 2.0 / limits.jerk < 0.0 {
        // The speed would become negative before the acceleration has ended.
        return None;
    }
    let pace = limits.pace();
    if reached(from, v, &pace) <= s + ROUNDED * (s - from.s) {
        return Some(v);
    }
    // The speed that is reached if the acceleration only ends.
    let free = (from.v + from.a * from.a.abs() / 2.0 / limits.jerk).max(0.0);
    if free >= v || reached(from, free, &pace) > s {
        return None;
    }
    Some(root(free, v, |v| reached(from, v, &pace) - s))
}
