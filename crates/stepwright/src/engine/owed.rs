//! What a visit leaves to the next ones.
//!
//! ```text
//!   X, Y, Z due     STEP of all    X takes its entry │ Y takes its entry │ Z takes its entry
//!   ────────────────┴──────────────────────────────► │ ────────────────► │ ────────────────►
//!                    one visit                         another, pended     another
//! ```
//!
//! Axes that step at once get their edges at once. What takes long is to find out what comes next: a
//! visit does that for one axis, and pends its interrupt for the others. In between an interrupt of
//! the same priority has its turn. The foreground, if it comes in between, pays first.

use super::{Engine, STEP};
use crate::drive::{Axes, Drive};
use crate::queue::Source;
use crate::timer::{Count, StepTimer};

/// Axes whose event was played at `edge`, and that have not looked at what comes next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Owed<C> {
    axes: Axes,
    edge: C,
}

impl<C: Count> Owed<C> {
    pub const NOTHING: Owed<C> = Owed { axes: 0, edge: C::ZERO.0 };
}

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Engine<T, D, S, N> {
    /// The edge of the events that are owed, if any are: the time of the next event.
    #[inline(always)]
    pub(super) fn owes(&self) -> Option<T::Count> {
        self.owed.get().filter(|owed| owed.axes != 0).map(|owed| owed.edge)
    }

    /// Plays the event of one of these axes, at `edge`; the others are owed.
    #[inline(never)]
    pub(super) fn advance_one(&mut self, mut due: Axes, edge: T::Count) {
        for (axis, (track, source)) in (0..).zip(self.tracks.iter_mut().zip(&mut self.sources)) {
            if due >> axis & 1 != 0 {
                due ^= 1 << axis;
                track.advance(source, &mut self.drive, &mut self.terms, axis, edge);
                break;
            }
        }
        if let Some(owed) = self.owed.get_mut() {
            *owed = Owed { axes: due, edge };
        }
        if due != 0
            && let Some(agenda) = self.first.get_mut()
        {
            agenda.hide_first();
        }
    }

    /// Pays for one axis, of those whose events were at `edge`. Returns when the next event comes.
    #[inline(never)]
    pub(super) fn pay_one(&mut self, edge: T::Count) -> T::Count {
        let axes = self.owed.get().map_or(0, |owed| owed.axes);
        self.advance_one(axes, edge);
        self.wake_for_first(edge)
    }

    /// Pays all, for the foreground, which sets the compare register if it has to.
    #[inline(always)]
    pub(super) fn pay(&mut self) {
        if Self::SPLITS && self.owes().is_some() {
            self.pay_all();
        }
    }

    #[cold]
    #[inline(never)]
    fn pay_all(&mut self) {
        while let Some(edge) = self.owes() {
            self.pay_one(edge);
        }
    }

    /// Steps of an axis that it has made, and that are not counted yet.
    #[inline(always)]
    pub(super) fn made_unpaid(&self, axis: usize) -> i64 {
        let owed = self.owed.get().map_or(0, |owed| owed.axes);
        match self.tracks.get(axis) {
            Some(track) if Self::SPLITS && owed >> axis & 1 != 0 && track.pins & STEP != 0 => {
                if track.forward {
                    1
                } else {
                    -1
                }
            }
            _ => 0,
        }
    }
}
