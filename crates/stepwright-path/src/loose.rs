//! The pieces that are added to a route, and the cells that are made of them.
//!
//! A piece becomes cells when the beginning of the next piece is known. A chord of a curve becomes cells a few
//! chords later, when more is known of how the curve turns ([`chords`]).

use crate::cell::Cell;
use crate::chords::{self, View};
use crate::joint::Joint;
use crate::law::SCALES;
use crate::pace::{PACES, Unplannable};
use crate::route::{Route, SLIVER};
use crate::shape::Shape;

/// The largest part of an arc in one cell, in radians.
const ARC: f64 = 0.1;

/// The most pieces behind a joint that are waited for.
pub(crate) const AHEAD: usize = 24;

/// Chords are rough if this many of their joints turn there and back. Where curves meet, one or two joints do.
const ROUGH: usize = 4;

/// A piece whose end is not known yet: it depends on the pieces that follow.
#[derive(Clone, Debug)]
pub(crate) struct Loose<const N: usize> {
    pub shape: Shape<N>,
    feed: f64,
    rapid: bool,
    begin: Joint<N>,
    /// How much more the route turns there than at the joint before; and whether that reverses such a change at
    /// the joint before.
    step: [f64; N],
    rough: bool,
}

impl<const N: usize> Route<N> {
    pub(crate) fn add(
        &mut self,
        shape: Shape<N>,
        feed: f64,
        rapid: bool,
    ) -> Result<(), Unplannable> {
        if !PACES.contains(&feed) {
            return Err(Unplannable::Speed);
        }
        self.forget_cancels();
        let begin = self.loose.back().map_or(Joint::REST, |last| {
            let ends = [&last.shape.direction(last.shape.end), &shape.direction(shape.begin)];
            let lengths = [last.shape.length(), shape.length()];
            // An override may double the speed.
            let top = last.feed.min(feed) * SCALES.end();
            Joint::new(ends, lengths, top, &self.axes, self.deviation)
        });
        let mut step = [0.0; N];
        let mut rough = false;
        if let Some(last) = self.loose.back().filter(|last| !last.begin.corner && !begin.corner) {
            step = std::array::from_fn(|n| begin.turn[n] - last.begin.turn[n]);
            rough = self.is_rough(&last.step, &step, feed);
        }
        self.length = shape.end;
        self.loose.push_back(Loose { shape, feed, rapid, begin, step, rough });
        self.closed = false;
        self.settle_known();
        Ok(())
    }

    /// Makes cells of the pieces behind which enough is known.
    fn settle_known(&mut self) {
        while let [Some(first), Some(next)] = [self.loose.front(), self.loose.get(1)] {
            let joint = &next.begin;
            let unequal = chords::is_unequal(joint, [&first.shape, &next.shape]);
            if joint.top > 0.0 && (unequal || self.steps() > 0) && !self.is_far() {
                return;
            }
            self.settle_first();
        }
    }

    /// Makes cells of all pieces but the last, by the pieces known now: the next one is late.
    pub(crate) fn settle_seen(&mut self) {
        while self.loose.len() > 1 {
            self.settle_first();
        }
    }

    /// Makes cells of all pieces: none follows.
    pub(crate) fn settle_all(&mut self) {
        while !self.loose.is_empty() {
            self.settle_first();
        }
        self.chords.clear();
    }

    /// Whether as much of the route is known from the second piece on as is considered.
    fn is_far(&self) -> bool {
        let (Some(next), Some(last)) = (self.loose.get(1), self.loose.back()) else { return false };
        last.shape.end - next.shape.begin >= self.reach(next)
            || self.loose.len() > AHEAD
            || self.loose.iter().skip(2).any(|piece| piece.begin.corner || piece.shape.is_round())
    }

    /// The largest distance around the beginning of a piece within which chords are considered: as far as the
    /// route moves while u changes by the jump, once with its jerk, or there and back with its acceleration.
    fn reach(&self, piece: &Loose<N>) -> f64 {
        let time = self.axes.iter().map(|axis| {
            let smooth = 2.0 * (axis.jump / axis.jerk).sqrt();
            smooth.max(2.0 * axis.jump / axis.accel)
        });
        piece.feed * time.fold(0.0, f64::max)
    }

    /// The number of joints around, as far as they are considered, at which the acceleration of turning goes
    /// there and back.
    fn steps(&self) -> usize {
        self.chords.rough() + self.loose.iter().filter(|piece| piece.rough).count()
    }

    /// Whether the acceleration of turning goes there and back by more than the jump hides. To hide a step of Δ
    /// takes Δ²/8J.
    fn is_rough(&self, there: &[f64; N], back: &[f64; N], feed: f64) -> bool {
        self.axes.iter().enumerate().any(|(n, axis)| {
            let [there, back] = [there[n], back[n]].map(|step| step * feed * feed);
            let hidden = (4.0 * axis.jump * axis.jerk).sqrt().min(axis.accel / 2.0);
            there * back < 0.0 && there.abs().min(back.abs()) > hidden
        })
    }

