//! Lists that a board keeps until they are read: unlimited, or short without `std`.

/// The most changes of the enable pin that are kept.
pub(crate) const MOST_CHANGES: usize = 64;

#[cfg(feature = "std")]
type List<T, const N: usize> = Vec<T>;
#[cfg(not(feature = "std"))]
type List<T, const N: usize> = Few<T, N>;

/// The bytes that a board has sent since they were last read. Without `std` at most 1024, which is more than
/// the answer to any line.
pub type Answers = List<u8, 1024>;

/// Changes of the enable pin: the time and the level.
pub type EnableChanges = List<(u64, bool), MOST_CHANGES>;

/// A list of at most `N` values; further values are dropped.
#[cfg(any(test, not(feature = "std")))]
#[derive(Clone, Copy, Debug)]
pub struct Few<T, const N: usize> {
    values: [T; N],
    len: usize,
}

#[cfg(any(test, not(feature = "std")))]
impl<T: Copy + Default, const N: usize> Default for Few<T, N> {
    fn default() -> Self {
        Few { values: [T::default(); N], len: 0 }
    }
}

#[cfg(any(test, not(feature = "std")))]
impl<T: Copy + Default, const N: usize> Few<T, N> {
    /// Adds a value, if there is room.
    pub fn push(&mut self, value: T) {
        if let Some(place) = self.values.get_mut(self.len) {
            *place = value;
            self.len += 1;
        }
    }

    /// The number of values.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the list is empty.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// All values, in order.
    pub fn iter(&self) -> core::slice::Iter<'_, T> {
        self.values.get(..self.len).unwrap_or_default().iter()
    }
}

#[cfg(test)]
mod tests {
    use super::Few;

    #[test]
    fn as_many_as_there_is_room_for() {
        let mut few = Few::<u8, 3>::default();
        assert!(few.is_empty());
        for byte in 1..=5 {
            few.push(byte);
        }
        assert_eq!((few.len(), few.iter().as_slice()), (3, &[1, 2, 3][..]));
    }
}
