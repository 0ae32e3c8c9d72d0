//! What a step of a law costs an AVR, for `docs/laws.md`.
//!
//! The move is the one of `cargo bench -p stepwright-austin`, a quarter as long: 1,000
//! steps, 10,000 steps/s², 2,000 steps/s, 1 MHz. Pin D12 (PB4) is high while a delay is made,
//! D13 (PB5) while a law is at work; `LAW_SUMS` has what the delays of each add up to.
//!
//! The laws are in four programs, for an Uno holds no more: 64 bits are long on 8. (The
//! motion that changes computes in 128, and doesn't fit at all.) On a Mega they would be
//! wrong, and are refused: see `xtask/src/check.rs`.

use core::hint::black_box;

use stepwright::{Accel, Rate, Speed};

use crate::chip::{PORTB, Peripherals};
use crate::slot::Slot;

/// Steps of the move.
pub const STEPS: u32 = 1_000;
/// c₀ of Austin's Eq 15, and the shortest delay.
pub const LISTED: (u32, u32) = (9_560, 500);

const MAKING: u8 = 1 << 4;
const AT_WORK: u8 = 1 << 5;
/// The most laws of a program.
const LAWS: usize = 4;

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
}

impl Trial {
    /// Takes the chip. `None` if the move is out of range, which it isn't.
    ///
    /// # Safety
    /// To be called once.
    pub unsafe fn begin() -> Option<Trial> {
        // SAFETY: the only time that anybody takes them.
        let pins = unsafe { Peripherals::steal() }.PORTB;
        // SAFETY: any value is one.
        pins.ddrb().write(|w| unsafe { w.bits(MAKING | AT_WORK) });
        Some(Trial {
            rate: Rate::MHZ,
            top: Speed::from_steps(2_000).ok()?,
            accel: black_box(Accel::from_steps(10_000).ok()?),
            pins,
            // SAFETY: the only time that anybody asks.
            sums: unsafe { LAW_SUMS.get() },
        })
    }

    /// Makes all delays of the program's next law.
    pub fn run(&mut self, mut delays: impl Iterator<Item = u32>) {
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

    #[inline(always)]
    fn set(&mut self, levels: u8) {
        // SAFETY: any value is one.
        self.pins.portb().write(|w| unsafe { w.bits(levels) });
    }
}

/// A program that measures laws: what it does with its [`Trial`]; `?` where a law can't be
/// laid out.
#[macro_export]
macro_rules! measured_laws {
    ($trial:ident => $laws:block) => {
        #[avr_device::entry]
        fn main() -> ! {
            // SAFETY: called once.
            let _ = unsafe { $crate::law::Trial::begin() }.and_then(laws);
            loop {}
        }

        fn laws(mut $trial: $crate::law::Trial) -> Option<()> {
            $laws
            Some(())
        }
    };
}
