//! The program of a motor in a cycle: stepper_h's `prepare_…` functions.
//!
//! | document | here |
//! | --- | --- |
//! | `prepare_steps` | [`Program::Steps`] |
//! | `prepare_whirl` | [`Program::Whirl`] |
//! | `prepare_simple_buffered_steps` | [`Program::List`] |
//! | `prepare_buffered_steps` | [`Program::Series`] |
//! | `prepare_dynamic_steps` | [`Program::Dynamic`], [`Program::Ramp`] |
//! | `prepare_dynamic_whirl` | [`Program::DynamicWhirl`], [`Program::Ramp`] |
//!
//! [`Program::Paced`] has no counterpart: it plays steps that were planned elsewhere. A count's
//! sign is its direction, as in the README of stepper_h; a delay is in µs, and 0 means the motor's
//! smallest.

use core::cell::Cell;

#[cfg(feature = "runs")]
use stepwright::run::Run;
use stepwright::units::Ticks;

use super::clock::Beat;
#[cfg(feature = "runs")]
use super::wide::product;

/// Whether there are programs to a tick of the timer; if not, none of their code is compiled.
pub(crate) const PACED: bool = cfg!(feature = "paced");

/// Whether legs may be runs; if not, none of their code is compiled.
pub(crate) const RUNS: bool = cfg!(feature = "runs");

/// A callback that returns the delay before each next step, in µs.
///
/// It is called from the step interrupt, once for each step, with the number of steps asked for
/// before: 0, 1, 2 …; after the previous step, and at the start for the first one. MUST NOT block.
pub type NextDelay<'a> = &'a mut (dyn FnMut(u32) -> u32 + Send);

/// The program of a motor in a cycle.
pub enum Program<'a> {
    /// `count` steps, one every `delay`.
    Steps {
        /// The number of steps; backward if negative.
        count: i32,
        /// µs from step to step.
        delay: u32,
    },
    /// Steps without end.
    Whirl {
        /// The direction.
        forward: bool,
        /// µs from step to step.
        delay: u32,
    },
    /// A list of delays, each for `each` steps.
    List {
        /// µs from step to step.
        delays: &'a [u32],
        /// Steps for each delay.
        each: u32,
        /// The direction.
        forward: bool,
    },
    /// Legs, one after another.
    Series(&'a [Leg]),
    /// Legs in memory that is written between cycles. If a leg is written while a cycle runs, it
    /// may or may not be played.
    Stored(&'a [Cell<Leg>]),
    /// Steps whose delays go from one value to another and stay there: like a callback, but without
    /// a closure.
    Ramp {
        /// The number of steps; `None`: without end.
        steps: Option<u32>,
        /// The direction.
        forward: bool,
        /// The delays.
        ramp: DelayRamp,
    },
    /// `count` steps, whose delays a callback gives.
    Dynamic {
        /// The number of steps; backward if negative.
        count: i32,
        /// Returns the delay before each step.
        next: NextDelay<'a>,
    },
    /// Steps without end, whose delays a callback gives.
    DynamicWhirl {
        /// The direction.
        forward: bool,
        /// Returns the delay before each step.
        next: NextDelay<'a>,
    },
    /// Steps to a tick of the timer, in either direction: any law, a line, a curve. By deadlines
    /// only.
    Paced(Paces<'a>),
}

/// Delays that go from one value to another and stay there.
///
/// ```
/// use stepwright_cycle::DelayRamp;
/// let ramp = DelayRamp { from: 3_000, to: 600, by: 1_000 };
/// assert_eq!([0, 1, 2, 3, 4].map(|step| ramp.delay(step)), [3_000, 2_000, 1_000, 600, 600]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DelayRamp {
    /// µs before the first step.
    pub from: u32,
    /// µs at the end.
    pub to: u32,
    /// µs by which each delay differs from the one before.
    pub by: u32,
}

impl DelayRamp {
    /// The delay before a step in µs; the first step is 0.
    pub const fn delay(self, step: u32) -> u32 {
        let way = self.by.saturating_mul(step);
        if self.from < self.to {
            let delay = self.from.saturating_add(way);
            if delay < self.to { delay } else { self.to }
        } else {
            let delay = self.from.saturating_sub(way);
            if delay > self.to { delay } else { self.to }
        }
    }
}

/// The next element of a [`Program::Paced`], in ticks of the timer after the previous one, or after
/// the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// A step.
    Step {
        /// After this many ticks.
        ticks: Ticks,
        /// The direction.
        forward: bool,
    },
    /// No step yet: asks again later, so that the next steps may still change.
    Wait {
        /// After this many ticks, 1 and more.
        ticks: Ticks,
    },
}

