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
//! **Late steps.** A step is late when its edge comes more than half its
//! interval after its deadline. It is counted, and caught up: the following
//! steps come at the minimum interval, never closer, until the deadlines are
//! met again. A feed that runs dry in the middle of a travel makes the next
//! step late too, but there the schedule slips: a motor that has stood still
//! is not asked to catch up. So does anything that is late by a quarter of the
//! timer's period or more.
//!
//! **Cost** per interrupt on a chip: not measured yet; it comes with the first
//! firmware. On the host a step of the virtual board, planning and both edges
//! included, takes some 30 ns (`docs/benchmarks.md`).

use crate::drive::{Axes, Drive};
use crate::queue::{Feed, Taken};
use crate::run::Run;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

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

/// What an axis does at its next deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
#[repr(u8)]
enum Event {
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

#[derive(Clone, Copy, Debug)]
struct Track<C: Count> {
    /// Time of the next event.
    due: C::Fine,
    interval: C::Fine,
    add: i32,
    /// Steps of this run that are still to come.
    left: u16,
    event: Event,
    /// A step that is later than this is late: half the interval.
    slack: i32,
    /// Hops of a long interval, and the event that follows them.
    hops: u32,
    then: Event,
    /// A run of long intervals, dealt out step by step.
    far: Run,
    /// Ticks by which `due` lies after the deadline, while catching up.
    debt: Ticks,
    forward: bool,
    /// Position at the end of the loaded run.
    end: i64,
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
        let mut engine = Engine { timer, drive, feeds, tracks, timing, late: 0 };
        engine.wake_for_first(now);
        engine
    }

    /// The step interrupt.
    ///
    /// Steps what is due, and returns when the next deadline lies ahead.
    #[inline(always)]
    pub fn on_compare(&mut self) {
        loop {
            let now = self.timer.now();
            let mut due: Axes = 0;
            let mut steps: Axes = 0;
            for axis in 0..N {
                let track = &self.tracks[axis];
                if !T::Count::of(track.due).is_after(now) {
                    due |= 1 << axis;
                    if matches!(track.event, Event::Step | Event::CatchUp) {
                        steps |= 1 << axis;
                    }
                }
            }
            if steps != 0 {
                self.drive.begin(steps);
            }
            for axis in 0..N {
                if due & 1 << axis != 0 {
                    self.advance(axis, now);
                }
            }
            let next = self.wake_for_first(now);
            if steps != 0 {
                self.timer.hold_until(now.plus(self.timing.pulse));
                self.drive.end(steps);
            }
            if next.since(self.timer.now()) > T::LINGER as i32 {
                return;
            }
        }
    }

    /// Sets the compare register to the first event, and returns that.
    #[inline(always)]
    fn wake_for_first(&mut self, now: T::Count) -> T::Count {
        let mut next = T::Count::of(self.tracks[0].due);
        let mut ahead = next.since(now);
        for track in &self.tracks[1..] {
            let at = T::Count::of(track.due);
            let wait = at.since(now);
            if wait < ahead {
                (next, ahead) = (at, wait);
            }
        }
        self.timer.wake_at(next);
        next
    }

    /// The event of an axis whose time has come.
    #[inline(always)]
    fn advance(&mut self, axis: usize, now: T::Count) {
        let track = &mut self.tracks[axis];
        if track.event != Event::Step {
            return self.advance_rarely(axis, now);
        }
        let behind = now.since(T::Count::of(track.due));
        let late = behind > track.slack;
        track.left = track.left.wrapping_sub(1);
        if track.left == 0 {
            self.load(axis, now);
        } else {
            track.due = T::Count::later(track.due, track.interval);
            track.interval = T::Count::grown(track.interval, track.add);
        }
        if late {
            self.fell_behind(axis, now);
        }
    }

