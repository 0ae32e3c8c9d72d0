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
//! **Late steps.** A step is late when its edge comes more than half an
//! interval after its deadline: when less than half its run's shorter interval
//! is left to the next deadline (where no near one follows, to that which would
//! have been next). It is counted, and caught up: the following
//! steps come at the minimum interval, never closer, until the deadlines are
//! met again. A feed that runs dry in the middle of a travel makes the next
//! step late too, but there the schedule slips: a motor that has stood still
//! is not asked to catch up. So does anything that is late by a quarter of the
//! timer's period or more.

mod late;
mod pause;
mod track;

use crate::drive::{Axes, Drive};
use crate::queue::{Feed, Fetched};
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;
pub use pause::Frozen;
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

/// A turn may be this many ticks late and yet keep its schedule.
const SLACK: i32 = 0x1000;

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
    timing: Timing,
    late: u32,
}

impl<T: StepTimer, D: Drive, F: Feed, const N: usize> Engine<T, D, F, N> {
    const AT_MOST_8_AXES: () = assert!(N >= 1 && N <= 8);

    /// All axes idle, at position 0, facing forward.
    pub fn new(timer: T, drive: D, feeds: [F; N], timing: Timing) -> Self {
        let mut engine = Engine::off(timer, drive, feeds, timing);
        engine.begin();
        engine
    }

    /// An engine that has yet to [`begin`](Engine::begin): a constant, for a static
    /// one, as it takes much code to move an engine into its place.
    pub const fn off(timer: T, drive: D, feeds: [F; N], timing: Timing) -> Self {
        let () = Self::AT_MOST_8_AXES;
        Engine { timer, drive, feeds, tracks: [Track::IDLE; N], timing, late: 0 }
    }

    /// Turns the axes to the front, and waits for what is ordered.
    pub fn begin(&mut self) {
        for axis in 0..N as u8 {
            self.drive.direction(axis, true);
        }
        let now = self.timer.now();
        for track in &mut self.tracks {
            track.due = fine_of(now);
        }
        self.wake_for_first(now);
    }

    /// The step interrupt.
    ///
    /// Steps what is due, and returns when the next deadline lies ahead.
    pub fn on_compare(&mut self) {
        loop {
            let now = self.timer.now();
            let (mut due, mut steps, mut bit): (Axes, Axes, Axes) = (0, 0, 1);
            for track in &self.tracks {
                if track.event != Event::Idle && !track.wake().is_after(now) {
                    due |= bit;
                    if matches!(track.event, Event::Step | Event::Far) {
                        steps |= bit;
                    }
                }
                bit = bit.wrapping_shl(1);
            }
            let mut edge = now;
            if steps != 0 {
                self.drive.begin(steps);
                edge = self.timer.now();
            }
            for axis in 0..N {
                if due & 1 != 0 {
                    self.advance(axis, edge);
                }
                due >>= 1;
            }
            let next = self.wake_for_first(edge);
            if steps != 0 {
                self.timer.hold_until(edge.plus(self.timing.pulse));
                self.drive.end(steps);
            }
            let soon = self.timer.now().plus(T::LINGER);
            if next.is_after(soon) {
                return;
            }
        }
    }

    /// Sets the compare register to the first event, and returns that.
    #[inline(never)]
    fn wake_for_first(&mut self, now: T::Count) -> T::Count {
        // Nothing to do: a look round, half a period from now at the latest.
        let mut next = now.plus(2 * T::Count::HOP - 1);
        for track in &self.tracks {
            if track.event != Event::Idle {
                next = next.first(track.wake(), now);
            }
        }
        self.timer.wake_at(next);
        next
    }