/// Steps and waits, each asked for when the previous one is over.
///
/// Asked from the step interrupt: MUST NOT block.
pub type Paces<'a> = &'a mut (dyn Iterator<Item = Pace> + Send);

/// A part of a [`Program::Series`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// `count` steps, one every `delay`.
    Steps {
        /// The number of steps; backward if negative.
        count: i32,
        /// µs from step to step.
        delay: u32,
    },
    /// No step for `count` times `delay` (direction 0 of stepper_h).
    Wait {
        /// The number of delays.
        count: u32,
        /// µs.
        delay: u32,
    },
    /// A run that was planned elsewhere, to a fraction of a tick of the timer; one without steps is
    /// a wait. By deadlines only. A start is refused if an interval of it is smaller than the
    /// motor's smallest delay, whatever the strategy.
    #[cfg(feature = "runs")] // without it legs are shorter
    Run {
        /// The intervals.
        run: Run,
        /// The direction.
        forward: bool,
    },
}

impl Leg {
    /// The smallest interval in µs, rounded down, if the leg makes a step. A delay below the
    /// motor's smallest is fixed or ends the cycle; an interval of a run is not.
    #[cfg_attr(not(feature = "runs"), allow(unused_variables))] // only runs need the clock
    fn delay(self, smallest: u32, beat: &Beat) -> Option<u32> {
        match self {
            Leg::Steps { count: 0, .. } | Leg::Wait { .. } => None,
            Leg::Steps { delay, .. } => Some(delay.max(smallest)),
            #[cfg(feature = "runs")]
            Leg::Run { run, .. } if run.count() == 0 => None,
            #[cfg(feature = "runs")]
            Leg::Run { run, .. } => {
                let least = run.interval().min(after(run, run.count().saturating_sub(1)));
                Some(beat.whole_micros(Ticks::try_from(least >> 16).unwrap_or(Ticks::MAX)))
            }
        }
    }

    /// Whether the leg is counted in ticks of the timer.
    fn is_paced(self) -> bool {
        match self {
            Leg::Steps { .. } | Leg::Wait { .. } => false,
            #[cfg(feature = "runs")]
            Leg::Run { .. } => true,
        }
    }

    fn next(self) -> Next {
        match self {
            Leg::Steps { count, delay } => steps(count, delay),
            Leg::Wait { count, delay } => Next::Wait { count, delay },
            #[cfg(feature = "runs")]
            Leg::Run { run, forward } => Next::Run { run, forward },
        }
    }
}

/// The interval of a run after this many of its steps, in 2⁻¹⁶ ticks.
#[cfg(feature = "runs")]
pub(crate) fn after(run: Run, steps: u16) -> u64 {
    let way = product(run.add().unsigned_abs(), steps.into());
    let end = if run.add() < 0 {
        run.interval().checked_sub(way)
    } else {
        run.interval().checked_add(way)
    };
    end.unwrap_or(0)
}

/// The next part of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// This many steps with one delay as given, forward or backward.
    Steps { count: u32, delay: u32, forward: bool },
    /// No step for this many delays as they are given.
    Wait { count: u32, delay: u32 },
    /// A single step with its own delay, or a wait.
    Pace(Pace),
    /// Steps whose intervals grow; a run without steps is a wait.
    #[cfg(feature = "runs")]
    Run { run: Run, forward: bool },
    /// The program is over.
    Over,
}

/// A program and the position of its reader.
pub(crate) struct Reader<'a> {
    program: Program<'a>,
    /// The number of legs or delays read.
    at: usize,
    /// The number of steps asked for.
    asked: u32,
}

/// Steps of an endless program that are handed out at once.
const MANY: u32 = u32::MAX;

impl<'a> Reader<'a> {
    pub(crate) const NONE: Reader<'a> = Reader::of(Program::Series(&[]));

