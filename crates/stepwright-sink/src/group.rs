//! The grouper: entries become groups of equal steps.
//!
//! ```text
//!   entry    step      step       step        step    intervals grow
//!           ──┴─────────┴──────────┴───────────┴────
//!   group    step       step       step        step   the mean interval, in whole ticks
//!           ──┴──────────┴──────────┴──────────┴────
//!                                             └─┴ carried to the next group
//! ```
//!
//! # Error
//!
//! With a bound of B ticks, a group of 2^k steps has 2^k ≤ B. The rounding of its interval therefore adds up
//! to at most B/2 at its end; it is carried to the next group, so nothing drifts. Within a group, a growth of
//! g ticks per step moves steps by g·4^k/8, which is kept at B/4 or less. The first interval belongs to the
//! entry before, and differs from the others by at most B/4. Every step is therefore within B ticks of the
//! entry's own time. The last step of a travel is a group of its own, and within half a tick. Two things may
//! delay a step by more: the minimum interval, and the set-up time of DIR. The steps after it then catch up at
//! the minimum interval.

use stepwright::engine::WIRING;
use stepwright::entry::{Entry, EntryParts};
use stepwright::{Ticks, Timing};

/// A group of steps at equal intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepGroup {
    /// Ticks from each rising edge to the next. The first interval begins at the last edge of the group before.
    pub interval: Ticks,
    /// The number of steps: a power of two, 1 to 1024.
    pub steps: u32,
    /// The direction: true for forward, with DIR high.
    pub forward: bool,
}

impl StepGroup {
    /// Ticks from the last edge before the group to its last edge.
    #[inline(always)]
    pub const fn duration(&self) -> u64 {
        // 32 bits are mostly enough, and a small chip multiplies them at once.
        if self.interval < 1 << 21 && self.steps <= 1 << 10 {
            return (self.interval * self.steps) as u64;
        }
        self.interval as u64 * self.steps as u64
    }

    /// The steps of the group; negative if backward.
    #[inline(always)]
    pub const fn travel(&self) -> i64 {
        if self.forward { self.steps as i64 } else { -(self.steps as i64) }
    }
}

/// The largest debt that a group of several steps makes up for, in 2⁻¹⁶ ticks.
const LARGE: u32 = 1 << 28;

/// The bound of the waits of groups of several steps, in 2⁻¹⁶ ticks: together with the debt they fit into
/// 31 bits.
const FAR: i64 = 0x7000_0000;

/// By how much these waits may be shorter than the minimum interval, in 2⁻¹⁶ ticks.
const BELOW: i64 = 16 << 16;

/// The largest bound in ticks, and the most steps of a group.
const MOST: Ticks = 1 << 10;

/// Makes groups from the entries of one axis.
///
/// ```
/// use stepwright::{Run, entry::{Entry, Sink, Writer}, engine::WIRING};
/// use stepwright_sink::Grouper;
/// # struct Two([Option<Entry>; 2], usize);
/// # impl Sink for Two {
/// #     fn put(&mut self, entry: Entry) { self.0[self.1] = Some(entry); self.1 += 1 }
/// # }
/// # let mut entries = Two([None; 2], 0);
/// let mut writer = Writer::new(WIRING);
/// writer.run(&Run::steady(500, 40), &mut entries); // a wait, and 39 steps; the last is due
/// let mut grouper = Grouper::new(125);
/// let mut steps = 0;
/// for entry in entries.0.into_iter().flatten() {
///     grouper.load(entry);
///     while let Some(group) = grouper.next() {
///         assert_eq!(group.interval, 500);
///         steps += group.steps;
///     }
/// }
/// assert_eq!(steps, 39);
/// ```
#[derive(Clone, Copy, Debug)]
#[repr(C)] // what each group asks for lies together, where a small chip reaches it at once
pub struct Grouper {
    /// A group has at most 2^bits steps.
    bits: u8,
    forward: bool,
    /// DIR changes before the next step.
    turns: bool,
    /// The numbers of `near` are valid, and `ahead`, `owed` and `wait` are out of date until
    /// [`settle`](Grouper::settle).
    is_near: bool,
    near: Near,
    /// The minimum interval, in ticks.
    least: i32,
    /// The steps left of the present entry after those of `near`. The first comes after `ahead`, the second after
    /// `wait`, which grows by `growth` from step to step.
    left: u32,
    growth: i32,
    /// The time from the last step handed out to the next one by the entries, in 2⁻¹⁶ ticks.
    ahead: i64,
    /// The debt: by how much the last step handed out comes too early, in 2⁻¹⁶ ticks.
    owed: i64,
    wait: i64,
    /// The part of the present entry that was not taken over yet.
    rest: EntryParts,
    /// A quarter of the bound, in 2⁻¹⁶ ticks.
    quarter: u32,
    /// The least first interval after a change of DIR.
    turn: Ticks,
    /// The largest `bits` that the bound allows.
    most: u8,
}

