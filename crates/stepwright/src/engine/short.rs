//! The short way through the step interrupt of an AVR: one plain step, on
//! time, in assembly. Everything else goes the long way, through [`Engine`].
//!
//! ```text
//!  interrupt ─► flags: whose? ─► raise ─► count ─► grow? ─► due += interval
//!                  │               ▲        │ 0               │
//!                  │ rare          │        ▼                 ▼
//!                  │               │      reload ─────► compare = due, drop
//!                  │               │        │ dry, far        │
//!                  ▼               │        ▼                 ▼
//!              the engine ◄────────┼─────────────── late? due already? ─► out
//!                                  └── first of several ◄──┘
//! ```
//!
//! # What it does
//!
//! A plain step of a near run; growth of the interval; the next run from a
//! [`Queue`], if it is near; late steps, counted and caught up; the next
//! deadline of several axes. It leaves what the engine would have left. A turn,
//! a long interval, an empty queue and a pulse longer than its own (2.8 µs) are
//! the engine's: some 700 to 2,000 cycles, in which other axes wait.
//!
//! # Cost
//!
//! Cycles of an ATmega328P in simulation, entry (4) and `jmp` (3) included:
//!
//! | | entry to exit |
//! | --- | --- |
//! | one axis, a step at constant speed; the second axis 106, the third 108 | 102 |
//! | … on which the interval grows (every 2nd to 32nd of a long ramp, `stride.rs`) | 129 |
//! | … that ends a run: the next one is there | 149 |
//! | … that was due on the way out of the one before, to the next edge (counted by hand) | 71 |
//! | … likewise, and late: at least `min_interval` | 114 |
//! | two axes due together | 239 |
//! | three axes due together | 309 |
//!
//! So one axis holds 133 cycles a step (120,000 steps/s) at 77 % load, and three
//! in phase hold 45,000 steps/s each at 87 %. Out of phase three such axes share
//! passes: the interrupt then never ends, and a few steps are late.
//!
//! # Registers
//!
//! It keeps its flags in GPIOR0 and saves in GPIOR1 and GPIOR2: nobody else
//! may use these.
//!
//! # How lateness is found
//!
//! After a step the short way looks at the timer, `LOOK` cycles after the
//! edge. A step is late when less than half an interval is left then from its
//! edge to the next deadline; a run's `room` is half its shorter interval less
//! `LOOK`, so one comparison tells. Where the interval has grown or a run was
//! loaded the look is later, and the rare way that counts allows for it. Not
//! allowed for: once in 256 steps the look is 11 cycles later, so that a step
//! may be counted that came 11 cycles before the limit. Of several axes all
//! edges come first, 13 cycles apart, and one look before them stands for all:
//! it is right for the second, and 13 cycles off for the first and the third.
//!
//! What is behind by 3,072 ticks slips: the pass over several axes looks 0x7000
//! ticks ahead in a 16-bit counter, and so no further back than 0x1000.

use super::Engine;
use super::late::FAR_BEHIND;
use super::track::Track;
use crate::drive::Drive;
use crate::queue::{Consumer, Feed, Queue};
use crate::stride::{LOOK, Slot};
use crate::timer::StepTimer;
use core::mem::{offset_of, size_of};

/// In `ended`: an axis is too far behind.
const BEHIND: u8 = 0x80;

/// Where things lie, for [`short_way!`](crate::short_way) and
/// [`direct_way!`](crate::direct_way).
impl<T, D, F, const N: usize> Engine<T, D, F, N>
where
    T: StepTimer<Count = u16>,
    D: Drive,
    F: Feed,
{
    #[doc(hidden)]
    pub const TRACKS: usize = offset_of!(Self, tracks);
    #[doc(hidden)]
    pub const TRACK: usize = size_of::<Track<u16>>();
    #[doc(hidden)]
    pub const OWN: usize = offset_of!(Track<u16>, own);
    /// Where the feeds lie.
    pub(crate) const FEEDS_AT: usize = offset_of!(Self, feeds);
    #[doc(hidden)]
    pub const ENDED: usize = offset_of!(Self, ended);
    #[doc(hidden)]
    pub const LATE: usize = offset_of!(Self, late);
    #[doc(hidden)]
    pub const FAR_BEHIND: i32 = FAR_BEHIND >> 8;
    #[doc(hidden)]
    pub const AXES: usize = N;

    const LAYOUT: () = {
        assert!(offset_of!(Track<u16>, at) == 4 && offset_of!(Track<u16>, loaded) == 6);
        assert!(size_of::<Slot>() == 13 && N <= 3);
    };

    /// The long way, from the short one: what that could not do. If a run has
    /// ended, `look` is the timer `LOOK` ticks after its last edge.
    pub fn on_long_way(&mut self, look: u16) {
        let () = Self::LAYOUT;
        let ended = core::mem::take(&mut self.ended);
        if ended != 0 {
            let edge = look.wrapping_sub(LOOK as u16);
            let mut axes = ended;
            for axis in 0..N {
                if axes & 1 != 0 {
                    self.finish(axis, edge);
                }
                axes >>= 1;
            }
            if ended & BEHIND != 0 {
                self.slip();
            }
        }
        self.on_compare();
    }
}

