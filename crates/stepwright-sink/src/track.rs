//! The state of one axis of a sink.

use stepwright::queue::{Consumer, Next, Source};
use stepwright::{Playing, Ticks};

use crate::group::{Grouper, StepGroup};
use crate::player::Player;

/// The number of groups that an axis remembers: the waiting groups and the one that is played. A power of
/// two.
const REMEMBERED: u8 = 8;

/// A remembered group: the interval, and twice the steps with the lowest bit for forward.
type Remembered = (Ticks, u32);

/// No group.
const NONE: Remembered = (1, 1);

/// The phase of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// There is no travel.
    Idle,
    /// A travel begins, and the player has not been started for it.
    Begins,
    /// The player plays the travel.
    Plays,
}

/// What the engine knows about an axis.
#[repr(C)] // what each group asks for lies together, where a small chip reaches it at once
pub(crate) struct Track<'q, const Q: usize> {
    pub phase: Phase,
    /// The last group of the travel has been put.
    ended: bool,
    /// The direction before the travel, true for forward.
    before: bool,
    /// The player has room, but the queue was empty or DIR could not change yet.
    pub hungry: bool,
    /// The player rests for a turn, or until a later step, and has run dry by that on purpose.
    rested: bool,
    /// Since the last [`fill`](Track::fill) an entry was taken from the queue, or the queue became empty.
    news: bool,
    /// The number of groups put, modulo 256.
    put: u8,
    pub grouper: Grouper,
    /// When the last step of all put groups comes, in the player's time; before the start, counted from the
    /// start.
    pub end: u64,
    /// The last groups put.
    groups: [Remembered; REMEMBERED as usize],
    /// The position after all put groups and the steps that the grouper has [at hand](Grouper::at_hand).
    target: i64,
    pub source: Consumer<'q, Q>,
    /// The number of times that the player ran dry.
    pub dry: u32,
    /// When the travel began, if it began with a wait and no step is known yet.
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

    /// The group that was put `back` groups before the last one.
    fn group(&self, back: u8) -> StepGroup {
        let at = self.put.wrapping_sub(1).wrapping_sub(back) % REMEMBERED;
        let (interval, steps) = self.groups.get(usize::from(at)).copied().unwrap_or(NONE);
        StepGroup { interval, steps: steps >> 1, forward: steps & 1 != 0 }
    }

    /// The steps that the grouper has at hand; negative if backward.
    fn at_hand(&self) -> i64 {
        let steps = i64::from(self.grouper.at_hand());
        if self.grouper.is_forward() { steps } else { steps.wrapping_neg() }
    }

    /// The position after all put groups.
    pub fn position(&self) -> i64 {
        self.target.wrapping_sub(self.at_hand())
    }

    /// Corrects the position by this many steps.
    pub fn displace(&mut self, steps: i64) {
        self.target = self.target.wrapping_add(steps);
    }

    /// Whether no travel is in progress. `hold` has passed since the last edge, so DIR may change.
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

    /// The position by the steps made. Within the present group they are computed from the time: just after an
    /// edge the position may be a step behind.
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
        // Rounded up: a step before its time has not been made.
        let left = Ticks::try_from(left).unwrap_or(Ticks::MAX);
        let missing = left.div_ceil(group.interval.max(1)).min(group.steps);
        let missing = StepGroup { steps: missing, ..group }.travel();
        position.wrapping_sub(missing)
    }

    /// How long the known steps of the taken entries last. The wait after the last of them does not count, as
    /// the player must know the step that ends a wait before the wait begins.
    pub fn playing(&self, player: &impl Player) -> Playing {
        if self.phase != Phase::Plays || self.ended {
            return Playing::Unknown;
        }
        let end = self.end.saturating_add(self.grouper.left());
        let left = Ticks::try_from(end.saturating_sub(player.now())).unwrap_or(Ticks::MAX);
        if self.hungry { Playing::Dry(left) } else { Playing::Left(left) }
    }

    /// Begins a travel.
    pub fn begin(&mut self) {
        self.before = self.grouper.is_forward();
        self.target = self.position();
        self.grouper.begin();
        (self.phase, self.end, self.ended, self.hungry) = (Phase::Begins, 0, false, false);
        (self.rested, self.origin) = (false, None);
        (self.groups, self.put) = ([NONE; REMEMBERED as usize], 0);
    }

    /// Whether a travel begins and has a group.
    pub fn is_ready(&self) -> bool {
        self.phase == Phase::Begins && self.group(0).steps != 0
    }

    /// Notes that the travel begins now with a wait, if it does. The player is started later, for the first
    /// step, which is not known yet.
    pub fn waits(&mut self, now: u64) {
        if self.origin.is_none() && self.grouper.is_ahead(0) {
            self.origin = Some(now);
        }
    }

    /// Whether the travel may have more groups.
    fn wants(&self) -> bool {
        self.phase != Phase::Idle && !self.ended
    }

    /// Notes that the player was started at this time.
    pub fn started(&mut self, now: u64) {
        self.end = self.end.saturating_add(now);
        self.phase = Phase::Plays;
    }

    /// Fills the player's FIFO. Returns whether there is news: an entry was taken from the queue, or the queue
    /// became empty.
    // (Small functions: as one function it would need more registers than a small chip has.)
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    pub fn fill(&mut self, player: &mut impl Player, axis: u8, hold: Ticks) -> bool {
        if let Some(group) = self.put_one(player, axis, hold) {
            // The player is asked once it has a group again: until then it is still dry.
            if player.ran_dry(axis) {
                self.has_been_dry(player.now(), group);
            }
            while self.put_one(player, axis, hold).is_some() {}
        }
        core::mem::take(&mut self.news)
    }

    /// Gives the player a group, if it has room and a group is there.
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

    /// Handles a player that stood still until it got this group now.
    #[inline(never)]
    fn has_been_dry(&mut self, now: u64, group: StepGroup) {
        let rested = core::mem::replace(&mut self.rested, false);
        if self.phase == Phase::Plays && !rested {
            self.dry = self.dry.saturating_add(1);
            // The player plays the group from now on.
            self.end = self.end.max(now.saturating_add(group.duration()));
        }
    }

    /// Prepares the next group, from the present entry or the next one. The grouper knows then whether it has
    /// one step or several. False if there is no group.
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
        // A resting axis is marked as hungry.
        if core::mem::take(&mut self.hungry)
            && self.catch_up(player, axis)
            && !self.grouper.is_loaded()
        {
            return self.prepare(player, axis, hold);
        }
        // The first group of a travel is a single step.
        if self.phase != Phase::Begins || self.is_ready() {
            self.grouper.approach();
        }
        true
    }

    /// Shortens the wait before the next step by the time that has passed: the player rests, and plays a group
    /// as soon as it gets it. A step that is late already counts as run dry. Returns true if it gave the player
    /// the step and started it, apart from the other axes, which have begun.
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

    /// Notes that the player gets no group now.
    fn starve(&mut self) {
        self.news |= !self.hungry;
        self.hungry = true;
    }

    /// Takes the next group of several steps.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn several(&mut self) -> Remembered {
        let group = self.grouper.several();
        // Less than 2^15 ticks, and at most 2^10 steps.
        self.remember(group, group.interval.wrapping_mul(group.steps))
    }

    /// Takes the next step as a group.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn single(&mut self) -> Remembered {
        let group = self.grouper.one();
        self.remember(group, group.interval)
    }

    /// Remembers a group of this duration as put.
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

    /// Takes entries from the queue until one has a step; false if none has.
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

    /// Whether DIR may change now. During a travel the player must rest, and the hold time must be over.
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

    /// Handles a halt of the player: corrects the position, and forgets the rest of the travel.
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
        // If no group has begun DIR is as before.
        let forward = if present.steps == 0 { self.before } else { present.forward };
        self.source.clear(forward);
        self.grouper.clear(forward);
        (self.phase, self.hungry, self.end) = (Phase::Idle, false, player.now());
    }
}
