//! The bytes between a board's link and its decoder.
//!
//! ```text
//!   take ──► whole frames ──► put ──► bytes of the frame that comes ──► …
//! ```
//!
//! A frame counts only after its checksum was right. A frame without room, as a damaged or repeated frame may
//! be, overwrites no byte that has not been read.

/// A FIFO of `LEN` bytes: 64 to 32,768.
#[derive(Clone, Debug)]
pub struct Fifo<const LEN: usize> {
    bytes: [u8; LEN],
    /// The place of the oldest byte.
    take: u16,
    /// Bytes of whole frames.
    used: u16,
    /// The place of the next byte written.
    part: u16,
    /// Bytes of the incomplete frame; [`NO_ROOM`](Fifo::NO_ROOM) once one of them had no room.
    fresh: u16,
}

impl<const LEN: usize> Fifo<LEN> {
    const SIZE: u16 = {
        assert!(LEN >= 64 && LEN <= 32_768);
        LEN as u16
    };

    /// More than any FIFO has.
    const NO_ROOM: u16 = u16::MAX;

    /// An empty FIFO.
    pub const fn new() -> Fifo<LEN> {
        Fifo { bytes: [0; LEN], take: 0, used: 0, part: 0, fresh: 0 }
    }

    #[inline(always)]
    fn behind(at: u16) -> u16 {
        let at = at.wrapping_add(1);
        if at >= Self::SIZE { 0 } else { at }
    }

    fn plus(at: u16, bytes: u16) -> u16 {
        let sum = at.wrapping_add(bytes);
        if sum >= Self::SIZE { sum.wrapping_sub(Self::SIZE) } else { sum }
    }

    /// The number of bytes in whole frames.
    #[inline(always)]
    pub const fn used(&self) -> u16 {
        self.used
    }

    /// The number of bytes not in whole frames; the incomplete frame may take some of them.
    pub const fn free(&self) -> u16 {
        Self::SIZE.wrapping_sub(self.used)
    }

    /// Begins a frame, and forgets an incomplete one.
    pub fn begin(&mut self) {
        self.part = Self::plus(self.take, self.used);
        self.fresh = 0;
    }

    /// Adds a byte to the incomplete frame.
    #[inline(always)]
    pub fn write(&mut self, byte: u8) {
        let room = self.fresh < Self::SIZE.wrapping_sub(self.used);
        if room && let Some(place) = self.bytes.get_mut(usize::from(self.part)) {
            *place = byte;
            self.part = Self::behind(self.part);
            self.fresh = self.fresh.wrapping_add(1);
        } else {
            self.fresh = Self::NO_ROOM;
        }
    }

    /// Completes the frame; false if it had no room and is dropped.
    pub fn commit(&mut self) -> bool {
        let fits = self.fresh != Self::NO_ROOM;
        if fits {
            self.used = self.used.wrapping_add(self.fresh);
        }
        self.fresh = 0;
        fits
    }

    /// The byte `ahead` places after the oldest; 0 if there is none.
    #[inline(always)]
    pub fn peek(&self, ahead: u16) -> u8 {
        let at = usize::from(Self::plus(self.take, ahead));
        if ahead < self.used { self.bytes.get(at).copied().unwrap_or(0) } else { 0 }
    }

    /// Takes the oldest byte; 0 if there is none.
    #[inline(always)]
    pub fn read(&mut self) -> u8 {
        if self.used == 0 {
            return 0;
        }
        let byte = self.bytes.get(usize::from(self.take)).copied().unwrap_or(0);
        self.take = Self::behind(self.take);
        self.used = self.used.wrapping_sub(1);
        byte
    }

    /// Forgets all whole frames. An incomplete frame continues.
    pub fn forget(&mut self) {
        self.take = Self::plus(self.take, self.used);
        self.used = 0;
    }

    /// Keeps the first `keep` bytes of whole frames, and forgets the others and an incomplete frame.
    pub fn cut(&mut self, keep: u16) {
        self.used = self.used.min(keep);
        self.begin();
    }
}

impl<const LEN: usize> Default for Fifo<LEN> {
    fn default() -> Self {
        Fifo::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_without_room_leaves_what_is_there() {
        let mut fifo = Fifo::<64>::new();
        fifo.begin();
        (0..60).for_each(|byte| fifo.write(byte));
        assert!(fifo.commit());
        fifo.begin();
        (100..104).for_each(|byte| fifo.write(byte));
        fifo.write(104);
        // Room that comes after a byte was lost does not help.
        assert_eq!(fifo.read(), 0);
        fifo.write(105);
        assert!(!fifo.commit());
        assert_eq!((fifo.used(), fifo.free()), (59, 5));
        fifo.begin();
        (110..115).for_each(|byte| fifo.write(byte));
        assert!(fifo.commit());
        let all: Vec<u8> = (0..64).map(|_| fifo.read()).collect();
        assert_eq!(all, (1..60).chain(110..115).collect::<Vec<u8>>());
        assert_eq!((fifo.read(), fifo.used()), (0, 0));
    }

    #[test]
    fn what_is_cut_or_forgotten_leaves_the_rest() {
        let mut fifo = Fifo::<64>::new();
        for round in 0..40u8 {
            fifo.begin();
            (0..10).for_each(|byte| fifo.write(round + byte));
            assert!(fifo.commit());
            fifo.cut(7);
            fifo.begin();
            fifo.write(99);
            assert!(fifo.commit());
            assert_eq!((fifo.peek(0), fifo.peek(6), fifo.peek(7)), (round, round + 6, 99));
            fifo.begin();
            fifo.write(1);
            fifo.forget();
            fifo.write(2);
            assert!(fifo.commit());
            assert_eq!((fifo.read(), fifo.read(), fifo.used()), (1, 2, 0));
        }
    }
}
