//! A run as the step interrupt plays it.
//!
//! A [`Run`] says what to do; a stride is the same, laid out so that an 8-bit
//! chip does it with byte additions and no multiplication. It is made in the
//! foreground, when the run is pushed.
//!
//! **Growth in strides.** At high speed the interval grows by a thousandth of
//! a tick a step, and adding it costs a third of the step. There it is added
//! every 2, 4 … 32 steps, as much as belongs to these, and the interval between
//! is their mean. Deadlines deviate by less than 1/16 tick within such a group
//! and agree at its end; where the mean has a half, it is rounded up in one run
//! and down in another, so that nothing gathers.
//!
//! A run so short that it would deviate as little with its mean interval alone is
//! played with that.
//!
//! ```text
//!   interval ▔▔▔▔╲          each step    ▔▔▔▔▔▔▏         each fourth
//!                 ╲▁▁▁▁                        ▕▁▁▁▁▁▁▁
//! ```

use crate::run::Run;
use crate::units::Ticks;

/// Intervals of at least this many ticks are waited for step by step.
pub(crate) const NEAR: Ticks = 0x7000;

/// A group's deadlines may deviate by so much, times 8, in 2⁻¹⁶ ticks.
const LOOSE: u32 = 1 << 15;
/// Groups of at most 2 to this many steps.
const LONGEST_GROUP: u8 = 5;

/// Steps of a run that are still to come: 1 … 65535.
///
/// `high` · 256 + `low`, where a `low` of 0 means 256: counting down touches
/// one byte, and looks at the other once in 256 steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(crate) struct Left {
    low: u8,
    high: u8,
}

impl Left {
    /// `count` steps, at least 1.
    pub(crate) fn new(count: u16) -> Left {
        Left { low: count as u8, high: (count.wrapping_sub(1) >> 8) as u8 }
    }

    pub(crate) fn steps(self) -> u16 {
        let high = if self.low == 0 { self.high.wrapping_add(1) } else { self.high };
        u16::from_le_bytes([self.low, high])
    }

    /// One step less. True if none is left.
    #[inline(always)]
    pub(crate) fn count_down(&mut self) -> bool {
        self.low = self.low.wrapping_sub(1);
        if self.low != 0 {
            return false;
        }
        if self.high == 0 {
            return true;
        }
        self.high -= 1;
        false
    }
}

/// A run whose intervals are all near, ready to play.
///
/// The layout is the one that `engine/short.rs` knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(crate) struct Stride {
    /// The interval in 2⁻¹⁶ ticks.
    pub(crate) interval: u32,
    /// What the interval grows by, once a group.
    pub(crate) add: i32,
    pub(crate) left: Left,
    /// Steps of a group less 1; 255 for no growth. The interval grows when no
    /// bit of it is set in `left`. (Then `add` only tells what the run was.)
    pub(crate) group: u8,
    /// Half the run's shorter interval in ticks, less [`LOOK`], little end
    /// first; the high byte is never [`FAR`].
    room: [u8; 2],
}

impl Stride {
    /// `None` if it is a turn, or an interval is not [`NEAR`].
    pub(crate) fn of(run: &Run) -> Option<Stride> {
        if run.count == 0 || run.ticks >= NEAR {
            return None;
        }
        let first = run.ticks as i32;
        let last = last_ticks(run);
        if !(0..NEAR as i32).contains(&last) {
            return None;
        }
        let mut interval = (run.ticks << 16) | Ticks::from(run.part);
        let mut add = run.add;
        let mut room = (first.min(last) as i16 >> 1) - LOOK;
        let group = if add == 0 || is_short(run) { 255 } else { group(run) };
        if add != 0 {
            let sum = add.wrapping_mul(span(group, run.count.into()));
            let mut mean = sum >> 1;
            if sum & 1 != 0 {
                // As often up as down; the last bit of `room` remembers.
                let up = run.part & 1;
                mean += i32::from(up);
                room = room & !1 | up as i16;
            }
            interval = interval.wrapping_add_signed(mean);
            if group != 255 {
                add = add.wrapping_mul(i32::from(group) + 1);
            }
        }
        Some(Stride { interval, add, left: Left::new(run.count), group, room: room.to_le_bytes() })
    }

