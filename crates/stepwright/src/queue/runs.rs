//! A queue of runs: what the portable engine plays.

use super::{Feed, Fetched, Shared, Taken, element};
use crate::run::Run;
use crate::stride::Slot;
use core::cell::UnsafeCell;
use core::marker::PhantomData;

/// Room for `LEN` runs of 13 bytes (16 on bigger chips); `LEN` is a power of
/// two, 2 … 128.
///
/// ```
/// use stepwright::{Run, queue::{Feed, Queue, Taken}};
/// let mut queue = Queue::<8>::new();
/// let (mut planner, mut engine) = queue.split();
/// planner.push(Run::steady(1000, 50)).unwrap();
/// assert_eq!(engine.take(), Taken::Run(Run::steady(1000, 50)));
/// assert_eq!(engine.take(), Taken::End);
/// ```
pub struct Queue<const LEN: usize> {
    /// Runs taken since the beginning, modulo 256; written by the consumer.
    taken: Shared,
    /// Runs pushed, modulo 256; written by the producer.
    pushed: Shared,
    /// More runs will follow those in the queue; written by the producer.
    open: Shared,
    slots: [UnsafeCell<Slot>; LEN],
}

// SAFETY: `split` borrows the queue mutably, so there is one producer and one
// consumer. A slot is touched by the producer only while pushed − taken < LEN
// leaves it free, and by the consumer only while pushed − taken > 0 says that
// it is filled; the release store of each counter is read with acquire on the
// other side, so the contents of a slot change hands with it.
unsafe impl<const LEN: usize> Sync for Queue<LEN> {}

impl<const LEN: usize> Queue<LEN> {
    const SIZE_IS_A_POWER_OF_TWO: () = assert!(LEN.is_power_of_two() && LEN >= 2 && LEN <= 128);

    /// An empty queue.
    pub const fn new() -> Queue<LEN> {
        let () = Self::SIZE_IS_A_POWER_OF_TWO;
        Queue {
            taken: Shared::new(),
            pushed: Shared::new(),
            open: Shared::new(),
            slots: [const { UnsafeCell::new(Slot::EMPTY) }; LEN],
        }
    }

    /// The two ends, for foreground and interrupt.
    pub fn split(&mut self) -> (Producer<'_, LEN>, Consumer<'_, LEN>) {
        let queue: &Queue<LEN> = self;
        (Producer::of(queue), Consumer { queue, held: false })
    }

    /// [`split`](Queue::split) of a queue that is shared already: a static.
    ///
    /// # Safety
    /// To be called once for a queue, or each end used once.
    #[allow(unsafe_code)]
    pub const unsafe fn ends(&self) -> (Producer<'_, LEN>, Consumer<'_, LEN>) {
        (Producer::of(self), Consumer { queue: self, held: false })
    }

    fn len(&self) -> u8 {
        self.pushed.get().wrapping_sub(self.taken.get())
    }

    /// The slot that a counter stands for.
    fn slot(&self, counter: u8) -> *mut Slot {
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
    /// Null in a [`Group::blank`](crate::Group::blank).
    queue: *const Queue<LEN>,
    borrowed: PhantomData<&'q Queue<LEN>>,
}

// SAFETY: it stands for a `&Queue`, which is `Send` and `Sync`.
unsafe impl<const LEN: usize> Send for Producer<'_, LEN> {}
// SAFETY: likewise.
unsafe impl<const LEN: usize> Sync for Producer<'_, LEN> {}

impl<'q, const LEN: usize> Producer<'q, LEN> {
    const fn of(queue: &'q Queue<LEN>) -> Self {
        Producer { queue, borrowed: PhantomData }
    }

    #[inline(always)]
    fn queue(&self) -> &'q Queue<LEN> {
        // SAFETY: it was made of such a reference.
        unsafe { &*self.queue }
    }

    /// Appends a run.
    ///
    /// # Errors
    /// Gives the run back when the queue is full.
    pub fn push(&mut self, run: Run) -> Result<(), Run> {
        if self.is_full() {
            return Err(run);
        }
        let at = self.queue().pushed.get();
        // SAFETY: the slot is free and only this producer fills slots.
        unsafe { self.queue().slot(at).write(Slot::of(&run)) };
        self.queue().pushed.set(at.wrapping_add(1));
        Ok(())
    }

    /// Whether there is no room.
    pub fn is_full(&self) -> bool {
        usize::from(self.queue().len()) >= LEN
    }

    /// Runs that the interrupt has not taken yet.
    pub fn len(&self) -> u8 {
        self.queue().len()
    }

    /// Runs pushed since the beginning, modulo 256.
    pub(crate) fn pushed(&self) -> u8 {
        self.queue().pushed.get()
    }

    /// Whether the interrupt has taken every run.
    pub fn is_empty(&self) -> bool {
        self.queue().len() == 0
    }

    /// Says that more runs will follow, or that these are all.
    pub fn set_open(&mut self, open: bool) {
        self.queue().open.set(open.into());
    }
}

/// The interrupt's end of a [`Queue`].
///
/// A run is played where it lies: its slot is free again when the next one is
/// asked for.
pub struct Consumer<'q, const LEN: usize> {
    queue: &'q Queue<LEN>,
    /// The first slot is being played.
    held: bool,
}

