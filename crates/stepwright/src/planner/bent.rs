//! Numbers that only bent ramps need: without S-curves they take no memory.

use core::ops::{Deref, DerefMut};

use crate::num::Num;

/// The number; empty without the feature `jerk`, where it is never read.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Bent(#[cfg(feature = "jerk")] Num);

impl Bent {
    /// The initial value of a number that is set before it is read.
    pub(super) const UNSET: Bent = Bent(
        #[cfg(feature = "jerk")]
        Num::UNSET,
    );
}

impl Deref for Bent {
    type Target = Num;

    #[inline(always)]
    fn deref(&self) -> &Num {
        #[cfg(feature = "jerk")]
        return &self.0;
        #[cfg(not(feature = "jerk"))]
        &Num::UNSET
    }
}

impl DerefMut for Bent {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Num {
        #[cfg(feature = "jerk")]
        return &mut self.0;
        // Not reached: `Planner::is_straight` is a constant.
        #[cfg(not(feature = "jerk"))]
        loop {
            core::hint::spin_loop();
        }
    }
}

/// Runs a second that bends need; empty without the feature `jerk`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Bends(#[cfg(feature = "jerk")] u16);

impl Bends {
    pub(crate) const NONE: Bends = Bends(
        #[cfg(feature = "jerk")]
        0,
    );

    #[inline(always)]
    pub(super) fn new(_runs: u16) -> Bends {
        Bends(
            #[cfg(feature = "jerk")]
            _runs,
        )
    }

    #[inline(always)]
    pub(crate) fn runs(self) -> u16 {
        #[cfg(feature = "jerk")]
        return self.0;
        #[cfg(not(feature = "jerk"))]
        0
    }
}
