//! The step interrupts, one an axis, and the foreground's hold on them.
//!
//! Each axis has a compare register of its own, so that the hardware sorts the
//! deadlines. An interrupt plays the events of a group ([`entry`]); when the group
//! is over the next one is ready, and the one after it is prepared with interrupts
//! on. Compiled code never runs while a step waits.
//!
//! ```text
//!   queue ──► prepare ──► next group ──► present group ──► pins, compare register
//!             (interrupts on)      (at a group's end)       (at each deadline)
//! ```
//!
//! # Cost
//!
//! A step, in cycles of an ATmega328P:
//!
//! | | cycles |
//! | --- | --- |
//! | entry, jump | 4 + 3 |
//! | save r24 (GPIOR1), SREG (GPIOR2), r25, r26 | 7 |
//! | pins to the port: the edge | 3 |
//! | deadline += interval, into the compare register | 21 |
//! | is it still far enough ahead? | 13 |
//! | pin down | 2 |
//! | count | 6 |
//! | restore and leave | 11 |
//! | in all | 70 |
//!
//! # Late steps
//!
//! 23 cycles after an edge the interrupt looks at the timer: less than half an interval
//! less 1 µs to the next deadline is a late step (`stepwright::late_after`), and is counted. If that deadline
//! has passed too, its step comes as soon as the minimum interval allows, and
//! steps of other axes may come in between. Such steps are some 112 cycles apart: where the interval is
//! shorter than that, nothing would be caught up, and the schedule slips at once, by less than two intervals.
//! Elsewhere it slips when it is 3,072 ticks behind.
//! An open queue that is empty at a deadline is one late step, and what comes then
//! is played at once, and from there on.
//!
//! # The Uno's third axis
//!
//! Timer 2 counts every eighth cycle, in phase with timer 1: the edges of the third
//! axis come at the next multiple of 8 cycles. A wait of more than 1,791 cycles is
//! several turns of that timer, and a look at each.
//!
//! Simulators tell nothing of two things, which want one look on real hardware with
//! an oscilloscope: the phase of timer 2 (the first and the third axis at one speed,
//! their edges 0 to 8 cycles apart, and no jumps), and a compare register written
//! just before it matches (the third axis at its highest speed, no step missing).
//!
//! [`entry`]: stepwright::entry

mod boards;
#[doc(hidden)] // for the assembly
#[allow(missing_docs)]
pub mod channels;
mod fill;
mod layout;
mod play;
#[cfg(feature = "stream")]
mod turning;

use avr_device::interrupt;
use stepwright::drive::{Axes, Drive};
use stepwright::queue::{Producer, Queue};
use stepwright::{Control, Playing, Report, Ticks, Timing};

use crate::board::{self, AXES, Pins};
use crate::slot::Slot;
use channels::{OCR, TCCRA, TCNT, TIFR, TIMSK};
#[doc(hidden)] // for the assembly
pub use layout::{AxisState, Common};

/// Entries queued for each axis, 11 bytes each. A Mega has the room for twice as many: a change or a
/// stop on a steep ramp is planned while these are played.
pub const RUNS: usize = if cfg!(feature = "mega") { 16 } else { 8 };

/// Cycles from an edge to the look at the timer, and the µs that a step may be later than
/// half an interval (`stepwright::late_after`).
pub const LOOK: u8 = 23 + 16;
/// High byte of −3,072 ticks: further behind, the schedule slips.
pub const SLIP: u8 = 0xF4;
/// Steps whose deadlines have passed are this many cycles apart: at shorter intervals none is caught up.
pub const CAUGHT: u8 = 114;
/// How long an axis looks for nothing while its queue is empty, in 257 ticks.
pub const POLL: u8 = 0x23;

/// Events that are `left` of a group.
fn events(left: [u8; 2]) -> u32 {
    let [low, high] = left;
    let high = if low == 0 { high.wrapping_add(1) } else { high };
    u16::from_le_bytes([low, high]).into()
}

/// Steps that are `left` of a group with these pins.
fn steps(left: [u8; 2], pins: u8) -> u32 {
    if pins & channels::STEPS == 0 { 0 } else { events(left) }
}

#[doc(hidden)] // the step interrupts play them
pub static STEPPERS: Slot<[AxisState; AXES]> = Slot::new([const { AxisState::new() }; AXES]);
#[doc(hidden)]
pub static COMMON: Slot<Common> = Slot::new(Common { late: [0; 3], resting: 0, hold: 0, pace: 0 });

