//! The engine: N axes on one timer, each with an absolute deadline.
//!
//! ```text
//!             deadline            deadline + wait
//!                │ pins               │ pins
//!   timer    ────┼──┬─────────────────┼──┬──────────► ticks
//!   STEP         ┌──┴──────┐          ┌──┴──────┐
//!            ────┘  width  └──────────┘         └────
//!   engine       pins, add the wait, set compare, drop
//! ```
//!
//! The engine plays [entries](crate::entry): pins, then a wait. `deadline += wait` never drifts and
//! needs no common tick, so axes of unrelated speeds each get exact edges. After writing the
//! compare register the engine reads the timer again and serves at once a deadline that has passed
//! meanwhile, so no compare can be missed. When the foreground sets the compare register, the timer
//! itself pends the interrupt for a deadline that has passed: see [`StepTimer`].
//!
//! **Pulses** that are over when all other work is done end in the same visit. Other pulses stay
//! high, and their end is an event like a deadline: [`StepTimer::SPIN`].
//!
//! **Late steps.** A step is late when its edge comes more than half an interval and 1 µs after its
//! deadline ([`late_after`](crate::late_after)). It is counted, and the axis catches up: the
//! following steps come at the minimum interval, never closer, until the deadlines are met again.
//! If a step is later than [`BEHIND`], the schedule shifts: all later deadlines move by its delay.
//!
//! **An empty queue** in the middle of a travel is read again at the next deadline. If that is far
//! away, it is also read 4,096 ticks before it (not on an AVR), so that an entry that has come by
//! then need not be fetched while its step waits. An entry that has come by the deadline is on
//! time. If none has come, that is one late step, and the next entry is played from the moment it
//! comes: a motor that has stood still does not catch up.
//!
//! On an AVR the controller has step interrupts in assembly, which behave the same.

mod agenda;
mod first;
mod late;
mod pause;
mod pulse;
mod track;

#[cfg(feature = "critical-section")]
use core::mem::offset_of;

use crate::drive::{Axes, Drive};
use crate::entry::Wiring;
use crate::queue::Source;
use crate::timer::{Count, StepTimer};
use crate::units::{Rate, Ticks};
use agenda::Agenda;
use first::First;
use late::Terms;
pub use pause::Frozen;
use pulse::Pulses;
#[cfg(feature = "critical-section")]
pub(crate) use track::Looked;
use track::{State, Track, fine_of};

/// STEP rises.
pub(crate) const STEP: u8 = 1;
/// DIR is toggled.
pub(crate) const TURN: u8 = 2;
/// DIR is set, whether it changes or not.
pub(crate) const FACE: u8 = 4;

/// The pins of entries for the engine, which plays all due events at once.
pub const WIRING: Wiring = Wiring::new(STEP, TURN).prompt();

/// µs behind its deadline beyond which the schedule of an axis shifts.
pub const BEHIND: u32 = 192;

/// ns from one read of an empty queue to the next: 8,995 ticks of 16 MHz.
const POLL: u32 = 562_188;

/// The times that drivers need, in ticks of the step timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// STEP stays high for at least this long.
    pub pulse: Ticks,
    /// DIR is set at least this long before the rising edge of STEP.
    pub setup: Ticks,
    /// DIR is kept at least this long after the rising edge of STEP.
    pub hold: Ticks,
    /// The shortest interval between two steps of one axis: at least the pulse width and a pause of
    /// the same length, and what the board can do.
    pub min_interval: Ticks,
}

/// Repeats a block for each of N ≤ 8 axes: not a loop, in which an 8-bit chip would compute the
/// address of each field.
macro_rules! each {
    ($axis:ident < $n:ident: $body:block) => {
        each!($axis < $n: $body, 0 1 2 3 4 5 6 7)
    };
    ($axis:ident < $n:ident: $body:block, $($place:literal)*) => {
        $(if $place < $n {
            let $axis: usize = $place;
            $body
        })*
    };
}

/// The engine's state of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Steps emitted, forward minus backward.
    pub position: i64,
    /// No travel is in progress.
    pub idle: bool,
    /// Direction of the last or present travel.
    pub forward: bool,
}

