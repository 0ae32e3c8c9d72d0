//! The one hardware resource of the engine: a free-running counter with a compare register.

use crate::units::Ticks;

/// The width of a counter: `u16` or `u32`.
///
/// Times have 16 fractional bits and wrap with the counter. With a 16-bit timer, deadlines and
/// intervals are 32-bit numbers, whose sum costs an 8-bit chip four additions. With a 32-bit timer
/// the whole ticks are a word of their own, which a 32-bit chip reads without a shift.
pub trait Count: Copy + Eq + core::fmt::Debug + sealed::Sealed {
    /// A count with at least 16 fractional bits; wraps like the counter.
    type Fine: Copy + core::fmt::Debug + Default;

    /// The count 0, also as a time.
    const ZERO: (Self, Self::Fine);

    /// The longest piece of a long wait, a hop: 2^`HOP_BITS` ticks, a quarter of the counter.
    const HOP_BITS: u8;
    /// The hop in ticks.
    const HOP: Ticks = 1 << Self::HOP_BITS;

    /// Whether the counter can measure 2²⁴ ticks.
    const WIDE: bool = Self::HOP_BITS > 24;

    /// The time of `ticks` and `part` · 2⁻¹⁶ ticks.
    fn fine(ticks: Ticks, part: u16) -> Self::Fine;
    /// The whole ticks of a time, as a count.
    fn of(fine: Self::Fine) -> Self;
    /// The time that is `by` · 2⁻¹⁶ ticks later.
    fn later(fine: Self::Fine, by: u32) -> Self::Fine;
    /// The time that is `by` · 2⁻¹⁶ ticks earlier.
    fn earlier(fine: Self::Fine, by: u32) -> Self::Fine;
    /// The time that is `ticks` whole ticks later; earlier if `ticks` is a negative number that has
    /// wrapped.
    fn delayed(fine: Self::Fine, ticks: Ticks) -> Self::Fine;
    /// The count that is `ticks` ticks later.
    fn plus(self, ticks: Ticks) -> Self;
    /// Ticks from `earlier` to this count; negative if this count is the earlier one. Correct while
    /// they are less than half the counter apart.
    fn since(self, earlier: Self) -> i32;
    /// Whether this count is later than `now`.
    fn is_after(self, now: Self) -> bool;
    /// Whether this count is at least `ticks` ticks after `now`; `ticks` is less than half the
    /// counter.
    fn leaves(self, now: Self, ticks: Ticks) -> bool;
    /// The earlier of two counts, as seen from `now`.
    fn first(self, other: Self, now: Self) -> Self;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
}

impl Count for u16 {
    type Fine = u32;
    const ZERO: (u16, u32) = (0, 0);
    const HOP_BITS: u8 = 14;

    #[inline(always)]
    fn fine(ticks: Ticks, part: u16) -> u32 {
        ticks << 16 | part as u32
    }
    #[inline(always)]
    fn of(fine: u32) -> u16 {
        (fine >> 16) as u16
    }
    #[inline(always)]
    fn later(fine: u32, by: u32) -> u32 {
        fine.wrapping_add(by)
    }
    #[inline(always)]
    fn earlier(fine: u32, by: u32) -> u32 {
        fine.wrapping_sub(by)
    }
    #[inline(always)]
    fn delayed(fine: u32, ticks: Ticks) -> u32 {
        fine.wrapping_add(ticks << 16)
    }
    #[inline(always)]
    fn plus(self, ticks: Ticks) -> u16 {
        self.wrapping_add(ticks as u16)
    }
    #[inline(always)]
    fn since(self, earlier: u16) -> i32 {
        i32::from(self.wrapping_sub(earlier) as i16)
    }
    #[inline(always)]
    fn is_after(self, now: u16) -> bool {
        (self.wrapping_sub(now) as i16) > 0
    }
    #[inline(always)]
    fn leaves(self, now: u16, ticks: Ticks) -> bool {
        self.wrapping_sub(now) as i16 >= ticks as i16
    }
    #[inline(always)]
    fn first(self, other: u16, now: u16) -> u16 {
        if (other.wrapping_sub(now) as i16) < self.wrapping_sub(now) as i16 { other } else { self }
    }
}

impl Count for u32 {
    type Fine = u64;
    const ZERO: (u32, u64) = (0, 0);
    const HOP_BITS: u8 = 30;

