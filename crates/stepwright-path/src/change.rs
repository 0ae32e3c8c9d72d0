//! Changes of a route while it is made: an override, a hold, the end of a hold, the end of a jog.
//!
//! A change takes effect at its time, from the speed at that time, but not before a step that was handed out.
//! The cell is divided there, and the rest is planned again. If the new plan would break the law of speed, the
//! plan before stays, and the change is tried again a little later. With limited jerk, gentler stops are tried
//! for a hold before that. Changes that are ordered while the route brakes for a hold take effect when it
//! stands.
//!
//! Changes are made in the order of their times. Only a hold or a cancellation overtakes an override that is
//! being tried again.

use std::collections::VecDeque;

use crate::cell::Scales;
use crate::law::SCALES;
use crate::pace::Unplannable;
use crate::passes::broken;
use crate::piece::{Moment, Piece};
use crate::route::{Route, SLIVER};

/// A change of a route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change {
    Scale(f64),
    Rapids(f64),
    Hold,
    Resume,
    Cancel,
}

impl Change {
    /// Whether the route brakes for it.
    fn brakes(self) -> bool {
        matches!(self, Change::Hold | Change::Cancel)
    }

    /// Whether it ends a hold.
    fn ends_hold(self) -> bool {
        matches!(self, Change::Resume | Change::Cancel)
    }
}

/// A change that was ordered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
    /// The ordered time, in s, but not before the end of the part that was made by then.
    at: f64,
    /// The time at which it is tried, in s: later than `at` if it was tried before.
    due: f64,
    change: Change,
}

/// An override, limited to its range.
fn within(scale: f64) -> Result<f64, Unplannable> {
    if scale.is_nan() {
        return Err(Unplannable::Scale);
    }
    Ok(scale.clamp(*SCALES.start(), *SCALES.end()))
}

/// The shortest time after which a change that would have broken the law is tried again, in s.
const AGAIN: f64 = 0.001;

impl<const N: usize> Route<N> {
    /// Overrides the ordered speed by this factor from `at` seconds on. The factor is limited to [`SCALES`]; no
    /// axis exceeds its own highest speed.
    ///
    /// # Errors
    /// [`Unplannable::Scale`] if the factor is NaN.
    pub fn scale(&mut self, at: f64, scale: f64) -> Result<(), Unplannable> {
        self.change(at, Change::Scale(within(scale)?));
        Ok(())
    }

    /// Overrides the speed of rapids by this factor from `at` seconds on. The factor is limited to [`SCALES`].
    ///
    /// # Errors
    /// As for [`scale`](Route::scale).
    pub fn scale_rapids(&mut self, at: f64, scale: f64) -> Result<(), Unplannable> {
        self.change(at, Change::Rapids(within(scale)?));
        Ok(())
    }

    /// Brakes along the route from `at` seconds on, and rests until it is resumed. If the route is over at that
    /// time, the pieces that follow are held.
    pub fn hold(&mut self, at: f64) {
        self.change(at, Change::Hold);
    }

    /// Continues at `at` seconds, or when the route has come to rest, whichever is later.
    pub fn resume(&mut self, at: f64) {
        self.change(at, Change::Resume);
    }

    /// Brakes along the route from `at` seconds on, and drops the rest of it: the end of a jog. Pieces that are
    /// added when the route rests continue from there. If the route is over at that time, nothing changes.
    pub fn cancel(&mut self, at: f64) {
        self.change(at, Change::Cancel);
    }

    /// Whether the route rests because of a hold.
    pub fn is_held(&self) -> bool {
        self.halt == Some(0) && self.front.is_none()
    }

    fn change(&mut self, at: f64, change: Change) {
        if at == f64::INFINITY {
            // This time never comes.
            return;
        }
        // No change is earlier than those that were tried. A time of NaN means now.
        let at = self.time().max(at);
        // In the order of their times; at the same time, in the order of the calls.
        let place = self.changes.partition_point(|known| known.at <= at);
        self.changes.insert(place, Order { at, due: at, change });
    }

    /// Drops the cancellations that are due by now, if the route is over. To be called before a piece is added.
    pub(crate) fn forget_cancels(&mut self) {
        if !self.is_over() {
            return;
        }
        while self.halt == Some(0) && self.stand().is_some() {}
        let now = self.time();
        self.changes.retain(|order| order.change != Change::Cancel || order.at > now);
    }

