//! One axis in the engine.

use super::late::Terms;
use super::{FACE, Playing, STEP, TURN};
use crate::drive::Drive;
use crate::entry::Play;
use crate::format::{self, Alike, EARLY, Half, Wait};
use crate::queue::{Loaded, Source};
use crate::timer::Count;
use crate::units::Ticks;

/// What an axis waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum State {
    /// Its next event.
    Play,
    /// The queue is empty, and the next entry is not late yet.
    Starved,
    /// The queue is empty, and the next entry is late.
    Late,
    /// Nothing.
    Idle,
}

#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "compact"), repr(C))] // bytes near the beginning take fewer instructions
pub(super) struct Track<C: Count> {
    /// The time of the next event, or of an [`early`] read of the queue.
    pub due: C::Fine,
    /// Ticks to wait beyond `due`, because of the minimum interval or the hold time.
    pub push: Ticks,
    pub state: State,
    /// The next event: its pins, and the wait after it in 2⁻¹⁶ ticks.
    pub pins: u8,
    pub wait: Wait,
    /// Half of the wait before the next event, in ticks.
    pub room: Half,
    /// Steps after the next event that are like it.
    pub alike: Alike,
    /// The events after those.
    pub play: Play,
    pub forward: bool,
    /// The position at the last turn, and the steps made since in that direction, including those
    /// of `alike`: an 8-bit chip counts half as many bytes.
    base: i64,
    made: u32,
}

/// A copy of the state of an axis from which the rest of its entry is computed.
pub(crate) struct Glance {
    /// Ticks to the next event.
    left: i32,
    state: State,
    wait: Wait,
    alike: Alike,
    play: Play,
}

impl Glance {
    /// See [`Engine::playing`](super::Engine::playing).
    #[inline(always)]
    pub(crate) fn playing(&self) -> Playing {
        let left = self.left.max(0) as Ticks;
        match self.state {
            State::Idle => Playing::Unknown,
            State::Play => {
                let next = (self.wait >> 16) as Ticks;
                Playing::Left(left.saturating_add(next).saturating_add(self.play.waits(self.alike)))
            }
            State::Starved | State::Late => {
                let early = early(self.state, self.wait) as i32;
                Playing::Dry(self.left.saturating_add(early).max(0) as Ticks)
            }
        }
    }
}

/// A track of which others may take a [`Glance`].
#[cfg(feature = "critical-section")]
#[repr(transparent)]
pub(crate) struct Looked<C: Count>(Track<C>);

#[cfg(feature = "critical-section")]
impl<C: Count> Looked<C> {
    /// See [`Track::glance`].
    #[inline(always)]
    pub fn glance(&self, now: C) -> Glance {
        self.0.glance(now)
    }
}

impl<C: Count> Track<C> {
    /// An axis at rest at position 0, facing forward.
    pub const IDLE: Track<C> = Track {
        due: C::ZERO.1,
        push: 0,
        state: State::Idle,
        pins: 0,
        wait: 0,
        room: 0,
        alike: Alike::NONE,
        play: Play::NONE,
        forward: true,
        base: 0,
        made: 0,
    };

    /// The earliest time of the next event.
    #[inline(always)]
    pub fn wake(&self) -> C {
        // There is mostly nothing to add, and the addition costs an 8-bit chip time.
        if self.push == 0 { C::of(self.due) } else { C::of(self.due).plus(self.push) }
    }

    /// The position in steps.
    pub fn position(&self) -> i64 {
        let made = i64::from(self.made.wrapping_sub(self.alike.count()));
        self.base.wrapping_add(if self.forward { made } else { made.wrapping_neg() })
    }

    /// See [`Engine::playing`](super::Engine::playing).
    pub fn playing(&self, now: C) -> Playing {
        self.glance(now).playing()
    }

    /// The state from which [`playing`](Track::playing) is computed.
    #[inline(always)]
    pub fn glance(&self, now: C) -> Glance {
        let Track { state, wait, alike, ref play, .. } = *self;
        Glance { left: self.wake().since(now), state, wait, alike, play: play.clone() }
    }

    /// Sets the position.
    #[cold]
    #[inline(never)]
    pub fn set_position(&mut self, position: i64) {
        (self.base, self.made) = (position, self.alike.count());
    }

