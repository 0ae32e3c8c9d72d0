//! A law that is computed step by step moves a motor: the second producer of entries. It also
//! measures the cost of a step of the law, for `docs/laws.md`.
//!
//! ```text
//!   law ──► delay ──► Run of one step ──► queue of the first axis ──► step interrupt
//!   (main loop, interrupts on; up to 6 steps ahead)
//! ```
//!
//! The measured move is that of `cargo bench -p stepwright-austin`, a quarter as long: 1,000 steps,
//! 10,000 steps/s², 2,000 steps/s, 1 MHz; no motor steps meanwhile. Pin D12 (PB4) is high while a
//! delay is computed, D13 (PB5) while a law is measured; `LAW_SUMS` has the sums of the delays of
//! each law. Then the motor makes the moves of the program, there and back, each as fast as the law
//! can be computed.
//!
//! The laws are spread over several programs, because an Uno holds no more: 64-bit arithmetic is
//! long on an 8-bit chip. (The motion that changes computes in 128 bits, and does not fit at all.)
//! On a Mega they would be wrong, and are refused: see `xtask/src/check.rs`.

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

/// The same for the article's demo.
pub const DEMO: (u32, u32) = (50_000, 2_500);

const MAKING: u8 = 1 << 4;
const AT_WORK: u8 = 1 << 5;
/// The most laws of a program.
const LAWS: usize = 4;

/// Where the present travels began.
static BASE: Slot<[i64; board::AXES]> = Slot::new([0; board::AXES]);

/// The sum of the delays of each law of the program, in order.
#[unsafe(no_mangle)]
static LAW_SUMS: Slot<[u32; LAWS]> = Slot::new([0; LAWS]);

/// The move, and the outputs of its measurement.
pub struct Trial {
    /// The timer's rate, in ticks per second.
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

/// Ticks of the step timer per tick of [`Rate::MHZ`].
const TICKS: u32 = 16;
/// Ticks for which DIR is kept before it changes, and from its change to the first step.
const LEAD: u32 = 4_000;

impl Trial {
    /// Takes the chip. `None` if the move is out of range, which does not occur.
    ///
    /// # Safety
    /// To be called once.
    pub unsafe fn begin() -> Option<Trial> {
        // SAFETY: they are taken only here.
        let chip = unsafe { Peripherals::steal() };
        let (axes, _) = board::pins(chip.PORTD, chip.PORTB);
        // SAFETY: D12 and D13 are not pins of an axis, and nothing else writes them.
        let pins = unsafe { Peripherals::steal() }.PORTB;
        // SAFETY: any value is valid.
        pins.ddrb().modify(|r, w| unsafe { w.bits(r.bits() | MAKING | AT_WORK) });
        // SAFETY: the caller's promise, and no interrupt comes yet. `lend` expects a producer of
        // zeros, and this is the only one of its axis.
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
            // SAFETY: taken only here.
            sums: unsafe { LAW_SUMS.get() },
        })
    }

    /// Computes all delays of the program's next law, without motion.
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

    /// Moves the motor with these delays between its steps, in ticks of 1 MHz, in the opposite
    /// direction each time. Returns when it rests.
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

    /// Queues a run as soon as there is room. When the queue is full, playing begins.
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
        // SAFETY: any value is valid. D8 goes low, which enables the drivers; the other pins of the
        // port are inputs.
        self.pins.portb().write(|w| unsafe { w.bits(levels) });
    }
}

/// Makes a program that measures laws and moves by them: its block uses the [`Trial`], and `?`
/// where a law does not accept its numbers.
#[macro_export]
macro_rules! measured_laws {
    ($trial:ident => $laws:block) => {
        $crate::step_interrupts!();

        #[avr_device::entry]
        fn main() -> ! {
            // SAFETY: called once, with interrupts off.
            let trial = unsafe { $crate::law::Trial::begin() };
            // SAFETY: everything that an interrupt uses is set up.
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