    #[inline(always)]
    fn fine(ticks: Ticks, part: u16) -> u64 {
        (ticks as u64) << 32 | (part as u64) << 16
    }
    #[inline(always)]
    fn of(fine: u64) -> u32 {
        (fine >> 32) as u32
    }
    #[inline(always)]
    fn later(fine: u64, by: u32) -> u64 {
        fine.wrapping_add((by as u64) << 16)
    }
    #[inline(always)]
    fn earlier(fine: u64, by: u32) -> u64 {
        fine.wrapping_sub((by as u64) << 16)
    }
    #[inline(always)]
    fn delayed(fine: u64, ticks: Ticks) -> u64 {
        fine.wrapping_add((ticks as u64) << 32)
    }
    #[inline(always)]
    fn plus(self, ticks: Ticks) -> u32 {
        self.wrapping_add(ticks)
    }
    #[inline(always)]
    fn since(self, earlier: u32) -> i32 {
        self.wrapping_sub(earlier) as i32
    }
    #[inline(always)]
    fn is_after(self, now: u32) -> bool {
        (self.wrapping_sub(now) as i32) > 0
    }
    #[inline(always)]
    fn leaves(self, now: u32, ticks: Ticks) -> bool {
        self.wrapping_sub(now) as i32 >= ticks as i32
    }
    #[inline(always)]
    fn first(self, other: u32, now: u32) -> u32 {
        if (other.wrapping_sub(now) as i32) < self.wrapping_sub(now) as i32 { other } else { self }
    }
}

/// A free-running timer with one compare register.
///
/// ```text
///   counter     ──┬───────┬────────────┬──────► ticks, modulo the counter
///                 │       │ at         │ at
///   wake_at(at) ──┘ ahead └► interrupt │
///   wake_at(at) ───────────── passed ──┴─► interrupt at once
/// ```
///
/// An implementation MUST
/// - count up through all values of [`Count`] at a constant rate, the [`Rate`](crate::Rate) of its
///   board, and never be stopped or set while an engine uses it;
/// - return counts from [`now`](StepTimer::now) that never go back: a counter that is read in parts
///   MUST be read consistently;
/// - have its interrupt pending once the counter reaches the value of the last
///   [`wake_at`](StepTimer::wake_at), and at once if the counter has reached or passed that value
///   when `wake_at` returns. A value has passed if it lies less than half the counter back;
/// - keep a pending interrupt while it is held off.
///
/// It MAY interrupt at other times: if nothing is due, the engine only sets the compare register
/// again, which costs time and nothing else. Its interrupt MAY come before there is an engine only
/// if it is held off until then, as `SharedEngine` does.
///
/// One order works on every timer: write the compare register, clear the old request, read the
/// counter, and pend the interrupt if the value has passed. A request that is cleared after the
/// counter was read may be that of the new value.
///
/// The crate `stepwright-port-test` tests an implementation, on the chip or on a model of it.
pub trait StepTimer {
    /// The counter's width.
    type Count: Count;

    /// If the next event is at most this many ticks away, the interrupt waits for it instead of
    /// leaving and entering again: about the cost of that. It affects speed only; 0 is correct.
    const LINGER: Ticks = 0;

    /// If a pulse has at most this many ticks left when all other work is done, the interrupt waits
    /// for its end. If more, STEP stays high until the next interrupt, which comes at the end of
    /// the pulse at the latest, so that other axes and other interrupts are served meanwhile.
    const SPIN: Ticks = Self::LINGER;

    /// Ticks from a deadline to its edge if nothing delays the interrupt: the time to enter it. The
    /// next edge is as late, so the minimum interval is counted from this much before an edge.
    /// Otherwise a chip that enters its interrupt slowly could not step as fast as its interval
    /// allows.
    const REACTION: Ticks = 0;

    /// The present count.
    fn now(&mut self) -> Self::Count;

    /// Sets the compare register. If the counter has reached `at` by the end of the call, the
    /// interrupt is pending then: see the [contract](StepTimer).
    fn wake_at(&mut self, at: Self::Count);

    /// [`wake_at`](StepTimer::wake_at) within the step interrupt, which reads the counter
    /// afterwards and itself serves what has passed. So this method may drop a value that has
    /// passed. For a timer whose counter takes long to read.
    #[inline(always)]
    fn set_compare(&mut self, at: Self::Count) {
        self.wake_at(at);
    }

    /// When an interrupt for a deadline of an axis comes: at `at`, or at the next match of a
    /// compare register that is coarser than the counter.
    #[inline(always)]
    fn reach(&self, axis: u8, at: Self::Count) -> Self::Count {
        let _ = axis;
        at
    }

    /// Waits until the counter has reached `at`; returns at once if it has. For the rest of a
    /// pulse, at most [`SPIN`](StepTimer::SPIN) ticks.
    #[inline]
    fn hold_until(&mut self, at: Self::Count) {
        while at.is_after(self.now()) {}
    }
}
