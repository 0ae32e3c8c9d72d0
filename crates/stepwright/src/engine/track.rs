//! One axis in the engine.

use super::late::Terms;
use super::{FACE, Playing, STEP, TURN};
use crate::drive::Drive;
use crate::entry::Play;
use crate::format::{self, Half, Wait};
use crate::queue::{Loaded, Source};
use crate::timer::Count;
use crate::units::Ticks;

/// What an axis waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum State {
    /// Its next event.
    Play,
    /// The queue is empty, and what is to follow is not late yet.
    Starved,
    /// … and it is.
    Late,
    /// Nothing.
    Idle,
}

#[derive(Clone, Debug)]
pub(super) struct Track<C: Count> {
    /// Time of the next event.
    pub due: C::Fine,
    /// Ticks to wait beyond `due`, for the sake of the minimum interval or the hold time.
    pub push: Ticks,
    pub state: State,
    /// The next event: its pins, and the wait after it in 2⁻¹⁶ ticks.
    pub pins: u8,
    pub wait: Wait,
    /// Half of the wait before it, in ticks.
    pub room: Half,
    /// The events after it.
    pub play: Play,
    pub forward: bool,
    /// Where it was, and how many steps it has made since, that way: an 8-bit chip counts
    /// half as many bytes.
    base: i64,
    pub made: u32,
}

impl<C: Count> Track<C> {
    /// At rest at position 0, facing forward.
    pub const IDLE: Track<C> = Track {
        due: C::ZERO.1,
        push: 0,
        state: State::Idle,
        pins: 0,
        wait: 0,
        room: 0,
        play: Play::NONE,
        forward: true,
        base: 0,
        made: 0,
    };

    /// When the next event may happen.
    #[inline(always)]
    pub fn wake(&self) -> C {
        // Most often there is nothing to add, and it costs an 8-bit chip.
        if self.push == 0 { C::of(self.due) } else { C::of(self.due).plus(self.push) }
    }

    /// Where it is.
    pub fn position(&self) -> i64 {
        let made = i64::from(self.made);
        self.base.wrapping_add(if self.forward { made } else { made.wrapping_neg() })
    }

    /// See [`Engine::playing`](super::Engine::playing).
    pub fn playing(&self, now: C) -> Playing {
        let left = self.wake().since(now).max(0) as Ticks;
        match self.state {
            State::Idle => Playing::Unknown,
            State::Play => {
                let next = (self.wait >> 16) as Ticks;
                Playing::Left(left.saturating_add(next).saturating_add(self.play.waits()))
            }
            State::Starved | State::Late => Playing::Dry(left),
        }
    }

    /// It is there.
    #[cold]
    #[inline(never)]
    pub fn set_position(&mut self, position: i64) {
        (self.base, self.made) = (position, 0);
    }

    /// Plays an event behind which the same comes again, at `edge`: a wait, or a step that
    /// is on time and leaves at least this many ticks. False if it is another one, and nothing
    /// is done. On a wide counter a step with another wait is the same.
    #[inline(never)]
    pub fn play_again(&mut self, edge: C, least: Ticks) -> bool {
        if self.pins & !STEP != 0 || C::WIDE && self.pins == 0 {
            return false;
        }
        let next = C::later(self.due, self.wait as u32);
        let steps = self.pins == STEP;
        if steps {
            let at = C::of(next);
            if !at.leaves(edge, least) || !at.leaves(edge, half(self.wait) as Ticks) {
                return false;
            }
        }
        if !self.play.again() && !self.goes_on() {
            return false;
        }
        (self.due, self.push) = (next, 0);
        if steps {
            self.made = self.made.wrapping_add(1);
        }
        true
    }

    /// Likewise, of a ramp; on a counter of 16 bits nothing is asked.
    #[inline(always)]
    fn goes_on(&mut self) -> bool {
        C::WIDE && self.play_ramp()
    }

    /// The step behind the present one is of the same ramp: it is the next. Out of line, as steps at
    /// one speed would pay for its registers.
    #[inline(never)]
    fn play_ramp(&mut self) -> bool {
        let Some(wait) = self.play.grows_on(STEP) else { return false };
        (self.room, self.wait) = (half(self.wait), wait.into());
        true
    }

    /// Its first event is now.
    pub fn start(&mut self, now: C, source: &mut impl Source, news: &mut bool) {
        (self.due, self.push, self.room) = (fine_of(now), 0, 0);
        self.play = Play::NONE;
        self.wait = 0;
        self.go_on_aside(source, news);
        if self.state == State::Play && self.pins == 0 {
            // It only waits: nothing that the interrupt need come for.
            self.go_on_aside(source, news);
        }
    }

    /// A queue was empty, and what was to follow is due: whether there is something now.
    #[cold]
    #[inline(never)]
    pub fn ask_again(&mut self, source: &mut impl Source, terms: &mut Terms) -> bool {
        let counted = self.state == State::Late;
        self.wait = 0;
        self.go_on_aside(source, &mut terms.news);
        if self.state == State::Starved {
            self.state = State::Late;
            self.due = C::delayed(self.due, terms.poll);
            if !counted {
                terms.count_late();
            }
        }
        terms.news |= self.state == State::Idle;
        self.state == State::Play
    }

    /// Plays the event, whose time has come, at `edge`.
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
            // What a program that is asked says of the wait, once the pins are set.
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
        // On time, and so is what comes next.
        self.push = 0;
    }

    /// Likewise, where it turns.
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
        // The set-up time counts from the edge. A turn that came late keeps
        // its schedule if that leaves enough, so that axes which begin
        // together stay together; if not, at rest a slip costs nothing.
        let left = C::of(self.due).since(edge);
        if self.pins & STEP != 0 && left <= terms.timing.setup as i32 {
            let behind = edge.since(C::of(due)).max(0);
            self.due = C::delayed(self.due, behind as Ticks);
        }
    }

    /// Whether the next event is a wait.
    #[inline(always)]
    pub fn only_waits(&self) -> bool {
        self.state == State::Play && self.pins == 0
    }

    /// The next event comes after the wait of this one.
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

    /// Likewise, where it need not be fast.
    #[cold]
    #[inline(never)]
    fn go_on_aside(&mut self, source: &mut impl Source, news: &mut bool) {
        self.go_on(source, news);
    }

    /// What comes next?
    #[inline(always)] // out of line, a Mega's compiler would pass its fields on the stack
    pub fn take<S: Source>(&mut self, source: &mut S, news: &mut bool) {
        loop {
            if let Some(event) = self.play.next() {
                (self.pins, self.wait) = (event.0, event.1.into());
                self.state = State::Play;
                if C::WIDE && self.pins == 0 && self.wait != 0 {
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
                Loaded::Late => return self.state = State::Starved,
                Loaded::End => return self.state = State::Idle,
            }
        }
    }
}

/// Half of a wait, in ticks.
#[inline(always)]
fn half(wait: Wait) -> Half {
    (wait >> 17) as Half
}

/// A count as a time.
pub(super) fn fine_of<C: Count>(at: C) -> C::Fine {
    // A count is its distance from 0, whichever its width.
    let zero = C::fine(0, 0);
    C::delayed(zero, at.since(C::of(zero)) as Ticks)
}