impl<const LEN: usize> Feed for Consumer<'_, LEN> {
    fn take(&mut self) -> Taken {
        let mut own = Slot::EMPTY;
        match self.fetch(&mut own) {
            Fetched::Run => {
                let run = self.playing(&mut own).run();
                self.release();
                Taken::Run(run)
            }
            Fetched::Late => Taken::Late,
            Fetched::End => Taken::End,
        }
    }

    fn clear(&mut self) {
        self.held = false;
        let pushed = self.queue.pushed.get();
        self.queue.taken.set(pushed);
    }

    #[inline]
    fn fetch(&mut self, _: &mut Slot) -> Fetched {
        self.release();
        // Whether more is to come is read before the length: a producer closes
        // after its last push.
        let open = self.queue.open.get() != 0;
        if self.queue.len() == 0 {
            return if open { Fetched::Late } else { Fetched::End };
        }
        self.held = true;
        Fetched::Run
    }

    #[inline(always)]
    fn playing<'a>(&'a mut self, own: &'a mut Slot) -> &'a mut Slot {
        if !self.held {
            return own;
        }
        // SAFETY: the slot is filled and not given back, so the producer leaves
        // it alone; the borrow of the only consumer keeps it from being given
        // back meanwhile.
        unsafe { &mut *self.first() }
    }

    fn left(&self, own: &Slot) -> u16 {
        if !self.held {
            return own.left();
        }
        // SAFETY: as in `playing`.
        unsafe { &*self.first() }.left()
    }
}

impl<const LEN: usize> Consumer<'_, LEN> {
    #[inline(always)]
    fn first(&self) -> *mut Slot {
        self.queue.slot(self.queue.taken.get())
    }

    /// Gives the slot back that has been played.
    #[inline]
    fn release(&mut self) {
        if core::mem::take(&mut self.held) {
            let at = self.queue.taken.get();
            self.queue.taken.set(at.wrapping_add(1));
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    extern crate std;
    use super::*;
    use std::boxed::Box;
    use std::cell::RefCell;

    std::thread_local! {
        /// What the other side does before the next read of a shared byte.
        static MEANWHILE: RefCell<Option<Box<dyn FnMut()>>> = const { RefCell::new(None) };
    }

    pub(in crate::queue) fn before_a_read() {
        // Taken out while it runs: its own reads interrupt nothing.
        if let Some(mut side) = MEANWHILE.take() {
            side();
            MEANWHILE.set(Some(side));
        }
    }

    #[test]
    fn a_last_run_is_taken_whenever_it_comes() {
        // A producer pushes its last run before the read number `push` of a
        // consumer, and closes before the read number `close`.
        const READS: u32 = 12;
        for push in 0..READS {
            for close in push..READS {
                let queue = Box::leak(Box::new(Queue::<2>::new()));
                let (mut producer, mut consumer) = queue.split();
                producer.set_open(true);
                let mut read = 0;
                MEANWHILE.set(Some(Box::new(move || {
                    if read == push {
                        producer.push(Run::steady(7, 3)).unwrap();
                    }
                    if read == close {
                        producer.set_open(false);
                    }
                    read += 1;
                })));
                let mut runs = 0;
                // Two reads at least for each: by then both have happened.
                for _ in 0..=READS / 2 {
                    match consumer.take() {
                        Taken::Run(run) => {
                            assert_eq!(run, Run::steady(7, 3));
                            runs += 1;
                        }
                        Taken::Late => {}
                        Taken::End => break,
                    }
                }
                MEANWHILE.take();
                assert_eq!(runs, 1, "pushed before read {push}, closed before {close}");
                assert_eq!(consumer.take(), Taken::End);
            }
        }
    }

    #[test]
    fn full_empty_and_wrapped() {
        let mut queue = Queue::<4>::new();
        let (mut producer, mut consumer) = queue.split();
        for round in 0..1000u32 {
            for k in 0..4 {
                producer.push(Run::steady(round * 4 + k, 1)).unwrap();
            }
            assert!(producer.push(Run::steady(9, 9)).is_err());
            for k in 0..4 {
                assert_eq!(consumer.take(), Taken::Run(Run::steady(round * 4 + k, 1)));
            }
            assert_eq!(consumer.take(), Taken::End);
        }
    }

    #[test]
    fn an_open_queue_is_late_not_ended() {
        let mut queue = Queue::<2>::new();
        let (mut producer, mut consumer) = queue.split();
        producer.set_open(true);
        assert_eq!(consumer.take(), Taken::Late);
        producer.push(Run::steady(1, 1)).unwrap();
        producer.set_open(false);
        consumer.clear();
        assert_eq!(consumer.take(), Taken::End);
        assert!(producer.is_empty());
    }

    #[test]
    fn threads_lose_and_invent_nothing() {
        let mut queue = Queue::<8>::new();
        let (mut producer, mut consumer) = queue.split();
        producer.set_open(true);
        std::thread::scope(|scope| {
            scope.spawn(move || {
                for n in 0..200_000u32 {
                    let mut run = Run::steady(n, n as u16 | 1);
                    while let Err(back) = producer.push(run) {
                        run = back;
                        std::hint::spin_loop();
                    }
                }
                producer.set_open(false);
            });
            let mut want = 0u32;
            loop {
                match consumer.take() {
                    Taken::Run(run) => {
                        assert_eq!(run, Run::steady(want, want as u16 | 1));
                        want += 1;
                    }
                    Taken::Late => std::hint::spin_loop(),
                    Taken::End => break,
                }
            }
            assert_eq!(want, 200_000);
        });
    }
}
