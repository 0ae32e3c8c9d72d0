//! A player whose tick is several ticks of another player.

use stepwright::drive::Axes;
use stepwright::{Ticks, Timing};
use stepwright_sink::{Halted, Player, StepGroup};

/// A player whose tick is 2^`SHIFT` ticks of the inner player.
pub struct Divided<P, const SHIFT: u32>(pub P);

impl<P: Player, const SHIFT: u32> Player for Divided<P, SHIFT> {
    const DEPTH: u8 = P::DEPTH;
    const LAG: Ticks = (P::LAG >> SHIFT) + 1;

    #[inline(always)]
    fn now(&self) -> u64 {
        self.0.now() >> SHIFT
    }

    fn set_timing(&mut self, timing: &Timing) {
        let Timing { pulse, setup, hold, min_interval } = *timing;
        let [pulse, setup, hold, min_interval] =
            [pulse, setup, hold, min_interval].map(|ticks| ticks << SHIFT);
        self.0.set_timing(&Timing { pulse, setup, hold, min_interval });
    }

    #[inline(always)]
    fn has_room(&self, axis: u8) -> bool {
        self.0.has_room(axis)
    }

    #[inline(always)]
    fn put(&mut self, axis: u8, group: StepGroup) {
        // Less than 2^24 ticks, even for a wait of some seconds: it is split into 8 ms.
        self.0.put(axis, StepGroup { interval: group.interval << SHIFT, ..group });
    }

    fn start(&mut self, axes: Axes) {
        self.0.start(axes);
    }

    #[inline(always)]
    fn waiting(&self, axis: u8) -> u8 {
        self.0.waiting(axis)
    }

    #[inline(always)]
    fn rests(&self, axis: u8) -> bool {
        self.0.rests(axis)
    }

    #[inline(always)]
    fn ran_dry(&mut self, axis: u8) -> bool {
        self.0.ran_dry(axis)
    }

    fn halt(&mut self, axes: Axes) {
        self.0.halt(axes);
    }

    fn forget(&mut self, axis: u8) -> Halted {
        self.0.forget(axis)
    }
}
