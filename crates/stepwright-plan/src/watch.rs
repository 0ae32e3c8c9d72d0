//! How far a long calculation is: billions of steps take minutes.

/// Told at every millionth step or so of a long walk: what is done, at which step, of how many.
pub type Watch<'a> = &'a dyn Fn(&'static str, u32, u32);

/// Tells nobody.
pub const UNWATCHED: Watch<'static> = &|_, _, _| ();

/// Steps between two words.
const STRIDE: u32 = 1 << 20;

/// A walk over the steps of a travel.
pub(crate) struct Walk<'a> {
    what: &'static str,
    of: u32,
    next: u32,
    watch: Watch<'a>,
}

impl<'a> Walk<'a> {
    /// Over `of` steps; of a short walk nothing is said.
    pub fn new(what: &'static str, of: u32, watch: Watch<'a>) -> Walk<'a> {
        Walk { what, of, next: STRIDE, watch }
    }

    /// At step `n`.
    pub fn at(&mut self, n: u32) {
        if n >= self.next {
            self.next = n.saturating_add(STRIDE);
            (self.watch)(self.what, n, self.of);
        }
    }
}
