//! A queue of entries.
//!
//! The foreground pushes runs, which become entries on the way. The interrupt takes entries out,
//! and marks them as played. Neither holds the other off: each counter has one writer and is a
//! byte.

use super::{Loaded, Source, element};
use crate::engine::WIRING;
use crate::entry::{Entry, MOST, NEAR, Play, Sink, Wiring, Writer};
use crate::format::Shared;
use crate::run::Run;
use crate::units::Ticks;
use core::cell::UnsafeCell;
use core::marker::PhantomData;
use core::mem::offset_of;

/// Room for `LEN` entries, of 11 bytes on an AVR; `LEN` is a power of two, 4 … 128.
///
/// ```
/// use stepwright::{Run, entry::Wiring, queue::entries::Queue};
/// let queue = Queue::<8>::new();
/// // SAFETY: the only ends of this queue.
/// let mut producer = unsafe { queue.producer(Wiring::new(4, 32)) };
/// producer.push(Run::steady(1000, 50)).unwrap();
/// assert_eq!(producer.len(), 2); // nothing is due before the first wait
/// ```
#[repr(C)] // an interrupt in assembly reads it
pub struct Queue<const LEN: usize> {
    /// Entries taken out since the beginning, modulo 256; written by the interrupt.
    taken: Shared,
    /// Entries pushed since the beginning, modulo 256; written by the producer.
    pushed: Shared,
    /// Whether more entries will follow those in the queue; written by the producer.
    open: Shared,
    /// Entries played to their end, modulo 256; written by the interrupt.
    played: Shared,
    /// 1 if DIR will point backward when all entries are played; used by the foreground only.
    backward: Shared,
    slots: [UnsafeCell<Entry>; LEN],
}

// SAFETY: there is one producer and one interrupt. The producer writes a slot only while pushed −
// taken < LEN says that it is free; the interrupt reads it only while pushed − taken > 0 says that
// it is filled.
unsafe impl<const LEN: usize> Sync for Queue<LEN> {}

impl<const LEN: usize> Queue<LEN> {
    const SIZE_IS_A_POWER_OF_TWO: () = assert!(LEN.is_power_of_two() && LEN >= 4 && LEN <= 128);

    /// The offset of a field of [`Queue`] that the interrupt reads or writes.
    pub const TAKEN: usize = offset_of!(Self, taken);
    /// See [`TAKEN`](Queue::TAKEN).
    pub const PUSHED: usize = offset_of!(Self, pushed);
    /// See [`TAKEN`](Queue::TAKEN).
    pub const OPEN: usize = offset_of!(Self, open);
    /// See [`TAKEN`](Queue::TAKEN).
    pub const PLAYED: usize = offset_of!(Self, played);
    /// See [`TAKEN`](Queue::TAKEN).
    pub const SLOTS: usize = offset_of!(Self, slots);

    /// An empty queue of an axis that faces forward.
    pub const fn new() -> Queue<LEN> {
        let () = Self::SIZE_IS_A_POWER_OF_TWO;
        Queue {
            taken: Shared::new(),
            pushed: Shared::new(),
            open: Shared::new(),
            played: Shared::new(),
            backward: Shared::new(),
            slots: [const { UnsafeCell::new(Entry::EMPTY) }; LEN],
        }
    }

    /// The two ends, for the foreground and the engine.
    pub const fn split(&mut self) -> (Producer<'_, LEN>, Consumer<'_, LEN>) {
        self.split_as(WIRING)
    }

    /// [`split`](Queue::split) for a player that is not [prompt](Wiring::prompt).
    pub const fn split_as(&mut self, wiring: Wiring) -> (Producer<'_, LEN>, Consumer<'_, LEN>) {
        let queue: &Queue<LEN> = self;
        // SAFETY: the queue is borrowed mutably, so there is one producer.
        let producer = unsafe { queue.producer(wiring) };
        (producer, queue.consumer())
    }