    /// The joint at the beginning of the first piece, as judged with the chords before and behind it.
    fn seen(&self, first: &Loose<N>) -> Joint<N> {
        let rough = self.steps() >= ROUGH;
        let strict = self.deviation.is_none();
        let reach = self.reach(first);
        let view = View { axes: &self.axes, feed: first.feed, reach, rough, strict };
        let one = |piece: &Loose<N>| piece.shape.begin == first.shape.begin || !piece.begin.corner;
        let behind = self.loose.iter().take_while(|piece| one(piece) && !piece.shape.is_round());
        view.joint(&first.begin, self.chords.iter(), behind.map(|piece| &piece.shape))
    }

    /// Makes cells of the first piece.
    fn settle_first(&mut self) {
        let Some(first) = self.loose.pop_front() else { return };
        let Loose { shape, feed, rapid, begin, rough, .. } = first;
        if begin.corner || shape.is_round() {
            self.chords.clear();
        }
        if !shape.is_round() {
            self.chords.push(shape, rough);
        }
        let next = self.loose.front().filter(|next| next.begin.top > 0.0);
        if let Some(joint) = next.map(|next| self.seen(next))
            && let Some(next) = self.loose.front_mut()
        {
            next.begin = joint;
        }
        let end = self.loose.front().map_or(Joint::REST, |next| next.begin);
        self.settle(&shape, (feed, rapid), [&begin, &end]);
    }

    /// Makes cells of a piece between two joints.
    fn settle(
        &mut self,
        shape: &Shape<N>,
        (feed, rapid): (f64, bool),
        [begin, end]: [&Joint<N>; 2],
    ) {
        let length = shape.length();
        let ([_, first], [last, _]) = (begin.zones, end.zones);
        // The inner ends of its cells. Most chords have none.
        let mut cuts = Vec::new();
        if first + last < length / 2.0 {
            cuts.extend([first, length - last]);
        }
        let parts = (shape.sweep() / ARC).ceil();
        let parts = if parts > 1.0 { parts as usize } else { 1 };
        cuts.extend((1..parts).map(|n| length * n as f64 / parts as f64));
        cuts.retain(|cut| (length * SLIVER..length * (1.0 - SLIVER)).contains(cut));
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|b, a| *b - *a <= length * SLIVER);
        let accel = self.axes.map(|axis| axis.accel);
        let speed = self.axes.map(|axis| axis.speed);
        let (mut cap, mut turn) = (begin.cap, begin.turns().then_some(begin.turn));
        let mut from = 0.0;
        for to in cuts.into_iter().chain([length]) {
            let zones = [(begin, from < first), (end, to > length - last)];
            let mut within = [Joint::REST.bend; 2];
            let mut count = 0;
            for (joint, _) in zones.iter().filter(|(_, within)| *within) {
                within[count] = joint.bend;
                count += 1;
            }
            let behind = if to < length { shape.begin + to } else { shape.end };
            let ends = (shape.begin + from, behind);
            from = to;
            let mut cell = Cell::new(shape, ends, &within[..count], &accel, &speed, feed);
            cell.rapid = rapid;
            cell.scale(self.scales);
            cell.cap = std::mem::replace(&mut cap, f64::INFINITY);
            cell.turn = turn.take();
            self.cells.push_back(cell);
            self.fresh += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AxisPace;

    /// A route of chords over a wave with sharp crests; and the last chord. Places are multiples of `grid`, if
    /// that is above 0.
    fn wave(grid: f64) -> (Route<2>, [f64; 2]) {
        let axis =
            AxisPace { step: 0.0125, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: 3_000.0 };
        let mut route = Route::new([axis; 2]).unwrap();
        let round = |place: f64| if grid > 0.0 { (place / grid).round() * grid } else { place };
        let (mut most, mut last) = (0, [0.0; 2]);
        for n in 1..=600 {
            let x = 0.1 * f64::from(n);
            let (from, to) = (route.end(), [x, 4.0 * (x / 3.0).sin()].map(round));
            route.line_to(to, 80.0).unwrap();
            most = most.max(route.loose.len());
            last = [to[0] - from[0], to[1] - from[1]];
        }
        assert!((1..=AHEAD).contains(&most), "{most}");
        (route, last)
    }

    /// The chords of a curve are not rough, however much it turns, and however fast that grows. Chords between
    /// rounded places are rough. A straight line that continues them is not.
    #[test]
    fn chords_are_rough_where_places_are_rounded() {
        assert_eq!(wave(0.0).0.steps(), 0);
        let (mut route, [dx, dy]) = wave(0.001);
        assert!(route.steps() > 2 * ROUGH, "{}", route.steps());
        let [x, y] = route.end();
        for n in (1..=200).map(f64::from) {
            route.line_to([x + n * dx, y + n * dy], 80.0).unwrap();
        }
        assert_eq!(route.steps(), 0);
    }

    /// A chord that turns at its beginning does not turn where it is divided.
    #[test]
    fn a_chord_turns_at_its_beginning_alone() {
        let (route, _) = wave(0.0);
        let turns = |cell: &&Cell<2>| cell.turn.is_some();
        assert!(route.cells.iter().filter(turns).all(|cell| cell.begin == cell.shape.begin));
        let count = route.cells.iter().filter(turns).count();
        let divided = route.cells.len() - count;
        assert!(count > 400 && divided > 20, "{count}, {divided}");
    }
}
