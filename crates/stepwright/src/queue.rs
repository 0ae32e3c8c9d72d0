//! The queue between planning and stepping: one producer, one consumer.
//!
//! The foreground pushes runs, which become entries, and the step interrupt takes these; neither ever
//! waits for the other or holds interrupts off. `heapless::spsc` does the same
//! with indices as wide as a pointer; here they are bytes, which an 8-bit chip
//! reads and writes in one instruction, and the queue also says whether more
//! is to come, so that the interrupt can tell the end of a travel from a
//! foreground that was too slow.

mod asked;
pub mod entries;

use crate::entry::Play;
pub use asked::{Asked, Feed, Taken};
pub use entries::{Consumer, Next, Producer, Queue};

/// Where an element of an array lies. Where the array has no more than 256 bytes
/// an 8-bit chip finds it by one product of bytes, in a third of the flash.
#[inline(always)]
pub(crate) const fn element<T, const LEN: usize>(array: *const [T; LEN], index: u8) -> *const T {
    let bytes = if size_of::<[T; LEN]>() <= 256 {
        index.wrapping_mul(size_of::<T>() as u8) as usize
    } else {
        (index as usize).wrapping_mul(size_of::<T>())
    };
    array.cast::<T>().wrapping_byte_add(bytes)
}

/// What a [`Source`] has for the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loaded {
    /// An entry, which is to be played.
    Entry,
    /// Nothing yet, but the travel is not over: the source is late.
    Late,
    /// The travel is over.
    End,
}

/// Where the engine gets its entries: a queue, or a program that is asked.
///
/// Called from the step interrupt, once an entry: MUST NOT block, and should take
/// no longer than the shortest entry.
pub trait Source {
    /// Whether an entry that is taken makes room for others, which is news to who fills it.
    const IS_QUEUE: bool = false;

    /// Puts the next entry where it is played. The one before has been played to its end,
    /// its last wait excepted.
    fn load(&mut self, play: &mut Play) -> Loaded;

    /// The last group of the present entry begins: what comes next may be taken.
    #[inline]
    fn look_ahead(&mut self) {}

    /// Forgets everything that is planned: a kill. The axis faces `forward`.
    fn clear(&mut self, forward: bool);
}
