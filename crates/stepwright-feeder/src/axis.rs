//! The moments of one axis, and the records made of them.

use std::collections::VecDeque;

use stepwright_stream::fit::{EntryFitter, FitTerms, Moment, What};
use stepwright_stream::record::Record;

use crate::fine;

/// The least time from a turn or a wait to the next step: what step interrupts need, and a margin.
const CALM: u64 = fine(1_250);
/// How long DIR stays unchanged after a step.
const HOLD: u64 = fine(40);

/// An axis of a run.
#[derive(Clone, Debug)]
pub(crate) struct AxisFeed {
    /// The moments, and for each the time of the step that caused it. The first `made` are in records already;
    /// they are kept in case a cut takes these records back.
    moments: VecDeque<Moment>,
    asked: VecDeque<u64>,
    made: usize,
    /// The number of moments that were dropped.
    gone: u64,
    fitter: EntryFitter,
    forward: bool,
    shortest: u64,
    /// The delay of this axis against the first one.
    shift: u64,
    /// Pairs of a step and the same step back that cancelled each other: when both were asked for.
    pairs: VecDeque<[u64; 2]>,
    over: bool,
}

/// The state of an axis between two records.
#[derive(Clone, Debug)]
pub(crate) struct AxisMark {
    fitter: EntryFitter,
    /// The number of the moment that is due.
    moment: u64,
}

impl AxisMark {
    /// When the next record starts.
    pub(crate) fn start(&self) -> u64 {
        self.fitter.played()
    }
}

impl AxisFeed {
    pub(crate) fn new(terms: FitTerms, shift: u64) -> AxisFeed {
        AxisFeed {
            moments: VecDeque::from([Moment { at: 0, what: What::Nothing }]),
            asked: VecDeque::from([0]),
            made: 0,
            gone: 0,
            fitter: EntryFitter::new(terms),
            forward: true,
            shortest: u64::from(terms.shortest) << 8,
            shift,
            pairs: VecDeque::new(),
            over: false,
        }
    }

    pub(crate) fn set_terms(&mut self, terms: FitTerms) {
        self.fitter.set_terms(terms);
    }

    /// When the next record starts, in 2⁻⁸ ticks.
    pub(crate) fn start(&self) -> u64 {
        self.fitter.played()
    }

    /// The last known moment, no earlier than the end of the records.
    fn last(&self) -> Moment {
        let start = self.start();
        let last = self.moments.back().map(|last| Moment { at: last.at.max(start), ..*last });
        last.unwrap_or(Moment { at: start, what: What::Nothing })
    }

    /// The number of moments that are in no record yet, including the one that is due.
    fn left(&self) -> usize {
        self.moments.len() - self.made
    }

    fn push(&mut self, at: u64, what: What, asked: u64) {
        self.moments.push_back(Moment { at, what });
        self.asked.push_back(asked);
    }

    fn pop(&mut self) -> u64 {
        self.moments.pop_back();
        self.asked.pop_back().unwrap_or(0)
    }

    /// Adds a step at this time, or a little later where that is too soon after the last moment. A step and the
    /// same step back cancel each other if they are closer together than a turn takes.
    pub(crate) fn step(&mut self, asked: u64, forward: bool) {
        let at = asked + self.shift;
        let last = self.last();
        if forward != self.forward {
            let before = self.asked.back().copied().unwrap_or(0) + self.shift;
            let close = at.saturating_sub(before) < 2 * CALM;
            if close && last.what == What::Step && self.left() > 1 {
                let first = self.pop();
                if self.last().what == What::Turn && self.left() > 1 {
                    self.pop();
                    self.forward = !self.forward;
                }
                self.pairs.push_back([first, asked]);
                return;
            }
            // DIR turns in the middle between two steps, if that leaves enough time on both sides.
            let middle = last.at + at.saturating_sub(last.at) / 2;
            let turn = middle.min(at.saturating_sub(CALM)).max(last.at + HOLD);
            let turn = if last.what == What::Step { turn } else { turn.max(last.at + CALM) };
            self.push(turn, What::Turn, asked);
            self.forward = forward;
        }
        let last = self.last();
        let least = if last.what == What::Step { self.shortest } else { CALM };
        self.push(at.max(last.at + least), What::Step, asked);
    }