/// The step timer.
#[inline(always)]
pub fn now() -> u16 {
    // Its upper byte is read behind the lower one, from where the chip keeps it for all registers of
    // 16 bits.
    // SAFETY: no interrupt comes in between.
    let bytes = interrupt::free(|_| unsafe {
        [register(TCNT).read_volatile(), register(TCNT + 1).read_volatile()]
    });
    u16::from_le_bytes(bytes)
}

/// Puts the step interrupts into a program.
#[macro_export]
macro_rules! step_interrupts {
    () => {
        core::arch::global_asm!(
            $crate::step_fill_text!(),
            $crate::step_play_text!(),
            ".macro sw_enter",
            $crate::entry!(),
            ".endm",
            $crate::step_board_text!(),
            axes = sym $crate::step::STEPPERS,
            common = sym $crate::step::COMMON,
            axis = const size_of::<$crate::step::AxisState>(),
            now = const $crate::step::AxisState::NOW,
            next = const $crate::step::AxisState::NEXT,
            group = const $crate::step::AxisState::GROUP,
            wait = const $crate::step::AxisState::WAIT,
            room = const $crate::step::AxisState::ROOM,
            left = const $crate::step::AxisState::LEFT,
            pins = const $crate::step::AxisState::PINS,
            growth = const $crate::step::AxisState::GROWTH,
            events = const $crate::step::AxisState::EVENTS,
            groups = const $crate::step::AxisState::GROUPS,
            then = const $crate::step::AxisState::THEN,
            due = const $crate::step::AxisState::DUE,
            starved = const $crate::step::AxisState::STARVED,
            loaded = const $crate::step::AxisState::LOADED,
            queue = const $crate::step::AxisState::QUEUE,
            taken = const $crate::step::EntryQueue::TAKEN,
            pushed = const $crate::step::EntryQueue::PUSHED,
            open = const $crate::step::EntryQueue::OPEN,
            played = const $crate::step::EntryQueue::PLAYED,
            slots_at = const $crate::step::EntryQueue::SLOTS,
            slots = const $crate::step::RUNS,
            late = const $crate::step::Common::LATE,
            resting = const $crate::step::Common::RESTING,
            hold = const $crate::step::Common::HOLD,
            pace = const $crate::step::Common::PACE,
            look = const $crate::step::LOOK,
            slip = const $crate::step::SLIP,
            caught = const $crate::step::CAUGHT,
            poll = const $crate::step::POLL,
            steps = const $crate::step::channels::STEPS,
            tcnt = const $crate::step::channels::TCNT,
            mask = const $crate::step::channels::TIMSK,
            tifr = const $crate::step::channels::TIFR,
            mask2 = const $crate::step::channels::MASK2,
            bit2 = const $crate::step::channels::BIT2,
            ocr = const $crate::step::channels::OCR,
            vector0 = const $crate::step::channels::VECTORS[0],
            vector1 = const $crate::step::channels::VECTORS[1],
            vector2 = const $crate::step::channels::VECTORS[2],
        );
    };
}

#[doc(hidden)]
pub type EntryQueue = Queue<RUNS>;

unsafe extern "C" {
    fn stepwright_refill(axes: Axes);
}

/// A register of one byte.
const fn register(address: u16) -> *mut u8 {
    core::ptr::without_provenance_mut(address as usize)
}

/// Where the ready flags are: GPIOR0.
const FLAGS: *mut u8 = register(0x3E);

/// Has the runs of an axis go to where its interrupt plays them.
///
/// # Safety
/// The producer is all zeros, and the only one of this axis.
pub unsafe fn lend(axis: u8, producer: &mut Producer<'static, RUNS>) {
    // SAFETY: the caller's promise. A queue is shared as it is.
    unsafe { (*place(axis)).queue.lend(producer, board::wiring(axis)) }
}

/// Where an axis is.
#[inline(always)]
fn place(axis: u8) -> *mut AxisState {
    let axis = if usize::from(axis) < AXES { axis } else { 0 };
    let offset = axis.wrapping_mul(size_of::<AxisState>() as u8);
    // A product of bytes where that is enough.
    let offset = if size_of::<AxisState>() * AXES <= 256 {
        usize::from(offset)
    } else {
        usize::from(axis).wrapping_mul(size_of::<AxisState>())
    };
    STEPPERS.address().cast_mut().cast::<AxisState>().wrapping_byte_add(offset)
}

