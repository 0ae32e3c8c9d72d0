//! The step interrupts, one for each axis, and the foreground's handle to them.
//!
//! Each axis has a compare register of its own, so that the hardware sorts the deadlines. An
//! interrupt plays the events of a group ([`entry`]). When the group is over, the next one is
//! ready, and the one after it is prepared with interrupts on. No compiled code runs while a step
//! waits.
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
//! 23 cycles after an edge the interrupt compares the timer with the next deadline. If that is
//! nearer than half an interval less 1 µs (`stepwright::late_after`), the step is counted as late.
//! If that deadline has passed too, its step comes as soon as the minimum interval allows, and
//! steps of other axes may come in between. Such steps are some 112 cycles apart. Where the
//! interval is shorter than that, the axis could not catch up, and the schedule slips at once, by
//! less than two intervals. Otherwise it slips when it is 3,072 ticks behind. An open queue that is
//! empty at a deadline counts as one late step; the next entry is played at once, and the schedule
//! continues from there.
//!
//! # The Uno's third axis
//!
//! Timer 2 counts every eighth cycle, in phase with timer 1: the edges of the third axis come at
//! the next multiple of 8 cycles. A wait of more than 1,791 cycles takes several turns of that
//! timer, with a check at each. Whether a step is late is found 12 cycles later than on the other axes: from
//! 113,000 steps/s on an axis that moves alone may count as late where it is not.
//!
//! Simulators do not show two things, which need one check on real hardware with an oscilloscope:
//! the phase of timer 2 (the first and the third axis at one speed, their edges 0 to 8 cycles
//! apart, without jumps), and a compare register written just before it matches (the third axis at
//! its highest speed, without a missing step).
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

/// The entries queued for each axis, 11 bytes each. A Mega has room for twice as many: a change or
/// a stop on a steep ramp is planned while these are played.
pub const RUNS: usize = if cfg!(feature = "mega") { 16 } else { 8 };

/// Cycles from an edge to the check of the timer, plus the µs by which a step may be later than
/// half an interval (`stepwright::late_after`).
pub const LOOK: u8 = 23 + 16;
/// High byte of −3,072 ticks: further behind, the schedule slips.
pub const SLIP: u8 = 0xF4;
/// Steps whose deadlines have passed are this many cycles apart: at shorter intervals an axis does
/// not catch up.
pub const CAUGHT: u8 = 114;
/// The time between two checks of an empty queue, in 257 ticks.
pub const POLL: u8 = 0x23;

/// The events `left` of a group.
fn events(left: [u8; 2]) -> u32 {
    let [low, high] = left;
    let high = if low == 0 { high.wrapping_add(1) } else { high };
    u16::from_le_bytes([low, high]).into()
}

/// The steps `left` of a group with these pins.
fn steps(left: [u8; 2], pins: u8) -> u32 {
    if pins & channels::STEPS == 0 { 0 } else { events(left) }
}

#[doc(hidden)] // the step interrupts play them
pub static STEPPERS: Slot<[AxisState; AXES]> = Slot::new([const { AxisState::new() }; AXES]);
#[doc(hidden)]
pub static COMMON: Slot<Common> = Slot::new(Common { late: [0; 3], resting: 0, hold: 0, pace: 0 });

