//! The queue between planning and stepping: one producer, one consumer.
//!
//! The foreground pushes runs, which become entries, and the step interrupt takes the entries.
//! Neither waits for the other or holds interrupts off. `heapless::spsc` does the same with indices
//! as wide as a pointer. Here the indices are bytes, which an 8-bit chip reads and writes in one
//! instruction. The queue also says whether more entries are to come, so that the interrupt can
//! tell the end of a travel from a foreground that is too slow.

mod asked;
pub mod entries;

use crate::entry::Play;
pub use asked::{Asked, Feed, Taken};
pub use entries::{Consumer, Next, Producer, Queue};

/// The address of an element of an array. If the array has at most 256 bytes, an 8-bit chip
/// computes it with one product of bytes, in a third of the flash.
#[inline(always)]
pub(crate) const fn element<T, const LEN: usize>(array: *const [T; LEN], index: u8) -> *const T {
    let bytes = if size_of::<[T; LEN]>() <= 256 {
        index.wrapping_mul(size_of::<T>() as u8) as usize
    } else {
        (index as usize).wrapping_mul(size_of::<T>())
    };
    array.cast::<T>().wrapping_byte_add(bytes)
}

/// The answer of a [`Source`] to the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loaded {
    /// An entry to play.
    Entry,
    /// No entry yet, but the travel is not over: the source is late.
    Late,
    /// The travel is over.
    End,
}

/// The source of the engine's entries: a queue, or a program that is asked.
///
/// Called from the step interrupt, once per entry: MUST NOT block, and should take no longer than
/// the shortest entry.
pub trait Source {
    /// Whether taking an entry makes room for others, which is news for the producer.
    const IS_QUEUE: bool = false;

    /// Writes the next entry into `play`. The previous entry has been played to its end, except for
    /// its last wait.
    fn load(&mut self, play: &mut Play) -> Loaded;

    /// Called when the last group of the present entry begins: the next entry may be taken.
    #[inline]
    fn look_ahead(&mut self) {}

    /// Forgets everything that is planned, after a kill. The axis faces `forward`.
    fn clear(&mut self, forward: bool);
}
