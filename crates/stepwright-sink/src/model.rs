//! A model of a player, in simulated time.

use stepwright::drive::Axes;
use stepwright::{Ticks, Timing};

use crate::engine::SinkEngine;
use crate::group::StepGroup;
use crate::player::{Halted, Player};

/// An edge of a model's pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelEdge {
    /// The time, in ticks.
    pub at: u64,
    /// The axis.
    pub axis: u8,
    /// STEP rose, with DIR at this level; `None`: DIR changed.
    pub step: Option<bool>,
}

/// The depth of the FIFO, as on an RP2040.
const DEPTH: usize = 4;

/// A player of N axes that keeps the contract to the tick. Time passes only in
/// [`pass`](ModelPlayer::pass), or in [`pass`](SinkEngine::pass) of its engine. It hands its edges to a
/// function.
pub struct ModelPlayer<const N: usize, F = fn(ModelEdge)> {
    now: u64,
    pulse: Ticks,
    axes: [ModelAxis; N],
    edge: F,
}

#[derive(Clone, Copy)]
struct ModelAxis {
    running: bool,
    /// The waiting groups, the oldest first.
    fifo: [StepGroup; DEPTH],
    waiting: u8,
    /// The steps of the present group that are still to come, and its interval.
    left: u32,
    interval: Ticks,
    /// When the last step rose, or the axis started.
    last: u64,
    /// Whether a step has been made since the start.
    stepped: bool,
    dir: bool,
    dry: bool,
}

const NONE: StepGroup = StepGroup { interval: 1, steps: 0, forward: true };

impl ModelAxis {
    const AT_REST: ModelAxis = ModelAxis {
        running: false,
        fifo: [NONE; DEPTH],
        waiting: 0,
        left: 0,
        interval: 1,
        last: 0,
        stepped: false,
        dir: true,
        dry: false,
    };

    /// The end of the last pulse, of `pulse` ticks.
    fn over(&self, pulse: Ticks) -> u64 {
        if self.stepped { self.last.saturating_add(pulse.into()) } else { self.last }
    }

    /// The time of the next event: a group that begins, or a step.
    fn next(&self, pulse: Ticks) -> Option<u64> {
        if !self.running {
            None
        } else if self.left != 0 {
            Some(self.last.saturating_add(self.interval.into()))
        } else if self.waiting != 0 {
            Some(self.over(pulse))
        } else {
            None
        }
    }

    /// Begins the oldest group.
    fn begin(&mut self) -> StepGroup {
        let [first, second, third, fourth] = self.fifo;
        self.fifo = [second, third, fourth, NONE];
        self.waiting = self.waiting.saturating_sub(1);
        (self.left, self.interval) = (first.steps, first.interval);
        first
    }
}

impl<const N: usize> Default for ModelPlayer<N> {
    /// A model that drops its edges.
    fn default() -> Self {
        ModelPlayer::new(|_| {})
    }
}

impl<const N: usize, F: FnMut(ModelEdge)> ModelPlayer<N, F> {
    /// A model at rest, at time 0. `edge` gets the edges of each axis in order.
    pub fn new(edge: F) -> ModelPlayer<N, F> {
        ModelPlayer { now: 0, pulse: 1, axes: [ModelAxis::AT_REST; N], edge }
    }

    /// Lets time pass up to `end`, or until a group begins. Returns whether a group began.
    pub fn pass_to(&mut self, end: u64) -> bool {
        loop {
            let mut first: Option<(u64, u8)> = None;
            for (axis, own) in (0u8..).zip(&self.axes) {
                if let Some(at) = own.next(self.pulse)
                    && first.is_none_or(|(earliest, _)| at < earliest)
                {
                    first = Some((at, axis));
                }
            }
            let Some((at, axis)) = first.filter(|(at, _)| *at <= end) else {
                self.now = self.now.max(end);
                self.look_for_dry();
                return false;
            };
            self.now = self.now.max(at);
            self.look_for_dry();
            let now = self.now;
            let Some(own) = self.axes.get_mut(usize::from(axis)) else { return false };
            if own.left == 0 {
                let group = own.begin();
                if own.dir != group.forward {
                    own.dir = group.forward;
                    (self.edge)(ModelEdge { at: now, axis, step: None });
                }
                return true;
            }
            own.left -= 1;
            (own.last, own.stepped) = (at, true);
            (self.edge)(ModelEdge { at, axis, step: Some(own.dir) });
        }
    }