    /// Plays an event at `edge` that is followed by the same again: a wait, or a step that is on
    /// time and leaves at least this many ticks. Returns false if the event is another one; then
    /// nothing is done. On a wide counter such steps are those that are [alike](Track::alike).
    #[inline(never)]
    pub fn play_again(&mut self, edge: C, least: Ticks) -> bool {
        if C::WIDE {
            let plays = self.alike.count() != 0;
            if plays && !self.step_alike(edge, least) {
                self.undo_alike();
                return false;
            }
            return plays;
        }
        if self.pins & !STEP != 0 {
            return false;
        }
        let next = C::later(self.due, self.wait as u32);
        let steps = self.pins == STEP;
        if steps && !leaves(C::of(next), edge, least, self.wait) || !self.play.again() {
            return false;
        }
        (self.due, self.push) = (next, 0);
        if steps {
            self.made = self.made.wrapping_add(1);
        }
        true
    }

    /// Plays a step at `edge` that is followed by one like it. Returns false if it is not on time
    /// or leaves less than this many ticks: then call [`undo_alike`](Track::undo_alike).
    #[inline(always)]
    pub fn step_alike(&mut self, edge: C, least: Ticks) -> bool {
        // Done first, and undone if it is late: this way the values fit into the registers of a
        // small chip.
        let wait = self.wait;
        self.push = 0;
        self.wait = self.alike.next(wait);
        self.due = C::later(self.due, wait as u32);
        leaves(C::of(self.due), edge, least, wait)
    }

    /// Takes back a step that [`step_alike`](Track::step_alike) has refused.
    #[cold]
    #[inline(never)]
    pub fn undo_alike(&mut self) {
        self.wait = self.alike.undo(self.wait);
        self.due = C::earlier(self.due, self.wait as u32);
    }

    /// Forgets all that comes after the next event.
    #[inline(always)]
    pub fn forget(&mut self) {
        self.made = self.made.wrapping_sub(self.alike.count());
        (self.play, self.alike, self.wait) = (Play::NONE, Alike::NONE, 0);
    }

    /// Starts the axis: its first event is now.
    pub fn start(&mut self, now: C, source: &mut impl Source, news: &mut bool) {
        (self.due, self.push, self.room) = (fine_of(now), 0, 0);
        self.forget();
        self.go_on_aside(source, news);
        if self.state == State::Play && self.pins == 0 {
            // A wait without pins needs no interrupt.
            self.go_on_aside(source, news);
        }
    }

    /// Reads a queue again that was empty, when the next entry is due or nearly so. Returns whether
    /// there is an event now that is due.
    #[cold]
    #[inline(never)]
    pub fn ask_again(&mut self, source: &mut impl Source, terms: &mut Terms) -> bool {
        let (counted, early) = (self.state == State::Late, self.early());
        self.due = C::delayed(self.due, early);
        self.wait = 0;
        self.go_on_aside(source, &mut terms.news);
        if self.state == State::Starved && early == 0 {
            self.state = State::Late;
            self.due = C::delayed(self.due, terms.poll);
            if !counted {
                terms.count_late();
            }
        }
        terms.news |= self.state == State::Idle;
        self.state == State::Play && early == 0
    }

    /// Ticks from `due` to the time of the next entry.
    #[inline(always)]
    pub fn early(&self) -> Ticks {
        early(self.state, self.wait)
    }

    /// Plays the due event at `edge`.
    #[inline(never)]
    pub fn advance(
        &mut self,
        source: &mut impl Source,
        drive: &mut impl Drive,
        terms: &mut Terms,
        axis: u8,
        edge: C,
    ) {
        let pins = self.pins;
        if pins & STEP != 0 {
            self.made = self.made.wrapping_add(1);
        }
        if pins & (TURN | FACE) != 0 || self.made >> 31 != 0 {
            self.set_position(self.position());
        }
        if pins & (TURN | FACE) != 0 {
            return self.turn(source, drive, terms, axis, edge);
        }
        let mut wait = self.wait;
        self.go_on(source, &mut terms.news);
        while wait == 0 && self.only_waits() {
            // The wait that a program gives after the pins are set.
            wait = self.wait;
            self.go_on(source, &mut terms.news);
        }
        terms.news |= self.state == State::Idle;
        let next = C::of(self.due);
        if pins & STEP != 0
            && (self.pins & (TURN | FACE) != 0
                || wait == 0
                || !next.leaves(edge, self.room as Ticks)
                || !next.leaves(edge, terms.least))
        {
            return self.judge(terms, wait, edge);
        }
        // On time, and so is the next event.
        self.push = 0;
    }