    pub(crate) const fn of(program: Program<'a>) -> Reader<'a> {
        Reader { program, at: 0, asked: 0 }
    }

    /// The next leg, if it is a run in memory.
    #[cfg(feature = "runs")]
    #[inline(always)]
    pub(crate) fn next_run(&self) -> Option<(Run, bool)> {
        match &self.program {
            Program::Stored(legs) => match legs.get(self.at)?.get() {
                Leg::Run { run, forward } => Some((run, forward)),
                _ => None,
            },
            _ => None,
        }
    }

    /// Skips the run that was taken.
    #[cfg(feature = "runs")]
    #[inline(always)]
    pub(crate) fn skip(&mut self) {
        self.at = self.at.saturating_add(1);
    }

    /// The next part. The answer is complete in itself: no state of one program or part can leak
    /// into another.
    pub(crate) fn next(&mut self) -> Next {
        let at = self.at;
        self.at = at.saturating_add(1);
        match &mut self.program {
            Program::Steps { count, delay } if at == 0 => steps(*count, *delay),
            Program::Whirl { forward, delay } => {
                Next::Steps { count: MANY, delay: *delay, forward: *forward }
            }
            Program::List { delays, each, forward } => match delays.get(at) {
                Some(&delay) => Next::Steps { count: *each, delay, forward: *forward },
                None => Next::Over,
            },
            Program::Series(legs) => legs.get(at).map_or(Next::Over, |leg| leg.next()),
            Program::Stored(legs) => legs.get(at).map_or(Next::Over, |leg| leg.get().next()),
            Program::Ramp { steps, forward, ramp } if steps.is_none_or(|all| self.asked < all) => {
                let delay = ramp.delay(self.asked);
                self.asked = self.asked.wrapping_add(1);
                Next::Steps { count: 1, delay, forward: *forward }
            }
            Program::Dynamic { count, next } if self.asked < count.unsigned_abs() => {
                let delay = next(self.asked);
                self.asked = self.asked.wrapping_add(1);
                Next::Steps { count: 1, delay, forward: *count >= 0 }
            }
            Program::DynamicWhirl { forward, next } => {
                let delay = next(self.asked);
                self.asked = self.asked.wrapping_add(1);
                Next::Steps { count: 1, delay, forward: *forward }
            }
            Program::Paced(paces) => paces.next().map_or(Next::Over, Next::Pace),
            Program::Steps { .. } | Program::Dynamic { .. } | Program::Ramp { .. } => Next::Over,
        }
    }

    /// The smallest delay of a leg that turns, in µs; `None` if none does.
    pub(crate) fn fastest_turn(&self, smallest: u32) -> Option<u32> {
        let (mut facing, mut least) = (None, None);
        let mut look = |leg: Leg| {
            if let Leg::Steps { count, delay } = leg
                && count != 0
                && facing.replace(count > 0).is_some_and(|before| before != (count > 0))
            {
                let delay = delay.max(smallest);
                least = Some(least.map_or(delay, |least: u32| least.min(delay)));
            }
        };
        match &self.program {
            Program::Series(legs) => legs.iter().for_each(|leg| look(*leg)),
            Program::Stored(legs) => legs.iter().for_each(|leg| look(leg.get())),
            _ => {}
        }
        least
    }

    /// Whether each step is asked for by itself, in ticks of the timer.
    pub(crate) fn has_own_paces(&self) -> bool {
        matches!(self.program, Program::Paced(_))
    }

    /// Whether any steps are counted in ticks of the timer.
    pub(crate) fn is_paced(&self) -> bool {
        match &self.program {
            Program::Paced(_) => true,
            Program::Series(legs) => RUNS && legs.iter().any(|leg| leg.is_paced()),
            Program::Stored(legs) => RUNS && legs.iter().any(|leg| leg.get().is_paced()),
            _ => false,
        }
    }

    /// The smallest delay that the program may have, as far as it is known; `None` if it makes no
    /// step.
    pub(crate) fn fastest(&self, smallest: u32, beat: &Beat) -> Option<u32> {
        let held = |delay: u32| delay.max(smallest);
        match &self.program {
            Program::Steps { count: 0, .. } | Program::Dynamic { count: 0, .. } => None,
            Program::Steps { delay, .. } | Program::Whirl { delay, .. } => Some(held(*delay)),
            Program::List { each: 0, .. } => None,
            Program::List { delays, .. } => quickest(delays, |delay| Some(*delay)).map(held),
            Program::Series(legs) => quickest(legs, |leg| leg.delay(smallest, beat)),
            Program::Stored(legs) => quickest(legs, |leg| leg.get().delay(smallest, beat)),
            Program::Ramp { steps: Some(0), .. } => None,
            Program::Ramp { ramp, .. } => Some(held(ramp.from.min(ramp.to))),
            Program::Dynamic { .. } | Program::DynamicWhirl { .. } | Program::Paced(_) => {
                Some(smallest)
            }
        }
    }
}

/// The smallest delay of a list.
fn quickest<T>(list: &[T], delay: impl Fn(&T) -> Option<u32>) -> Option<u32> {
    let mut least = None;
    for item in list {
        match (delay(item), least) {
            (Some(delay), Some(known)) if delay >= known => {}
            (None, _) => {}
            (some, _) => least = some,
        }
    }
    least
}

fn steps(count: i32, delay: u32) -> Next {
    Next::Steps { count: count.unsigned_abs(), delay, forward: count >= 0 }
}