    /// The engine's end.
    pub(crate) const fn consumer(&self) -> Consumer<'_, LEN> {
        Consumer { queue: self, ahead: None }
    }

    /// The foreground's end.
    ///
    /// # Safety
    /// There may be only one producer of a queue.
    #[allow(unsafe_code)]
    pub const unsafe fn producer(&self, wiring: Wiring) -> Producer<'_, LEN> {
        let writer = Writer::new(wiring);
        Producer { queue: self, borrowed: PhantomData, writer, far: Run::steady(0, 0) }
    }

    /// Initialises a producer of zeros as [`producer`](Queue::producer) does, with as few stores as
    /// possible.
    ///
    /// # Safety
    /// There may be only one producer of a queue; this one must be all zeros.
    #[allow(unsafe_code)]
    pub unsafe fn lend<'q>(&'q self, producer: &mut Producer<'q, LEN>, wiring: Wiring) {
        producer.queue = self;
        producer.writer.wire(wiring);
    }

    /// Forgets all entries: the axis has been stopped, and `forward` is the direction of its DIR.
    /// Nothing may play the queue meanwhile.
    pub fn clear(&self, forward: bool) {
        let pushed = self.pushed.get();
        self.taken.set(pushed);
        self.played.set(pushed);
        self.open.set(0);
        self.backward.set((!forward).into());
    }

    /// Whether the entry that is being played is the last one taken out: no other is held ready
    /// after it.
    #[inline(always)]
    pub fn plays_last_taken(&self) -> bool {
        self.taken.get().wrapping_sub(self.played.get()) == 1
    }

    /// Takes out the oldest entry.
    pub fn take(&self) -> Option<Entry> {
        let at = self.taken.get();
        // A producer closes after its last push, and pushes after it has written.
        if self.pushed.get() == at {
            return None;
        }
        // SAFETY: the slot is filled, and only the interrupt takes it.
        let entry = unsafe { self.slot(at).read() };
        self.taken.set(at.wrapping_add(1));
        Some(entry)
    }

    /// The slot of a counter's value.
    fn slot(&self, counter: u8) -> *mut Entry {
        // LEN is a power of two of at most 128, so the index is in range.
        let index = counter & (LEN as u8).wrapping_sub(1);
        UnsafeCell::raw_get(element(&self.slots, index))
    }
}

impl<const LEN: usize> Default for Queue<LEN> {
    fn default() -> Self {
        Queue::new()
    }
}

/// The foreground's end of a [`Queue`].
pub struct Producer<'q, const LEN: usize> {
    /// Null in a [`OrderedMotors::blank`](crate::OrderedMotors::blank).
    queue: *const Queue<LEN>,
    borrowed: PhantomData<&'q Queue<LEN>>,
    writer: Writer,
    /// The rest of a run of several steps with long intervals, each of which takes entries of its
    /// own.
    far: Run,
}

// SAFETY: the pointer stands for a `&Queue`, which is `Send` and `Sync`.
unsafe impl<const LEN: usize> Send for Producer<'_, LEN> {}
// SAFETY: as above.
unsafe impl<const LEN: usize> Sync for Producer<'_, LEN> {}

impl<'q, const LEN: usize> Producer<'q, LEN> {
    #[inline(always)]
    fn queue(&self) -> &'q Queue<LEN> {
        // SAFETY: the pointer was made from such a reference.
        unsafe { &*self.queue }
    }

    /// Appends a run.
    ///
    /// # Errors
    /// Returns the run if the queue is full.
    pub fn push(&mut self, run: Run) -> Result<(), Run> {
        if self.append(&run) { Ok(()) } else { Err(run) }
    }

    /// Appends a run; false if the queue is full.
    pub(crate) fn append(&mut self, run: &Run) -> bool {
        if self.is_full() {
            return false;
        }
        let queue = &mut self.queue();
        let Producer { writer, far, .. } = self;
        if let Some(forward) = run.turns() {
            let changes = queue.backward.get() == u8::from(forward);
            queue.backward.set((!forward).into());
            writer.turn(run.ticks, changes, queue);
        } else if run.count > 1 && is_far(run) {
            *far = *run;
            self.go_far();
        } else {
            writer.run(run, queue);
        }
        true
    }

    /// Whether there is no room for another run.
    #[inline(always)]
    pub fn is_full(&mut self) -> bool {
        self.lacks_room() || (self.far.count != 0 && self.go_far())
    }

    fn lacks_room(&self) -> bool {
        let queue = self.queue();
        queue.pushed.get().wrapping_sub(queue.taken.get()) > LEN as u8 - MOST
    }

    /// Makes entries of the rest of a run while there is room. Returns whether the queue is full
    /// then.
    #[inline(never)]
    fn go_far(&mut self) -> bool {
        loop {
            let full = self.lacks_room();
            if full || self.far.count == 0 {
                return full;
            }
            let queue = &mut self.queue();
            let Producer { writer, far, .. } = self;
            writer.run(&Run { count: 1, ..*far }, queue);
            let next = far.interval().wrapping_add_signed(far.add.into());
            *far = Run::new(next, far.add, far.count.wrapping_sub(1));
        }
    }

    /// The duration of appended steps that have no entries yet, because there is no room: in ticks.
    // Out of line, so that a program that does not ask how long it may sleep is compiled without
    // the call.
    #[inline(never)]
    pub(crate) fn behind(&self) -> Ticks {
        if self.far.count == 0 { 0 } else { (self.far.duration() >> 16) as Ticks }
    }

    /// Entries that have not been played to their end.
    pub fn len(&self) -> u8 {
        let queue = self.queue();
        queue.pushed.get().wrapping_sub(queue.played.get()).min(LEN as u8)
    }

    /// Appends an entry that was made elsewhere; returns false if the queue is full. Do not mix
    /// with [`push`](Producer::push): steps that it keeps for later would come after this entry.
    ///
    /// ```
    /// use stepwright::entry::{EntryParts, Wiring};
    /// use stepwright::queue::Queue;
    /// let mut queue = Queue::<4>::new();
    /// let (mut producer, _) = queue.split_as(Wiring::new(1, 2));
    /// let parts =
    ///     EntryParts { pins: 1, then: 1, events: 9, groups: 1, interval: 800 << 16, growth: 0 };
    /// for _ in 0..4 {
    ///     assert!(producer.put(parts.entry()));
    /// }
    /// assert!(!producer.put(parts.entry()));
    /// assert_eq!(producer.waiting(), 4);
    /// ```
    #[inline(always)]
    pub fn put(&mut self, entry: Entry) -> bool {
        if self.waiting() >= LEN as u8 {
            return false;
        }
        Sink::put(&mut self.queue(), entry);
        true
    }

    /// Entries that have not been taken out.
    #[inline(always)]
    pub fn waiting(&self) -> u8 {
        let queue = self.queue();
        queue.pushed.get().wrapping_sub(queue.taken.get())
    }

    /// Entries pushed since the beginning, modulo 256.
    pub fn pushed(&self) -> u8 {
        self.queue().pushed.get()
    }

    /// Whether every entry has been played.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Says whether more runs will follow; if not, the last step is due.
    pub fn set_open(&mut self, open: bool) {
        let queue = &mut self.queue();
        let Producer { writer, far, .. } = self;
        if open || queue.open.get() == 0 {
            writer.forget();
            far.count = 0;
        } else {
            writer.end(queue);
        }
        queue.open.set(open.into());
    }
}

