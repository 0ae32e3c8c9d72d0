//! A test of a player against its contract.

use core::fmt;

use stepwright::{Ticks, Timing};

use crate::group::StepGroup;
use crate::player::Player;

/// A player under test, and an observer of its pins.
pub trait PlayerPort {
    /// The player under test.
    type Player: Player;

    /// The player.
    fn player(&mut self) -> &mut Self::Player;

    /// Lets time pass: for a model by one or a few ticks. On a chip it does nothing.
    fn idle(&mut self);

    /// The rising edges of STEP of an axis, forward less backward, observed independently of the player: by an
    /// edge counter, a second state machine, or a model's pins. `None` without an observer: the counts after a
    /// halt are then checked against the time alone.
    fn seen(&mut self, axis: u8) -> Option<i64>;
}

/// What was tried without a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tried {
    /// The number of groups put.
    pub groups: u32,
    /// The number of halts during a travel.
    pub halts: u32,
    /// Whether the pins were observed.
    pub watched: bool,
}

/// A breach of the contract, with the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayerFault {
    /// The player had no room at rest, or room for more groups than its depth and one.
    Room(u8),
    /// The axis moved before its start.
    Moved(u8),
    /// The axis came to rest too late, by this many ticks.
    Slow(u8, u64),
    /// The axis came to rest too soon, by this many ticks.
    Fast(u8, u64),
    /// This count of waiting groups is impossible.
    Waiting(u8, u8),
    /// The pins made another number of steps than the player reported: observed, and reported.
    Count(u8, i64, i64),
    /// The player reported that it ran dry when it had not, or the other way round.
    Dry(u8),
    /// Two axes that were started together came to rest this many ticks apart.
    Apart(u64),
}

impl fmt::Display for PlayerFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            PlayerFault::Room(axis) => write!(f, "axis {axis}: wrong about its room"),
            PlayerFault::Moved(axis) => write!(f, "axis {axis} moved before it was started"),
            PlayerFault::Slow(axis, by) => write!(f, "axis {axis} rests {by} ticks too late"),
            PlayerFault::Fast(axis, by) => write!(f, "axis {axis} rests {by} ticks too soon"),
            PlayerFault::Waiting(axis, count) => {
                write!(f, "axis {axis}: {count} groups can't be waiting")
            }
            PlayerFault::Count(axis, seen, said) => {
                write!(f, "axis {axis} made {seen} steps, and tells {said}")
            }
            PlayerFault::Dry(axis) => write!(f, "axis {axis}: wrong about having run dry"),
            PlayerFault::Apart(by) => write!(f, "two axes ended {by} ticks apart"),
        }
    }
}

impl core::error::Error for PlayerFault {}

/// Tries a player of `axes` axes with this timing, with groups of intervals of some `interval` ticks.
/// `latency` is the longest delay, in ticks, with which this program observes the player.
///
/// # Errors
/// The first [`PlayerFault`].
pub fn check<P: PlayerPort>(
    port: &mut P,
    axes: u8,
    timing: &Timing,
    interval: Ticks,
    latency: Ticks,
) -> Result<Tried, PlayerFault> {
    port.player().set_timing(timing);
    let tried = Tried { groups: 0, halts: 0, watched: port.seen(0).is_some() };
    let mut trial = Trial { port, interval, latency: latency.into(), pulse: timing.pulse, tried };
    for axis in 0..axes {
        trial.begin(axis);
        trial.room(axis)?;
        trial.plays(axis)?;
        trial.begin(axis);
        trial.dries(axis)?;
        trial.begin(axis);
        for after in 0..60 {
            trial.halts(axis, after)?;
        }
    }
    if axes > 1 {
        trial.together()?;
    }
    Ok(trial.tried)
}

struct Trial<'p, P> {
    port: &'p mut P,
    interval: Ticks,
    latency: u64,
    pulse: Ticks,
    tried: Tried,
}

