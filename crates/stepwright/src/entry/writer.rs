//! Makes entries of runs.

use super::{Entry, Events, LAST, LEAST, NEAR, Wiring, bytes};
use crate::format;
use crate::run::Run;
use crate::units::Ticks;

/// At intervals below this many ticks a group of a few steps would be over before the next one is
/// prepared: such steps are joined with those that follow.
const FAST: Ticks = 1 << 10;
/// Steps at intervals below this come in groups as large as possible, in ticks: no more than two axes are as fast.
pub(super) const JOINED: Ticks = 300;
pub(super) const FEW: u16 = 4;
/// Steps are joined only if their intervals differ by less than this, in 2⁻¹⁶ ticks.
const APART: u32 = 2 << 16;

/// The deadlines of a group may deviate by one tick: times 8, in 2⁻¹⁶ ticks.
const LOOSE: u32 = 8 << 16;

/// What the next event does. `Nothing` is 0: a blank writer has zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Due {
    Nothing,
    Step,
    Turn,
}

/// Takes entries.
pub trait Sink {
    /// Appends an entry.
    fn put(&mut self, entry: Entry);
}

/// Makes entries of the runs of one axis, which are passed in order.
#[derive(Clone, Copy, Debug)]
pub struct Writer {
    pub(super) wiring: Wiring,
    pub(super) due: Due,
    /// Time that the entries so far owe to the runs, in 2⁻¹⁶ ticks.
    pub(super) owed: i32,
    /// A few fast steps, which wait for the steps that follow them.
    kept: Kept,
    /// The steps that are made into entries. (A field, because arguments are expensive on an 8-bit
    /// chip.)
    part: Steps,
}

/// `count` steps, the first interval and its growth in 2⁻¹⁶ ticks.
#[derive(Clone, Copy, Debug)]
struct Steps {
    first: u32,
    add: i32,
    count: u16,
}

impl Steps {
    const NONE: Steps = Steps { first: 0, add: 0, count: 0 };
}

/// `count` steps with this interval, in 2⁻¹⁶ ticks.
#[derive(Clone, Copy, Debug)]
struct Kept {
    first: u32,
    count: u16,
}

impl Writer {
    /// A writer for an axis at rest.
    pub const fn new(wiring: Wiring) -> Writer {
        Writer {
            wiring,
            due: Due::Nothing,
            owed: 0,
            kept: Kept { first: 0, count: 0 },
            part: Steps::NONE,
        }
    }

    /// Initialises a writer of zeros as [`new`](Writer::new) does.
    pub(crate) fn wire(&mut self, wiring: Wiring) {
        self.wiring = wiring;
    }

    /// Forgets the pins that are due: the axis has been stopped.
    pub(crate) fn forget(&mut self) {
        (self.due, self.owed, self.kept.count) = (Due::Nothing, 0, 0);
    }

    /// Writes the wait of a [`Run::turn`], after which DIR is toggled if `changes`.
    #[inline(never)]
    pub fn turn(&mut self, wait: Ticks, changes: bool, to: &mut impl Sink) {
        if self.wiring.is_prompt() {
            return self.exact_turn(wait, changes, to);
        }
        self.wait(wait, 0, to);
        self.due = if changes { Due::Turn } else { Due::Nothing };
    }

    /// Writes a run of steps. If it has several steps, their intervals are below [`NEAR`].
    #[inline(never)]
    pub fn run(&mut self, run: &Run, to: &mut impl Sink) {
        if self.wiring.is_prompt() {
            return self.exact_run(run, to);
        }
        let first = run.ticks << 16 | Ticks::from(run.part);
        self.part = Steps { first, add: run.add, count: run.count };
        if self.due != Due::Step || run.count == 1 && run.ticks >= FAST {
            // Another pin comes first, or the step is a single one.
            self.wait(run.ticks, run.part, to);
            self.due = Due::Step;
            self.skip(1);
        }
        if self.part.count != 0 {
            self.several(to);
        }
    }

    /// Writes the last step of the travel, if one is due; no wait for another event follows.
    pub fn end(&mut self, to: &mut impl Sink) {
        if self.wiring.is_prompt() {
            return self.exact_end(to);
        }
        self.flush(to);
        if self.due == Due::Step {
            self.wait(LAST, 0, to);
        }
        self.forget();
    }

