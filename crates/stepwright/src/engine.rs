//! The engine: N axes on one timer, each with an absolute deadline.
//!
//! ```text
//!             deadline            deadline + interval
//!                │ entry              │
//!   timer    ────┼──┬─────────────────┼──┬──────────► ticks
//!   STEP         ┌──┴──────┐          ┌──┴──────┐
//!            ────┘  width  └──────────┘         └────
//!   engine       raise, advance, set compare, wait, drop
//! ```
//!
//! `deadline += interval; interval += add` never drifts and needs no common
//! tick; axes of unrelated speeds get their own exact edges. After the compare
//! register is written the engine looks at the timer again: a deadline that
//! has passed meanwhile is served at once, so no compare can be missed.
//!
//! **Late steps.** A step is late when its edge comes more than half the
//! interval to the next one after its deadline (half the interval before it, if
//! none follows at once). It is counted, and caught up: the following
//! steps come at the minimum interval, never closer, until the deadlines are
//! met again. A feed that runs dry in the middle of a travel makes the next
//! step late too, but there the schedule slips: a motor that has stood still
//! is not asked to catch up. So does anything that is late by a quarter of the
//! timer's period or more.
//!
//! **The short way.** On an AVR most interrupts are one plain step in time.
//! [`short_way!`](crate::short_way) makes an interrupt handler in assembly
//! that does these, at fixed addresses, and calls the engine for the rest; it
//! leaves what the engine would have left. `engine/short.rs` has the costs.

mod late;
#[cfg(target_arch = "avr")]
mod short;
#[cfg(target_arch = "avr")]
mod short_text;
mod track;

use crate::drive::{Axes, Drive};
use crate::queue::{Feed, Fetched};
use crate::stride::Entry;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;
use track::{Event, Track, fine_of};

/// The times that drivers need, in ticks of the step timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// STEP stays high for at least so long.
    pub pulse: Ticks,
    /// DIR is set at least so long before the rising edge of STEP.
    pub setup: Ticks,
    /// DIR is kept at least so long after the rising edge of STEP.
    pub hold: Ticks,
    /// Two steps of one axis never come closer: at least the pulse width and
    /// as long a pause, and what the board can do.
    pub min_interval: Ticks,
}

/// What the engine knows of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Steps emitted, forward minus backward.
    pub position: i64,
    /// No travel is in progress.
    pub idle: bool,
    /// Direction of the last or present travel.
    pub forward: bool,
}

/// Plays the runs of N ≤ 8 axes with one timer.
///
/// Belongs to the step interrupt, which calls [`on_compare`](Engine::on_compare).
/// The other methods are for the foreground, with that interrupt held off for
/// the few microseconds they take.
pub struct Engine<T: StepTimer, D, F, const N: usize> {
    timer: T,
    drive: D,
    feeds: [F; N],
    tracks: [Track<T::Count>; N],
    /// For the short way: the first deadline that is not for a plain step.
    rare: T::Count,
    timing: Timing,
    late: u32,
}

impl<T: StepTimer, D: Drive, F: Feed, const N: usize> Engine<T, D, F, N> {
    const AT_MOST_8_AXES: () = assert!(N >= 1 && N <= 8);

    /// All axes idle, at position 0, facing forward.
    pub fn new(mut timer: T, mut drive: D, feeds: [F; N], timing: Timing) -> Self {
        let () = Self::AT_MOST_8_AXES;
        let now = timer.now();
        let mut axis = 0;
        let tracks = [(); N].map(|()| {
            drive.direction(axis, true);
            axis += 1;
            Track::idle(now)
        });
        let mut engine = Engine { timer, drive, feeds, tracks, rare: now, timing, late: 0 };
        engine.wake_for_first(now);
        engine
    }

    /// The step interrupt.
    ///
    /// Steps what is due, and returns when the next deadline lies ahead.
    pub fn on_compare(&mut self) {
        loop {
            let now = self.timer.now();
            let mut due: Axes = 0;
            let mut steps: Axes = 0;
            for (axis, track) in self.tracks.iter().enumerate() {
                if track.is_due(now) {
                    due |= 1 << axis;
                    if matches!(track.event, Event::Step | Event::CatchUp) {
                        steps |= 1 << axis;
                    }
                }
            }
            let mut edge = now;
            if steps != 0 {
                self.drive.begin(steps);
                edge = self.timer.now();
            }
            for axis in 0..N {
                if due & 1 << axis != 0 {
                    self.advance(axis, edge);
                }
            }
            let next = self.wake_for_first(now);
            if steps != 0 {
                self.timer.hold_until(edge.plus(self.timing.pulse));
                self.drive.end(steps);
            }
            if next.since(self.timer.now()) > T::LINGER as i32 {
                return;
            }
        }
    }

    /// Sets the compare register to the first event, and returns that.
    fn wake_for_first(&mut self, now: T::Count) -> T::Count {
        // Nothing to do: a look round, half a period from now at the latest.
        let mut ahead = (2 * T::Count::HOP - 1) as i32;
        let mut next = now.plus(ahead as Ticks);
        let mut rare = ahead;
        let mut flags = short_flags::NONE;
        for (axis, track) in self.tracks.iter().enumerate() {
            if track.event == Event::Idle {
                continue;
            }
            let at = T::Count::of(track.due);
            let wait = at.since(now);
            let first = wait < ahead;
            if first {
                (next, ahead) = (at, wait);
            }
            if T::SHORT {
                let plain = track.event == Event::Step;
                if !plain && wait <= rare {
                    (self.rare, rare) = (at, wait);
                }
                flags = short_flags::with(flags, axis, plain, first);
            }
        }
        self.timer.wake_at(next);
        if T::SHORT {
            self.timer.arm(if self.timing.pulse > PULSE { 0 } else { flags });
        }
        next
    }

