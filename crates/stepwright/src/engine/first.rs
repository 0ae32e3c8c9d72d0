//! The short path of a step, taken by most visits where the counter is wide.
//!
//! ```text
//!   due     X│       X│   Y│  X│
//!        ────┴────────┴────┴───┴──►
//!         short    short  long: Y is before X now
//! ```
//!
//! The engine knows from the last visit which single axis is due. If its step is on time, if the
//! next step is [like it](super::track::Track::alike), and if no other axis comes before that,
//! nothing else is examined.

use super::agenda::Agenda;
use super::track::State;
use super::{Engine, STEP};
use crate::drive::{Axes, Drive};
use crate::format::Kept;
use crate::queue::Source;
use crate::timer::{Count, StepTimer};

/// The agenda of an engine on a wide counter.
pub(super) type First<C, const N: usize> = Kept<Agenda<C, N>>;

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Engine<T, D, S, N> {
    /// A [visit](Engine::visit) that first tries to make the step of the axis that is due alone.
    #[inline(always)]
    pub(super) fn step_first(&mut self) -> bool {
        let now = self.timer.now();
        let Some(agenda) = self.first.get() else { return self.go_first(now) };
        let axis = agenda.first_step();
        let Some(track) = self.tracks.get_mut(usize::from(axis)) else { return self.go_first(now) };
        if self.timer.reach(axis, track.wake()).is_after(now) {
            return self.go_first(now);
        }
        let steps: Axes = 1 << axis;
        self.drive.begin(steps);
        let edge = self.timer.now();
        if track.alike.count() == 0 {
            return self.advance_first(edge);
        }
        if !track.step_alike(edge, self.terms.least) {
            return self.go_on_late(edge);
        }
        let next = self.timer.reach(axis, track.wake());
        if !agenda.others_after(next) {
            return self.go_on(edge);
        }
        self.timer.set_compare(next);
        let now = self.timer.now();
        if !now.leaves(edge, self.terms.timing.pulse) {
            return self.go_on(edge);
        }
        self.drive.end(steps);
        // Such a step causes no news.
        !next.leaves(now, T::LINGER + 1) && self.go_round()
    }

    /// Plays the event of the axis that is due alone, and returns the time of the first event.
    /// `None` if no single axis is due; then nothing is done.
    #[cfg_attr(feature = "compact", inline(always))]
    #[cfg_attr(not(feature = "compact"), inline(never))]
    pub(super) fn play_first(&mut self, now: T::Count) -> Option<T::Count> {
        let agenda = self.first.get()?;
        let axis = agenda.first();
        let place = usize::from(axis);
        let (track, source) = (self.tracks.get_mut(place)?, self.sources.get_mut(place)?);
        if self.timer.reach(axis, track.wake()).is_after(now) || !agenda.others_after(now) {
            return None;
        }
        let (mut edge, mut steps): (_, Axes) = (now, 0);
        loop {
            if track.pins & STEP != 0 {
                steps = 1u8.wrapping_shl(axis.into());
                self.drive.begin(steps);
                edge = self.timer.now();
            }
            if !track.play_again(edge, self.terms.least) {
                track.advance(source, &mut self.drive, &mut self.terms, axis, edge);
            }
            // A step that was fetched after a wait is due at once.
            let fetched = steps == 0 && track.state == State::Play && track.pins & STEP != 0;
            if !fetched || self.timer.reach(axis, track.wake()).is_after(now) {
                break;
            }
        }
        self.see_to_pulses(steps, edge);
        Some(self.wake_behind_first(edge))
    }

    /// Examines all axes, and returns the time of the first event, or of the next examination.
    #[inline(always)]
    pub(super) fn find_first(&mut self, now: T::Count) -> T::Count {
        let Some(agenda) = self.first.get_mut() else { return now };
        agenda.clear(now);
        for (axis, track) in (0u8..).zip(&self.tracks) {
            if track.state != State::Idle {
                let at = self.timer.reach(axis, track.wake());
                let steps = (track.state == State::Play).then_some(track.pins & STEP != 0);
                agenda.insert(axis, at, steps);
            }
        }
        agenda.hide_twins();
        agenda.next(now)
    }

    /// Sets the compare register after the event of the first axis has been played, and returns the
    /// time of the first event.
    #[inline(always)]
    fn wake_behind_first(&mut self, now: T::Count) -> T::Count {
        if !self.pulses.any()
            && let Some(agenda) = self.first.get_mut()
            && let Some(track) = self.tracks.get(usize::from(agenda.first()))
            && track.state == State::Play
        {
            let at = self.timer.reach(agenda.first(), track.wake());
            let next = agenda.put_off(at, track.pins & STEP != 0);
            self.timer.set_compare(next);
            return next;
        }
        self.wake_for_first(now)
    }

    /// Continues after a step of the first axis at `edge` that was late, or whose next step is
    /// near.
    #[cold]
    #[inline(never)]
    fn go_on_late(&mut self, edge: T::Count) -> bool {
        let axis = self.first.get().map_or(0, Agenda::first);
        if let Some(track) = self.tracks.get_mut(usize::from(axis)) {
            track.undo_alike();
        }
        self.advance_first(edge)
    }

    /// Continues after the beginning of a step of the first axis at `edge`, if the next event is
    /// not like it.
    #[inline(never)]
    fn advance_first(&mut self, edge: T::Count) -> bool {
        self.terms.news = false;
        let axis = self.first.get().map_or(0, Agenda::first);
        let place = usize::from(axis);
        if let (Some(track), Some(source)) =
            (self.tracks.get_mut(place), self.sources.get_mut(place))
        {
            track.advance(source, &mut self.drive, &mut self.terms, axis, edge);
        }
        self.see_to_pulses(1u8.wrapping_shl(axis.into()), edge);
        let next = self.wake_behind_first(edge);
        self.go_on_from(next)
    }

    /// Continues after a step of the first axis at `edge` if another axis comes first, or if the
    /// pulse is not over when all other work is done.
    #[inline(never)]
    fn go_on(&mut self, edge: T::Count) -> bool {
        let axis = self.first.get().map_or(0, Agenda::first);
        self.see_to_pulses(1u8.wrapping_shl(axis.into()), edge);
        let next = self.wake_behind_first(edge);
        self.terms.news = false;
        self.go_on_from(next)
    }

    /// Begins a visit whose first event is not a step of a single axis.
    #[inline(never)]
    fn go_first(&mut self, now: T::Count) -> bool {
        self.terms.news = false;
        let alone = self.first.get().is_some_and(|agenda| usize::from(agenda.first()) < N);
        let next = if alone { self.play_first(now) } else { None };
        let next = match next {
            Some(next) => next,
            None => self.play_due(now),
        };
        self.go_on_from(next)
    }

    /// Continues a visit that has had no news.
    #[inline(never)]
    fn go_round(&mut self) -> bool {
        self.terms.news = false;
        self.visit()
    }

    /// Ends the visit if the next event, at this time, is ahead; else continues it.
    #[inline(always)]
    fn go_on_from(&mut self, next: T::Count) -> bool {
        if next.leaves(self.timer.now(), T::LINGER + 1) { self.terms.news } else { self.visit() }
    }
}