    /// Adds the growth, if a group begins.
    #[inline(always)]
    pub(crate) fn grow(&mut self) {
        if self.left.low & self.group == 0 {
            self.interval = self.interval.wrapping_add_signed(self.add);
        }
    }

    /// Half an interval in ticks: a step with less than this from its edge to
    /// the next deadline is late.
    #[inline(always)]
    pub(crate) fn half(&self) -> i32 {
        i32::from(i16::from_le_bytes(self.room)) + i32::from(LOOK)
    }
}

/// Ticks between an edge and the look at the timer after it in the short way,
/// so that it compares once.
pub(crate) const LOOK: i16 = 53;

/// Whole ticks of the last interval; outside 0 … [`NEAR`] if it does not fit.
fn last_ticks(run: &Run) -> i32 {
    let steps = run.count.wrapping_sub(1);
    // Two 16-bit products: 64 bits are dear on an 8-bit chip.
    let low = u32::from(run.add as u16) * u32::from(steps);
    let high = (run.add >> 16).wrapping_mul(i32::from(steps));
    let carried = (low.wrapping_add(u32::from(run.part)) >> 16) as i32;
    (run.ticks as i32).wrapping_add(high).wrapping_add(carried)
}

/// The longest group that deviates little enough, less 1.
fn group(run: &Run) -> u8 {
    let growth = run.add.unsigned_abs();
    let mut bits = 0;
    while bits < LONGEST_GROUP
        && run.count & ((2 << bits) - 1) == 0
        && growth <= LOOSE >> (2 * bits + 2)
    {
        bits += 1;
    }
    (1u8 << bits) - 1
}

/// Whether the run at its mean interval deviates little enough. Its steps are
/// then fewer than 256.
fn is_short(run: &Run) -> bool {
    let count = u32::from(run.count);
    count == 1
        || count < 256 && run.add.unsigned_abs() <= LOOSE && {
            // 16 bits by 16.
            let square = (run.count).wrapping_mul(run.count);
            u32::from(square).saturating_mul(run.add.unsigned_abs()) <= LOOSE
        }
}

/// Steps less 1 that an interval stands for, of `count` in the run.
fn span(group: u8, count: u32) -> i32 {
    if group == 255 { count.wrapping_sub(1) as i32 } else { group.into() }
}

/// How a run waits in a queue: a stride, or a run that is none in its place.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Slot(Stride);

/// The high byte of `room` of a run that is not a stride.
const FAR: u8 = 0x80;

impl Slot {
    /// All zeros, so that queues need no room in flash.
    pub(crate) const EMPTY: Slot = Slot(Stride {
        interval: 0,
        add: 0,
        left: Left { low: 0, high: 0 },
        group: 0,
        room: [0; 2],
    });

    pub(crate) fn of(run: &Run) -> Slot {
        Slot(Stride::of(run).unwrap_or_else(|| {
            let [low, high] = ((run.ticks >> 16) as u16).to_le_bytes();
            let [left_low, left_high] = run.count.to_le_bytes();
            Stride {
                interval: run.ticks << 16 | Ticks::from(run.part),
                add: run.add,
                left: Left { low: left_low, high: left_high },
                group: high,
                room: [low, FAR],
            }
        }))
    }

    /// The run that was put in.
    #[cfg_attr(target_arch = "avr", allow(dead_code))]
    pub(crate) fn run(&self) -> Run {
        match self.entry() {
            Entry::Far(run) => run,
            Entry::Near(Stride { mut interval, mut add, left, group, room }) => {
                if group != 255 {
                    add >>= group.count_ones();
                }
                let sum = add.wrapping_mul(span(group, u32::from(left.steps())));
                let up = if sum & 1 != 0 { i32::from(room[0] & 1) } else { 0 };
                let mean = (sum >> 1) + up;
                interval = interval.wrapping_add_signed(mean.wrapping_neg());
                Run { ticks: interval >> 16, part: interval as u16, count: left.steps(), add }
            }
        }
    }

