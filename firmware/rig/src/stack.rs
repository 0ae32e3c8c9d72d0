//! The depth of the stack, compared with the end of the statics below it.
//!
//! Two figures, of which the larger counts: the deepest byte that was written, and the deepest push
//! of the main program where it lets a step interrupt in, plus the deepest interrupt, whether the
//! two ever coincided or not.

use crate::silicon::Silicon;

/// The bytes that every firmware leaves free between its statics and its stack, in its worst case.
/// An interrupt of the line, which may nest in addition, takes fewer.
pub const RESERVE: u32 = 48;

/// The most that a push, a call and the entry of an interrupt take at once.
const PUSH: u16 = 6;

/// The stack pointer, instruction by instruction.
#[derive(Clone, Debug)]
pub(crate) struct Stack {
    /// The mask registers of the step timers.
    masks: Vec<u16>,
    /// The stack pointer after the previous instruction.
    last: u16,
    /// The stack pointer at the entry of the running interrupt.
    entry: Option<u16>,
    /// The deepest push of the main program where it lets a step interrupt in.
    open: u16,
    /// The deepest interrupt, in bytes.
    depth: u16,
}

impl Stack {
    /// For step timers with these numbers.
    pub(crate) fn new(timers: impl Iterator<Item = u8>) -> Stack {
        // TIMSK0 …
        let masks = timers.map(|number| 0x6E + u16::from(number)).collect();
        Stack { masks, last: 0, entry: None, open: u16::MAX, depth: 0 }
    }

    /// Called after an instruction. Only pushes count: a half-written pointer is ignored.
    pub(crate) fn look(&mut self, silicon: &Silicon, inside: bool) {
        let sp = silicon.sp();
        let pushed = self.last.wrapping_sub(sp);
        if !inside {
            self.entry = None;
        } else if self.entry.is_none() {
            self.entry = Some(self.last);
        }
        if (1..=PUSH).contains(&pushed) {
            match self.entry {
                Some(entry) => self.depth = self.depth.max(entry.saturating_sub(sp)),
                None => {
                    let lets = |mask: &u16| silicon.byte(*mask) != 0;
                    if silicon.interrupts() && self.masks.iter().any(lets) {
                        self.open = self.open.min(sp);
                    }
                }
            }
        }
        self.last = sp;
    }

    /// The bytes of the deepest push of the main program plus the deepest interrupt, for a RAM that
    /// ends at `end`.
    pub(crate) fn met(&self, end: u16) -> u32 {
        u32::from(end.saturating_sub(self.open)) + u32::from(self.depth)
    }
}
