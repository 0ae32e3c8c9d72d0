//! What an interrupt handler in assembly knows of an [`Engine`], and how it calls it:
//! see `direct/short.rs`.
//!
//! After a step such a handler looks at the timer. What is behind by 3,072 ticks
//! slips: the handler looks 0x7000 ticks ahead in a 16-bit counter, and so no further
//! back than 0x1000.

use super::Engine;
use super::late::FAR_BEHIND;
use super::track::Track;
use crate::drive::Drive;
use crate::queue::Feed;
use crate::stride::{LOOK, Slot};
use crate::timer::StepTimer;
use core::mem::{offset_of, size_of};

/// In `ended`: an axis is too far behind.
const BEHIND: u8 = 0x80;

/// Where things lie, for [`direct_way!`](crate::direct_way).
impl<T, D, F, const N: usize> Engine<T, D, F, N>
where
    T: StepTimer<Count = u16>,
    D: Drive,
    F: Feed,
{
    #[doc(hidden)]
    pub const TRACKS: usize = offset_of!(Self, tracks);
    #[doc(hidden)]
    pub const TRACK: usize = size_of::<Track<u16>>();
    #[doc(hidden)]
    pub const OWN: usize = offset_of!(Track<u16>, own);
    /// Where the feeds lie.
    pub(crate) const FEEDS_AT: usize = offset_of!(Self, feeds);
    #[doc(hidden)]
    pub const ENDED: usize = offset_of!(Self, ended);
    #[doc(hidden)]
    pub const LATE: usize = offset_of!(Self, late);
    #[doc(hidden)]
    pub const FAR_BEHIND: i32 = FAR_BEHIND >> 8;
    #[doc(hidden)]
    pub const AXES: usize = N;

    const LAYOUT: () = {
        assert!(offset_of!(Track<u16>, at) == 4 && offset_of!(Track<u16>, loaded) == 6);
        assert!(size_of::<Slot>() == 13 && N <= 3);
    };

    /// The long way, from the short one: what that could not do. If a run has
    /// ended, `look` is the timer `LOOK` ticks after its last edge.
    pub fn on_long_way(&mut self, look: u16) {
        let () = Self::LAYOUT;
        let ended = core::mem::take(&mut self.ended);
        if ended != 0 {
            let edge = look.wrapping_sub(LOOK as u16);
            let mut axes = ended;
            for axis in 0..N {
                if axes & 1 != 0 {
                    self.finish(axis, edge);
                }
                axes >>= 1;
            }
            if ended & BEHIND != 0 {
                self.slip();
            }
        }
        self.on_compare();
    }
}
