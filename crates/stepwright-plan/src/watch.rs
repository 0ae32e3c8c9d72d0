//! The progress of a long calculation: billions of steps take minutes.

/// Called at about every millionth step of a long walk: with the name of the work, the step, and the number
/// of steps.
pub type Watch<'a> = &'a dyn Fn(&'static str, u32, u32);

/// Ignores all progress.
pub const UNWATCHED: Watch<'static> = &|_, _, _| ();

/// Steps between two calls.
const STRIDE: u32 = 1 << 20;

/// A walk over the steps of a travel.
pub(crate) struct Walk<'a> {
    what: &'static str,
    of: u32,
    next: u32,
    watch: Watch<'a>,
}

impl<'a> Walk<'a> {
    /// A walk over `of` steps. A short walk reports nothing.
    pub fn new(what: &'static str, of: u32, watch: Watch<'a>) -> Walk<'a> {
        Walk { what, of, next: STRIDE, watch }
    }

    /// Reports that the walk is at step `n`, if it is time to.
    pub fn at(&mut self, n: u32) {
        if n >= self.next {
            self.next = n.saturating_add(STRIDE);
            (self.watch)(self.what, n, self.of);
        }
    }
}