    /// The event of an axis whose time has come.
    fn advance(&mut self, axis: usize, now: T::Count) {
        let Some(track) = self.tracks.get_mut(axis) else { return };
        match track.event {
            Event::Step | Event::CatchUp => {
                let behind = now.since(T::Count::of(track.due));
                if track.play.left.count_down() {
                    self.load(axis, now);
                } else {
                    track.play.grow();
                    track.due = T::Count::later(track.due, track.play.interval);
                }
                self.judge(axis, behind, now);
            }
            Event::Turn => {
                let forward = track.turn();
                // The set-up time counts from now: at rest a slip costs nothing.
                track.due = fine_of(now);
                self.drive.direction(axis as u8, forward);
                self.load(axis, now);
            }
            Event::Hop => track.hop(),
            Event::Dry => {
                // The motor stands: what comes now starts from here.
                track.due = fine_of(now);
                if self.load(axis, now) {
                    self.late = self.late.saturating_add(1);
                }
            }
            Event::Idle => {}
        }
    }

    /// The last step of a run has been made: what comes next? False if the
    /// feed is late.
    #[inline(never)]
    fn load(&mut self, axis: usize, now: T::Count) -> bool {
        let (Some(track), Some(feed)) = (self.tracks.get_mut(axis), self.feeds.get_mut(axis))
        else {
            return true;
        };
        if track.far.count == 0 {
            match feed.fetch() {
                Fetched::Slot(slot) => match slot.entry() {
                    Entry::Near(stride) => {
                        track.play(stride);
                        return true;
                    }
                    Entry::Far(run) => {
                        track.far = run;
                        if run.count == 0 {
                            track.wait(run.interval(), Event::Turn);
                            return true;
                        }
                        track.loaded = track.loaded.wrapping_add(run.count.into());
                    }
                },
                Fetched::Late => {
                    track.event = Event::Dry;
                    let poll = self.timing.min_interval.saturating_mul(4).min(T::Count::HOP);
                    track.due = T::Count::delayed(fine_of(now), poll);
                    return false;
                }
                Fetched::End => {
                    track.event = Event::Idle;
                    return true;
                }
            }
        }
        track.deal();
        true
    }

    /// Starts the axes in `axes` together: the first interval of each counts
    /// from now. An axis that is moving already is left alone.
    pub fn start(&mut self, axes: Axes) {
        let now = self.timer.now();
        for axis in 0..N {
            let Some(track) = self.tracks.get_mut(axis) else { break };
            if axes >> axis & 1 != 0 && track.event == Event::Idle {
                track.due = fine_of(now);
                track.debt = 0;
                self.load(axis, now);
            }
        }
        self.wake_from_outside(now);
    }

    /// [`wake_for_first`](Engine::wake_for_first) from the foreground, which
    /// can't serve what is due: then the interrupt comes a little later.
    fn wake_from_outside(&mut self, now: T::Count) {
        let next = self.wake_for_first(now);
        let now = self.timer.now();
        if next.since(now) <= T::LINGER as i32 {
            self.timer.wake_at(now.plus(T::LINGER + 1));
        }
    }

    /// Stops the axes in `axes` between two steps and forgets what was planned
    /// for them. Steps already made are counted.
    pub fn halt(&mut self, axes: Axes) {
        let now = self.timer.now();
        for (axis, (track, feed)) in self.tracks.iter_mut().zip(&mut self.feeds).enumerate() {
            if axes >> axis & 1 != 0 {
                feed.clear();
                track.halt();
            }
        }
        self.wake_from_outside(now);
    }

    /// What the engine knows of an axis; of the first one if there is no such.
    pub fn report(&self, axis: u8) -> Report {
        let track = self.tracks.get(usize::from(axis)).unwrap_or(&self.tracks[0]);
        Report {
            position: track.position(),
            idle: track.event == Event::Idle,
            forward: track.forward,
        }
    }

    /// Sets the position of an axis. Meant for an axis at rest.
    pub fn set_position(&mut self, axis: u8, position: i64) {
        if let Some(track) = self.tracks.get_mut(usize::from(axis)) {
            track.base = track.base.wrapping_add(position.wrapping_sub(track.position()));
        }
    }

    /// Late steps since the beginning, or since they were cleared.
    pub fn late(&self) -> u32 {
        self.late
    }

    /// Forgets the late steps.
    pub fn clear_late(&mut self) {
        self.late = 0;
    }

    /// The times that drivers need.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// The timer.
    pub fn timer(&mut self) -> &mut T {
        &mut self.timer
    }

    /// The drive.
    pub fn drive(&mut self) -> &mut D {
        &mut self.drive
    }
}

/// The short way's pulse is so long or longer.
const PULSE: Ticks = 40;

/// What the short way is told.
mod short_flags {
    pub(super) const NONE: u8 = 0;
    const FIRST: u8 = 0b111;
    const STEPS: u8 = 0b111 << 3;
    const RARE: u8 = 1 << 6;
    const SEVERAL: u8 = 1 << 7;

    /// An axis more: whether a plain step is what comes, and whether it is the
    /// first of all so far.
    pub(super) const fn with(flags: u8, axis: usize, plain: bool, first: bool) -> u8 {
        let mut all = flags;
        if flags & (STEPS | RARE) != 0 {
            all |= SEVERAL;
        }
        if first {
            all &= !FIRST;
        }
        match (plain, first) {
            (true, true) => all | 0b1001 << axis,
            (true, false) => all | 0b1000 << axis,
            (false, _) => all | RARE,
        }
    }
}