    #[cold]
    #[inline(never)]
    fn advance_rarely(&mut self, axis: usize, now: T::Count) {
        let track = &mut self.tracks[axis];
        match track.event {
            Event::Step | Event::CatchUp => {
                let deadline = now.since(T::Count::of(track.due)).saturating_add(track.debt as i32);
                if deadline > track.slack {
                    self.late = self.late.saturating_add(1);
                }
                track.left = track.left.wrapping_sub(1);
                track.event = Event::Step;
                if track.left == 0 {
                    self.load(axis, now);
                } else {
                    track.due = T::Count::later(track.due, track.interval);
                    track.interval = T::Count::grown(track.interval, track.add);
                }
                self.catch_up(axis, now);
            }
            Event::Turn => {
                let forward = track.far.turns().unwrap_or(true);
                track.forward = forward;
                // The set-up time counts from now: at rest a slip costs nothing.
                track.due = fine::<T>(now);
                track.debt = 0;
                self.drive.direction(axis as u8, forward);
                self.load(axis, now);
            }
            Event::Hop => {
                track.due = T::Count::later(track.due, T::Count::fine(T::Count::HOP, 0));
                track.hops = track.hops.wrapping_sub(1);
                if track.hops == 0 {
                    track.event = track.then;
                }
            }
            Event::Dry => {
                // The motor stands: what comes now starts from here.
                track.due = fine::<T>(now);
                self.load(axis, now);
                if self.tracks[axis].event != Event::Dry {
                    self.late = self.late.saturating_add(1);
                }
            }
            Event::Idle => {
                track.due = T::Count::later(fine::<T>(now), T::Count::fine(T::Count::HOP, 0));
            }
        }
    }

    /// The last step of a run has been made: what comes next?
    #[cold]
    #[inline(never)]
    fn load(&mut self, axis: usize, now: T::Count) {
        let track = &mut self.tracks[axis];
        if track.far.count == 0 {
            match self.feeds[axis].take() {
                Taken::Run(run) => match run.turns() {
                    None => {
                        let steps = i64::from(run.count);
                        let steps = if track.forward { steps } else { -steps };
                        track.end = track.end.wrapping_add(steps);
                        let near = u64::from(T::Count::NEAR) << 16;
                        if run.interval() < near && run.last_interval() < near {
                            return track.play(&run);
                        }
                        track.far = run;
                    }
                    Some(_) => {
                        track.far = run;
                        return track.wait(run.interval(), Event::Turn);
                    }
                },
                Taken::Late => {
                    track.event = Event::Dry;
                    // Far enough apart that the foreground gets to plan: an
                    // interrupt that looked as often as it can would starve it.
                    let poll = self.timing.min_interval.saturating_mul(64).min(T::Count::HOP);
                    track.due = T::Count::later(fine::<T>(now), T::Count::fine(poll, 0));
                    return;
                }
                Taken::End => {
                    track.event = Event::Idle;
                    track.debt = 0;
                    track.due = T::Count::later(fine::<T>(now), T::Count::fine(T::Count::HOP, 0));
                    return;
                }
            }
        }
        // One step of a run whose intervals are long.
        let interval = track.far.interval();
        let next = interval.wrapping_add_signed(track.far.add.into());
        (track.far.ticks, track.far.part) = ((next >> 16) as Ticks, next as u16);
        track.far.count -= 1;
        track.left = 1;
        track.slack = (interval >> 17).min(u64::from(T::Count::HOP)) as i32;
        track.wait(interval, Event::Step);
    }

    /// A step came late for the first time.
    #[cold]
    #[inline(never)]
    fn fell_behind(&mut self, axis: usize, now: T::Count) {
        self.late = self.late.saturating_add(1);
        self.catch_up(axis, now);
    }

    /// Moves the next step to its deadline or the minimum interval after this
    /// one, whichever is later.
    fn catch_up(&mut self, axis: usize, now: T::Count) {
        let min = self.timing.min_interval as i32;
        let track = &mut self.tracks[axis];
        match track.event {
            Event::Step | Event::CatchUp => {}
            // A long wait: the deadline needs no help.
            Event::Hop => {
                track.due = earlier::<T>(track.due, track.debt);
                track.debt = 0;
                return;
            }
            Event::Turn | Event::Dry | Event::Idle => {
                track.debt = 0;
                return;
            }
        }
        let room = T::Count::of(track.due).since(now).saturating_sub(min);
        if room < 0 {
            let push = room.unsigned_abs();
            track.due = T::Count::later(track.due, T::Count::fine(push, 0));
            track.debt = track.debt.saturating_add(push);
        } else {
            let pull = (room as Ticks).min(track.debt);
            track.due = earlier::<T>(track.due, pull);
            track.debt -= pull;
        }
        if track.debt >= T::Count::HOP {
            track.debt = 0; // too far behind: the schedule slips
        }
        track.event = if track.debt == 0 { Event::Step } else { Event::CatchUp };
    }

