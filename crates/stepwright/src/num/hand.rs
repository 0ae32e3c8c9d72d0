//! The number in hand: a chain of operations without stored intermediate results.
//!
//! ```text
//!   hand(a).times(b).plus(c).root().to(d)       d = √(a·b + c)
//! ```
//!
//! The results are those of [`Num`]'s own operations, bit for bit. On an AVR the number is at a
//! fixed address, so that an operation takes one address where [`Num`]'s take three, which halves
//! the code around it. There is one hand, for the foreground. A second chain that begins before the
//! first has ended would overwrite it; the tests detect that.

use super::Num;
use crate::clamp;

/// A chain in progress. The operation that ends it returns or stores the number.
#[must_use = "the chain has no end"]
pub(crate) struct Hand(Place);

/// Begins a chain with a number.
#[inline(always)]
pub(crate) fn hand(a: &Num) -> Hand {
    Hand(Place::load(a))
}

/// Begins a chain with an integer.
#[inline(always)]
pub(crate) fn whole(n: u32) -> Hand {
    Hand(Place::whole(n))
}

/// Begins a chain with a fraction, in 2⁻³².
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(crate) fn part(x: u32) -> Hand {
    whole(x).scaled(-32)
}

/// Defines the operations with a second operand.
macro_rules! operations {
    ($($(#[$doc:meta])* $name:ident),*) => { $(
        $(#[$doc])*
        #[inline(always)]
        pub(crate) fn $name(mut self, other: &Num) -> Hand {
            self.0.$name(other);
            self
        }
    )* };
}

impl Hand {
    operations! {
        /// · other.
        times,
        /// · other, to 15 bits.
        roughly,
        /// / other.
        over,
        /// other / this.
        under,
        /// + other.
        plus,
        /// − other.
        minus,
        /// other − this.
        off
    }

    /// The square.
    #[inline(always)]
    pub(crate) fn square(mut self) -> Hand {
        self.0.square();
        self
    }

    /// The square root.
    #[inline(always)]
    pub(crate) fn root(mut self) -> Hand {
        self.0.root();
        self
    }

    /// · 2^by.
    #[inline(always)]
    pub(crate) fn scaled(mut self, by: i8) -> Hand {
        self.0.scale(by);
        self
    }

    /// Stores the number, and continues.
    #[inline(always)]
    pub(crate) fn also(self, a: &mut Num) -> Hand {
        self.0.store(a);
        self
    }

    /// Stores the number.
    #[inline(always)]
    pub(crate) fn to(self, a: &mut Num) {
        self.0.store(a);
        self.0.end();
    }

    /// Returns the number.
    #[inline(always)]
    pub(crate) fn number(self) -> Num {
        let number = self.0.number();
        self.0.end();
        number
    }

    /// The least e for which the number is less than 2^e.
    #[inline(always)]
    pub(crate) fn bits(&self) -> i16 {
        self.0.bits()
    }

    /// Whether the number is less than 2^e.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn below(self, e: i8) -> bool {
        let bits = self.bits();
        self.0.end();
        bits <= e.into()
    }

    /// The whole part, at most `u32::MAX`, and the rest in 2⁻³².
    #[inline(always)]
    pub(crate) fn split(self) -> (u32, u32) {
        let parts = self.0.split();
        self.0.end();
        parts
    }

    /// The nearest integer, at most `u32::MAX`.
    #[inline(always)]
    pub(crate) fn rounded_whole(self) -> u32 {
        let (whole, part) = self.split();
        clamp::sum(whole, part >> 31)
    }

    /// Whether the number is at least `other`.
    #[inline(always)]
    pub(crate) fn at_least(self, other: &Num) -> bool {
        let is = self.0.at_least(other);
        self.0.end();
        is
    }
}

#[cfg(feature = "external-numbers")]
use super::external::Place;

/// The place of the number.
#[cfg(not(feature = "external-numbers"))]
struct Place(Num);

#[cfg(not(feature = "external-numbers"))]
impl Place {
    fn load(a: &Num) -> Place {
        #[cfg(test)]
        busy::begin();
        Place(*a)
    }

    fn whole(n: u32) -> Place {
        Place::load(&Num::from(n))
    }

    fn times(&mut self, other: &Num) {
        self.0 = self.0.times(other);
    }

    fn roughly(&mut self, other: &Num) {
        self.0 = self.0.roughly(other);
    }

    fn over(&mut self, other: &Num) {
        self.0 = self.0.over(other);
    }

    fn under(&mut self, other: &Num) {
        self.0 = other.over(&self.0);
    }

    fn plus(&mut self, other: &Num) {
        self.0 = self.0.plus(other);
    }

    fn minus(&mut self, other: &Num) {
        self.0 = self.0.minus(other);
    }

    fn off(&mut self, other: &Num) {
        self.0 = other.minus(&self.0);
    }

    fn square(&mut self) {
        self.0 = self.0.times(&self.0);
    }

    fn root(&mut self) {
        self.0 = self.0.root();
    }

    fn scale(&mut self, by: i8) {
        self.0 = self.0.scaled(by.into());
    }

    fn store(&self, a: &mut Num) {
        *a = self.0;
    }

    fn number(&self) -> Num {
        self.0
    }

    fn split(&self) -> (u32, u32) {
        self.0.split()
    }

    fn bits(&self) -> i16 {
        self.0.bits()
    }

    fn at_least(&self, other: &Num) -> bool {
        self.0.at_least(other)
    }

    #[cfg_attr(not(test), allow(clippy::unused_self))]
    fn end(&self) {
        #[cfg(test)]
        busy::end();
    }
}

/// Checks that there is one chain at a time.
#[cfg(test)]
mod busy {
    extern crate std;
    use core::cell::Cell;

    std::thread_local!(static BUSY: Cell<bool> = const { Cell::new(false) });

    pub(super) fn begin() {
        assert!(!BUSY.replace(true), "a chain begins within another");
    }

    pub(super) fn end() {
        assert!(BUSY.replace(false));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_the_operations_one_by_one() {
        let (a, b, c) = (Num::from(1_000_003), Num::from(77), part(5 << 29).number());
        let mut d = Num::UNSET;
        hand(&a).times(&b).plus(&c).root().to(&mut d);
        assert_eq!(d, a.times(&b).plus(&c).root());
        hand(&a).over(&b).minus(&c).scaled(-3).to(&mut d);
        assert_eq!(d, a.over(&b).minus(&c).scaled(-3));
        let mut e = Num::UNSET;
        whole(77).under(&a).also(&mut e).off(&a).square().roughly(&c).to(&mut d);
        assert_eq!(e, a.over(&b));
        let off = a.minus(&e);
        assert_eq!(d, off.times(&off).roughly(&c));
        assert_eq!(hand(&c).split(), c.split());
        assert!(hand(&a).at_least(&b) && !hand(&b).at_least(&a));
    }

    #[test]
    #[should_panic(expected = "within another")]
    fn a_chain_within_another_is_found_out() {
        let (a, mut b) = (Num::ONE, Num::UNSET);
        let first = hand(&a);
        hand(&a).to(&mut b);
        first.to(&mut b);
    }
}
