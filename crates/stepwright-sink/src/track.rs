//! One axis of a sink.

use stepwright::queue::{Consumer, Next, Source};
use stepwright::{Playing, Ticks};

use crate::group::{Grouper, StepGroup};
use crate::player::Player;

/// Groups that an axis remembers, a power of two: those that wait, and the one that is played.
const REMEMBERED: u8 = 8;

/// A group as it is remembered: its interval, its steps, and the lowest bit for forward.
type Remembered = (Ticks, u32);

/// No group.
const NONE: Remembered = (1, 1);

/// How far an axis is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// No travel.
    Idle,
    /// Its travel begins: the player has not been started for it.
    Begins,
    /// It is played.
    Plays,
}

/// What the engine knows of an axis.
#[repr(C)] // what each group asks for lies together, where a small chip reaches it at once
pub(crate) struct Track<'q, const Q: usize> {
    pub phase: Phase,
    /// The last group of the travel has been put.
    ended: bool,
    /// Which way it faced before its travel.
    before: bool,
    /// The player has room, and the queue had nothing for it.
    pub hungry: bool,
    /// The player rests for a turn, or until a step that is later, and so has run dry.
    rested: bool,
    /// An entry has left the queue, or there was none for the first time, since the last [`fill`](Track::fill).
    news: bool,
    /// How many groups were put, modulo 256.
    put: u8,
    pub grouper: Grouper,
    /// When the last step of all groups that were put comes, in the player's time; before a start, from
    /// that on.
    pub end: u64,
    /// The last of them.
    groups: [Remembered; REMEMBERED as usize],
    /// Where they lead to, and the steps that the grouper has [at hand](Grouper::at_hand).
    target: i64,
    pub source: Consumer<'q, Q>,
    /// How often the player has run dry.
    pub dry: u32,
    /// When its travel has begun with a wait, while no step of it is known.
    origin: Option<u64>,
}

