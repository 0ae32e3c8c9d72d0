//! The moments of one axis, and the records that become of them.

use std::collections::VecDeque;

use stepwright_stream::fit::{EntryFitter, FitTerms, Moment, What};
use stepwright_stream::record::Record;

use crate::fine;

/// Ticks from a turn or a wait to the next step, at least: what step interrupts ask for, and a margin.
const CALM: u64 = fine(1_250);
/// Ticks that DIR stays after a step.
const HOLD: u64 = fine(40);

/// An axis of a run.
#[derive(Debug)]
pub(crate) struct AxisFeed {
    moments: VecDeque<Moment>,
    fitter: EntryFitter,
    forward: bool,
    shortest: u64,
    /// It comes this much later than the others.
    shift: u64,
    /// When its last step was to come.
    asked: u64,
    over: bool,
}

impl AxisFeed {
    pub(crate) fn new(terms: FitTerms, shift: u64) -> AxisFeed {
        AxisFeed {
            moments: VecDeque::from([Moment { at: 0, what: What::Nothing }]),
            fitter: EntryFitter::new(terms),
            forward: true,
            shortest: u64::from(terms.shortest) << 8,
            shift,
            asked: 0,
            over: false,
        }
    }

    pub(crate) fn set_terms(&mut self, terms: FitTerms) {
        self.fitter.set_terms(terms);
    }

    /// When its next record starts.
    pub(crate) fn start(&self) -> u64 {
        self.fitter.played()
    }

    fn last(&self) -> Moment {
        self.moments.back().copied().unwrap_or(Moment { at: self.start(), what: What::Nothing })
    }

    /// A step comes at this time, or a little later where that is too soon. A step and the same step
    /// back that are closer than a turn takes are none.
    pub(crate) fn step(&mut self, at: u64, forward: bool) {
        let at = at + self.shift;
        let last = self.last();
        if forward != self.forward {
            let close = at.saturating_sub(self.asked) < 2 * CALM;
            if close && last.what == What::Step && self.moments.len() > 1 {
                self.moments.pop_back();
                if self.last().what == What::Turn && self.moments.len() > 1 {
                    self.moments.pop_back();
                    self.forward = !self.forward;
                }
                self.asked = self.last().at;
                return;
            }
            // In the middle, so far as that leaves enough on both sides.
            let middle = last.at + at.saturating_sub(last.at) / 2;
            let turn = middle.min(at.saturating_sub(CALM)).max(last.at + HOLD);
            let turn = if last.what == What::Step { turn } else { turn.max(last.at + CALM) };
            self.moments.push_back(Moment { at: turn, what: What::Turn });
            self.forward = forward;
        }
        let last = self.last();
        let least = if last.what == What::Step { self.shortest } else { CALM };
        self.moments.push_back(Moment { at: at.max(last.at + least), what: What::Step });
        self.asked = at;
    }

    /// No more steps come: it waits until this time, when all axes rest.
    pub(crate) fn end(&mut self, at: u64) {
        let last = self.last();
        self.moments.push_back(Moment { at: at.max(last.at + 2 * CALM), what: What::End });
        self.over = true;
    }

    /// Nothing comes before this time: it waits until a little before that, so that a step which comes
    /// then is on time.
    pub(crate) fn wait(&mut self, until: u64) {
        let at = until.saturating_sub(CALM);
        if !self.over && at > self.last().at + CALM {
            self.moments.push_back(Moment { at, what: What::Nothing });
        }
    }

    /// Whether all is known up to `longest` behind its next record.
    pub(crate) fn is_known(&self, longest: u64) -> bool {
        self.over || self.moments.len() > 1 && self.last().at > self.start() + longest
    }

    /// Whether all became records.
    pub(crate) fn is_over(&self) -> bool {
        self.over && self.moments.len() <= 1
    }

    /// The next record.
    pub(crate) fn record(&mut self) -> Option<Record> {
        let (record, played) = self.fitter.next(self.moments.make_contiguous())?;
        self.moments.drain(..played);
        Some(record)
    }
}