/// Groups of equally many steps, computed in 32 bits, in 2⁻¹⁶ ticks.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct Near {
    /// The number of groups left.
    groups: u32,
    /// The wait after the first step of the next group, and its growth from group to group.
    wait: i32,
    jump: i32,
    /// The debt, as in [`Grouper`].
    owed: i32,
    /// By how much a group lasts longer than `wait` for each of its steps: its waits grow, and the first
    /// one belongs to the group before.
    longer: i32,
}

const NOT_NEAR: Near = Near { groups: 0, wait: 0, jump: 0, owed: 0, longer: 0 };

const NOTHING: EntryParts =
    EntryParts { pins: 0, then: 0, events: 0, groups: 0, interval: 0, growth: 0 };

impl Grouper {
    /// A grouper for an axis at rest that faces forward. No step deviates by more than `bound` ticks. A good
    /// bound is 1 µs; a larger one, up to 1,024 ticks, makes fewer groups.
    pub const fn new(bound: Ticks) -> Grouper {
        let bound = if bound < MOST { bound } else { MOST };
        let mut most = 0;
        while 2u32 << most <= bound {
            most += 1;
        }
        Grouper {
            bits: 0,
            forward: true,
            turns: false,
            is_near: false,
            near: NOT_NEAR,
            least: 1,
            left: 0,
            growth: 0,
            ahead: 0,
            owed: 0,
            wait: 0,
            rest: NOTHING,
            quarter: bound << 14,
            turn: 1,
            most,
        }
    }

    /// Sets the times to keep: the minimum interval, and the set-up time of DIR before the first step after a
    /// change. The player changes DIR at most `lag` ticks after the end of a pulse.
    pub fn set_timing(&mut self, timing: &Timing, lag: Ticks) {
        self.settle();
        let least = timing.min_interval.clamp(1, Ticks::MAX >> 1);
        self.least = least.cast_signed();
        let turn = timing.setup.saturating_add(timing.pulse).saturating_add(lag);
        self.turn = turn.max(least);
    }

    /// Begins a travel: time counts from its start.
    pub fn begin(&mut self) {
        (self.is_near, self.near.groups) = (false, 0);
        (self.ahead, self.owed, self.left, self.rest.groups) = (0, 0, 0, 0);
    }

    /// Forgets everything that was loaded, and sets the direction.
    pub fn clear(&mut self, forward: bool) {
        self.begin();
        (self.forward, self.turns) = (forward, false);
    }

    /// Whether the next step goes forward.
    pub const fn is_forward(&self) -> bool {
        self.forward
    }

    /// Loads the next entry. Nothing may be left of the entry before.
    pub fn load(&mut self, entry: Entry) {
        self.rest = entry.parts();
    }

    /// Whether the present entry has another step. Waits without a step are added to the time of the next one.
    #[inline]
    pub fn has_step(&mut self) -> bool {
        while !self.is_loaded() {
            if self.rest.groups == 0 {
                return false;
            }
            self.take();
        }
        true
    }

    /// Whether steps of the present entry are at hand.
    #[inline(always)]
    pub(crate) const fn is_loaded(&self) -> bool {
        self.left | self.near.groups != 0
    }

    /// The number of steps of the present entry that are at hand and have not been handed out.
    #[inline(always)]
    pub(crate) const fn at_hand(&self) -> u32 {
        self.left.wrapping_add(self.near.groups << (self.bits & 31))
    }