    /// Ends the axis: there are no more steps, and the axis waits until this time, when all axes rest.
    pub(crate) fn end(&mut self, at: u64) {
        let last = self.last();
        self.push(at.max(last.at + 2 * CALM), What::End, at);
        self.over = true;
    }

    /// Adds a wait, as no step comes before `until`. It ends a little earlier, so that a step at `until` is on
    /// time, and lasts `most` at the longest.
    pub(crate) fn wait(&mut self, until: u64, most: u64) {
        let last = self.last();
        let at = (until + self.shift).saturating_sub(CALM).min(last.at + most);
        if !self.over && at > last.at + CALM {
            self.push(at, What::Nothing, until.min(at));
        }
    }

    /// Whether all moments up to `longest` after the start of the next record are known.
    pub(crate) fn is_known(&self, longest: u64) -> bool {
        self.over || self.left() > 1 && self.last().at > self.start() + longest
    }

    /// Whether the axis has ended and all its moments are in records.
    pub(crate) fn is_over(&self) -> bool {
        self.over && self.left() <= 1
    }

    /// Makes the next record; `None` at the end.
    pub(crate) fn record(&mut self) -> Option<Record> {
        let due = self.moments.make_contiguous().get(self.made..)?;
        let (record, played) = self.fitter.next(due)?;
        self.made += played;
        Some(record)
    }

    /// The present state, to come back to.
    pub(crate) fn mark(&self) -> AxisMark {
        AxisMark { fitter: self.fitter.clone(), moment: self.gone + self.made as u64 }
    }

    /// Drops moments that are in records before this mark.
    pub(crate) fn forget(&mut self, mark: &AxisMark) {
        let count = (mark.moment.saturating_sub(self.gone) as usize).min(self.made);
        self.moments.drain(..count);
        self.asked.drain(..count);
        (self.made, self.gone) = (self.made - count, self.gone + count as u64);
        let begin = mark.fitter.played();
        while self.pairs.front().is_some_and(|pair| pair[1] + CALM < begin) {
            self.pairs.pop_front();
        }
    }

    /// The soonest time from which on the axis can do something else if its records end at this mark: after
    /// the moment that is due there. An axis that `brakes` and is not due before `patience` needs no wait, as
    /// braking makes its next step no sooner.
    pub(crate) fn free_from(&self, mark: &AxisMark, patience: u64, brakes: bool) -> u64 {
        let due = mark.moment.saturating_sub(self.gone) as usize;
        let end = mark.fitter.played().saturating_sub(self.shift);
        let far = end > patience && brakes;
        // Steps in records before the mark will be made.
        let made = due.checked_sub(1).and_then(|last| self.asked.get(last));
        let made = made.map_or(0, |asked| asked + 1);
        let free = match self.moments.get(due) {
            Some(moment) if moment.what == What::Step && !mark.fitter.waits() && !far => {
                self.asked.get(due).map_or(end, |asked| end.max(asked + 1))
            }
            _ if brakes => 0,
            _ => end,
        };
        free.max(made)
    }

    /// The first time at or after `from` that separates no pair of cancelled steps.
    pub(crate) fn between_pairs(&self, from: u64) -> u64 {
        let split = self.pairs.iter().find(|pair| pair[0] < from && from <= pair[1]);
        split.map_or(from, |pair| self.between_pairs(pair[1] + 1))
    }

    /// Returns to this mark, and forgets the steps that were asked for at `end` and later.
    pub(crate) fn rewind(&mut self, mark: &AxisMark, end: u64) {
        self.fitter = mark.fitter.clone();
        self.made = mark.moment.saturating_sub(self.gone) as usize;
        let kept = self.asked.partition_point(|asked| *asked < end);
        // Moments that the records before the mark have played stay.
        let kept = kept.max(self.made + usize::from(self.fitter.waits()));
        // The end is taken back with any cut.
        let ends = end != u64::MAX && self.last().what == What::End;
        let kept = kept.min(self.moments.len() - usize::from(ends)).max(self.made);
        while self.moments.len() > kept {
            self.forward ^= self.last().what == What::Turn;
            self.over &= self.last().what != What::End;
            self.pop();
        }
        if self.left() == 0 {
            self.push(self.start(), What::Nothing, end);
        }
        while self.pairs.back().is_some_and(|pair| pair[0] >= end) {
            self.pairs.pop_back();
        }
    }
}
