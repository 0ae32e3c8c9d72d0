//! Axes and sets of axes, typed by the number of axes: an axis beyond the last does not exist.

use core::ops::{BitOr, BitOrAssign};

use crate::drive::Axes;
use crate::units::OutOfRange;

/// One of N axes, 1 ≤ N ≤ 8.
///
/// The first three have names. An axis beyond the last of N does not compile:
///
/// ```
/// use stepwright::Axis;
/// let third: Axis<3> = Axis::Z;
/// assert_eq!(third.index(), 2);
/// assert_eq!(Axis::<5>::at::<4>(), Axis::new(4)?);
/// # Ok::<(), stepwright::OutOfRange>(())
/// ```
///
/// ```compile_fail
/// let third: stepwright::Axis<2> = stepwright::Axis::Z;
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Axis<const N: usize>(u8);

impl<const N: usize> Axis<N> {
    /// The first axis, index 0: axis 1 of the serial line.
    pub const X: Axis<N> = Axis::at::<0>();
    /// The second axis, index 1.
    pub const Y: Axis<N> = Axis::at::<1>();
    /// The third axis, index 2.
    pub const Z: Axis<N> = Axis::at::<2>();

    /// The axis with this index, 0 … N − 1, as a compile-time constant. An index beyond N − 1 does
    /// not compile.
    pub const fn at<const INDEX: usize>() -> Axis<N> {
        const { assert!(INDEX < N && N <= 8, "there is no such axis") };
        Axis(INDEX as u8)
    }

    /// The axis with this index.
    ///
    /// ```
    /// use stepwright::Axis;
    /// assert!(Axis::<3>::new(2).is_ok());
    /// let error = Axis::<3>::new(3).unwrap_err();
    /// assert_eq!(error.to_string(), "axis out of range: 0 to 2 (X is 0)");
    /// ```
    ///
    /// # Errors
    /// [`OutOfRange`] if the index is N or more.
    pub const fn new(index: usize) -> Result<Axis<N>, OutOfRange> {
        const { assert!(N >= 1 && N <= 8, "1 to 8 axes") };
        if index < N {
            Ok(Axis(index as u8))
        } else {
            Err(OutOfRange { what: "axis", min: 0, max: N as u64 - 1, unit: "(X is 0)" })
        }
    }

    /// The index of the axis, 0 … N − 1.
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// All N axes in order.
    ///
    /// ```
    /// assert_eq!(stepwright::Axis::<4>::all().count(), 4);
    /// ```
    pub fn all() -> impl Iterator<Item = Axis<N>> + Clone {
        const { assert!(N >= 1 && N <= 8, "1 to 8 axes") };
        (0..N as u8).map(Axis)
    }

    pub(crate) const fn number(self) -> u8 {
        self.0
    }
}

/// A set of N axes.
///
/// ```
/// use stepwright::{Axis, AxisSet};
/// let set: AxisSet<3> = Axis::X | Axis::Z;
/// assert!(set.contains(Axis::Z) && !set.contains(Axis::Y));
/// assert_eq!(set.iter().count(), 2);
/// assert_eq!(set | Axis::Y, AxisSet::ALL);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AxisSet<const N: usize>(Axes);

impl<const N: usize> AxisSet<N> {
    /// No axis.
    pub const NONE: AxisSet<N> = AxisSet(0);
    /// All N axes.
    pub const ALL: AxisSet<N> = AxisSet(if N < 8 { (1 << N) - 1 } else { Axes::MAX });

    /// The set whose bit 0 stands for the first axis; bits beyond N are ignored.
    ///
    /// ```
    /// use stepwright::{Axis, AxisSet};
    /// assert_eq!(AxisSet::<2>::from_bits(0b110), Axis::Y.into());
    /// ```
    pub const fn from_bits(bits: Axes) -> AxisSet<N> {
        AxisSet(bits & AxisSet::<N>::ALL.0)
    }

    /// The set as bits; bit 0 stands for the first axis.
    pub const fn bits(self) -> Axes {
        self.0
    }

    /// Whether this axis is in the set.
    pub const fn contains(self, axis: Axis<N>) -> bool {
        self.0 >> axis.0 & 1 != 0
    }

    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The axes of the set in order.
    pub fn iter(self) -> impl Iterator<Item = Axis<N>> + Clone {
        Axis::all().filter(move |axis| self.contains(*axis))
    }
}

impl<const N: usize> From<Axis<N>> for AxisSet<N> {
    fn from(axis: Axis<N>) -> AxisSet<N> {
        AxisSet(1 << axis.0)
    }
}

impl<const N: usize> FromIterator<Axis<N>> for AxisSet<N> {
    fn from_iter<I: IntoIterator<Item = Axis<N>>>(axes: I) -> AxisSet<N> {
        axes.into_iter().fold(AxisSet::NONE, BitOr::bitor)
    }
}

impl<const N: usize, S: Into<AxisSet<N>>> BitOr<S> for AxisSet<N> {
    type Output = AxisSet<N>;
    fn bitor(self, other: S) -> AxisSet<N> {
        AxisSet(self.0 | other.into().0)
    }
}

impl<const N: usize, S: Into<AxisSet<N>>> BitOr<S> for Axis<N> {
    type Output = AxisSet<N>;
    fn bitor(self, other: S) -> AxisSet<N> {
        AxisSet::from(self) | other
    }
}

impl<const N: usize, S: Into<AxisSet<N>>> BitOrAssign<S> for AxisSet<N> {
    fn bitor_assign(&mut self, other: S) {
        *self = *self | other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_holds_no_axis_beyond_the_last() {
        assert_eq!(AxisSet::<3>::from_bits(0xFF), AxisSet::ALL);
        assert_eq!(AxisSet::<8>::ALL.bits(), 0xFF);
        assert_eq!(AxisSet::<1>::ALL.iter().count(), 1);
        assert_eq!(Axis::<8>::all().collect::<AxisSet<8>>(), AxisSet::ALL);
        assert!((AxisSet::<3>::NONE | AxisSet::NONE).is_empty());
    }
}