impl<'q, const Q: usize> Track<'q, Q> {
    pub fn new(source: Consumer<'q, Q>, bound: Ticks) -> Track<'q, Q> {
        Track {
            source,
            grouper: Grouper::new(bound),
            phase: Phase::Idle,
            ended: false,
            before: true,
            hungry: false,
            rested: false,
            news: false,
            dry: 0,
            target: 0,
            end: 0,
            origin: None,
            groups: [NONE; REMEMBERED as usize],
            put: 0,
        }
    }

    /// The group that was put as the last but `back`.
    fn group(&self, back: u8) -> StepGroup {
        let at = self.put.wrapping_sub(1).wrapping_sub(back) % REMEMBERED;
        let (interval, steps) = self.groups.get(usize::from(at)).copied().unwrap_or(NONE);
        StepGroup { interval, steps: steps >> 1, forward: steps & 1 != 0 }
    }

    /// The steps that the grouper has at hand, negative backward.
    fn at_hand(&self) -> i64 {
        let steps = i64::from(self.grouper.at_hand());
        if self.grouper.is_forward() { steps } else { steps.wrapping_neg() }
    }

    /// Where all groups that were put lead to.
    pub fn position(&self) -> i64 {
        self.target.wrapping_sub(self.at_hand())
    }

    /// It is so far from where it was taken to be.
    pub fn displace(&mut self, steps: i64) {
        self.target = self.target.wrapping_add(steps);
    }

    /// Whether no travel is in progress. DIR may change then: `hold` has passed since the last edge.
    pub fn is_idle(&self, player: &impl Player, axis: u8, hold: Ticks) -> bool {
        match self.phase {
            Phase::Idle => true,
            Phase::Begins => false,
            Phase::Plays => {
                self.ended
                    && player.rests(axis)
                    && player.now() >= self.end.saturating_add(hold.into())
            }
        }
    }

    /// Steps made.
    ///
    /// Of the group that is played, by the time: at the edge itself this may be a step behind.
    pub fn made(&self, player: &impl Player, axis: u8) -> i64 {
        let (mut position, mut end) = (self.position(), self.end);
        if self.phase == Phase::Idle {
            return position;
        }
        let begins = self.phase == Phase::Begins;
        let waiting = if begins { REMEMBERED } else { player.waiting(axis).min(REMEMBERED - 1) };
        for back in 0..waiting {
            let group = self.group(back);
            position = position.wrapping_sub(group.travel());
            end = end.saturating_sub(group.duration());
        }
        if begins {
            return position;
        }
        let group = self.group(waiting);
        let left = end.saturating_sub(player.now());
        if left == 0 {
            return position;
        }
        // Rounded up: a step whose time has not come is not made.
        let left = Ticks::try_from(left).unwrap_or(Ticks::MAX);
        let missing = left.div_ceil(group.interval.max(1)).min(group.steps);
        let missing = StepGroup { steps: missing, ..group }.travel();
        position.wrapping_sub(missing)
    }

    /// How long the steps last that are known of the entries taken. The wait behind the last of them
    /// does not count: the player has to know the step that ends it before it begins.
    pub fn playing(&self, player: &impl Player) -> Playing {
        if self.phase != Phase::Plays || self.ended {
            return Playing::Unknown;
        }
        let end = self.end.saturating_add(self.grouper.left());
        let left = Ticks::try_from(end.saturating_sub(player.now())).unwrap_or(Ticks::MAX);
        if self.hungry { Playing::Dry(left) } else { Playing::Left(left) }
    }

    /// A travel begins.
    pub fn begin(&mut self) {
        self.before = self.grouper.is_forward();
        self.target = self.position();
        self.grouper.begin();
        (self.phase, self.end, self.ended, self.hungry) = (Phase::Begins, 0, false, false);
        (self.rested, self.origin) = (false, None);
        (self.groups, self.put) = ([NONE; REMEMBERED as usize], 0);
    }

    /// Whether a travel is to begin, and has a group.
    pub fn is_ready(&self) -> bool {
        self.phase == Phase::Begins && self.group(0).steps != 0
    }

    /// Its travel begins now, if it begins with a wait: the player is started for its first step, which
    /// is not known.
    pub fn waits(&mut self, now: u64) {
        if self.origin.is_none() && self.grouper.is_ahead(0) {
            self.origin = Some(now);
        }
    }

    /// Whether it would take a group.
    fn wants(&self) -> bool {
        self.phase != Phase::Idle && !self.ended
    }

    /// The player was started at this time.
    pub fn started(&mut self, now: u64) {
        self.end = self.end.saturating_add(now);
        self.phase = Phase::Plays;
    }

    /// Gives the player what it has room for, in a travel. True if there is news: an entry has left the queue, or
    /// there was none.
    // (Small functions: where all is one, a small chip's registers don't suffice.)
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    pub fn fill(&mut self, player: &mut impl Player, axis: u8, hold: Ticks) -> bool {
        if let Some(group) = self.put_one(player, axis, hold) {
            // Asked when it has something again: until then it runs dry.
            if player.ran_dry(axis) {
                self.has_been_dry(player.now(), group);
            }
            while self.put_one(player, axis, hold).is_some() {}
        }
        core::mem::take(&mut self.news)
    }

    /// Gives the player a group, if it has room and there is one.
    #[inline(always)]
    fn put_one(&mut self, player: &mut impl Player, axis: u8, hold: Ticks) -> Option<StepGroup> {
        if !player.has_room(axis) {
            return None;
        }
        if !self.grouper.is_near() && !self.prepare(player, axis, hold) {
            return None;
        }
        let (interval, steps) = if self.grouper.is_near() { self.several() } else { self.single() };
        let group = StepGroup { interval, steps: steps >> 1, forward: steps & 1 != 0 };
        player.put(axis, group);
        Some(group)
    }

    /// The player stood still until now, and has this group.
    #[inline(never)]
    fn has_been_dry(&mut self, now: u64, group: StepGroup) {
        let rested = core::mem::replace(&mut self.rested, false);
        if self.phase == Phase::Plays && !rested {
            self.dry = self.dry.saturating_add(1);
            // What came now is played from here on.
            self.end = self.end.max(now.saturating_add(group.duration()));
        }
    }

    /// Whether there is another group, of the present entry or the one behind it: of several steps or
    /// a single one, as the grouper says then.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn prepare(&mut self, player: &mut impl Player, axis: u8, hold: Ticks) -> bool {
        if !self.wants() || !self.grouper.is_loaded() && !self.load() {
            return false;
        }
        if self.grouper.turns() && !self.may_turn(player, axis, hold) {
            self.starve();
            return false;
        }
        // Who rests has been starved.
        if core::mem::take(&mut self.hungry)
            && self.catch_up(player, axis)
            && !self.grouper.is_loaded()
        {
            return self.prepare(player, axis, hold);
        }
        // Of a travel the first is a single step.
        if self.phase != Phase::Begins || self.is_ready() {
            self.grouper.approach();
        }
        true
    }

