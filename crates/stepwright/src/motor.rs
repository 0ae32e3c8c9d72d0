//! One axis, seen from the foreground: plans runs ahead of the interrupt.

use crate::order::{Order, Refusal};
use crate::planner::{Clock, Planned, Planner, Work};
use crate::queue::Producer;
use crate::run::Run;
use crate::units::Ticks;

/// The planner of one axis: lays a travel out and keeps its queue filled.
///
/// Plans until the queue is full, or what is queued lasts for the board's
/// horizon: so a change of mind is obeyed after that time and one run (at most
/// 8 ms by default), or one step if that takes longer.
pub(crate) struct Motor<const Q: usize> {
    planner: Planner,
    /// A travel is laid out, and not yet planned to its end.
    planning: bool,
    /// Direction of what is queued last, and of the prepared travel.
    forward: bool,
    next_forward: bool,
    /// Durations of the last Q runs pushed, by push number, in the units of
    /// [`Horizon`].
    spans: [u8; Q],
    pushed: u8,
}

/// How far ahead to plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Horizon {
    /// Ticks in a unit, as a power of two.
    unit: u8,
    /// 64 … 127 units; fewer for a horizon of fewer ticks.
    units: u16,
}

impl Horizon {
    pub(crate) const fn new(ticks: Ticks) -> Horizon {
        let unit = 25u32.saturating_sub(ticks.leading_zeros()) as u8;
        Horizon { unit, units: (ticks >> unit) as u16 }
    }
}

impl<const Q: usize> Motor<Q> {
    pub(crate) const IDLE: Self = Motor {
        planner: Planner::IDLE,
        planning: false,
        forward: true,
        next_forward: true,
        spans: [0; Q],
        pushed: 0,
    };

    /// Lays out a travel of at least one pulse, and gives its highest speed
    /// in 0.001 steps/s. It waits for [`begin`](Motor::begin); the motor must be idle.
    ///
    /// # Errors
    /// [`Refusal::Unfit`] if the timer can't hold it.
    pub(crate) fn prepare(&mut self, clock: &Clock, order: &Order) -> Result<u32, Refusal> {
        self.planner.lay_out(clock, order)?;
        self.planning = true;
        self.next_forward = order.travel.forward();
        Ok(self.planner.peak())
    }

    /// Queues the beginning of the prepared travel: the change of direction
    /// if there is one, then the first pulse `hold + lead` ticks after the
    /// start. The queue must be empty.
    pub(crate) fn begin(&mut self, feed: &mut Producer<'_, Q>, wait: Wait, horizon: &Horizon) {
        let forward = self.next_forward;
        feed.set_open(true);
        let mut lead = wait.lead;
        // A long wait is a turn too, if only to the same side: so the first step
        // is always near, and costs a chip no more than the others.
        if forward != self.forward || wait.hold > lead {
            self.push(feed, Run::turn(wait.hold, forward), wait.hold, horizon);
        } else {
            lead = lead.saturating_add(wait.hold);
        }
        self.forward = forward;
        // Half a tick ahead from here on: deadlines rounded down are rounded to
        // the nearest.
        let first = u64::from(lead) << 16 | 1 << 15;
        self.push(feed, Run::new(first, 0, 1), lead, horizon);
    }

    /// Forgets a prepared travel that was not begun.
    pub(crate) fn forget(&mut self) {
        self.planning = false;
    }

    /// Appends a run that lasts for so many ticks.
    fn push(&mut self, feed: &mut Producer<'_, Q>, run: Run, ticks: Ticks, horizon: &Horizon) {
        let span = u8::try_from(ticks >> horizon.unit).unwrap_or(u8::MAX);
        if feed.push(run).is_ok() {
            if let Some(slot) = self.spans.get_mut(usize::from(self.pushed) & (Q - 1)) {
                *slot = span;
            }
            self.pushed = self.pushed.wrapping_add(1);
        }
    }

    /// How long what is queued lasts, in units.
    fn ahead(&self, feed: &Producer<'_, Q>) -> u16 {
        let mut sum = 0u16;
        for back in 1..=feed.len() {
            let at = usize::from(self.pushed.wrapping_sub(back)) & (Q - 1);
            sum = sum.saturating_add(self.spans.get(at).copied().unwrap_or(0).into());
        }
        sum
    }

    /// Does a piece of planning, if a run is wanted.
    pub(crate) fn plan(
        &mut self,
        feed: &mut Producer<'_, Q>,
        clock: &Clock,
        work: &mut Work,
        horizon: &Horizon,
    ) -> Progress {
        if !self.planning || feed.is_full() || (feed.len() > 1 && self.ahead(feed) >= horizon.units)
        {
            return Progress::Nothing;
        }
        let mut run = Run::steady(0, 0);
        match self.planner.next(clock, work, &mut run) {
            Planned::Run(ticks) => self.push(feed, run, ticks, horizon),
            Planned::Again => return Progress::Midway,
            Planned::End => self.finish(feed),
        }
        Progress::Done
    }

    fn finish(&mut self, feed: &mut Producer<'_, Q>) {
        self.planning = false;
        feed.set_open(false);
    }

    /// Brakes from the end of what is queued.
    pub(crate) fn brake(&mut self) {
        self.planner.brake();
    }

    /// Forgets the travel; the engine has been halted.
    pub(crate) fn abandon(&mut self, feed: &mut Producer<'_, Q>, forward: bool) {
        self.finish(feed);
        self.forward = forward;
    }

    /// Whether its travel leads forward.
    pub(crate) fn is_forward(&self) -> bool {
        self.forward
    }

    /// Whether it goes on until it is stopped.
    pub(crate) fn is_endless(&self) -> bool {
        self.planning && self.planner.is_endless()
    }

    /// Whether there is still something to plan.
    pub(crate) fn planning(&self) -> bool {
        self.planning
    }
}

/// What a motor's turn at planning has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// There was nothing to do.
    Nothing,
    /// A run is half planned: it is this motor's turn again.
    Midway,
    /// A run is planned, or the travel to its end.
    Done,
}

/// Times before a travel's first pulse, in ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Wait {
    /// Before a change of direction.
    pub hold: Ticks,
    /// After it, before the first pulse.
    pub lead: Ticks,
}