    /// The event of an axis whose time has come.
    fn advance(&mut self, axis: usize, now: T::Count) {
        let (Some(track), Some(feed)) = (self.tracks.get_mut(axis), self.feeds.get_mut(axis))
        else {
            return;
        };
        match track.event {
            Event::Step => {
                let play = feed.playing(&mut track.own).stride();
                if play.left.count_down() {
                    return self.finish(axis, now);
                }
                play.grow();
                let half = play.half();
                track.due = T::Count::later(track.due, play.interval);
                let next = T::Count::of(track.due);
                self.judge(axis, next, half, now);
            }
            Event::Far => {
                // Late by half of what the timer can tell in one hop.
                let half = (T::Count::HOP / 2) as i32;
                let next = T::Count::of(track.due).plus(T::Count::HOP);
                self.load_and_judge(axis, next, half, now);
            }
            Event::Turn => {
                let forward = track.turn();
                track.push = 0;
                self.drive.direction(axis as u8, forward);
                // The set-up time counts from now. A turn that came late keeps
                // its schedule if that leaves enough, so that axes which begin
                // together stay together; if not, at rest a slip costs nothing.
                let due = track.due;
                self.load(axis, now);
                let setup = self.timing.setup as i32;
                let Some(track) = self.tracks.get_mut(axis) else { return };
                let behind = now.since(T::Count::of(due));
                let kept = (0..SLACK).contains(&behind)
                    && (track.event != Event::Step || track.wake().since(now) > setup);
                if !kept {
                    track.due = T::Count::delayed(track.due, behind.max(0) as Ticks);
                }
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

    /// The last step of a near run was made at `edge`.
    fn finish(&mut self, axis: usize, edge: T::Count) {
        let (Some(track), Some(feed)) = (self.tracks.get_mut(axis), self.feeds.get_mut(axis))
        else {
            return;
        };
        let play = feed.playing(&mut track.own).stride();
        let half = play.half();
        let next = T::Count::of(T::Count::later(track.due, play.interval));
        self.load_and_judge(axis, next, half, edge);
    }

    /// Loads, and judges the step at `edge` by the next deadline; by `next`
    /// and `half`, if that is not a step in a near run.
    fn load_and_judge(&mut self, axis: usize, next: T::Count, half: i32, edge: T::Count) {
        self.load(axis, edge);
        let (Some(track), Some(feed)) = (self.tracks.get_mut(axis), self.feeds.get_mut(axis))
        else {
            return;
        };
        if track.event == Event::Step {
            let half = feed.playing(&mut track.own).stride().half();
            let next = T::Count::of(track.due);
            self.judge(axis, next, half, edge);
        } else {
            self.judge(axis, next, half, edge);
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
            match feed.fetch(&mut track.own) {
                Fetched::Run => {
                    let slot = feed.playing(&mut track.own);
                    let Some(run) = slot.far() else {
                        track.loaded = track.loaded.wrapping_add(slot.left().into());
                        track.due = T::Count::later(track.due, slot.stride().interval);
                        track.event = Event::Step;
                        return true;
                    };
                    track.far = run;
                    if run.count == 0 {
                        track.wait(run.interval(), Event::Turn);
                        return true;
                    }
                    track.loaded = track.loaded.wrapping_add(run.count.into());
                }
                Fetched::Late => {
                    track.event = Event::Dry;
                    // Far enough apart that the foreground gets to plan: an
                    // interrupt that looked as often as it can would starve it.
                    let poll = self.timing.min_interval.saturating_mul(64).min(T::Count::HOP);
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
                track.push = 0;
                self.load(axis, now);
            }
        }
        self.wake_from_outside(now);
    }

    /// Whether no travel is in progress.
    pub fn rests(&self) -> bool {
        self.tracks.iter().all(|track| track.event == Event::Idle)
    }

    /// [`start`](Engine::start) for feeds that take their time: the first intervals count
    /// from when all have been asked. The axes MUST rest.
    pub fn start_when_loaded(&mut self, axes: Axes) {
        let begun = self.timer.now();
        self.start(axes);
        // Modulo the counter, so for any time.
        let took = self.timer.now().since(begun) as Ticks;
        for (axis, track) in self.tracks.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                track.due = T::Count::delayed(track.due, took);
            }
        }
        let now = self.timer.now();
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
                track.halt(feed.left(&track.own));
                feed.clear();
            }
        }
        self.wake_from_outside(now);
    }

    /// What the engine knows of an axis; of the first one if there is no such.
    pub fn report(&self, axis: u8) -> Report {
        let axis = if usize::from(axis) < N { usize::from(axis) } else { 0 };
        let (track, feed) = (&self.tracks[axis], &self.feeds[axis]);
        Report {
            position: track.position(feed.left(&track.own)),
            idle: track.event == Event::Idle,
            forward: track.forward,
        }
    }

    /// Sets the position of an axis. Meant for an axis at rest.
    pub fn set_position(&mut self, axis: u8, position: i64) {
        let axis = usize::from(axis);
        if let (Some(track), Some(feed)) = (self.tracks.get_mut(axis), self.feeds.get(axis)) {
            track.set_position(feed.left(&track.own), position);
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

    /// Has other times from now on. Meant for axes at rest.
    pub fn set_timing(&mut self, timing: Timing) {
        self.timing = timing;
    }

    /// The times that drivers need.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// What feeds an axis, if there is one.
    pub fn feed(&mut self, axis: u8) -> Option<&mut F> {
        self.feeds.get_mut(usize::from(axis))
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