    /// Of the wait before the next step what has passed already is over: the player rests, and plays at once
    /// what it is given. If that step is late, it is so: the player has run dry. True if the player was
    /// given that step, and started for it: not with the other axes, which have begun.
    #[inline(never)]
    fn catch_up(&mut self, player: &mut impl Player, axis: u8) -> bool {
        let since = match (self.phase, self.origin.take()) {
            (Phase::Begins, Some(origin)) => origin,
            (Phase::Plays, _) if player.rests(axis) => self.end,
            _ => return false,
        };
        let now = player.now();
        let rested = now.saturating_sub(since);
        let waits = rested != 0 && self.grouper.is_ahead(rested);
        if self.phase == Phase::Plays {
            if waits {
                self.grouper.pass(rested);
                (self.end, self.rested) = (now, true);
            }
            return false;
        }
        self.dry = self.dry.saturating_add(u32::from(rested != 0 && !waits));
        self.grouper.pass(rested);
        (self.phase, self.end) = (Phase::Plays, now);
        let (interval, steps) = self.single();
        player.put(axis, StepGroup { interval, steps: steps >> 1, forward: steps & 1 != 0 });
        player.start(1u8.wrapping_shl(axis.into()));
        true
    }

    /// There is nothing for the player, or not yet.
    fn starve(&mut self) {
        self.news |= !self.hungry;
        self.hungry = true;
    }

    /// The next group of several steps.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn several(&mut self) -> Remembered {
        let group = self.grouper.several();
        // Less than 2^15 ticks, and at most 2^10 steps.
        self.remember(group, group.interval.wrapping_mul(group.steps))
    }

    /// The next step.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn single(&mut self) -> Remembered {
        let group = self.grouper.one();
        self.remember(group, group.interval)
    }

    /// A group is put that lasts so long.
    #[inline(always)]
    fn remember(&mut self, group: StepGroup, lasts: Ticks) -> Remembered {
        self.end = self.end.wrapping_add(lasts.into());
        let group = (group.interval, group.steps << 1 | u32::from(group.forward));
        if let Some(place) = self.groups.get_mut(usize::from(self.put % REMEMBERED)) {
            *place = group;
        }
        self.put = self.put.wrapping_add(1);
        group
    }

    /// Takes entries over until one has a step: false if there is none.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn load(&mut self) -> bool {
        while !self.grouper.has_step() {
            match self.source.take() {
                Next::Entry(entry) => {
                    self.news = true;
                    self.grouper.load(entry);
                }
                Next::Late => {
                    self.starve();
                    return false;
                }
                Next::End => {
                    (self.ended, self.hungry) = (true, false);
                    if self.phase == Phase::Begins && !self.is_ready() {
                        self.phase = Phase::Idle;
                    }
                    return false;
                }
            }
        }
        self.target = self.target.wrapping_add(self.at_hand());
        true
    }

    /// Whether DIR may change before the next step: on the way not before the last one has been held.
    #[inline(never)]
    fn may_turn(&mut self, player: &impl Player, axis: u8, hold: Ticks) -> bool {
        if self.phase == Phase::Begins {
            return !self.is_ready();
        }
        let now = player.now();
        let rested = now.saturating_sub(self.end);
        if !player.rests(axis) || rested < hold.into() {
            return false;
        }
        self.grouper.pass(rested);
        (self.end, self.rested) = (now, true);
        true
    }

    /// The player has been halted.
    pub fn halted(&mut self, player: &mut impl Player, axis: u8) {
        let halted = player.forget(axis);
        let waiting = halted.waiting.min(REMEMBERED - 1);
        self.target = self.position();
        for back in 0..waiting {
            self.target = self.target.wrapping_sub(self.group(back).travel());
        }
        let present = self.group(waiting);
        let left = StepGroup { steps: halted.left.min(present.steps), ..present };
        self.target = self.target.wrapping_sub(left.travel());
        // Where no group has begun it faces as before.
        let forward = if present.steps == 0 { self.before } else { present.forward };
        self.source.clear(forward);
        self.grouper.clear(forward);
        (self.phase, self.hungry, self.end) = (Phase::Idle, false, player.now());
    }
}