    /// Takes over the uniform beginning of the rest of the present entry: all of it, or its first group.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn take(&mut self) {
        self.settle();
        let EntryParts { pins, then, events, groups, interval, growth } = self.rest;
        let (wait, mut grows) = (i64::from(interval), growth);
        let alike = groups == 1 || pins == then && (events == 1 || growth == 0);
        let count = if alike { events.saturating_mul(groups) } else { events };
        if events != 1 || !alike {
            grows = 0;
        }
        let next = if alike { 0 } else { groups.wrapping_sub(1) };
        let interval = interval.wrapping_add_signed(growth);
        self.rest = EntryParts { pins: then, groups: next, interval, ..self.rest };
        if pins & WIRING.turn != 0 && count & 1 != 0 {
            self.forward = !self.forward;
            self.turns = !self.turns;
        }
        if pins & WIRING.step == 0 {
            let lasts = if count == 1 { wait } else { lasts(wait, grows.into(), count) };
            self.ahead = self.ahead.saturating_add(lasts);
            return;
        }
        (self.left, self.wait, self.growth) = (count, wait, grows);
        // In the middle of 2^k steps the deviation is growth · 4^k / 8, at the first interval it is one growth.
        // (A quarter is below 2^24.)
        let (mut bits, mut off) = (0, grows.unsigned_abs());
        if off == 0 {
            bits = self.most;
        } else if off <= self.quarter {
            off >>= 1;
            while off <= self.quarter && bits < self.most {
                bits += 1;
                off <<= 2;
            }
        }
        self.bits = bits;
    }

    /// Whether DIR changes before the next step. To be called after [`has_step`](Grouper::has_step).
    #[inline]
    pub const fn turns(&self) -> bool {
        self.turns
    }

    /// Notes that the axis has stood still for these ticks since its last step.
    pub fn pass(&mut self, ticks: u64) {
        let passed = i64::try_from(ticks).unwrap_or(i64::MAX).min(i64::MAX >> 17) << 16;
        self.owed = self.owed.max(0);
        self.ahead = self.ahead.saturating_sub(passed).max(0);
    }

    /// Whether the next step comes more than this many ticks after the last one that was handed out.
    pub(crate) fn is_ahead(&mut self, ticks: u64) -> bool {
        self.settle();
        self.ahead >> 16 > i64::try_from(ticks).unwrap_or(i64::MAX)
    }

    /// The time from the last step handed out to the last known step, in ticks.
    pub fn left(&self) -> u64 {
        let mut now = *self;
        now.settle();
        let Some(behind) = now.left.checked_sub(1) else { return 0 };
        let own = now.ahead.saturating_add(lasts(now.wait, now.growth.into(), behind));
        (own.max(0) >> 16) as u64
    }

    /// The next group of the loaded entry: a single step if `single`. `None` if nothing is left.
    fn take_group(&mut self, single: bool) -> Option<StepGroup> {
        if !self.has_step() {
            return None;
        }
        if single || !self.is_near() && !self.approach() {
            self.settle();
            return Some(self.one());
        }
        Some(self.several())
    }

    /// Whether the next group has [`several`](Grouper::several) steps, as the last one had.
    #[inline(always)]
    pub(crate) const fn is_near(&self) -> bool {
        self.near.groups != 0
    }

    /// Switches to groups of several steps, if there are enough steps. Otherwise the next group is a single
    /// step. Steps of the present entry must be at hand.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    pub(crate) fn approach(&mut self) -> bool {
        while self.left >> (self.bits & 31) == 0 {
            self.bits = self.bits.wrapping_sub(1);
        }
        let bits = self.bits & 31;
        if bits == 0 || self.turns || !self.is_near && !self.fits() {
            self.settle();
            return false;
        }
        // n − 1 of the waits lie between the steps; the last one is before the next group. (With a growth
        // that allows groups at all, growth · n² fits.)
        let between = (1i32 << bits).wrapping_sub(1);
        let triangle = between.wrapping_mul(between.wrapping_sub(1)) >> 1;
        self.near.longer = self.growth.wrapping_mul(triangle.wrapping_sub(1));
        self.near.jump = self.growth << bits;
        self.near.groups = self.left >> bits;
        self.left = self.left.wrapping_sub(self.near.groups << bits);
        true
    }

    /// Switches to 32 bits, if they are enough for the rest of the present entry. They are not if the interval
    /// ahead, which belongs to the entry before, differs from the others by more than a quarter of the bound.
    fn fits(&mut self) -> bool {
        let near = |value: i64, most: u32| match i32::try_from(value) {
            Ok(value) if value.unsigned_abs() <= most => Some(value),
            _ => None,
        };
        let differs = near(self.ahead.wrapping_sub(self.wait), self.quarter);
        let (Some(differs), Some(owed)) = (differs, near(self.owed, LARGE)) else { return false };
        let least = i64::from(self.least) << 16;
        let mut last = self.wait;
        if self.growth != 0 {
            last = last.wrapping_add(i64::from(self.growth).wrapping_mul(self.left.into()));
        }
        if last.min(self.wait) < least.wrapping_sub(BELOW) || last.max(self.wait) > FAR {
            return false;
        }
        self.near.wait = self.wait as i32;
        self.near.owed = differs.wrapping_add(self.growth).wrapping_add(owed);
        self.is_near = true;
        true
    }

    /// Switches back to 64 bits. At least one group of several steps must have been made since.
    fn settle(&mut self) {
        if self.is_near {
            self.is_near = false;
            self.owed = self.near.owed.into();
            self.wait = self.near.wait.into();
            self.ahead = self.near.wait.wrapping_sub(self.growth).into();
            self.left = self.left.wrapping_add(self.near.groups << (self.bits & 31));
            self.near.groups = 0;
        }
    }

    /// The next group of several steps, computed in 32 bits.
    #[inline(always)]
    pub(crate) fn several(&mut self) -> StepGroup {
        let (bits, Near { groups, wait, jump, owed, longer }) = (self.bits & 31, self.near);
        // By how much the group is to last longer than n waits.
        let longer = longer.wrapping_add(owed);
        let mean = wait.wrapping_add(longer >> bits);
        let mut interval = mean.wrapping_add(0x8000) >> 16;
        if interval < self.least {
            interval = self.least;
        }
        let each = (interval << 16).wrapping_sub(wait);
        self.near.owed = longer.wrapping_sub(each << bits);
        self.near.wait = wait.wrapping_add(jump);
        self.near.groups = groups.wrapping_sub(1);
        if interval == self.least {
            self.check();
        }
        StepGroup { interval: interval.cast_unsigned(), steps: 1 << bits, forward: self.forward }
    }

    /// Switches back if the debt is larger than a group of several steps makes up for, as it may become at the
    /// minimum interval.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    fn check(&mut self) {
        if self.near.owed.unsigned_abs() > LARGE {
            self.settle();
        }
    }

    /// The next single step.
    #[inline(never)]
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    pub(crate) fn one(&mut self) -> StepGroup {
        let all = self.ahead.saturating_add(self.owed);
        let least = if self.turns { self.turn } else { self.least.cast_unsigned() };
        let interval = all.wrapping_add(0x8000) >> 16;
        let interval = if interval < i64::from(least) {
            least
        } else {
            // (An interval too long for a number leaves a debt: the next steps wait longer.)
            Ticks::try_from(interval).unwrap_or(Ticks::MAX)
        };
        self.owed = all.wrapping_sub(i64::from(interval) << 16);
        self.ahead = self.wait;
        self.wait = self.wait.wrapping_add(self.growth.into());
        self.left = self.left.wrapping_sub(1);
        self.turns = false;
        StepGroup { interval, steps: 1, forward: self.forward }
    }

    /// The first group after a start: a single step, whose interval counts from the start.
    pub fn first(&mut self) -> Option<StepGroup> {
        self.take_group(true)
    }
}

impl Iterator for Grouper {
    type Item = StepGroup;

    /// The next group of the loaded entry; `None` if another entry must be [loaded](Grouper::load).
    #[inline]
    fn next(&mut self) -> Option<StepGroup> {
        self.take_group(false)
    }
}

/// The sum of `count` waits that grow, in their unit.
fn lasts(wait: i64, growth: i64, count: u32) -> i64 {
    let count = i64::from(count);
    let triangle = growth.saturating_mul(count.saturating_mul(count.wrapping_sub(1)) >> 1);
    wait.saturating_mul(count).saturating_add(triangle)
}
