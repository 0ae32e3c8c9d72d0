//! The speed over cells with limited jerk: courses from one node that binds to the next.
//!
//! ```text
//!   v    ╱▔▔▔▔▔╲          ╱▔▔╲              the acceleration is 0 where a node binds: at B, and
//!       ╱       ╲        ╱    ╲    ╱▔╲      at rest; at a corner, C, it jumps; in between it
//!      ╱         ╲__B___╱      ╲C╱    ╲     goes on over whatever joints there are
//!    rest  · · ·  · · ·   · · ·  ·  · rest
//! ```
//!
//! First there are two of them, the beginning and the end. The fastest course between two is
//! known ([`Limits::over`]). Where it is beyond what a node allows, the node at which it is most so
//! binds too, at its speed; or at less, where that can't be risen to or fallen from within the
//! limits, for which there is a pass back and a pass on over what binds. This ends when all
//! courses are allowed, or all nodes bind.

use std::collections::VecDeque;

use crate::beyond::Beyond;
use crate::cell::Cell;
use crate::course::{join, reach, reached};
use crate::kink::Kink;
use crate::piece::{Moment, Piece};
use crate::ramp::{Limits, root};
use crate::span::{Bind, Span, divided};

/// Rounding, of w.
pub(crate) const ROUNDED: f64 = 1e-9;

/// Part of the acceleration there is on a straight line below which a node binds instead.
const LEAST: f64 = 0.4;

/// Parts of the acceleration at corners that are tried where all of it would make another node bind.
const PARTS: [f64; 3] = [0.75, 0.5, 0.25];

/// Rounds in which the limits on the way of a stop are looked for.
const STOPS: usize = 16;

/// What is known of each cell and of the nodes between them.
pub(crate) struct Ground<'a, const N: usize> {
    pub cells: &'a VecDeque<Cell<N>>,
    /// w at each node, and within each cell, at most.
    pub caps: Vec<f64>,
    pub tops: Vec<f64>,
    /// Along each cell, where it does not turn.
    pub limits: Vec<Limits>,
    /// The accelerations that each node may be come to and left with, if it binds.
    pub kinks: Vec<Kink>,
}

/// What comes out of looking for a course between two that bind.
enum Bound {
    None(Vec<Piece>),
    Node(Bind),
    /// The acceleration over a cell is less.
    Accel(usize, f64),
}

/// What braking comes to.
pub(crate) enum Stop {
    /// A stop, and the cell in which it ends.
    Found(Vec<Piece>, usize),
    /// It is faster on the way than the axes can be.
    TooFast,
    /// It ends behind the last cell.
    Beyond,
}

impl<const N: usize> Ground<'_, N> {
    /// Along all cells from one node to another.
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

    /// From a moment to rest at the end, in time. `None` if it can't be done from there.
    pub fn courses(&mut self, from: Moment) -> Option<Vec<Piece>> {
        let full = self.limits.clone();
        let courses = self.bound_courses(from, &full);
        self.limits = full;
        courses
    }

    /// The same, with accelerations that become less as courses are beyond them. Where another node comes
    /// to bind, they are as they were before: its courses are slower.
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
                // Over fewer cells the limits may be higher.
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

    /// Lowers what can't be come from or to; what it changes is unknown again.
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
                // It can't be slower here.
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

    /// The course from one to the other, or what binds in between. At corners it has as much
    /// acceleration as there is room for, and makes no other node bind.
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

    /// The same, with these accelerations at both ends, or less where it is too short for them.
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
                    // As it is: the law decides.
                    return Bound::None(pieces);
                }
                None => return Bound::None(pieces),
            }
        }
    }

    fn bind(&self, node: usize, v: f64) -> Bind {
        Bind { node, s: self.place(node), v: v.min(self.caps[node].sqrt()) }
    }

    /// Whether it is nowhere, up to the cell in which it ends, faster than the axes can be: its speed
    /// may be beyond the ordered one.
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

    /// Along the first cells, at most at the speed there is: what turning leaves.
    fn falling(&self, from: Moment, cells: usize) -> Limits {
        let all = self.limits(0, cells);
        let v = from.v + from.a.max(0.0).powi(2) / 2.0 / all.jerk;
        let slopes = self.cells.iter().take(cells).map(|cell| cell.slope(v * v));
        Limits { accel: slopes.fold(all.accel, f64::min), ..all }.with(from.a)
    }

    /// From an acceleration to none, by the jerk of the cells that it leads over.
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

    /// A stop with a part of the limits, the fastest with all of them.
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
            // By the least of what there is on its own way.
            if (end.s - known).abs() <= ROUNDED * (end.s - from.s) {
                let allowed = self.allowed(&pieces, cell);
                return if allowed { Stop::Found(pieces, cell) } else { Stop::TooFast };
            }
            known = end.s;
        }
        Stop::TooFast
    }

    /// What turning leaves to a stop, at the speeds of another one: as on a circle, for a stop is
    /// tried with the law.
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

    /// From a speed that is beyond what is allowed now, or an acceleration: down to what is, and
    /// the cell in which that is reached.
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

/// The speed at a place of a course.
fn speed(pieces: &[Piece], s: f64) -> f64 {
    let piece = pieces.iter().find(|piece| piece.to.s >= s).or(pieces.last());
    piece.map_or(0.0, |piece| piece.at(piece.time(s)).v)
}

/// The speed, `v` at most, at which it can be at a place without acceleration.
fn arrive(from: Moment, s: f64, v: f64, limits: &Limits) -> Option<f64> {
    if from.v + from.a.min(0.0) * -from.a.min(0.0) / 2.0 / limits.jerk < 0.0 {
        // It would go back before the acceleration has ended.
        return None;
    }
    let pace = limits.pace();
    if reached(from, v, &pace) <= s + ROUNDED * (s - from.s) {
        return Some(v);
    }
    // What it comes to if the acceleration only ends.
    let free = (from.v + from.a * from.a.abs() / 2.0 / limits.jerk).max(0.0);
    if free >= v || reached(from, free, &pace) > s {
        return None;
    }
    Some(root(free, v, |v| reached(from, v, &pace) - s))
}