impl<P: PlayerPort> Trial<'_, P> {
    fn group(&self, steps: u32, forward: bool) -> StepGroup {
        StepGroup { interval: self.interval, steps, forward }
    }

    fn put(&mut self, axis: u8, group: StepGroup) {
        self.tried.groups += 1;
        self.port.player().put(axis, group);
    }

    /// Halts the axis, so that the next groups wait for a start.
    fn begin(&mut self, axis: u8) {
        self.port.player().halt(1 << axis);
        self.port.player().forget(axis);
    }

    /// Waits until a time.
    fn until(&mut self, time: u64) {
        while self.port.player().now() < time {
            self.port.idle();
        }
    }

    /// Waits until the axis rests, and returns the time. A fault if it takes too long.
    fn rests(&mut self, axis: u8, end: u64) -> Result<u64, PlayerFault> {
        loop {
            let now = self.port.player().now();
            if self.port.player().rests(axis) {
                return Ok(now);
            }
            if now > end.saturating_add(self.latency) {
                return Err(PlayerFault::Slow(axis, now - end));
            }
            self.port.idle();
        }
    }

    /// Compares the observed steps with the reported ones.
    fn counts(&mut self, axis: u8, before: Option<i64>, said: i64) -> Result<(), PlayerFault> {
        let Some((before, seen)) = before.zip(self.port.seen(axis)) else { return Ok(()) };
        let seen = seen.wrapping_sub(before);
        if seen == said { Ok(()) } else { Err(PlayerFault::Count(axis, seen, said)) }
    }

    /// The axis takes as many groups as it has room for, does not move, and forgets them.
    fn room(&mut self, axis: u8) -> Result<(), PlayerFault> {
        let before = self.port.seen(axis);
        let mut put = 0;
        while self.port.player().has_room(axis) {
            if put > P::Player::DEPTH {
                return Err(PlayerFault::Room(axis));
            }
            let group = self.group(2, true);
            self.put(axis, group);
            put += 1;
            let waiting = self.port.player().waiting(axis);
            if waiting != put {
                return Err(PlayerFault::Waiting(axis, waiting));
            }
        }
        if put == 0 {
            return Err(PlayerFault::Room(axis));
        }
        let end = self.port.player().now().saturating_add(u64::from(self.interval) * 4);
        self.until(end);
        if self.port.player().waiting(axis) != put || self.port.player().rests(axis) {
            return Err(PlayerFault::Moved(axis));
        }
        self.counts(axis, before, 0)?;
        self.port.player().halt(1 << axis);
        let halted = self.port.player().forget(axis);
        if halted.waiting != put || halted.left != 0 || !self.port.player().rests(axis) {
            return Err(PlayerFault::Waiting(axis, halted.waiting));
        }
        Ok(())
    }

    /// The axis plays a long sequence of groups of all sizes in time, in both directions.
    fn plays(&mut self, axis: u8) -> Result<(), PlayerFault> {
        for forward in [true, false] {
            self.begin(axis);
            let (before, mut said, mut lasts, mut started) = (self.port.seen(axis), 0, 0u64, None);
            for n in 0..40u32 {
                let group = StepGroup {
                    interval: self.interval + n * 7 % 23,
                    ..self.group(1 << (n * 5 % 7), forward)
                };
                while !self.port.player().has_room(axis) {
                    if started.is_none() {
                        self.port.player().start(1 << axis);
                        started = Some(self.port.player().now());
                    }
                    let waiting = self.port.player().waiting(axis);
                    if waiting > P::Player::DEPTH {
                        return Err(PlayerFault::Waiting(axis, waiting));
                    }
                    let due = started.unwrap_or(0) + lasts + self.latency;
                    if self.port.player().now() > due {
                        return Err(PlayerFault::Slow(axis, self.latency));
                    }
                    self.port.idle();
                }
                self.put(axis, group);
                (said, lasts) = (said + group.travel(), lasts + group.duration());
            }
            let end = started.unwrap_or(0) + lasts;
            let rested = self.rests(axis, end.saturating_add(self.pulse.into()))?;
            if rested.saturating_add(self.latency) < end {
                return Err(PlayerFault::Fast(axis, end - rested));
            }
            self.counts(axis, before, said)?;
            if self.port.player().waiting(axis) != 0 {
                return Err(PlayerFault::Waiting(axis, self.port.player().waiting(axis)));
            }
        }
        Ok(())
    }

    /// The player reports that it ran dry if it did, once, and not if it did not.
    fn dries(&mut self, axis: u8) -> Result<(), PlayerFault> {
        let group = self.group(8, true);
        self.put(axis, group);
        self.put(axis, group);
        self.port.player().start(1 << axis);
        let begun = self.port.player().now();
        self.until(begun + group.duration());
        self.put(axis, group);
        if self.port.player().ran_dry(axis) {
            return Err(PlayerFault::Dry(axis));
        }
        self.until(begun + 3 * group.duration() + u64::from(self.pulse) + self.latency + 10);
        self.put(axis, group);
        let first = self.port.player().ran_dry(axis);
        if !first || self.port.player().ran_dry(axis) {
            return Err(PlayerFault::Dry(axis));
        }
        let end = self.port.player().now() + group.duration() + u64::from(self.pulse);
        self.rests(axis, end).map(|_| ())
    }

    /// The counts after a halt at any moment are exact to the step, and the axis starts again afterwards.
    fn halts(&mut self, axis: u8, after: u32) -> Result<(), PlayerFault> {
        let before = self.port.seen(axis);
        let forward = after & 1 == 0;
        let sizes = [4, 1, 8];
        let mut all = 0;
        for steps in sizes {
            let group = self.group(steps, forward);
            self.put(axis, group);
            all += steps;
        }
        self.port.player().start(1 << axis);
        let begun = self.port.player().now();
        // Moments spread over the interval, and over all three groups and their end.
        let moment = u64::from(after) * (u64::from(self.interval) * 14) / 59;
        self.until(begun + moment);
        self.port.player().halt(1 << axis);
        let halted = self.port.player().forget(axis);
        self.tried.halts += 1;
        let waiting = usize::from(halted.waiting);
        let Some(begun_groups) = sizes.len().checked_sub(waiting) else {
            return Err(PlayerFault::Waiting(axis, halted.waiting));
        };
        let present = sizes.get(begun_groups.wrapping_sub(1)).copied().unwrap_or(0);
        let missing: u32 = sizes.iter().rev().take(waiting).sum();
        let left = if halted.left == u32::MAX { present } else { halted.left };
        if left > present {
            return Err(PlayerFault::Count(axis, 0, left.into()));
        }
        let made = i64::from(all - missing - left);
        let said = if forward { made } else { -made };
        self.counts(axis, before, said)?;
        // Checked by the time: with one step of tolerance, and the latency.
        let least = moment.saturating_sub(self.latency) / u64::from(self.interval);
        let most = (moment + self.latency) / u64::from(self.interval) + 1;
        let made = made.unsigned_abs();
        if made + 1 < least.min(all.into()) || made > most {
            return Err(PlayerFault::Count(axis, least as i64, said));
        }
        if !self.port.player().rests(axis) || self.port.player().waiting(axis) != 0 {
            return Err(PlayerFault::Waiting(axis, self.port.player().waiting(axis)));
        }
        // The axis does not move on.
        let end = self.port.player().now().saturating_add(u64::from(self.interval) * 3);
        self.until(end);
        self.counts(axis, before, said)
    }

    /// Two axes that start together end together.
    fn together(&mut self) -> Result<(), PlayerFault> {
        let group = self.group(16, true);
        self.put(0, group);
        self.put(1, group);
        self.port.player().start(0b11);
        let end = self.port.player().now() + group.duration() + u64::from(self.pulse);
        let first = self.rests(0, end)?;
        let second = self.rests(1, end)?;
        let apart = second.saturating_sub(first);
        if apart > self.latency { Err(PlayerFault::Apart(apart)) } else { Ok(()) }
    }
}