/// The same pointer, of which the compiler does not know what it is: so it is loaded once,
/// where the address of each field would be added up. In registers: `black_box` goes by the
/// stack.
#[inline(always)]
fn pointed(mut at: *mut AxisState) -> *mut AxisState {
    // SAFETY: no instruction.
    unsafe {
        core::arch::asm!("/* {0} */", inout(reg_pair) at, options(pure, nomem, nostack, preserves_flags));
    }
    at
}

/// Has the timers run. Returns the foreground's hold on the axes, which rest and face
/// forward.
///
/// # Safety
/// To be called once, with interrupts disabled.
pub unsafe fn start(mut pins: Pins, base: &'static mut [i64; AXES]) -> AvrEngine {
    for axis in 0..AXES as u8 {
        pins.direction(axis, true);
    }
    // SAFETY: the step interrupts' registers, and no interrupt comes.
    unsafe {
        COMMON.get().resting = 0b111;
        FLAGS.write_volatile(0);
        register(TCCRA).write_volatile(0);
        // Every cycle.
        register(TCCRA + 1).write_volatile(1);
        #[cfg(feature = "uno")]
        in_phase();
    }
    let mut held = AvrEngine { base };
    held.set_timing(board::description().timing);
    held
}

/// Lets timer 2 count every eighth cycle, when timer 1 has a multiple of 8.
///
/// The prescaler of timer 2 is held while both are set, and goes on with the last
/// store. A simulator may know no prescaler, and lets the timer run from when it gets a
/// clock: two cycles earlier.
///
/// # Safety
/// Interrupts are off.
#[cfg(feature = "uno")]
unsafe fn in_phase() {
    // SAFETY: the caller's promise; registers that are the step interrupts'.
    unsafe {
        core::arch::asm!(
            "sts 0xB0, r1",   // TCCR2A: normal mode
            "out 0x23, {hold}", // GTCCR: TSM, PSRASY
            "sts 0xB2, r1",   // TCNT2
            "sts 0x85, {high}",
            "sts 0x84, {low}", // TCNT1: 0xFFFC; 4 cycles to 0
            "sts 0xB1, {eighth}", // TCCR2B
            "nop",
            "out 0x23, r1",
            hold = in(reg) 0x82u8,
            high = in(reg) 0xFFu8,
            low = in(reg) 0xFCu8,
            eighth = in(reg) 2u8,
        );
    }
}

/// The axes with their interrupts held off for moments.
pub struct AvrEngine {
    /// Positions at which the present travels began: in the main function's frame, as
    /// statics are what a chip has little room for.
    base: *mut [i64; AXES],
}

/// Ticks from the call to the first event of those that start.
const SOON: u16 = 400;

/// Cycles of a pulse that is not held.
const PULSE: Ticks = 36;
/// … of one that is held, and of a late step to the next, but for the loop.
const HELD: Ticks = 71;
const PACE: Ticks = 103;

/// Times round a loop of 3 cycles that lasts this long, less what is spent besides.
#[inline(never)]
fn rounds(cycles: Ticks, besides: Ticks) -> u8 {
    let cycles = cycles.saturating_sub(besides).min(762);
    // A third, by multiplication: exact up to here, and without the 1.1 KB that
    // a routine for division takes.
    (cycles.wrapping_mul(21_846) >> 16) as u8 + 1
}

/// Axes whose interrupts are on: those that move.
#[inline(always)]
fn live() -> Axes {
    // SAFETY: one read each.
    unsafe {
        let wide = register(TIMSK).read_volatile() >> 1;
        #[cfg(feature = "uno")]
        let wide = wide & 3 | register(channels::MASK2).read_volatile() << 1 & 4;
        wide & 7
    }
}

/// The laps that an axis still waits for, and a part in 64 more, in 256 ticks; of 255 laps at most,
/// which are longer than anybody plans ahead. [`u16::MAX`] if it steps.
///
/// A wait may begin with a step, in its first lap: `then`, of the laps behind it, tells it from
/// steps. What is held ready is of the next entry once that has been taken, and so are its laps.
#[inline(never)]
fn laps(axis: u8) -> u16 {
    let at = pointed(place(axis));
    // SAFETY: reads of a byte. Interrupts stay on while it steps: this is asked at each piece of
    // planning, and a step would wait.
    let pins = unsafe { (&raw const (*at).now.pins).read_volatile() };
    // SAFETY: as above.
    if pins & unsafe { (&raw const (*at).then).read_volatile() } != 0 {
        return u16::MAX;
    }
    // SAFETY: no interrupt comes, and none refills.
    let (left, lap, groups, pins, last) = interrupt::free(|_| unsafe {
        let AxisState { now, groups, queue, .. } = &*at;
        (now.left, now.interval[2], *groups, now.pins, queue.plays_last_taken())
    });
    if pins != 0 && !last {
        return u16::MAX;
    }
    let more = if last { groups } else { 0 };
    let laps = events(left).saturating_add(more.into()).min(255) as u16;
    laps.wrapping_mul(u16::from(lap).wrapping_add(1))
}

