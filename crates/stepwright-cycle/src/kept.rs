//! What only some builds keep: a small chip's cycle has no byte of what is left out of it.

/// A value that is there where `N` is 1, and its type's default, without memory, where `N` is 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept<T, const N: usize>([T; N]);

impl<T: Copy + Default, const N: usize> Kept<T, N> {
    pub(crate) const fn new(value: T) -> Kept<T, N> {
        Kept([value; N])
    }

    #[inline(always)]
    pub(crate) fn get(&self) -> T {
        self.0.first().copied().unwrap_or_default()
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, value: T) {
        if let Some(place) = self.0.first_mut() {
            *place = value;
        }
    }

    #[inline(always)]
    pub(crate) fn take(&mut self) -> T {
        let value = self.get();
        self.set(T::default());
        value
    }
}