    /// The time at which a change is tried, not before the end of the part that was made.
    fn due(&self, order: &Order) -> f64 {
        order.due.max(self.now).max(self.time)
    }

    /// Moves a hold or a cancellation to the front if it is due before an override is tried again.
    fn let_hold_pass(&mut self, due: f64) {
        let Some(first) = self.changes.front().filter(|first| first.due > first.at) else { return };
        let hold = self.changes.iter().position(|order| order.change.brakes());
        if let Some(place) = hold
            && self.changes[place].due < first.due
            && self.due(&self.changes[place]) < due
            && let Some(hold) = self.changes.remove(place)
        {
            let after = self.changes.split_off(place);
            // Before the hold there was nothing to resume.
            self.changes.retain(|order| order.change != Change::Resume);
            self.changes.extend(after);
            self.changes.push_front(hold);
        }
    }

    /// Makes the first change if it is due before `due`, within the first cell. Returns whether anything was
    /// changed.
    pub(crate) fn disturb(&mut self, due: f64) -> bool {
        if self.halt.is_some() {
            return false;
        }
        self.let_hold_pass(due);
        let Some(at) = self.changes.front().map(|order| self.due(order)) else { return false };
        if at >= due || !self.cut(at) {
            // It is due later, or at the end of this cell.
            return false;
        }
        let Some(order) = self.changes.pop_front() else { return false };
        let done = match order.change {
            Change::Resume => true,
            Change::Scale(feed) => self.rescale(Scales { feed, ..self.scales }),
            Change::Rapids(rapid) => self.rescale(Scales { rapid, ..self.scales }),
            Change::Hold => self.brake(),
            Change::Cancel => {
                // The cancellation waits until all axes rest.
                if self.brake() {
                    self.changes.push_front(order);
                    return true;
                }
                false
            }
        };
        if !done {
            // Planning an override takes long: it is tried again after as long as it has waited.
            let waited = if order.change.brakes() { 0.0 } else { at - order.at };
            let due = (at + AGAIN.max(waited)).max(at.next_up());
            self.changes.push_front(Order { due, ..order });
        }
        true
    }

    /// Divides the first cell at this time: the cell begins there from now on. Returns false if nothing of the
    /// cell is left.
    fn cut(&mut self, at: f64) -> bool {
        let (Some(pieces), Some(cell)) = (self.front, self.cells.front()) else { return false };
        let piece = pieces.iter().find(|piece| piece.to.t >= at).unwrap_or(&pieces[2]);
        let here = piece.at(at);
        let s = here.s.max(cell.begin).min(cell.end);
        if cell.end - s <= cell.shape.length() * SLIVER {
            return false;
        }
        self.take_down(at);
        let Some(cell) = self.cells.front_mut() else { return false };
        (cell.begin, cell.first) = (s, cell.shape.direction(s));
        if self.smooth.is_some() {
            let cell = cell.clone();
            let part = Piece { from: piece.from, to: Moment { s, ..here }, jerk: piece.jerk };
            self.leave_smooth(&part, &cell);
        } else {
            self.bucket.wait(here.t - self.time, &self.axes);
            self.bucket.meet(here.v, &cell.first, 0, &self.axes);
            self.passes.w[0] = here.v * here.v;
        }
        (self.time, self.front) = (here.t, None);
        true
    }

    /// Plans all cells with other overrides, if the law allows it.
    fn rescale(&mut self, scales: Scales) -> bool {
        let old = std::mem::replace(&mut self.scales, scales);
        self.cells.iter_mut().for_each(|cell| cell.scale(scales));
        let planned = self.plan();
        if !planned {
            self.scales = old;
            self.cells.iter_mut().for_each(|cell| cell.scale(old));
            if self.smooth.as_ref().is_some_and(|smooth| smooth.here.v == 0.0) {
                // The plan from rest was made with the other overrides.
                self.plan();
            }
        }
        planned
    }

