//! One axis of a sink.

use stepwright::queue::{Consumer, Next, Source};
use stepwright::{Playing, Ticks};

use crate::group::{Grouper, StepGroup};
use crate::player::Player;

/// Groups that an axis remembers, a power of two: those that wait, and the one that is played.
const REMEMBERED: u8 = 8;

/// No group.
const NONE: StepGroup = StepGroup { interval: 1, steps: 0, forward: true };

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
pub(crate) struct Track<'q, const Q: usize> {
    pub source: Consumer<'q, Q>,
    pub grouper: Grouper,
    pub phase: Phase,
    /// The last group of the travel has been put.
    ended: bool,
    /// Which way it faced before its travel.
    before: bool,
    /// The player has room, and the queue had nothing for it.
    pub hungry: bool,
    /// The player rests for a turn, and so has run dry.
    rested: bool,
    /// An entry has left the queue since this was cleared.
    pub took: bool,
    /// Where all groups that were put lead to.
    pub position: i64,
    /// When the last step of those comes, in the player's time; before a start, from that on.
    pub end: u64,
    /// The last groups that were put, and how many those were, modulo 256.
    groups: [StepGroup; REMEMBERED as usize],
    put: u8,
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
            took: false,
            position: 0,
            end: 0,
            groups: [NONE; REMEMBERED as usize],
            put: 0,
        }
    }

    /// The group that was put as the last but `back`.
    fn group(&self, back: u8) -> StepGroup {
        let at = self.put.wrapping_sub(1).wrapping_sub(back) % REMEMBERED;
        self.groups.get(usize::from(at)).copied().unwrap_or(NONE)
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
        if self.phase == Phase::Idle {
            return self.position;
        }
        let (mut position, mut end) = (self.position, self.end);
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
        self.grouper.begin();
        (self.phase, self.end, self.ended, self.hungry) = (Phase::Begins, 0, false, false);
        (self.groups, self.put) = ([NONE; REMEMBERED as usize], 0);
    }

    /// Whether a travel is to begin, and has a group.
    pub fn is_ready(&self) -> bool {
        self.phase == Phase::Begins && self.group(0).steps != 0
    }

    /// Whether it would take a group.
    pub fn wants(&self) -> bool {
        self.phase != Phase::Idle && !self.ended
    }

    /// The player was started at this time.
    pub fn started(&mut self, now: u64) {
        self.end = self.end.saturating_add(now);
        self.phase = Phase::Plays;
    }

    /// Gives the player what it has room for. Returns how often it has run dry.
    // (Small functions: where all is one, a small chip's registers don't suffice.)
    #[inline(never)]
    pub fn fill(&mut self, player: &mut impl Player, axis: u8, hold: Ticks) -> u32 {
        let (mut dry, mut asked) = (0, self.phase == Phase::Begins);
        while player.has_room(axis) {
            if !self.grouper.is_loaded() && !self.load() {
                break;
            }
            if self.grouper.turns() && !self.may_turn(player, axis, hold) {
                self.hungry = true;
                break;
            }
            let Some(group) = self.next_group() else { break };
            player.put(axis, group);
            // Asked when it has something again: until then it runs dry.
            if !asked {
                asked = true;
                if player.ran_dry(axis) && !self.rested {
                    dry = 1;
                    // What comes now is played from here on.
                    self.end = self.end.max(player.now());
                }
                self.rested = false;
            }
            self.remember(group);
        }
        dry
    }

    /// The next group of the present entry; of a travel the first is a single step.
    #[inline(always)]
    fn next_group(&mut self) -> Option<StepGroup> {
        if self.phase == Phase::Begins && !self.is_ready() {
            self.grouper.first()
        } else {
            self.grouper.next()
        }
    }

    /// A group has been put.
    #[inline(always)]
    fn remember(&mut self, group: StepGroup) {
        self.hungry = false;
        self.end = self.end.wrapping_add(group.duration());
        self.position = self.position.wrapping_add(group.travel());
        if let Some(place) = self.groups.get_mut(usize::from(self.put % REMEMBERED)) {
            *place = group;
        }
        self.put = self.put.wrapping_add(1);
    }

    /// Takes entries over until one has a step: false if there is none.
    #[inline(never)]
    fn load(&mut self) -> bool {
        while !self.grouper.has_step() {
            match self.source.take() {
                Next::Entry(entry) => {
                    self.took = true;
                    self.grouper.load(entry);
                }
                Next::Late => {
                    self.hungry = true;
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
        for back in 0..waiting {
            self.position = self.position.wrapping_sub(self.group(back).travel());
        }
        let present = self.group(waiting);
        let left = StepGroup { steps: halted.left.min(present.steps), ..present };
        self.position = self.position.wrapping_sub(left.travel());
        // Where no group has begun it faces as before.
        let forward = if present.steps == 0 { self.before } else { present.forward };
        self.source.clear(forward);
        self.grouper.clear(forward);
        (self.phase, self.hungry, self.end) = (Phase::Idle, false, player.now());
    }
}