/// What is left of the entry that an axis plays: the first entry that its queue does not count as
/// played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Playing {
    /// Unknown: at rest, or if the engine can't tell. Allowed only for steps; the rest of a wait
    /// must be given, because a planner assumes that an unknown entry may last in full and may
    /// be over at once.
    Unknown,
    /// This many ticks.
    Left(Ticks),
    /// Nothing: the queue was empty this many ticks before the next event was due.
    Dry(Ticks),
}

/// Plays the entries of N ≤ 8 axes with one timer.
///
/// Belongs to the step interrupt, which calls [`on_compare`](Engine::on_compare). The foreground
/// calls the other methods, with that interrupt held off for the few microseconds that they take.
#[cfg_attr(not(feature = "compact"), repr(C))] // the fields that most visits read come first
pub struct Engine<T: StepTimer, D, S, const N: usize> {
    first: First<T::Count, N>,
    timer: T,
    drive: D,
    sources: [S; N],
    tracks: [Track<T::Count>; N],
    pulses: Pulses<T::Count, N>,
    terms: Terms,
}

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Engine<T, D, S, N> {
    const AT_MOST_8_AXES: () = assert!(N >= 1 && N <= 8);
    /// Whether the interrupt may leave while STEP is high.
    const LEAVES_HIGH: bool = T::SPIN != Ticks::MAX;

    /// All axes idle, at position 0, facing forward. The timer counts at `rate`.
    pub fn new(timer: T, drive: D, sources: [S; N], timing: Timing, rate: Rate) -> Self {
        let mut engine = Engine::off(timer, drive, sources, timing, rate);
        engine.begin();
        engine
    }

    /// An engine before [`begin`](Engine::begin): a constant, for a static engine, as it takes much
    /// code to move an engine into its place.
    pub const fn off(timer: T, drive: D, sources: [S; N], timing: Timing, rate: Rate) -> Self {
        let () = Self::AT_MOST_8_AXES;
        Engine {
            first: First::new(Agenda::EMPTY),
            terms: Terms::new::<T::Count>(Self::seen(timing), rate),
            tracks: [Track::IDLE; N],
            pulses: Pulses::NONE,
            sources,
            timer,
            drive,
        }
    }

    /// The times as the engine keeps them. Intervals count from an edge, which is
    /// [`REACTION`](StepTimer::REACTION) late, as the next one is. A pulse and a pause always fit.
    const fn seen(timing: Timing) -> Timing {
        if T::REACTION == 0 {
            return timing;
        }
        let least = timing.min_interval.saturating_sub(T::REACTION);
        let pulses = timing.pulse.saturating_mul(2);
        let both = if timing.min_interval < pulses { timing.min_interval } else { pulses };
        Timing { min_interval: if least < both { both } else { least }, ..timing }
    }

    /// Sets all directions forward, and sets the compare register.
    pub fn begin(&mut self) {
        for axis in 0..N as u8 {
            self.drive.direction(axis, true);
        }
        let now = self.timer.now();
        for track in &mut self.tracks {
            track.due = fine_of(now);
        }
        self.wake_from_outside(now);
    }

    /// The step interrupt.
    ///
    /// Plays what is due, and returns when the next deadline is ahead. Returns true if there was
    /// news for the foreground meanwhile: an axis has ended its travel, a step was late, or a queue
    /// has room for more. Room is no news of programs that are [asked](crate::queue::Asked).
    #[cfg_attr(not(feature = "compact"), inline(always))]
    pub fn on_compare(&mut self) -> bool {
        if T::Count::WIDE {
            return self.step_first();
        }
        self.terms.news = false;
        self.visit()
    }

    /// Plays what is due until the next event is ahead. Returns whether there was news.
    #[cfg_attr(feature = "compact", inline(always))]
    #[cfg_attr(not(feature = "compact"), inline(never))]
    fn visit(&mut self) -> bool {
        loop {
            let now = self.timer.now();
            let next = match self.play_first(now) {
                Some(next) => next,
                None => self.play_due(now),
            };
            if next.is_after(self.timer.now().plus(T::LINGER)) {
                return self.terms.news;
            }
        }
    }

    /// Plays all that is due, and returns the time of the first event.
    #[cfg_attr(feature = "compact", inline(always))]
    #[cfg_attr(not(feature = "compact"), inline(never))]
    fn play_due(&mut self, now: T::Count) -> T::Count {
        self.end_pulses(now);
        let (mut due, mut steps): (Axes, Axes) = (0, 0);
        each!(axis < N: {
            let track = &mut self.tracks[axis];
            if track.state != State::Idle
                && !self.timer.reach(axis as u8, track.wake()).is_after(now)
                && (track.state == State::Play
                    || track.ask_again(&mut self.sources[axis], &mut self.terms))
            {
                due |= 1 << axis;
                if track.pins & STEP != 0 {
                    steps |= 1 << axis;
                }
            }
        });
        let mut edge = now;
        if steps != 0 {
            self.drive.begin(steps);
            edge = self.timer.now();
        }
        let least = self.terms.least;
        each!(axis < N: {
            if due & 1 << axis != 0 && self.tracks[axis].play_again(edge, least) {
                due ^= 1 << axis;
            }
        });
        self.conclude(due, steps, edge)
    }

    /// Plays those events at `edge` that have not been played yet, ends or leaves the pulses of
    /// these steps, and returns the time of the first event.
    #[cfg_attr(feature = "compact", inline(always))]
    fn conclude(&mut self, due: Axes, steps: Axes, edge: T::Count) -> T::Count {
        if due != 0 {
            self.advance_all(due, edge);
        }
        if Self::LEAVES_HIGH {
            self.leave_high(steps, edge);
        }
        let next = self.wake_for_first(edge);
        if !Self::LEAVES_HIGH {
            self.hold_high(steps, edge);
        }
        next
    }

    /// Sets the compare register to the first event, and returns its time. For the interrupt, which
    /// reads the timer afterwards.
    #[inline(never)]
    fn wake_for_first(&mut self, now: T::Count) -> T::Count {
        let mut next = if T::Count::WIDE {
            self.find_first(now)
        } else {
            // Nothing to do: look at all axes again half a period from now at the latest.
            let mut next = now.plus(2 * T::Count::HOP - 1);
            each!(axis < N: {
                let track = &self.tracks[axis];
                if track.state != State::Idle {
                    next = next.first(self.timer.reach(axis as u8, track.wake()), now);
                }
            });
            next
        };
        if Self::LEAVES_HIGH && self.pulses.any() {
            next = self.pulses.first(next, now);
            if let Some(agenda) = self.first.get_mut() {
                agenda.hide_first();
            }
        }
        self.timer.set_compare(next);
        next
    }

    /// Plays the due events of these axes at `edge`.
    #[inline(never)]
    fn advance_all(&mut self, due: Axes, edge: T::Count) {
        let Engine { drive, sources, tracks, terms, .. } = self;
        each!(axis < N: {
            if due & 1 << axis != 0 {
                tracks[axis].advance(&mut sources[axis], drive, terms, axis as u8, edge);
            }
        });
    }

    /// Starts the axes in `axes` together: the first entry of each is played now. An axis that is
    /// already moving is not changed.
    pub fn start(&mut self, axes: Axes) {
        let now = self.timer.now();
        for (axis, (track, source)) in self.tracks.iter_mut().zip(&mut self.sources).enumerate() {
            if axes >> axis & 1 != 0 && track.state == State::Idle {
                track.start(now, source, &mut self.terms.news);
            }
        }
        self.wake_from_outside(now);
    }

    /// Whether no travel is in progress.
    #[doc(hidden)]
    pub fn rests(&self) -> bool {
        self.tracks.iter().all(|track| track.state == State::Idle)
    }

    /// [`start`](Engine::start) for sources that take long: the first waits count from the time
    /// when all have been asked. The axes are at rest.
    #[doc(hidden)]
    pub fn start_when_loaded(&mut self, axes: Axes) {
        let begun = self.timer.now();
        self.start(axes);
        // If asking takes time, an axis that turns first does so here: a small chip takes longer to
        // ask some programs than their first delay lasts.
        if self.timer.now().since(begun) != 0 {
            let mut turns: Axes = 0;
            for (axis, track) in self.tracks.iter().enumerate() {
                if axes >> axis & 1 != 0 && track.state == State::Play && track.pins & STEP == 0 {
                    turns |= u8::from(track.pins != 0) << axis;
                }
            }
            self.advance_all(turns, begun);
        }
        // Modulo the counter, so correct for any time.
        let took = self.timer.now().since(begun) as Ticks;
        for (axis, track) in self.tracks.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                track.due = T::Count::delayed(track.due, took);
            }
        }
        let now = self.timer.now();
        self.wake_from_outside(now);
    }

    /// Sets the compare register to the first event, from the foreground, which can't serve what is
    /// due: the timer pends its interrupt for that.
    fn wake_from_outside(&mut self, now: T::Count) {
        let next = self.wake_for_first(now);
        self.timer.wake_at(next);
    }

    /// Stops the axes in `axes` at once, between two steps, and forgets what was planned for them.
    /// Steps already made are counted.
    pub fn kill(&mut self, axes: Axes) {
        let now = self.timer.now();
        for (axis, (track, source)) in self.tracks.iter_mut().zip(&mut self.sources).enumerate() {
            if axes >> axis & 1 != 0 {
                track.state = State::Idle;
                source.clear(track.forward);
            }
        }
        self.wake_from_outside(now);
    }

    /// The state of an axis; of the first axis if there is no such axis.
    pub fn report(&self, axis: u8) -> Report {
        let axis = if usize::from(axis) < N { usize::from(axis) } else { 0 };
        let track = &self.tracks[axis];
        Report {
            position: track.position(),
            idle: track.state == State::Idle,
            forward: track.forward,
        }
    }

    /// Whether the next event of an axis sets no pins.
    pub fn waits(&self, axis: u8) -> bool {
        self.tracks.get(usize::from(axis)).is_some_and(Track::only_waits)
    }

    /// What is left of the present entry of an axis. A planner that knows this queues nothing after
    /// a long wait until the wait is nearly over.
    pub fn playing(&mut self, axis: u8) -> Playing {
        let now = self.timer.now();
        self.tracks.get(usize::from(axis)).map_or(Playing::Unknown, |track| track.playing(now))
    }

    /// Pointers to the timer and to the axis of an engine, from which [`playing`](Engine::playing)
    /// is computed; `None` if there is no such axis.
    #[cfg(feature = "critical-section")]
    #[inline(always)]
    pub(crate) fn places(this: *mut Self, axis: u8) -> Option<(*mut T, *const Looked<T::Count>)> {
        if usize::from(axis) >= N {
            return None;
        }
        let at = |offset| this.cast::<u8>().wrapping_add(offset);
        let tracks = at(offset_of!(Self, tracks)).cast::<Looked<T::Count>>();
        Some((at(offset_of!(Self, timer)).cast(), tracks.wrapping_add(axis.into())))
    }

    /// Whether an axis has no travel in progress; true if there is no such axis.
    #[inline(always)]
    pub fn is_idle(&self, axis: u8) -> bool {
        self.tracks.get(usize::from(axis)).is_none_or(|track| track.state == State::Idle)
    }

    /// Sets the position of an axis. Call it while the axis is at rest.
    pub fn set_position(&mut self, axis: u8, position: i64) {
        if let Some(track) = self.tracks.get_mut(usize::from(axis)) {
            track.set_position(position);
        }
    }

    /// The number of late steps since the beginning, or since it was cleared.
    pub fn late(&self) -> u32 {
        self.terms.late
    }

    /// Sets the number of late steps to 0.
    pub fn clear_late(&mut self) {
        self.terms.late = 0;
    }

    /// Sets the drivers' times. Call it while all axes are at rest.
    pub fn set_timing(&mut self, timing: Timing) {
        self.terms.set_timing::<T::Count>(Self::seen(timing));
    }

    /// The drivers' times; the minimum interval as the engine keeps it, counted from
    /// [`REACTION`](StepTimer::REACTION) before an edge.
    pub fn timing(&self) -> Timing {
        self.terms.timing
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
