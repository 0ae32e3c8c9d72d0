//! The planner without limits of jerk, for a chip that has no room for
//! curves: what it has in the place of `bent.rs`. An
//! order that names a jerk is refused.

use super::{Clock, Layout, Planned, Planner, Work};
use crate::num::Num;
use crate::profile::Unfit;
use crate::units::Jerk;

/// Nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bent;

impl Bent {
    pub(super) const NONE: Bent = Bent;

    pub(super) fn limit(&mut self, jerk: Option<Jerk>) -> Result<(), Unfit> {
        if jerk.is_some() { Err(Unfit::Jerk) } else { Ok(()) }
    }

    pub(super) fn can_start(&self, _: &Clock) -> bool {
        true
    }

    pub(super) fn ends(&self, _: &Num, _: &Num) -> bool {
        true
    }

    pub(super) fn is_again(&self) -> bool {
        false
    }
}

/// Never asked for.
impl Planner {
    #[inline(always)]
    pub(crate) fn is_bent(&self) -> bool {
        false
    }

    pub(super) fn divide_bent(&mut self, _: Layout, _: u32) -> Layout {
        Layout::Check
    }

    pub(super) fn goes_to(&mut self, _: &Work) {}

    pub(super) fn divide_again(&mut self) {}

    pub(super) fn go_on(&mut self, _: i32) {}

    pub(super) fn follow(&mut self, _: &Clock, _: &mut Work, _: bool) {}

    pub(super) fn bent_corner(&mut self, _: &Clock, _: &mut Work, _: bool) -> Planned {
        Planned::End
    }
}
