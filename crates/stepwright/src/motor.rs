//! One axis, seen from the foreground: plans runs ahead of the interrupt.

use crate::profile::path::Bounds;
use crate::profile::{Cursor, Fit, Path};
use crate::queue::Producer;
use crate::run::Run;
use crate::units::Ticks;

/// The planner of one axis: walks a path and keeps its queue filled.
///
/// Plans until the queue is full, or what is queued lasts for the board's
/// horizon: so a change of mind is obeyed after that time and one run (at most
/// 8 ms by default), or one step if that takes longer.
pub(crate) struct Motor<'q, const Q: usize> {
    feed: Producer<'q, Q>,
    cursor: Option<Cursor>,
    bounds: Option<Bounds>,
    forward: bool,
    /// Durations of the last Q runs pushed, by push number.
    spans: [Ticks; Q],
    pushed: u8,
}

impl<'q, const Q: usize> Motor<'q, Q> {
    pub(crate) fn new(feed: Producer<'q, Q>) -> Self {
        Motor { feed, cursor: None, bounds: None, forward: true, spans: [0; Q], pushed: 0 }
    }

    /// Queues the beginning of a travel along `path`: the change of direction
    /// if there is one, then the first pulse `hold + lead` ticks after the
    /// start. The queue must be empty and the path have a pulse.
    pub(crate) fn begin(
        &mut self,
        path: Path,
        bounds: Bounds,
        forward: bool,
        wait: Wait,
        fit: Fit,
    ) {
        self.feed.set_open(true);
        let mut lead = wait.lead;
        if forward != self.forward {
            self.push(Run::turn(wait.hold, forward));
        } else {
            lead = lead.saturating_add(wait.hold);
        }
        self.forward = forward;
        self.push(Run::steady(lead, 1));
        self.cursor = Some(Cursor::new(path, fit));
        self.bounds = Some(bounds);
    }

    fn push(&mut self, run: Run) {
        let span = u32::try_from(run.duration() >> 16).unwrap_or(Ticks::MAX);
        if self.feed.push(run).is_ok() {
            if let Some(slot) = self.spans.get_mut(usize::from(self.pushed) & (Q - 1)) {
                *slot = span;
            }
            self.pushed = self.pushed.wrapping_add(1);
        }
    }

    /// How long what is queued lasts.
    fn ahead(&self) -> Ticks {
        let mut sum = 0u32;
        for back in 1..=self.feed.len() {
            let at = usize::from(self.pushed.wrapping_sub(back)) & (Q - 1);
            sum = sum.saturating_add(self.spans.get(at).copied().unwrap_or(0));
        }
        sum
    }

    /// Plans one run, if one is wanted. False if there was nothing to do.
    pub(crate) fn plan(&mut self, horizon: Ticks) -> bool {
        if self.feed.is_full() || (self.feed.len() > 1 && self.ahead() >= horizon) {
            return false;
        }
        let Some(cursor) = &mut self.cursor else { return false };
        match cursor.next() {
            Some(run) => self.push(run),
            None => self.finish(),
        }
        true
    }

    fn finish(&mut self) {
        self.cursor = None;
        self.feed.set_open(false);
    }

    /// Brakes from the end of what is queued.
    pub(crate) fn brake(&mut self) {
        if let (Some(cursor), Some(bounds)) = (&mut self.cursor, &self.bounds) {
            let stop = Path::stop(bounds, cursor.speed_squared());
            cursor.change(stop);
        }
    }

    /// Forgets the travel; the engine has been halted.
    pub(crate) fn abandon(&mut self, forward: bool) {
        self.finish();
        self.forward = forward;
    }

    /// Whether its travel leads forward.
    pub(crate) fn is_forward(&self) -> bool {
        self.forward
    }

    /// Whether it goes on until it is stopped.
    pub(crate) fn is_endless(&self) -> bool {
        self.cursor.as_ref().is_some_and(|cursor| cursor.path().is_endless())
    }

    /// Whether there is still something to plan.
    pub(crate) fn planning(&self) -> bool {
        self.cursor.is_some()
    }
}

/// Times before a travel's first pulse, in ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Wait {
    /// Before a change of direction.
    pub hold: Ticks,
    /// After it, before the first pulse.
    pub lead: Ticks,
}