    /// What plays, if it is a stride.
    #[inline(always)]
    pub(crate) fn stride(&mut self) -> &mut Stride {
        &mut self.0
    }

    /// Steps that are left of a stride.
    pub(crate) fn left(&self) -> u16 {
        self.0.left.steps()
    }

    /// Whether it is a stride, or the run that it is.
    pub(crate) fn far(&self) -> Option<Run> {
        match self.entry() {
            Entry::Near(_) => None,
            Entry::Far(run) => Some(run),
        }
    }

    fn entry(&self) -> Entry {
        let stride = &self.0;
        let [low, high] = stride.room;
        if high != FAR {
            return Entry::Near(*stride);
        }
        let count = u16::from_le_bytes([stride.left.low, stride.left.high]);
        let ticks = Ticks::from(u16::from_le_bytes([low, stride.group]));
        Entry::Far(Run {
            ticks: ticks << 16 | stride.interval >> 16,
            part: stride.interval as u16,
            count,
            add: stride.add,
        })
    }
}

/// What a run is for the step interrupt.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(target_arch = "avr", allow(dead_code))]
enum Entry {
    Near(Stride),
    /// A turn, or a run whose intervals are dealt out step by step.
    Far(Run),
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// Deadlines after the step before the run, in 2⁻¹⁶ ticks.
    fn played(mut stride: Stride) -> Vec<i64> {
        let mut due = 0;
        let mut all = Vec::new();
        loop {
            due += i64::from(stride.interval);
            all.push(due);
            if stride.left.count_down() {
                return all;
            }
            stride.grow();
        }
    }

    fn run() -> impl Strategy<Value = Run> {
        let count = prop_oneof![1u16..2000, (0u32..16).prop_map(|bits| 1 << bits), Just(0)];
        let ticks = prop_oneof![0u32..NEAR, 60u32..400, any::<u32>()];
        let add = prop_oneof![-40i32..40, -9000i32..9000, any::<i32>(), Just(0)];
        (ticks, any::<u16>(), add, count).prop_map(|(ticks, part, add, count)| Run {
            ticks,
            part,
            count,
            add,
        })
    }

    proptest! {
        #[test]
        fn a_slot_gives_the_run_back(run in run()) {
            prop_assert_eq!(Slot::of(&run).run(), run);
        }

        #[test]
        fn a_stride_is_its_run_within_a_sixteenth_of_a_tick(run in run()) {
            let near = |interval: i128| (0..i128::from(NEAR) << 16).contains(&interval);
            let first = i128::from(run.interval());
            let last = first + i128::from(run.add) * (i128::from(run.count) - 1);
            let Some(stride) = Stride::of(&run) else {
                prop_assert!(run.count == 0 || !near(first) || !near(last));
                return Ok(());
            };
            prop_assert!(near(first) && near(last));
            let (mut due, mut interval) = (0, first as i64);
            let times = played(stride);
            prop_assert_eq!(times.len(), usize::from(run.count));
            for (n, time) in times.iter().enumerate() {
                due += interval;
                interval += i64::from(run.add);
                let lost = n as i64 / 2 + 1;
                prop_assert!((time - due).abs() <= (1 << 12) + lost, "step {n}: {time}, not {due}");
            }
            prop_assert!((times[times.len() - 1] - due).abs() <= i64::from(run.count) / 2);
        }
    }

    #[test]
    fn left_counts_down_to_nothing() {
        for count in [1u16, 2, 255, 256, 257, 512, 65535] {
            let mut left = Left::new(count);
            for rest in (1..=count).rev() {
                assert_eq!(left.steps(), rest);
                assert_eq!(left.count_down(), rest == 1);
            }
        }
    }
}