/// … and for those who play a queue.
impl<T, D, const N: usize, const Q: usize> Engine<T, D, Consumer<'static, Q>, N>
where
    T: StepTimer<Count = u16>,
    D: Drive,
{
    #[doc(hidden)]
    pub const RARE: usize = offset_of!(Self, rare);
    #[doc(hidden)]
    pub const PACE: usize = offset_of!(Self, pace);
    #[doc(hidden)]
    pub const QUEUE: usize = {
        assert!(Queue::<Q>::SLOTS_AT == 3 && Q * 13 < 256);
        size_of::<Queue<Q>>()
    };
    #[doc(hidden)]
    pub const SLOTS: usize = Q * size_of::<Slot>();
    /// Cycles by which the look after a step is later when the interval grew.
    #[doc(hidden)]
    pub const GROWN: usize = 27;
    /// … when the step was the last of its run.
    #[doc(hidden)]
    pub const RELOADED: usize = 48;
    /// Cycles from the look at the timer before the edges of several axes to
    /// where it would be after one of them.
    #[doc(hidden)]
    pub const EDGES: i16 = 28 + LOOK;
}

/// Makes the step interrupt's handler: the short way in front of an [`Engine`].
///
/// For up to 3 axes with a [`Queue`] of 2 to 16 runs each, on a 16-bit timer
/// that counts every cycle in normal mode. Engine and queues lie in statics,
/// from their first byte on; the handler calls a function for the long way. The
/// timer's [`StepTimer`] has `SHORT` true and writes [`arm`](StepTimer::arm)'s
/// flags to GPIOR0; nothing else uses GPIOR0, 1 and 2.
///
/// ```ignore
/// type Motion = Engine<Timer, Pins, Consumer<'static, 8>, 3>;
/// static ENGINE: Shared<MaybeUninit<Motion>> = …; // repr(transparent)
/// static QUEUES: Shared<[Queue<8>; 3]> = …;       // split once, at the start
///
/// unsafe extern "C" fn long_way(look: u16) {
///     // SAFETY: only the step interrupt calls it, and interrupts are off.
///     unsafe { (*ENGINE.get()).assume_init_mut() }.on_long_way(look);
/// }
///
/// stepwright::short_way! {
///     vector: "__vector_11",          // TIMER1_COMPA of an ATmega328P
///     engine: ENGINE as Motion,
///     queues: QUEUES,
///     long_way: long_way,
///     // addresses of TCNT1L and OCR1AL, I/O address of TIFR1, where bit 1 is OCF1A
///     timer: 0x84, compare: 0x88, flags: 0x16,
///     // I/O addresses and bits of the STEP pins (three, the last repeated)
///     steps: (0x0B, 2) (0x0B, 3) (0x0B, 4),
/// }
/// ```
///
/// `vector: "__vector_11" + "rjmp .+0",` puts an instruction first: a build
/// for a simulator that charges no cycles for entering an interrupt spends the
/// chip's 4 with two of these.
#[macro_export]
macro_rules! short_way {
    (
        vector: $vector:literal $(+ $enter:literal)?,
        engine: $engine:path as $Engine:ty,
        queues: $queues:path,
        long_way: $long:path,
        timer: $timer:expr, compare: $compare:expr, flags: $flags:expr,
        steps: ($port0:expr, $bit0:expr) ($port1:expr, $bit1:expr) ($port2:expr, $bit2:expr) $(,)?
    ) => {
        core::arch::global_asm!(
            $crate::short_way_text!(),
            concat!(".global ", $vector),
            concat!(".type ", $vector, ",@function"),
            concat!($vector, ":"),
            $($enter,)?
            "sw_handler",
            engine = sym $engine,
            queues = sym $queues,
            long = sym $long,
            tracks = const <$Engine>::TRACKS,
            track = const <$Engine>::TRACK,
            rare_at = const <$Engine>::RARE,
            ended_at = const <$Engine>::ENDED,
            pace_at = const <$Engine>::PACE,
            far_behind = const <$Engine>::FAR_BEHIND,
            late_at = const <$Engine>::LATE,
            axes = const <$Engine>::AXES,
            queue = const <$Engine>::QUEUE,
            slots = const <$Engine>::SLOTS,
            reloaded = const <$Engine>::RELOADED,
            grown = const <$Engine>::GROWN,
            edges = const <$Engine>::EDGES,
            tcnt = const $timer,
            ocr = const $compare,
            tifr = const $flags,
            port0 = const $port0, bit0 = const $bit0,
            port1 = const $port1, bit1 = const $bit1,
            port2 = const $port2, bit2 = const $bit2,
        );
    };
}
