//! The direct way through the step interrupt of an AVR: a step of one axis, and
//! the law's next interval, in assembly. The rest goes through [`Engine`].
//!
//! ```text
//!  interrupt ─► flags: whose? ─► raise ─► due += ready ─► compare = due, drop
//!                  │ several       ▲                            │
//!                  │               │ due already                ▼
//!                  ▼               │                     late? count it
//!              the engine ◄────────┼─ far: 1.8 ms or more       │
//!                                  │                            ▼
//!                                  └────────────── ready = Ramp::step ──► out
//! ```
//!
//! It leaves what the engine would have left, and computes what [`Ramp`] does,
//! bit for bit. Two and more axes, and intervals too long for it, are the
//! engine's: some 1,000 to 2,000 cycles.
//!
//! # Cost
//!
//! Cycles of an ATmega328P in simulation, entry (4) and `jmp` (3) included:
//!
//! | | entry to exit |
//! | --- | --- |
//! | at top speed | 180 |
//! | on a ramp at 40,000 steps/s and 40,000 steps/s², where 2c/(4n+1) is 2 to 3 | 330 |
//! | … where the quotient has 8 bits | 540 |
//!
use super::feed::Direct;
use super::ramp::Ramp;
use crate::drive::Drive;
use crate::engine::Engine;
use crate::stride::{LOOK, NEAR};
use crate::timer::StepTimer;
use core::mem::{offset_of, size_of};

/// Where things lie, for [`direct_way!`](crate::direct_way).
impl<T, D, const N: usize> Engine<T, D, Direct, N>
where
    T: StepTimer<Count = u16>,
    D: Drive,
{
    #[doc(hidden)]
    pub const FEEDS: usize = {
        assert!(offset_of!(Direct, ready) == 0 && offset_of!(Direct, ramp) == 4);
        let () = Ramp::LAYOUT;
        Self::FEEDS_AT
    };
    #[doc(hidden)]
    pub const FEED: usize = size_of::<Direct>();
    /// Intervals from here on are far: the high byte.
    #[doc(hidden)]
    pub const NEAR: usize = NEAR as usize >> 8;
    /// Cycles between an edge and the look at the timer after it, here …
    #[doc(hidden)]
    pub const LOOK: usize = 50;
    /// … and where a run has ended.
    #[doc(hidden)]
    pub const REACH: i16 = LOOK;
}

/// Makes the step interrupt's handler: the direct way in front of an [`Engine`]
/// whose feeds are [`Direct`].
///
/// For up to 3 axes, on a 16-bit timer that counts every cycle in normal mode. The
/// engine lies in a static, from its first byte on; the handler calls a function for the
/// long way. The timer's [`StepTimer`] has `SHORT` true and writes
/// [`arm`](StepTimer::arm)'s flags to GPIOR0; nothing else uses GPIOR0, 1 and 2.
///
/// `vector: "__vector_11" + "rjmp .+0",` puts an instruction first: a build for a
/// simulator that charges no cycles for entering an interrupt spends the chip's 4 with
/// two of these.
#[macro_export]
macro_rules! direct_way {
    (
        vector: $vector:literal $(+ $enter:literal)?,
        engine: $engine:path as $Engine:ty,
        long_way: $long:path,
        timer: $timer:expr, compare: $compare:expr, flags: $flags:expr,
        steps: ($port0:expr, $bit0:expr) ($port1:expr, $bit1:expr) ($port2:expr, $bit2:expr) $(,)?
    ) => {
        core::arch::global_asm!(
            $crate::direct_way_text!(),
            concat!(".global ", $vector),
            concat!(".type ", $vector, ",@function"),
            concat!($vector, ":"),
            $($enter,)?
            "sd_handler",
            engine = sym $engine,
            long = sym $long,
            tracks = const <$Engine>::TRACKS,
            track = const <$Engine>::TRACK,
            own = const <$Engine>::OWN,
            feeds = const <$Engine>::FEEDS,
            feed = const <$Engine>::FEED,
            ended_at = const <$Engine>::ENDED,
            far_behind = const <$Engine>::FAR_BEHIND,
            late_at = const <$Engine>::LATE,
            axes = const <$Engine>::AXES,
            near = const <$Engine>::NEAR,
            look = const <$Engine>::LOOK,
            reach = const <$Engine>::REACH,
            tcnt = const $timer,
            ocr = const $compare,
            tifr = const $flags,
            port0 = const $port0, bit0 = const $bit0,
            port1 = const $port1, bit1 = const $bit1,
            port2 = const $port2, bit2 = const $bit2,
        );
    };
}