impl AvrEngine {
    /// For a static, until [`start`] makes one that may be used.
    pub const NONE: AvrEngine = AvrEngine { base: core::ptr::null_mut() };

    /// Prepares what has been queued since: to be called after something was.
    #[inline(never)]
    pub fn refill(&mut self) {
        // SAFETY: a read of a byte.
        let resting = unsafe { (&raw const (*COMMON.address()).resting).read_volatile() };
        let wanting = resting & live();
        if wanting != 0 {
            // SAFETY: the foreground calls, so that no refill is at work.
            unsafe { stepwright_refill(wanting) };
        }
    }

    /// Steps made since the travel began.
    #[cfg(not(feature = "stream"))]
    #[inline(never)]
    fn made(&self, axis: u8) -> i64 {
        // No more than the loads while interrupts are off: from one pointer, whose address the
        // compiler would add up for each.
        let at = pointed(place(axis));
        let (loaded, now, pins, next, then, flags) = interrupt::free(|_| {
            // SAFETY: no interrupt comes, and none refills.
            unsafe {
                let AxisState { loaded, now, next, .. } = &*at;
                (*loaded, now.left, now.pins, next.left, next.pins, FLAGS.read_volatile())
            }
        });
        let mut left = steps(now, pins);
        if flags >> axis & 1 != 0 {
            left = left.wrapping_add(steps(next, then));
        }
        // Never less than 0: what is left has been loaded.
        let [a, b, c, d, high] = loaded;
        let (low, under) = u32::from_le_bytes([a, b, c, d]).overflowing_sub(left);
        let [a, b, c, d] = low.to_le_bytes();
        i64::from_le_bytes([a, b, c, d, high.wrapping_sub(under.into()), 0, 0, 0])
    }

    /// The axis rests: its travel begins here.
    fn settle(&mut self, axis: u8, position: i64) {
        // SAFETY: `start` has made it, and nobody else has it.
        let bases = unsafe { &mut *self.base };
        if let Some(base) = bases.get_mut(usize::from(axis)) {
            *base = position;
        }
        let at = pointed(place(axis));
        // SAFETY: an axis that rests is the foreground's. As two numbers: five bytes would be
        // zeroed by a call.
        unsafe {
            let at = (&raw mut (*at).loaded).cast::<u8>();
            at.cast::<u32>().write_unaligned(0);
            at.add(4).write(0);
            #[cfg(feature = "stream")]
            at.add(5).write(u8::from(!board::is_forward(axis)));
        }
    }
}

impl Control for AvrEngine {
    fn start(&mut self, axes: Axes) {
        let axes = axes & !live() & 0b111;
        let mut left = axes;
        for axis in 0..AXES as u8 {
            if left & 1 != 0 {
                let position = self.position(axis);
                self.settle(axis, position);
                // SAFETY: an axis that rests is the foreground's.
                unsafe { (*place(axis)).groups = 1 };
            }
            left >>= 1;
        }
        // SAFETY: the foreground calls, so that no refill is at work.
        unsafe { stepwright_refill(axes) };
        // SAFETY: one read.
        let ready = axes & unsafe { FLAGS.read_volatile() };
        left = ready;
        for axis in 0..AXES as u8 {
            if left & 1 != 0 {
                // From one pointer, whose address the compiler would add up for each field.
                let at = pointed(place(axis));
                // SAFETY: an axis that rests is the foreground's, and nobody prepares a group
                // behind one that is ready.
                unsafe { (*at).now = (*at).next };
            }
            left >>= 1;
        }
        // SAFETY: no interrupt comes.
        interrupt::free(|_| unsafe {
            let flags = FLAGS.read_volatile() & !ready;
            let now = u16::from_le_bytes([
                register(TCNT).read_volatile(),
                register(TCNT + 1).read_volatile(),
            ]);
            let due = now.wrapping_add(SOON);
            let [low, high] = due.to_le_bytes();
            left = ready;
            for axis in 0..AXES as u8 {
                if left & 1 != 0 {
                    (*pointed(place(axis))).due = [0, low, high];
                    if cfg!(feature = "mega") || axis != 2 {
                        let compare = OCR + 2 * u16::from(axis);
                        register(compare + 1).write_volatile(high);
                        register(compare).write_volatile(low);
                    }
                }
                left >>= 1;
            }
            // The third axis of an Uno has a timer of its own.
            #[cfg(feature = "uno")]
            let (flags, ready) = if ready & 0b100 == 0 {
                (flags, ready)
            } else {
                register(0xB3).write_volatile((due >> 3) as u8);
                register(0x37).write_volatile(2);
                register(channels::MASK2).write_volatile(2);
                (flags & !(1 << 6), ready & 0b011)
            };
            FLAGS.write_volatile(flags);
            register(TIFR as u16 + 0x20).write_volatile(ready << 1);
            let mask = register(TIMSK);
            mask.write_volatile(mask.read_volatile() | ready << 1);
        });
    }

