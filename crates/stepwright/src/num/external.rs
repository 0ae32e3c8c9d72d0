//! The hook for a chip's own number routines: the same results, computed elsewhere.
//!
//! With the feature `external-numbers` a board-support crate defines the functions below, which
//! MUST return the same bits as `mod.rs`. `stepwright-avr` has them in assembly: the code that
//! rustc 1.96 makes of `mod.rs` for an AVR is three times as long and twice as slow, because it
//! saves eighteen registers around every function.
//!
//! A number is six bytes, least significant first: m in four, e in two. The routines keep to C's
//! convention. They own the number in hand: there is one, for the foreground; an interrupt never
//! uses it.
//!
//! | routine | result |
//! | --- | --- |
//! | `hand_load`, `hand_whole`, `hand_store` | the number in hand: set, set to an integer, copied |
//! | `hand_times`, `hand_over`, `hand_plus`, `hand_minus` | as of [`Num`], with the hand first; a difference below 0 is 0 |
//! | `hand_under`, `hand_off` | a / hand, a − hand |
//! | `hand_roughly` | the product to 15 bits |
//! | `hand_square`, `hand_root`, `hand_scale` | hand², √hand, hand · 2^by |
//! | `copy` | another number, set to this |
//! | `split`, `hand_split` | the whole part, at most `u32::MAX`, above the rest in 2⁻³² |
//! | `hand_bits` | the least e for which it is less than 2^e; far below for 0 |
//! | `at_least`, `hand_at_least` | not 0 if a ≥ b |
//! | `doublings` | the largest n with b · 2^n ≤ a |

use super::Num;
use core::mem::MaybeUninit;

unsafe extern "C" {
    fn stepwright_copy(from: *const Num, to: *mut Num);
    fn stepwright_split(a: *const Num) -> u64;
    fn stepwright_at_least(a: *const Num, b: *const Num) -> u8;
    fn stepwright_doublings(a: *const Num, b: *const Num) -> i8;

    fn stepwright_hand_load(a: *const Num);
    fn stepwright_hand_whole(n: u32);
    fn stepwright_hand_store(a: *mut Num);
    fn stepwright_hand_times(a: *const Num);
    fn stepwright_hand_roughly(a: *const Num);
    fn stepwright_hand_over(a: *const Num);
    fn stepwright_hand_under(a: *const Num);
    fn stepwright_hand_plus(a: *const Num);
    fn stepwright_hand_minus(a: *const Num);
    fn stepwright_hand_off(a: *const Num);
    fn stepwright_hand_square();
    fn stepwright_hand_root();
    fn stepwright_hand_scale(by: i8);
    fn stepwright_hand_split() -> u64;
    fn stepwright_hand_bits() -> i16;
    fn stepwright_hand_at_least(a: *const Num) -> u8;
}

/// The offsets of the parts of a number, in bytes.
pub mod layout {
    use super::Num;
    use core::mem::offset_of;

    /// m, least significant byte first.
    pub const MANTISSA: usize = offset_of!(Num, low);
    /// e, least significant byte first.
    pub const EXPONENT: usize = offset_of!(Num, e);
    /// The size of a number.
    pub const SIZE: usize = size_of::<Num>();
    const _: () = assert!(offset_of!(Num, high) == MANTISSA + 2, "the halves of m are apart");
}

/// The right to use the number in hand (`hand.rs`): there is one chain at a time.
pub(super) struct Place(());

/// Defines the operations with a second operand.
macro_rules! in_hand {
    ($($name:ident = $routine:ident),*) => { $(
        #[inline(always)]
        pub(super) fn $name(&mut self, other: &Num) {
            // SAFETY: the routine reads a number and works on the one in hand, which nothing else
            // uses: no interrupt plans.
            unsafe { $routine(other) }
        }
    )* };
}

impl Place {
    in_hand! {
        times = stepwright_hand_times,
        roughly = stepwright_hand_roughly,
        over = stepwright_hand_over,
        under = stepwright_hand_under,
        plus = stepwright_hand_plus,
        minus = stepwright_hand_minus,
        off = stepwright_hand_off
    }

    #[inline(always)]
    pub(super) fn load(a: &Num) -> Place {
        // SAFETY: as above.
        unsafe { stepwright_hand_load(a) };
        Place(())
    }

    #[inline(always)]
    pub(super) fn whole(n: u32) -> Place {
        // SAFETY: as above.
        unsafe { stepwright_hand_whole(n) };
        Place(())
    }

    #[inline(always)]
    pub(super) fn store(&self, a: &mut Num) {
        // SAFETY: as above; the routine writes a number.
        unsafe { stepwright_hand_store(a) };
    }

    #[inline(always)]
    pub(super) fn number(&self) -> Num {
        let mut number = MaybeUninit::uninit();
        // SAFETY: as above.
        unsafe {
            stepwright_hand_store(number.as_mut_ptr());
            number.assume_init()
        }
    }

    #[inline(always)]
    pub(super) fn square(&mut self) {
        // SAFETY: as above.
        unsafe { stepwright_hand_square() };
    }

    #[inline(always)]
    pub(super) fn root(&mut self) {
        // SAFETY: as above.
        unsafe { stepwright_hand_root() };
    }

    #[inline(always)]
    pub(super) fn scale(&mut self, by: i8) {
        // SAFETY: as above.
        unsafe { stepwright_hand_scale(by) };
    }

    #[inline(always)]
    pub(super) fn split(&self) -> (u32, u32) {
        // SAFETY: as above.
        let both = unsafe { stepwright_hand_split() };
        ((both >> 32) as u32, both as u32)
    }

    #[inline(always)]
    pub(super) fn bits(&self) -> i16 {
        // SAFETY: as above.
        unsafe { stepwright_hand_bits() }
    }

    #[inline(always)]
    pub(super) fn at_least(&self, other: &Num) -> bool {
        // SAFETY: as above.
        unsafe { stepwright_hand_at_least(other) != 0 }
    }

    #[inline(always)]
    pub(super) fn end(&self) {}
}

/// The operations of `mod.rs`, which documents them.
impl Num {
    #[inline(always)]
    pub(crate) fn set(&mut self, to: &Num) {
        // SAFETY: the routine reads a number and writes one.
        unsafe { stepwright_copy(to, self) }
    }

    #[inline(always)]
    pub(crate) fn split(&self) -> (u32, u32) {
        // SAFETY: the routine reads a number.
        let both = unsafe { stepwright_split(self) };
        ((both >> 32) as u32, both as u32)
    }

    #[inline(always)]
    pub(crate) fn doublings_of(&self, x: &Num) -> i8 {
        // SAFETY: the routine reads two numbers.
        unsafe { stepwright_doublings(self, x) }
    }

    #[inline(always)]
    pub(crate) fn at_least(&self, other: &Num) -> bool {
        // SAFETY: the routine reads two numbers.
        unsafe { stepwright_at_least(self, other) != 0 }
    }
}
