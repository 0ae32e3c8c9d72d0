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
//! edge. A step is late when its edge came after half the interval to the next
//! one, so then less than half of it, less `LOOK`, is left: that is the run's
//! `suspect`, computed when the run was pushed. The engine takes the path's
//! length off the timer and gets the edge to within a cycle.

use super::Engine;
use super::track::{Event, Track};
use crate::drive::Drive;
use crate::queue::Consumer;
use crate::timer::{Count, StepTimer};
use core::mem::{offset_of, size_of};

/// Cycles from the edge to the look at the timer that comes with a code.
const EMPTY: i32 = 36;
const FAR: i32 = 52;
const RELOADED: i32 = 171;
const SUSPECT: i32 = 61;
/// More, if the interval has grown, or the low byte of the count is through.
const GROWN: i32 = 27;
const WRAPPED: i32 = 11;

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
    pub const FEEDS: usize = offset_of!(Self, feeds);
    #[doc(hidden)]
    pub const RARE_AT: usize = offset_of!(Self, rare);
    #[doc(hidden)]
    pub const AXES: usize = N;
    #[doc(hidden)]
    pub const QUEUE_MASK: usize = Q - 1;
    #[doc(hidden)]
    pub const RELOADED_LATER: i32 = 105;

    const LAYOUT: () = {
        use crate::stride::Stride;
        assert!(offset_of!(Track<u16>, play) == 4 && offset_of!(Track<u16>, loaded) == 17);
        assert!(offset_of!(Stride, add) == 4 && offset_of!(Stride, left) == 8);
        assert!(offset_of!(Stride, group) == 10 && offset_of!(Stride, suspect) == 11);
        assert!(size_of::<Stride>() == 13 && N <= 3 && 13 * Q <= 256);
    };

    /// The long way, after the short one: `code` says from where, `look` what
    /// the timer showed.
    pub fn on_long_way(&mut self, code: u8, look: u16) {
        let () = Self::LAYOUT;
        let axis = usize::from(code & 3);
        if let Some(track) = self.tracks.get(axis)
            && track.event == Event::Step
        {
            let ended = code & 8 != 0;
            let since = match code & 12 {
                8 => EMPTY,
                12 => FAR,
                4 => RELOADED,
                _ => {
                    let low = track.play.left.low();
                    let grown = if low & track.play.group == 0 { GROWN } else { 0 };
                    SUSPECT + grown + if low == 0 { WRAPPED } else { 0 }
                }
            };
            let edge = look.wrapping_sub(since as u16);
            let deadline =
                if ended { track.due } else { u16::earlier(track.due, track.play.interval) };
            let behind = edge.since(u16::of(deadline));
            if ended {
                self.load(axis, edge);
            }
            self.judge(axis, behind, edge);
        }
        self.on_compare();
    }
}

/// Makes the step interrupt's handler: the short way in front of an [`Engine`].
///
/// For up to 3 axes with a [`Queue`](crate::queue::Queue) of 2 to 16 runs each, on a 16-bit timer
/// that counts every cycle in normal mode. The engine lies in a static, from
/// its first byte on; the handler calls a function for the long way. The
/// timer's [`StepTimer`] has `SHORT` true and writes [`arm`](StepTimer::arm)'s
/// flags to GPIOR0; nothing else uses GPIOR0, 1 and 2.
///
/// ```ignore
/// type Motion = Engine<Timer, Pins, Consumer<'static, 8>, 3>;
/// static ENGINE: Shared<MaybeUninit<Motion>> = …; // repr(transparent)
///
/// extern "C" fn long_way(code: u8, look: u16) {
///     // SAFETY: only the step interrupt calls it, and interrupts are off.
///     unsafe { (*ENGINE.get()).assume_init_mut() }.on_long_way(code, look);
/// }
///
/// stepwright::short_way! {
///     vector: "__vector_11",          // TIMER1_COMPA of an ATmega328P
///     engine: ENGINE as Motion,
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
            long = sym $long,
            tracks = const <$Engine>::TRACKS,
            track = const <$Engine>::TRACK,
            feeds = const <$Engine>::FEEDS,
            rare = const <$Engine>::RARE_AT,
            axes = const <$Engine>::AXES,
            mask = const <$Engine>::QUEUE_MASK,
            later = const <$Engine>::RELOADED_LATER,
            tcnt = const $timer,
            ocr = const $compare,
            port0 = const $port0, bit0 = const $bit0,
            port1 = const $port1, bit1 = const $bit1,
            port2 = const $port2, bit2 = const $bit2,
        );
    };
}
