//! A law that is asked step by step moves a motor: the second producer of entries. And what
//! a step of it costs, for `docs/laws.md`.
//!
//! ```text
//!   law ──► delay ──► Run of one step ──► queue of the first axis ──► step interrupt
//!   (main loop, interrupts on; up to 6 steps ahead)
//! ```
//!
//! The measured move is the one of `cargo bench -p stepwright-austin`, a quarter as long: 1,000
//! steps, 10,000 steps/s², 2,000 steps/s, 1 MHz; nothing steps meanwhile. Pin D12 (PB4) is high
//! while a delay is made, D13 (PB5) while a law is at work; `LAW_SUMS` has what the delays of
//! each add up to. Then the motor makes the moves of the program, there and back, each as fast
//! as the law can be asked.
//!
//! The laws are in several programs, for an Uno holds no more: 64 bits are long on 8. (The
//! motion that changes computes in 128, and doesn't fit at all.) On a Mega they would be
//! wrong, and are refused: see `xtask/src/check.rs`.

use core::hint::black_box;

use core::iter::once;
use core::mem::MaybeUninit;

use stepwright::queue::Producer;
use stepwright::{Accel, Control, Rate, Run, Speed};

use crate::board;
use crate::chip::{PORTB, Peripherals};
use crate::slot::Slot;
use crate::step::{self, AvrEngine, RUNS};

/// Steps of the move.
pub const STEPS: u32 = 1_000;
/// c₀ of Austin's Eq 15, and the shortest delay.
pub const LISTED: (u32, u32) = (9_560, 500);

/// The same of the article's demo.
pub const DEMO: (u32, u32) = (50_000, 2_500);

const MAKING: u8 = 1 << 4;
const AT_WORK: u8 = 1 << 5;
/// The most laws of a program.
const LAWS: usize = 4;

/// Where the present travels began.
static BASE: Slot<[i64; board::AXES]> = Slot::new([0; board::AXES]);

/// Of each law of the program, in its order.
#[unsafe(no_mangle)]
static LAW_SUMS: Slot<[u32; LAWS]> = Slot::new([0; LAWS]);

/// The move, and where its laws leave their traces.
pub struct Trial {
    /// Ticks a second.
    pub rate: Rate,
    /// Its top speed.
    pub top: Speed,
    /// Its acceleration.
    pub accel: Accel,
    pins: PORTB,
    sums: &'static mut [u32],
    engine: AvrEngine,
    feed: Producer<'static, RUNS>,
    forward: bool,
}

/// Ticks of the step timer in one of [`Rate::MHZ`].
const TICKS: u32 = 16;
/// Ticks that DIR is kept before it changes, and from there to the first step.
const LEAD: u32 = 4_000;

impl Trial {
    /// Takes the chip. `None` if the move is out of range, which it isn't.
    ///
    /// # Safety
    /// To be called once.
    pub unsafe fn begin() -> Option<Trial> {
        // SAFETY: the only time that anybody takes them.
        let chip = unsafe { Peripherals::steal() };
        let (axes, _) = board::pins(chip.PORTD, chip.PORTB);
        // SAFETY: D12 and D13 are no pins of an axis, and nobody else writes them.
        let pins = unsafe { Peripherals::steal() }.PORTB;
        // SAFETY: any value is one.
        pins.ddrb().modify(|r, w| unsafe { w.bits(r.bits() | MAKING | AT_WORK) });
        // SAFETY: the caller's promise, and no interrupt comes yet. A producer of zeros is
        // what `lend` asks for, and this one is the only one of its axis.
        let (engine, feed) = unsafe {
            let engine = step::start(axes, BASE.get());
            let mut feed = MaybeUninit::zeroed().assume_init();
            step::lend(0, &mut feed);
            (engine, feed)
        };
        Some(Trial {
            engine,
            feed,
            forward: true,
            rate: Rate::MHZ,
            top: Speed::from_steps(2_000).ok()?,
            accel: black_box(Accel::from_steps(10_000).ok()?),
            pins,
            // SAFETY: the only time that anybody asks.
            sums: unsafe { LAW_SUMS.get() },
        })
    }

    /// Makes all delays of the program's next law, and moves nothing.
    pub fn measure(&mut self, mut delays: impl Iterator<Item = u32>) {
        let mut sum = 0u32;
        self.set(AT_WORK);
        loop {
            self.set(AT_WORK | MAKING);
            let delay = black_box(black_box(&mut delays).next());
            self.set(AT_WORK);
            let Some(delay) = delay else { break };
            sum = sum.wrapping_add(delay);
        }
        if let Some((place, rest)) = core::mem::take(&mut self.sums).split_first_mut() {
            *place = sum;
            self.sums = rest;
        }
        self.set(0);
    }

    /// Moves the motor by these delays, in ticks of 1 MHz, between its steps; the other way
    /// round each time. Returns when it rests.
    ///
    /// A delay of 0 is the one before the first step. Without a delay nothing moves.
    pub fn play(&mut self, mut delays: impl Iterator<Item = u32>) {
        let Some(first) = delays.next() else { return };
        self.feed.set_open(true);
        self.push(Run::turn(LEAD, self.forward));
        self.push(Run::steady(LEAD, 1));
        for delay in once(first).chain(delays).filter(|delay| *delay != 0) {
            self.push(Run::steady(delay.wrapping_mul(TICKS), 1));
        }
        self.feed.set_open(false);
        if self.engine.is_idle(0) {
            self.engine.start(1);
        }
        while !self.engine.is_idle(0) {
            self.engine.refill();
        }
        self.forward = !self.forward;
    }

    /// Queues a run as soon as there is room for it; a full queue begins to be played.
    fn push(&mut self, mut run: Run) {
        while let Err(back) = self.feed.push(run) {
            run = back;
            if self.engine.is_idle(0) {
                self.engine.start(1);
            }
            self.engine.refill();
        }
        self.engine.refill();
    }

    #[inline(always)]
    fn set(&mut self, levels: u8) {
        // SAFETY: any value is one; the other pins of the port are inputs.
        self.pins.portb().write(|w| unsafe { w.bits(levels) });
    }
}

/// A program that measures and moves by laws: what it does with its [`Trial`]; `?` where a
/// law does not take its numbers.
#[macro_export]
macro_rules! measured_laws {
    ($trial:ident => $laws:block) => {
        $crate::step_interrupts!();

        #[avr_device::entry]
        fn main() -> ! {
            // SAFETY: called once, with interrupts off.
            let trial = unsafe { $crate::law::Trial::begin() };
            // SAFETY: all that an interrupt touches has been made.
            unsafe { avr_device::interrupt::enable() };
            let _ = trial.and_then(laws);
            loop {}
        }

        fn laws(mut $trial: $crate::law::Trial) -> Option<()> {
            $laws
            Some(())
        }
    };
}