/// The engine's end of a [`Queue`].
pub struct Consumer<'q, const LEN: usize> {
    queue: &'q Queue<LEN>,
    /// The entry after the present one: it is taken when the last group of the present entry
    /// begins.
    ahead: Option<Entry>,
}

/// The result of [`Consumer::take`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The oldest entry.
    Entry(Entry),
    /// None, and more entries are to come.
    Late,
    /// None, and the travel is over.
    End,
}

impl<const LEN: usize> Consumer<'_, LEN> {
    /// Takes the next entry. The previous one counts as played.
    #[inline]
    pub fn take(&mut self) -> Next {
        // Whether more entries are to come is read before the entries: a producer closes after its
        // last push.
        let open = self.queue.open.get() != 0;
        self.look_ahead();
        let taken = self.queue.taken.get();
        let Some(entry) = self.ahead.take() else {
            self.queue.played.set(taken);
            return if open { Next::Late } else { Next::End };
        };
        self.queue.played.set(taken.wrapping_sub(1));
        Next::Entry(entry)
    }

    /// Marks all entries that were taken as played to their end: for a player that knows this
    /// before it takes the next one. From now on the foreground counts them as
    /// [played](Producer::len).
    pub fn set_played(&mut self) {
        let ahead = u8::from(self.ahead.is_some());
        self.queue.played.set(self.queue.taken.get().wrapping_sub(ahead));
    }
}

impl<const LEN: usize> Source for Consumer<'_, LEN> {
    const IS_QUEUE: bool = true;

    #[inline]
    fn load(&mut self, play: &mut Play) -> Loaded {
        match self.take() {
            Next::Entry(entry) => {
                *play = entry.play();
                Loaded::Entry
            }
            Next::Late => Loaded::Late,
            Next::End => Loaded::End,
        }
    }

    #[inline]
    fn look_ahead(&mut self) {
        if self.ahead.is_none() {
            self.ahead = self.queue.take();
        }
    }

    fn clear(&mut self, forward: bool) {
        self.ahead = None;
        self.queue.clear(forward);
    }
}

/// Whether an interval of a run is [`NEAR`] or more.
fn is_far(run: &Run) -> bool {
    // Certainly not: 63 steps that grow by less than 256 ticks each.
    if run.ticks < NEAR / 4 && run.count < 64 && run.add < 1 << 24 {
        return false;
    }
    // In 2⁻⁸ ticks; the rounding is less than the margin.
    let last = (run.add >> 8).wrapping_mul(i32::from(run.count.wrapping_sub(1)));
    run.ticks >= NEAR - 2
        || (run.ticks << 8) as i32 >= (((NEAR - 2) << 8) as i32).wrapping_sub(last)
}

/// For the producer only, which checks for room.
impl<const LEN: usize> Sink for &Queue<LEN> {
    #[inline(never)] // one copy in flash
    fn put(&mut self, entry: Entry) {
        let at = self.pushed.get();
        // SAFETY: the slot is free, and there is one producer.
        unsafe { self.slot(at).write(entry) };
        self.pushed.set(at.wrapping_add(1));
    }
}

#[cfg(test)]
pub(crate) mod tests;