    /// Starts the axes in `axes` together: the first interval of each counts
    /// from now. An axis that is moving already is left alone.
    pub fn start(&mut self, axes: Axes) {
        let now = self.timer.now();
        for axis in 0..N {
            if axes >> axis & 1 != 0 && self.tracks[axis].event == Event::Idle {
                let track = &mut self.tracks[axis];
                track.due = fine::<T>(now);
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
            self.timer.wake_at(now.plus(self.timing.min_interval));
        }
    }

    /// Stops the axes in `axes` between two steps and forgets what was planned
    /// for them. Steps already made are counted.
    pub fn halt(&mut self, axes: Axes) {
        let now = self.timer.now();
        for axis in 0..N {
            if axes >> axis & 1 != 0 {
                self.feeds[axis].clear();
                let track = &mut self.tracks[axis];
                let (position, forward) = (track.position(), track.forward);
                *track = Track { end: position, forward, ..Track::idle(now) };
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
            track.end = track.end.wrapping_add(position.wrapping_sub(track.position()));
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

    /// The timer.
    pub fn timer(&mut self) -> &mut T {
        &mut self.timer
    }

    /// The drive.
    pub fn drive(&mut self) -> &mut D {
        &mut self.drive
    }
}

impl<C: Count> Track<C> {
    fn idle(now: C) -> Track<C> {
        Track {
            due: C::later(fine_of(now), C::fine(C::HOP, 0)),
            interval: C::Fine::default(),
            add: 0,
            left: 0,
            event: Event::Idle,
            slack: 0,
            hops: 0,
            then: Event::Idle,
            far: Run::steady(0, 0),
            debt: 0,
            forward: true,
            end: 0,
        }
    }

    /// Steps made: the end of the loaded run less what is left of it.
    fn position(&self) -> i64 {
        let left = i64::from(self.left) + i64::from(self.far.count);
        self.end.wrapping_sub(if self.forward { left } else { -left })
    }

    /// Begins a run of near intervals.
    fn play(&mut self, run: &Run) {
        self.left = run.count;
        self.add = run.add;
        // The run's shorter end: a little strict in between.
        self.slack = (run.interval().min(run.last_interval()) >> 17) as i32;
        let interval = C::fine(run.ticks, run.part);
        self.due = C::later(self.due, interval);
        self.interval = C::grown(interval, run.add);
        self.event = Event::Step;
    }

    /// Waits for an interval in 2⁻¹⁶ ticks of any length, then does `then`.
    fn wait(&mut self, interval: u64, then: Event) {
        let ticks = (interval >> 16) as Ticks;
        let (hops, rest) =
            if ticks < C::NEAR { (0, ticks) } else { (ticks >> C::HOP_BITS, ticks & (C::HOP - 1)) };
        self.due = C::later(self.due, C::fine(rest, interval as u16));
        (self.hops, self.then) = (hops, then);
        self.event = if hops == 0 { then } else { Event::Hop };
    }
}

fn fine_of<C: Count>(at: C) -> C::Fine {
    // A count is its distance from 0, whichever its width.
    C::fine(at.since(C::of(C::fine(0, 0))) as Ticks, 0)
}

fn fine<T: StepTimer>(at: T::Count) -> <T::Count as Count>::Fine {
    fine_of(at)
}

fn earlier<T: StepTimer>(
    due: <T::Count as Count>::Fine,
    ticks: Ticks,
) -> <T::Count as Count>::Fine {
    T::Count::later(due, T::Count::fine(0u32.wrapping_sub(ticks), 0))
}
