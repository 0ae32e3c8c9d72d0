//! Axes as a line names them.

use crate::grammar::{Argument, Shape};
use crate::raw_line::RawLine;
use crate::text::Piece;

/// The most axes that a slave can have: one digit names each.
pub const MAX_AXES: u8 = 8;

/// One axis: 1 … 8 on the line, 0 … 7 as an index.
///
/// The slave checks whether the board has that many axes; this type does not.
///
/// ```
/// use stepwright_protocol::AxisId;
/// let third = AxisId::numbered(3).unwrap();
/// assert_eq!((third.number(), third.index()), (3, 2));
/// assert!(AxisId::numbered(0).is_none() && AxisId::numbered(9).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AxisId(u8);

impl AxisId {
    /// Axis 1, which PO selects.
    pub const FIRST: AxisId = AxisId(0);

    /// The axis with this number on the line, 1 … 8.
    pub const fn numbered(number: u8) -> Option<AxisId> {
        match number.checked_sub(1) {
            Some(index) if index < MAX_AXES => Some(AxisId(index)),
            _ => None,
        }
    }

    /// The axis with this index, modulo [`MAX_AXES`].
    pub(crate) const fn at(index: u8) -> AxisId {
        AxisId(index % MAX_AXES)
    }

    /// The number on the line, 1 … 8.
    pub const fn number(self) -> u8 {
        self.0.wrapping_add(1)
    }

    /// The index in an array, 0 … 7.
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// The first `axes` axes (at most eight), in order.
    pub fn first(axes: u8) -> impl Iterator<Item = AxisId> + Clone {
        (0..if axes > MAX_AXES { MAX_AXES } else { axes }).map(AxisId)
    }
}

/// The axes that the following lines address, as `A` selects them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Selection {
    /// `A1` … `A8`.
    One(AxisId),
    /// `A0`.
    All,
}

impl Selection {
    /// The selection at power-up and after PO: axis 1.
    pub const FIRST: Selection = Selection::One(AxisId::FIRST);

    /// Whether a line with this selection addresses `axis`.
    pub fn contains(self, axis: AxisId) -> bool {
        match self {
            Selection::One(one) => one == axis,
            Selection::All => true,
        }
    }

    /// The number after the `A`.
    pub(crate) fn number(self) -> u8 {
        match self {
            Selection::One(axis) => axis.number(),
            Selection::All => 0,
        }
    }
}

impl Argument for AxisId {
    const SHAPE: Shape = Shape::number(1, MAX_AXES as u32);

    fn of(raw: &RawLine) -> Option<AxisId> {
        AxisId::numbered(raw.number as u8)
    }

    fn piece(self, n: u8) -> Option<Piece> {
        (n == 0).then_some(Piece::Number(self.number().into()))
    }
}

impl Argument for Selection {
    const SHAPE: Shape = Shape::number(0, MAX_AXES as u32);

    fn of(raw: &RawLine) -> Option<Selection> {
        Some(AxisId::numbered(raw.number as u8).map_or(Selection::All, Selection::One))
    }

    fn piece(self, n: u8) -> Option<Piece> {
        (n == 0).then_some(Piece::Number(self.number().into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_one_based_and_bounded() {
        assert_eq!(AxisId::numbered(1), Some(AxisId::FIRST));
        assert_eq!(AxisId::numbered(8).map(AxisId::index), Some(7));
        assert_eq!((AxisId::numbered(0), AxisId::numbered(9)), (None, None));
        assert_eq!((AxisId::at(7).number(), AxisId::at(8).number()), (8, 1));
        assert_eq!(AxisId::first(200).count(), 8);
    }
}
