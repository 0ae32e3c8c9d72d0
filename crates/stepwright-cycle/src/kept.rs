//! Values that only some builds keep: in a build without them a small chip's cycle spends no byte
//! on them.

/// A value that exists if `N` is 1; if `N` is 0 it takes no memory and reads as its type's default.
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
