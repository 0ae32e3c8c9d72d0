//! One axis in the engine.

use crate::run::Run;
use crate::stride::{NEAR, Stride};
use crate::timer::Count;
use crate::units::Ticks;

/// What an axis does at its next deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Event {
    /// Steps.
    Step,
    /// Steps, behind its deadlines.
    CatchUp,
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
    /// What is being played.
    pub play: Stride,
    /// Steps of all runs loaded in this direction.
    pub loaded: u64,
    pub event: Event,
    /// The event after the last hop.
    pub then: Event,
    /// Hops of a long interval that are still to come.
    pub hops: u32,
    /// A turn, or a run of long intervals, dealt out step by step.
    pub far: Run,
    /// Ticks by which `due` lies after the deadline, while catching up.
    pub debt: Ticks,
    pub forward: bool,
    /// Position when nothing had been loaded in this direction.
    pub base: i64,
}

impl<C: Count> Track<C> {
    pub fn idle(now: C) -> Track<C> {
        Track {
            due: fine_of(now),
            play: Stride::NONE,
            loaded: 0,
            event: Event::Idle,
            then: Event::Idle,
            hops: 0,
            far: Run::steady(0, 0),
            debt: 0,
            forward: true,
            base: 0,
        }
    }

    #[inline(always)]
    pub fn is_due(&self, now: C) -> bool {
        self.event != Event::Idle && !C::of(self.due).is_after(now)
    }

    /// Steps made: all that were loaded less what is left of them.
    pub fn position(&self) -> i64 {
        let playing = match self.event {
            Event::Hop => self.then == Event::Step,
            event => matches!(event, Event::Step | Event::CatchUp),
        };
        let left = if playing { self.play.left.steps() } else { 0 } + u32::from(self.far.count);
        let made = self.loaded.wrapping_sub(left.into()) as i64;
        self.base.wrapping_add(if self.forward { made } else { made.wrapping_neg() })
    }

    /// Nothing is left to do.
    pub fn halt(&mut self) {
        self.base = self.position();
        self.loaded = 0;
        self.far.count = 0;
        self.event = Event::Idle;
    }

    /// Changes direction as the turn says that is waited for.
    pub fn turn(&mut self) -> bool {
        self.base = self.position();
        self.loaded = 0;
        self.debt = 0;
        self.forward = self.far.turns().unwrap_or(true);
        self.forward
    }

    /// Begins a run of near intervals.
    pub fn play(&mut self, stride: Stride) {
        self.play = stride;
        self.loaded = self.loaded.wrapping_add(stride.left.steps().into());
        self.due = C::later(self.due, stride.interval);
        self.event = Event::Step;
    }

    /// One step of a run whose intervals are long.
    pub fn deal(&mut self) {
        let interval = self.far.interval();
        let next = interval.wrapping_add_signed(self.far.add.into());
        (self.far.ticks, self.far.part) = ((next >> 16) as Ticks, next as u16);
        self.far.count = self.far.count.wrapping_sub(1);
        // Late by half of it, or by half a quarter of the counter.
        let longest = u64::from(NEAR) << 16;
        self.play = Stride::single(interval.min(longest) as u32);
        self.wait(interval, Event::Step);
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