    /// The pins that are due.
    pub(super) fn pins(&self) -> u8 {
        match self.due {
            Due::Nothing => 0,
            Due::Step => self.wiring.step,
            Due::Turn => self.wiring.turn,
        }
    }

    /// Writes the pins that are due and a wait of any length, as 2^k events.
    #[inline(never)]
    fn wait(&mut self, ticks: Ticks, part: u16, to: &mut impl Sink) {
        self.flush(to);
        // Modulo 2³²: what is left of a wait may be negative, too.
        let (sum, over) = part.overflowing_add(self.owed as u16);
        let carried = (self.owed >> 16).wrapping_add(over.into());
        let mut ticks = ticks.wrapping_add_signed(carried);
        let lack = (LEAST as i32).wrapping_sub(ticks as i32);
        if self.due != Due::Step && (1..0x4000).contains(&lack) {
            self.owed = i32::from(sum).wrapping_sub(lack << 16);
            return to.put(self.one(LEAST << 8, 1));
        }
        let [part, mut low] = sum.to_le_bytes();
        // Halved until it is below `NEAR`; the dropped bits are owed.
        let (mut k, mut bit) = (0u8, 1u32 << 8);
        self.owed = part.into();
        while ticks >= NEAR {
            if low & 1 != 0 {
                self.owed |= bit as i32;
            }
            low = low >> 1 | (ticks as u8) << 7;
            ticks >>= 1;
            bit <<= 1;
            k += 1;
        }
        let interval = ticks << 8 | u32::from(low);
        // The number 2^k in a byte: 0 for 256 and its multiples.
        to.put(self.one(interval, (bit >> 8) as u8));
        if k > 8 {
            // 2^k − 256 more, in groups of 256 times a divisor: 33, 73, …
            let (high, groups) = match k {
                18 => (32, 31),
                17 => (72, 7),
                _ => (((bit >> 16) as u8).wrapping_sub(2), 1),
            };
            to.put(entry(interval, 0, Events { low: 0, high }, groups, 0, 0));
        }
    }

    /// The pins that are due, then events without pins, in groups of one.
    fn one(&self, interval: u32, groups: u8) -> Entry {
        entry(interval, 0, Events::ONE, groups, 0, self.pins())
    }

    /// Removes the first steps from the part.
    fn skip(&mut self, steps: u16) {
        let Steps { first, add, count } = &mut self.part;
        if *count == steps {
            *count = 0; // no step is left
            return;
        }
        let grown = if steps == 1 { *add } else { add.wrapping_mul(steps.into()) };
        *first = first.wrapping_add_signed(grown);
        *count = count.wrapping_sub(steps);
    }

    /// Writes steps with growing intervals; a step is due.
    #[inline(never)]
    fn several(&mut self, to: &mut impl Sink) {
        let Steps { add, count, .. } = self.part;
        let growth = add.unsigned_abs();
        let flat = growth <= LOOSE && count < 256 && {
            // count² · growth, within 32 bits.
            let once = growth.wrapping_mul(count.into());
            once <= LOOSE && once.wrapping_mul(count.into()) <= LOOSE
        };
        if growth == 0 || flat {
            return self.flat(count, to);
        }
        // Fast steps come in groups as large as possible, and those that are left over come first.
        let mut odd = if self.part.first < JOINED << 16 { 0 } else { count };
        let (mut bits, mut most) = (0u8, LOOSE >> 2);
        while bits < 8 && odd & 1 == 0 && growth <= most {
            bits += 1;
            odd >>= 1;
            most >>= 2;
        }
        // No run of the planner is that long: its groups would deviate by more.
        while count >> bits > 255 {
            bits += 1;
        }
        let group = 1u16 << bits;
        let mut lead = count & group.wrapping_sub(1);
        if lead <= FEW && (lead != 0 || self.kept.count != 0) {
            lead = lead.wrapping_add(group);
        }
        if lead != 0 {
            self.flat(lead, to);
        }
        if self.part.count != 0 {
            self.flush(to);
            self.groups(bits, to);
        }
    }

    /// Writes the next steps at their mean interval, together with those that have been kept.
    #[inline(never)]
    fn flat(&mut self, mut steps: u16, to: &mut impl Sink) {
        let Steps { first, add, .. } = self.part;
        self.skip(steps);
        let spread = add.wrapping_mul(i32::from(steps).wrapping_sub(1));
        let first = first.wrapping_add_signed(spread >> 1);
        let apart = self.kept.first.wrapping_sub(first) as i32;
        if self.kept.count != 0
            && apart.unsigned_abs() < APART
            && let Some(all) = steps.checked_add(self.kept.count)
        {
            self.owed = self.owed.wrapping_add(apart.wrapping_mul(self.kept.count.into()));
            self.kept.count = 0;
            steps = all;
        }
        self.flush(to);
        self.kept = Kept { first, count: steps };
        if steps > FEW || first >= FAST << 16 {
            self.flush(to);
        }
    }

