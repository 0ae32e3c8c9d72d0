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
//! [`Queue`](crate::queue::Queue), if it is near; the next deadline of several
//! axes. It leaves exactly what the engine would have left. A turn, a long
//! interval, an empty queue, a pulse longer than its own and catching up are
//! the engine's. So is a step that may have been late: the short way finds
//! these by one comparison, the engine counts.
//!
//! # Cost
//!
//! Cycles of an ATmega328P, entry (4) and `jmp` (3) included, first axis:
//!
//! | | one axis | of it before the edge |
//! | --- | --- | --- |
//! | a step, entry to exit | 90 | 16 |
//! | … on which the interval grows | 117 | 16 |
//! | a step that was due on the way out of the one before | 65 | |
//!
//! The second axis has its edge 4 cycles later, the third 6. On a long ramp
//! the interval grows every 2 … 32 steps (`stride.rs`).
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
//! `LOOK`, so one comparison tells. Where the interval has grown the look is
//! later, and the rare way that counts allows for it. Of several axes all edges
//! come first; that look is reckoned, to within 30 cycles. Once in 256 steps a
//! look is 11 cycles late.

use super::Engine;
use super::track::Track;
use crate::drive::Drive;
use crate::queue::{Consumer, Queue};
use crate::stride::{LOOK, Slot};
use crate::timer::StepTimer;
use core::mem::{offset_of, size_of};

/// Where things lie, for [`short_way!`](crate::short_way).
impl<T, D, const N: usize, const Q: usize> Engine<T, D, Consumer<'static, Q>, N>
where
    T: StepTimer<Count = u16>,
    D: Drive,
{
    #[doc(hidden)]
    pub const TRACKS: usize = offset_of!(Self, tracks);
    #[doc(hidden)]
    pub const TRACK: usize = size_of::<Track<u16>>();
    #[doc(hidden)]
    pub const RARE: usize = offset_of!(Self, rare);
    #[doc(hidden)]
    pub const ENDED: usize = offset_of!(Self, ended);
    #[doc(hidden)]
    pub const PACE: usize = offset_of!(Self, pace);
    #[doc(hidden)]
    pub const LATE: usize = offset_of!(Self, late);
    #[doc(hidden)]
    pub const AXES: usize = N;
    #[doc(hidden)]
    pub const QUEUE: usize = size_of::<Queue<Q>>();
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

    const LAYOUT: () = {
        assert!(offset_of!(Track<u16>, at) == 4 && offset_of!(Track<u16>, loaded) == 6);
        assert!(size_of::<Slot>() == 13 && Queue::<Q>::SLOTS_AT == 3);
        assert!(N <= 3 && Q * 13 < 256);
    };

    /// The long way, from the short one: what that could not do. If a run has
    /// ended, `look` is the timer `LOOK` ticks after its last edge.
    pub fn on_long_way(&mut self, look: u16) {
        let () = Self::LAYOUT;
        let ended = core::mem::take(&mut self.ended);
        let edge = look.wrapping_sub(LOOK as u16);
        for axis in 0..N {
            if ended >> axis & 1 != 0 {
                self.finish(axis, edge);
            }
        }
        self.slip();
        self.on_compare();
    }
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
/// extern "C" fn long_way(look: u16) {
///     // SAFETY: only the step interrupt calls it, and interrupts are off.
///     unsafe { (*ENGINE.get()).assume_init_mut() }.on_long_way(look);
/// }
///
/// stepwright::short_way! {
///     vector: "__vector_11",          // TIMER1_COMPA of an ATmega328P
///     engine: ENGINE as Motion,
///     queues: QUEUES,
///     long_way: long_way,
///     timer: 0x84, compare: 0x88,     // addresses of TCNT1L and OCR1AL
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
        timer: $timer:expr, compare: $compare:expr,
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
            late_at = const <$Engine>::LATE,
            axes = const <$Engine>::AXES,
            queue = const <$Engine>::QUEUE,
            slots = const <$Engine>::SLOTS,
            reloaded = const <$Engine>::RELOADED,
            grown = const <$Engine>::GROWN,
            edges = const <$Engine>::EDGES,
            tcnt = const $timer,
            ocr = const $compare,
            port0 = const $port0, bit0 = const $bit0,
            port1 = const $port1, bit1 = const $bit1,
            port2 = const $port2, bit2 = const $bit2,
        );
    };
}
