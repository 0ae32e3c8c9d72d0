//! The structures that the step interrupts and the foreground share: the assembly's offsets are
//! constants of these structures, and its other assumptions are asserted here.

use core::mem::offset_of;

use stepwright::drive::Axes;
use stepwright::entry::Entry;
use stepwright::queue::Queue;

use super::RUNS;

/// Events with the same pins and the same wait.
#[derive(Clone, Copy)]
#[repr(C)]
pub(super) struct Group {
    /// The interval, in 2⁻⁸ ticks.
    pub(super) interval: [u8; 3],
    /// Half the interval less [`LOOK`](super::LOOK), in ticks: with less time to the next deadline
    /// a step is late.
    pub(super) room: [u8; 2],
    /// The number of events left, coded as in `entry::Events`.
    pub(super) left: [u8; 2],
    pub(super) pins: u8,
}

impl Group {
    const NONE: Group = Group { interval: [0; 3], room: [0; 2], left: [0; 2], pins: 0 };
}

/// The state of an axis that its interrupt plays.
#[doc(hidden)]
#[repr(C)]
pub struct AxisState {
    pub(super) now: Group,
    pub(super) next: Group,
    pub(super) growth: [u8; 3],
    pub(super) events: [u8; 2],
    pub(super) groups: u8,
    pub(super) then: u8,
    /// The deadline in 2⁻⁸ ticks. A 16-bit compare register holds its upper bytes.
    pub(super) due: [u8; 3],
    /// 1: the queue is empty, and the next event is not late yet; 2: it is late.
    pub(super) starved: u8,
    /// The steps of the groups prepared since the travel began.
    pub(super) loaded: [u8; 5],
    /// Bit 0: the last prepared group is backward.
    #[cfg(feature = "stream")]
    pub(super) facing: u8,
    pub(super) queue: Queue<RUNS>,
}

#[doc(hidden)] // for the assembly
impl AxisState {
    pub const NEXT: usize = offset_of!(AxisState, next);
    pub const GROWTH: usize = offset_of!(AxisState, growth);
    pub const EVENTS: usize = offset_of!(AxisState, events);
    pub const GROUPS: usize = offset_of!(AxisState, groups);
    pub const THEN: usize = offset_of!(AxisState, then);
    pub const DUE: usize = offset_of!(AxisState, due);
    pub const STARVED: usize = offset_of!(AxisState, starved);
    pub const LOADED: usize = offset_of!(AxisState, loaded);
    pub const QUEUE: usize = offset_of!(AxisState, queue);
    /// The layout of a group.
    pub const NOW: usize = offset_of!(AxisState, now);
    pub const GROUP: usize = size_of::<Group>();
    pub const WAIT: usize = offset_of!(Group, interval);
    pub const ROOM: usize = offset_of!(Group, room);
    pub const LEFT: usize = offset_of!(Group, left);
    pub const PINS: usize = offset_of!(Group, pins);

    const LAYOUT: () = {
        // The assembly has the sizes of these fields built in.
        assert!(size_of::<Group>() == 3 + 2 + 2 + 1);
        assert!(Self::LOADED + 5 <= size_of::<AxisState>() && size_of::<AxisState>() < 256);
        #[cfg(feature = "stream")]
        assert!(offset_of!(AxisState, facing) == Self::LOADED + 5);
        // An entry is read from its first byte to its last, and its offset is 11 times its number.
        assert!(size_of::<Entry>() == 11);
        assert!(Entry::INTERVAL == 0 && Entry::GROWTH == 3 && Entry::EVENTS == 6);
        assert!(Entry::GROUPS == 8 && Entry::THEN == 9 && Entry::PINS == 10);
        // A slot's number is the counter with the upper bits masked.
        assert!(RUNS.is_power_of_two());
        // The assembly reaches these fields through Z.
        assert!(Self::QUEUE + Queue::<RUNS>::PLAYED < 64);
    };

    pub(super) const fn new() -> AxisState {
        let () = Self::LAYOUT;
        AxisState {
            now: Group::NONE,
            next: Group::NONE,
            growth: [0; 3],
            events: [0; 2],
            groups: 0,
            then: 0,
            due: [0; 3],
            starved: 0,
            loaded: [0; 5],
            #[cfg(feature = "stream")]
            facing: 0,
            queue: Queue::new(),
        }
    }
}

/// The state that all axes share.
#[doc(hidden)]
#[repr(C)]
pub struct Common {
    /// Late steps.
    pub(super) late: [u8; 3],
    /// The axes with nothing to prepare.
    pub(super) resting: Axes,
    /// The time for which a pulse lasts beyond its own 36 cycles, in 3 cycles; 0 for no longer.
    pub(super) hold: u8,
    /// The wait of a late step, in 3 cycles.
    pub(super) pace: u8,
}

#[doc(hidden)] // for the assembly
impl Common {
    pub const LATE: usize = offset_of!(Common, late);
    pub const RESTING: usize = offset_of!(Common, resting);
    pub const HOLD: usize = offset_of!(Common, hold);
    pub const PACE: usize = offset_of!(Common, pace);
}
