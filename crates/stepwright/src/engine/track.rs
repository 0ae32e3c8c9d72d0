//! One axis in the engine.

use crate::run::Run;
use crate::stride::{NEAR, Slot};
use crate::timer::Count;
use crate::units::Ticks;

/// What an axis does at its next deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Event {
    /// Steps.
    Step,
    /// Steps after a long interval.
    Far,
    /// Changes direction.
    Turn,
    /// Waits on: the interval is longer than the timer can tell.
    Hop,
    /// Looks whether the feed has caught up.
    Dry,
    /// Nothing.
    Idle,
}

/// The layout up to `loaded` is the one that the short way knows.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Track<C: Count> {
    /// Time of the next event.
    pub due: C::Fine,
    /// Where the short way finds what is played.
    pub at: u16,
    /// Where the axis will be when all that is loaded is made, counted in its
    /// direction from [`ORIGIN`] on.
    pub loaded: u64,
    pub event: Event,
    /// The event after the last hop.
    pub then: Event,
    /// Hops of a long interval that are still to come.
    pub hops: u32,
    /// A turn, or a run of long intervals, dealt out step by step.
    pub far: Run,
    /// What is played, if the feed does not keep it.
    pub own: Slot,
    /// Ticks to wait beyond `due`, for the sake of the minimum interval or the hold time.
    pub push: Ticks,
    pub forward: bool,
}

/// What `loaded` is at position 0: so large that nobody gets below 0, for the
/// short way carries into 40 bits. At 120,000 steps/s they last for 53 days, in
/// one direction.
const ORIGIN: u64 = 1 << 39;

/// The position of an axis that has `left` of the loaded steps still to make.
#[inline(always)]
pub(super) fn position(loaded: u64, forward: bool, left: u16) -> i64 {
    let made = loaded.wrapping_sub(ORIGIN).wrapping_sub(left.into()) as i64;
    if forward { made } else { made.wrapping_neg() }
}

impl<C: Count> Track<C> {
    /// At rest at position 0, facing forward.
    pub const IDLE: Track<C> = Track {
        due: C::ZERO.1,
        at: 0,
        loaded: ORIGIN,
        event: Event::Idle,
        then: Event::Idle,
        hops: 0,
        far: Run::steady(0, 0),
        own: Slot::EMPTY,
        push: 0,
        forward: true,
    };

    /// When the next event may happen.
    #[inline(always)]
    pub fn wake(&self) -> C {
        // Most often there is nothing to add, and it costs an 8-bit chip.
        if self.push == 0 { C::of(self.due) } else { C::of(self.due).plus(self.push) }
    }

    /// Where the axis is, with `playing` steps left of a near run.
    pub fn position(&self, playing: u16) -> i64 {
        position(self.loaded, self.forward, self.left(playing))
    }

    /// Steps of what was loaded that are still to be made.
    pub fn left(&self, playing: u16) -> u16 {
        let left = match self.event {
            Event::Step => playing,
            Event::Far => 1,
            Event::Hop if self.then == Event::Far => 1,
            _ => 0,
        };
        left.wrapping_add(self.far.count)
    }

    /// The present position has this number.
    pub fn set_position(&mut self, playing: u16, position: i64) {
        let counted = if self.forward { position } else { position.wrapping_neg() };
        let left = u64::from(self.left(playing));
        self.loaded = ORIGIN.wrapping_add_signed(counted).wrapping_add(left);
    }

    /// Nothing is left to do.
    pub fn halt(&mut self, playing: u16) {
        self.loaded = self.loaded.wrapping_sub(self.left(playing).into());
        self.far.count = 0;
        self.event = Event::Idle;
    }

    /// Changes direction as the turn says that is waited for.
    pub fn turn(&mut self) -> bool {
        let forward = self.far.turns().unwrap_or(true);
        if forward != self.forward {
            self.forward = forward;
            self.loaded = (2 * ORIGIN).wrapping_sub(self.loaded);
        }
        forward
    }

    /// One step of a run whose intervals are long.
    pub fn deal(&mut self) {
        let interval = self.far.interval();
        let next = interval.wrapping_add_signed(self.far.add.into());
        (self.far.ticks, self.far.part) = ((next >> 16) as Ticks, next as u16);
        self.far.count = self.far.count.wrapping_sub(1);
        self.wait(interval, Event::Far);
    }

    /// Waits for an interval in 2⁻¹⁶ ticks of any length, then does `then`.
    pub fn wait(&mut self, interval: u64, then: Event) {
        let ticks = (interval >> 16) as Ticks;
        let (hops, rest) =
            if ticks < NEAR { (0, ticks) } else { (ticks >> C::HOP_BITS, ticks & (C::HOP - 1)) };
        self.due = C::delayed(C::later(self.due, interval as u16 as u32), rest);
        (self.hops, self.then) = (hops, then);
        self.event = if hops == 0 { then } else { Event::Hop };
    }

    /// One hop of a long interval is over.
    pub fn hop(&mut self) {
        self.due = C::delayed(self.due, C::HOP);
        self.hops = self.hops.wrapping_sub(1);
        if self.hops == 0 {
            self.event = self.then;
        }
    }
}

/// A count as a time.
pub(super) fn fine_of<C: Count>(at: C) -> C::Fine {
    // A count is its distance from 0, whichever its width.
    let zero = C::fine(0, 0);
    C::delayed(zero, at.since(C::of(zero)) as Ticks)
}