    fn kill(&mut self, axes: Axes) {
        for axis in 0..AXES as u8 {
            if axes >> axis & 1 == 0 {
                continue;
            }
            interrupt::free(|_| {
                // SAFETY: no interrupt comes.
                unsafe {
                    #[cfg(feature = "uno")]
                    if axis == 2 {
                        register(channels::MASK2).write_volatile(0);
                    }
                    #[cfg(feature = "uno")]
                    let bit = if axis == 2 { 0 } else { 2 << axis };
                    #[cfg(feature = "mega")]
                    let bit = 2 << axis;
                    let mask = register(TIMSK);
                    mask.write_volatile(mask.read_volatile() & !bit);
                }
            });
            // Its interrupt is off, and no refill is at work.
            let position = self.position(axis);
            self.settle(axis, position);
            // SAFETY: so the axis is the foreground's; others change what they share.
            interrupt::free(|_| unsafe {
                let at = &mut *pointed(place(axis));
                (at.now.pins, at.next.pins, at.starved) = (0, 0, 0);
                at.queue.clear(board::is_forward(axis));
                COMMON.get().resting |= 1 << axis;
                FLAGS.write_volatile(FLAGS.read_volatile() & !(1 << axis));
            });
        }
    }

    fn report(&self, axis: u8) -> Report {
        Report {
            position: self.position(axis),
            idle: self.is_idle(axis),
            forward: self.is_forward(axis),
        }
    }

    /// Of waits alone.
    #[inline(always)]
    fn playing(&mut self, axis: u8) -> Playing {
        match if self.is_idle(axis) { u16::MAX } else { laps(axis) } {
            u16::MAX => Playing::Unknown,
            left => Playing::Left(Ticks::from(left) << 8),
        }
    }

    #[inline(always)]
    fn is_idle(&self, axis: u8) -> bool {
        live() >> axis & 1 == 0
    }

    fn position(&self, axis: u8) -> i64 {
        let made = self.made(axis);
        // SAFETY: as in `settle`.
        let bases = unsafe { &*self.base };
        let base = bases.get(usize::from(axis)).copied().unwrap_or(0);
        #[cfg(feature = "stream")]
        return base.wrapping_add(made);
        #[cfg(not(feature = "stream"))]
        if self.is_forward(axis) { base.wrapping_add(made) } else { base.wrapping_sub(made) }
    }

    fn is_forward(&self, axis: u8) -> bool {
        board::is_forward(axis)
    }

    fn set_position(&mut self, axis: u8, position: i64) {
        self.settle(axis, position);
    }

    #[inline(always)]
    fn refill(&mut self) {
        AvrEngine::refill(self);
    }

    fn set_timing(&mut self, timing: Timing) {
        let hold = if timing.pulse > PULSE { rounds(timing.pulse, HELD) } else { 0 };
        let pace = rounds(timing.min_interval, PACE);
        // SAFETY: the interrupts read bytes, and the axes rest.
        interrupt::free(|_| unsafe { (COMMON.get().hold, COMMON.get().pace) = (hold, pace) });
    }

    fn late(&self) -> u32 {
        // SAFETY: no interrupt comes.
        let [a, b, c] = interrupt::free(|_| unsafe { COMMON.get().late });
        u32::from_le_bytes([a, b, c, 0])
    }

    fn clear_late(&mut self) {
        // SAFETY: no interrupt comes.
        interrupt::free(|_| unsafe { COMMON.get().late = [0; 3] });
    }
}