/// The counter of the step timer.
#[inline(always)]
pub fn now() -> u16 {
    // The upper byte is read after the lower one, from the temporary register that the chip shares
    // among all its 16-bit registers.
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

/// The address of a register of one byte.
const fn register(address: u16) -> *mut u8 {
    core::ptr::without_provenance_mut(address as usize)
}

/// The address of the ready flags: GPIOR0.
const FLAGS: *mut u8 = register(0x3E);

/// Connects the producer of an axis to the queue that its interrupt plays.
///
/// # Safety
/// The producer is all zeros, and the only one of this axis.
pub unsafe fn lend(axis: u8, producer: &mut Producer<'static, RUNS>) {
    // SAFETY: the caller's promise. The queue is shared as it is.
    unsafe { (*place(axis)).queue.lend(producer, board::wiring(axis)) }
}

/// The address of the state of an axis.
#[inline(always)]
fn place(axis: u8) -> *mut AxisState {
    let axis = if usize::from(axis) < AXES { axis } else { 0 };
    let offset = axis.wrapping_mul(size_of::<AxisState>() as u8);
    // A product of bytes if that is enough.
    let offset = if size_of::<AxisState>() * AXES <= 256 {
        usize::from(offset)
    } else {
        usize::from(axis).wrapping_mul(size_of::<AxisState>())
    };
    STEPPERS.address().cast_mut().cast::<AxisState>().wrapping_byte_add(offset)
}

/// The same pointer, hidden from the compiler, so that it is loaded once; otherwise the address of
/// each field would be computed. It stays in registers: `black_box` uses the stack.
#[inline(always)]
fn pointed(mut at: *mut AxisState) -> *mut AxisState {
    // SAFETY: no instruction.
    unsafe {
        core::arch::asm!("/* {0} */", inout(reg_pair) at, options(pure, nomem, nostack, preserves_flags));
    }
    at
}

/// Starts the timers. Returns the foreground's handle to the axes, which rest and face forward.
///
/// # Safety
/// To be called once, with interrupts disabled.
pub unsafe fn start(mut pins: Pins, base: &'static mut [i64; AXES]) -> AvrEngine {
    for axis in 0..AXES as u8 {
        pins.direction(axis, true);
    }
    // SAFETY: registers of the step interrupts, and no interrupt comes.
    unsafe {
        COMMON.get().resting = 0b111;
        FLAGS.write_volatile(0);
        register(TCCRA).write_volatile(0);
        // No prescaler: every cycle counts.
        register(TCCRA + 1).write_volatile(1);
        #[cfg(feature = "uno")]
        in_phase();
    }
    let mut held = AvrEngine { base };
    held.set_timing(board::description().timing);
    held
}

/// Starts timer 2, which counts every eighth cycle, when timer 1 is at a multiple of 8.
///
/// The prescaler of timer 2 is held while both are set, and released by the last store. A simulator
/// may not model the prescaler, and starts the timer when it gets a clock: two cycles earlier.
///
/// # Safety
/// Interrupts are off.
#[cfg(feature = "uno")]
unsafe fn in_phase() {
    // SAFETY: the caller's promise; registers of the step interrupts.
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

/// The axes, whose interrupts are held off for short times.
pub struct AvrEngine {
    /// The positions at which the present travels began. They are in the main function's frame,
    /// because the chip has little room for statics.
    base: *mut [i64; AXES],
}

/// Ticks from the call to the first event of the axes that start.
const SOON: u16 = 400;

/// Cycles of a pulse without a waiting loop.
const PULSE: Ticks = 36;
/// The same for a pulse with a waiting loop, and from a late step to the next, without the loop
/// itself.
const HELD: Ticks = 71;
const PACE: Ticks = 103;

/// Rounds of a 3-cycle loop for this time, less the cycles spent `besides`.
#[inline(never)]
fn rounds(cycles: Ticks, besides: Ticks) -> u8 {
    let cycles = cycles.saturating_sub(besides).min(762);
    // A third, by multiplication: exact up to here, and without the 1.1 KB of a division routine.
    (cycles.wrapping_mul(21_846) >> 16) as u8 + 1
}

/// The axes whose interrupts are on: the moving axes.
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

/// The rest of a wait of an axis: its laps and 1/64 more, in 256 ticks. It counts 255 laps at most,
/// which is longer than any planning horizon. [`u16::MAX`] if the axis steps.
///
/// A wait may begin with a step, in its first lap: `then`, the pins of the following laps,
/// distinguishes it from steps. Once the next entry has been taken, the prepared group and its laps
/// belong to that entry.
#[inline(never)]
fn laps(axis: u8) -> u16 {
    let at = pointed(place(axis));
    // SAFETY: reads of a byte. Interrupts stay on while the axis steps: this is called at each
    // piece of planning, and would delay a step.
    let pins = unsafe { (&raw const (*at).now.pins).read_volatile() };
    // SAFETY: as above.
    if pins & unsafe { (&raw const (*at).then).read_volatile() } != 0 {
        return u16::MAX;
    }
    // SAFETY: no interrupt comes, and no refill is in progress.
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
    /// A placeholder for a static, until [`start`] makes a usable one.
    pub const NONE: AvrEngine = AvrEngine { base: core::ptr::null_mut() };

    /// Prepares newly queued entries. Call it after queueing.
    #[inline(never)]
    pub fn refill(&mut self) {
        // SAFETY: a read of a byte.
        let resting = unsafe { (&raw const (*COMMON.address()).resting).read_volatile() };
        let wanting = resting & live();
        if wanting != 0 {
            // SAFETY: called from the foreground, so no refill is in progress.
            unsafe { stepwright_refill(wanting) };
        }
    }

    /// The steps made since the travel began.
    #[cfg(not(feature = "stream"))]
    #[inline(never)]
    fn made(&self, axis: u8) -> i64 {
        // Only the loads are done with interrupts off, from one pointer: the compiler would compute
        // an address for each.
        let at = pointed(place(axis));
        let (loaded, now, pins, next, then, flags) = interrupt::free(|_| {
            // SAFETY: no interrupt comes, and no refill is in progress.
            unsafe {
                let AxisState { loaded, now, next, .. } = &*at;
                (*loaded, now.left, now.pins, next.left, next.pins, FLAGS.read_volatile())
            }
        });
        let mut left = steps(now, pins);
        if flags >> axis & 1 != 0 {
            left = left.wrapping_add(steps(next, then));
        }
        // Never negative: `left` is part of `loaded`.
        let [a, b, c, d, high] = loaded;
        let (low, under) = u32::from_le_bytes([a, b, c, d]).overflowing_sub(left);
        let [a, b, c, d] = low.to_le_bytes();
        i64::from_le_bytes([a, b, c, d, high.wrapping_sub(under.into()), 0, 0, 0])
    }

    /// Sets the start of the next travel of an axis at rest.
    fn settle(&mut self, axis: u8, position: i64) {
        // SAFETY: `start` has set it, and nothing else has it.
        let bases = unsafe { &mut *self.base };
        if let Some(base) = bases.get_mut(usize::from(axis)) {
            *base = position;
        }
        let at = pointed(place(axis));
        // SAFETY: the foreground owns an axis at rest. Written as two numbers: the compiler would
        // zero five bytes by a call.
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
                // SAFETY: the foreground owns an axis at rest.
                unsafe { (*place(axis)).groups = 1 };
            }
            left >>= 1;
        }
        // SAFETY: called from the foreground, so no refill is in progress.
        unsafe { stepwright_refill(axes) };
        // SAFETY: one read.
        let ready = axes & unsafe { FLAGS.read_volatile() };
        left = ready;
        for axis in 0..AXES as u8 {
            if left & 1 != 0 {
                // From one pointer: the compiler would compute the address of each field.
                let at = pointed(place(axis));
                // SAFETY: the foreground owns an axis at rest, and nothing prepares a group behind
                // a ready one.
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
            // Its interrupt is off, and no refill is in progress.
            let position = self.position(axis);
            self.settle(axis, position);
            // SAFETY: so the foreground owns the axis; interrupts of other axes change shared
            // bytes.
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

    /// Reports waits only.
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