    /// Marks the axes that have had nothing to play since the end of their last pulse.
    fn look_for_dry(&mut self) {
        for own in &mut self.axes {
            if own.running && own.left == 0 && own.waiting == 0 && own.over(self.pulse) < self.now {
                own.dry = true;
            }
        }
    }

    /// Lets this many ticks pass without new groups.
    pub fn pass(&mut self, ticks: Ticks) {
        let end = self.now.saturating_add(ticks.into());
        while self.pass_to(end) {}
    }
}

impl<const N: usize, F: FnMut(ModelEdge)> Player for ModelPlayer<N, F> {
    const DEPTH: u8 = DEPTH as u8;
    const LAG: Ticks = 0;

    fn now(&self) -> u64 {
        self.now
    }

    fn set_timing(&mut self, timing: &Timing) {
        self.pulse = timing.pulse;
    }

    fn has_room(&self, axis: u8) -> bool {
        self.axes.get(usize::from(axis)).is_some_and(|own| usize::from(own.waiting) < DEPTH)
    }

    fn put(&mut self, axis: u8, group: StepGroup) {
        let Some(own) = self.axes.get_mut(usize::from(axis)) else { return };
        // The axis may have stood still until now.
        if own.running && own.left == 0 && own.waiting == 0 && own.over(self.pulse) < self.now {
            (own.last, own.stepped) = (self.now, false);
        }
        if let Some(place) = own.fifo.get_mut(usize::from(own.waiting)) {
            *place = group;
            own.waiting += 1;
        }
    }

    fn start(&mut self, axes: Axes) {
        for (axis, own) in self.axes.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                (own.running, own.stepped, own.dry, own.last) = (true, false, false, self.now);
            }
        }
    }

    fn waiting(&self, axis: u8) -> u8 {
        self.axes.get(usize::from(axis)).map_or(0, |own| own.waiting)
    }

    fn rests(&self, axis: u8) -> bool {
        self.axes
            .get(usize::from(axis))
            .is_none_or(|own| own.waiting == 0 && own.left == 0 && own.over(self.pulse) <= self.now)
    }

    fn ran_dry(&mut self, axis: u8) -> bool {
        let Some(own) = self.axes.get_mut(usize::from(axis)) else { return false };
        core::mem::take(&mut own.dry)
    }

    fn halt(&mut self, axes: Axes) {
        for (axis, own) in self.axes.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                // (The rest of a pulse takes no time.)
                (own.running, own.stepped, own.last) = (false, false, self.now);
            }
        }
    }

    fn forget(&mut self, axis: u8) -> Halted {
        let Some(own) = self.axes.get_mut(usize::from(axis)) else {
            return Halted { waiting: 0, left: 0 };
        };
        let halted = Halted { waiting: own.waiting, left: own.left };
        (own.waiting, own.left) = (0, 0);
        halted
    }
}

impl<F: FnMut(ModelEdge), const N: usize, const Q: usize> SinkEngine<'_, ModelPlayer<N, F>, N, Q> {
    /// Lets this many ticks pass. The player plays, and its interrupt serves it whenever a group begins.
    pub fn pass(&mut self, ticks: Ticks) {
        let end = self.player().now().saturating_add(ticks.into());
        self.catch_up();
        while self.player().pass_to(end) {
            self.serve(Axes::MAX);
        }
        self.catch_up();
    }
}