    /// Writes the steps that have been kept.
    #[inline(never)]
    fn flush(&mut self, to: &mut impl Sink) {
        if self.kept.count != 0 {
            // (In registers: copying it as a whole takes a small chip 100 cycles, and stack.)
            let Steps { first, add, count } = self.part;
            let Kept { first: first_kept, count: count_kept } = self.kept;
            self.part = Steps { first: first_kept, add: 0, count: count_kept };
            self.kept.count = 0;
            self.groups(16, to);
            self.part = Steps { first, add, count };
        }
    }

    /// Writes as much of the part as makes groups of 2^bits steps; or all of it as a single group.
    #[inline(never)]
    fn groups(&mut self, bits: u8, to: &mut impl Sink) {
        let Steps { first, add, count } = self.part;
        let (mut group, mut groups) = (count, 1);
        if bits < 16 {
            (group, groups) = (1 << bits, (count >> bits) as u8);
        }
        // No more than the part has: 16 bits.
        let steps = if bits < 16 { u16::from(groups) << bits } else { count };
        // The mean interval: so the duration of all steps is exact, except for half the last bit of
        // a step if the spread is odd.
        let spread = match add {
            0 => 0,
            _ => add.wrapping_mul(steps.wrapping_sub(1).into()),
        };
        self.part.first = first.wrapping_add_signed(spread.wrapping_add(add));
        self.part.count = count.wrapping_sub(steps);
        let mut exact = first.wrapping_add_signed(spread >> 1);
        let mut growth = 0;
        if groups != 1 {
            let whole = if bits == 0 { add } else { add << bits };
            growth = whole.wrapping_add(128) >> 8;
            let spread = growth.wrapping_mul(i32::from(groups.wrapping_sub(1)));
            exact = exact.wrapping_sub((spread << 7) as u32);
        }
        // Rounded to nearest, including what is owed.
        self.owed =
            self.owed.wrapping_add(u32::from(exact as u8 as u16).wrapping_mul(steps.into()) as i32);
        let interval = (exact >> 8).wrapping_add_signed(self.settle(steps).into());
        let step = self.wiring.step;
        to.put(entry(interval, growth, Events::new(group), groups, step, step));
    }

    /// What each of these steps takes of the time that is owed, in 2⁻⁸ ticks, rounded to nearest.
    ///
    /// Mostly 0 or 1. After joined steps it is up to two ticks and is found bit by bit: a division
    /// would take 200 cycles more. 128 ticks and more come from a wait of a minute; they are left
    /// for the next wait.
    #[inline(never)]
    fn settle(&mut self, steps: u16) -> i16 {
        let [low, a, b, high] = self.owed.to_le_bytes();
        let owed = i16::from_le_bytes([a, b]);
        if high != (b as i8 >> 7) as u8 {
            return 0;
        }
        let half = steps >> 1;
        let mut left = owed.unsigned_abs().wrapping_add(half);
        let (mut part, mut bits) = (steps, 1u8);
        while part <= left >> 1 {
            part <<= 1;
            bits += 1;
        }
        let mut each = 0i16;
        while bits != 0 {
            each <<= 1;
            if let Some(less) = left.checked_sub(part) {
                left = less;
                each |= 1;
            }
            part >>= 1;
            bits -= 1;
        }
        let mut rest = left.wrapping_sub(half) as i16;
        if owed < 0 {
            (each, rest) = (each.wrapping_neg(), rest.wrapping_neg());
        }
        self.owed = i32::from(rest) << 8 | i32::from(low);
        each
    }
}

/// An entry with an interval and a growth in 2⁻⁸ ticks.
const fn entry(
    interval: u32,
    growth: i32,
    events: Events,
    groups: u8,
    then: u8,
    pins: u8,
) -> Entry {
    let (interval, growth) = (bytes(interval << 8), bytes((growth << 8) as u32));
    let groups = format::groups(if groups == 0 { 256 } else { groups as u32 });
    Entry { interval, growth, events, groups, then, pins }
}