    /// Plans a stop from here on, if the law allows it. The cell in which the stop ends is divided there.
    fn brake(&mut self) -> bool {
        if self.smooth.is_some() {
            let count = self.brake_smooth();
            if let Some(count) = count {
                (self.passes.sure, self.halt) = (count, Some(count));
            }
            return count.is_some();
        }
        let mut w = VecDeque::from([self.passes.w[0]]);
        let mut ahead = VecDeque::new();
        let mut rest = None;
        for cell in &self.cells {
            let from = w[ahead.len()];
            if from == 0.0 {
                break;
            }
            let mut cell = cell.clone();
            let to = cell.fall(from);
            let way = from / cell.brake(from) / 2.0;
            if to <= 0.0 && cell.length() - way > cell.shape.length() * SLIVER {
                let mut behind = cell.clone();
                cell.end = cell.begin + way;
                cell.last = cell.shape.direction(cell.end);
                (behind.begin, behind.first) = (cell.end, cell.last);
                rest = Some(behind);
            }
            w.push_back(if to > 0.0 { to } else { 0.0 });
            ahead.push_back(cell);
        }
        let count = ahead.len();
        if let Some(last) = w.back_mut() {
            // Exactly at rest at the end of the route, too, in spite of rounding.
            *last = 0.0;
        }
        let strict = self.deviation.is_none();
        if strict && !broken(&ahead, &w, self.bucket, &self.axes).is_empty() {
            return false;
        }
        self.cells.drain(..count);
        if let Some(behind) = rest {
            self.cells.push_front(behind);
        }
        ahead.extend(self.cells.drain(..));
        self.cells = ahead;
        w.resize(self.cells.len() + 1, 0.0);
        (self.passes.w, self.passes.sure) = (w, count);
        self.halt = Some(count);
        true
    }

    /// Makes the next change of a route that rests; `None` if no change ends the rest. Changes before that one
    /// are made at rest, those after it at their times.
    pub(crate) fn stand(&mut self) -> Option<()> {
        if !self.changes.iter().any(|order| order.change.ends_hold()) {
            return None;
        }
        let Order { at, change, .. } = self.changes.pop_front()?;
        match change {
            Change::Scale(feed) => self.scales.feed = feed,
            Change::Rapids(rapid) => self.scales.rapid = rapid,
            Change::Hold => {}
            Change::Resume => {
                self.rest(at);
                let scales = self.scales;
                self.cells.iter_mut().for_each(|cell| cell.scale(scales));
                self.plan();
            }
            Change::Cancel => {
                self.rest(at);
                self.drop_rest();
            }
        }
        Some(())
    }

    /// Rests until `at`, and ends the hold.
    fn rest(&mut self, at: f64) {
        let wait = (at - self.time).max(0.0);
        self.stand_for(wait);
        self.halt = None;
    }

    /// Ends the route where it rests.
    fn drop_rest(&mut self) {
        let known = self.cells.front().map(|cell| (cell.shape, cell.begin));
        let here = known.or(self.loose.front().map(|loose| (loose.shape, loose.shape.begin)));
        if let Some((shape, s)) = here {
            self.place = std::array::from_fn(|axis| shape.place(axis, s));
            self.length = s;
        }
        self.fresh = 0;
        self.loose.clear();
        self.chords.clear();
        self.cells.clear();
        self.passes.w = VecDeque::from([0.0]);
        self.passes.sure = 0;
        if let Some(smooth) = &mut self.smooth {
            smooth.end(self.length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AxisPace;

    /// A plan takes longer than 1 ms. An override that was tried every ms would fall behind the motion by
    /// seconds.
    #[test]
    fn an_override_is_tried_again_ever_later() {
        let axis =
            AxisPace { step: 0.0125, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: 10_000.0 };
        let mut made = Route::new([axis; 2]).unwrap();
        for n in 1..=200 {
            let x = 0.2 * f64::from(n);
            made.line_to([x, 4.0 * (x / 3.0).sin()], 80.0).unwrap();
        }
        made.close();
        let mut most = 0;
        for n in 0..20 {
            let mut route = made.clone();
            let ordered = 0.1 + 0.03 * f64::from(n);
            route.scale(ordered, 0.9).unwrap();
            let (mut tries, mut last) = (1, ordered);
            while route.next().is_some() && !route.changes.is_empty() {
                let due = route.changes[0].due;
                tries += u32::from(due > last);
                last = due;
            }
            assert!(
                f64::from(tries) <= 3.0 + ((last - ordered) / AGAIN).max(1.0).log2(),
                "{tries}"
            );
            most = most.max(tries);
        }
        assert!(most > 3, "none had to be tried again: {most}");
    }
}