    /// [`advance`](Track::advance) for an event that turns the axis.
    #[cold]
    #[inline(never)]
    fn turn(
        &mut self,
        source: &mut impl Source,
        drive: &mut impl Drive,
        terms: &mut Terms,
        axis: u8,
        edge: C,
    ) {
        let (due, pins, mut wait) = (self.due, self.pins, self.wait);
        self.forward ^= pins & TURN != 0;
        drive.direction(axis, self.forward);
        self.go_on_aside(source, &mut terms.news);
        while wait == 0 && self.only_waits() {
            wait = self.wait;
            self.go_on_aside(source, &mut terms.news);
        }
        terms.news |= self.state == State::Idle;
        if pins & STEP != 0 {
            return self.judge(terms, wait, edge);
        }
        self.push = 0;
        // The set-up time counts from the edge. A turn that came late keeps its schedule if that
        // leaves enough time, so that axes which begin together stay together. If not, the schedule
        // shifts, which does no harm at rest.
        let left = C::of(self.due).since(edge);
        if self.pins & STEP != 0 && left <= terms.timing.setup as i32 {
            let behind = edge.since(C::of(due)).max(0);
            self.due = C::delayed(self.due, behind as Ticks);
        }
    }

    /// Whether the next event sets no pins.
    #[inline(always)]
    pub fn only_waits(&self) -> bool {
        self.state == State::Play && self.pins == 0
    }

    /// Moves on to the next event, after the wait of this one.
    #[inline(always)]
    pub fn go_on(&mut self, source: &mut impl Source, news: &mut bool) {
        if self.wait != 0 {
            self.room = half(self.wait);
        }
        self.due = if C::WIDE {
            let part = C::later(self.due, (self.wait & 0xFFFF) as u32);
            C::delayed(part, (self.wait >> 16) as Ticks)
        } else {
            C::later(self.due, self.wait as u32)
        };
        self.take(source, news);
    }

    /// [`go_on`](Track::go_on), out of line, where speed does not matter.
    #[cold]
    #[inline(never)]
    fn go_on_aside(&mut self, source: &mut impl Source, news: &mut bool) {
        self.go_on(source, news);
    }

    /// Takes the next event.
    #[inline(always)] // out of line, a Mega's compiler would pass its fields on the stack
    pub fn take<S: Source>(&mut self, source: &mut S, news: &mut bool) {
        if C::WIDE && self.alike.count() != 0 {
            // The step is counted already.
            self.made = self.made.wrapping_sub(1);
            self.wait = self.alike.next(self.wait);
            return;
        }
        loop {
            if let Some(event) = self.play.next() {
                (self.pins, self.wait) = (event.0, event.1.into());
                self.state = State::Play;
                if C::WIDE && self.pins == STEP {
                    self.alike = Alike::of(&mut self.play, STEP);
                    self.made = self.made.wrapping_add(self.alike.count());
                } else if C::WIDE && self.pins == 0 && self.wait != 0 {
                    self.wait = format::joined(self.wait, &mut self.play, C::HOP);
                }
                if self.play.is_last() {
                    source.look_ahead();
                }
                return;
            }
            match source.load(&mut self.play) {
                Loaded::Entry if S::IS_QUEUE => *news = true,
                Loaded::Entry => {}
                Loaded::Late => {
                    self.state = State::Starved;
                    self.due = C::delayed(self.due, self.early().wrapping_neg());
                    return;
                }
                Loaded::End => return self.state = State::Idle,
            }
        }
    }
}

/// Ticks from an early read of an empty queue to the next entry, after this wait; 0 without an
/// early read. A far step that is fetched only when it is due would come later than others.
#[inline(always)]
fn early(state: State, wait: Wait) -> Ticks {
    let far = state == State::Starved && wait >> 16 >= 4 * Wait::from(EARLY);
    if far { EARLY } else { 0 }
}

/// Half of a wait, in ticks.
#[inline(always)]
fn half(wait: Wait) -> Half {
    (wait >> 17) as Half
}

/// Whether the next step is at least this many ticks, and half of its wait, after a step at `edge`.
#[inline(always)]
fn leaves<C: Count>(next: C, edge: C, least: Ticks, wait: Wait) -> bool {
    next.leaves(edge, least) && next.leaves(edge, wait as u32 >> 17)
}

/// A count as a time.
pub(super) fn fine_of<C: Count>(at: C) -> C::Fine {
    // A count is its distance from 0, for any width of the counter.
    let zero = C::fine(0, 0);
    C::delayed(zero, at.since(C::of(zero)) as Ticks)
}
