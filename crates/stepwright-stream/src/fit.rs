//! The fitter: steps with times become records that cost a chip the fewest cycles within a tolerance.
//!
//! Among all records that begin with the due step and keep each of their steps within the tolerance, the
//! fitter takes the one with the fewest cycles per step on an 8-bit chip: 400 for a record, 200 for each of
//! its bytes, 200 for each of its groups. Errors do not add up: a record begins where the record before has
//! led, and is compared with the steps' own times.

use stepwright::Ticks;

use crate::record::{FAR, Record, RecordAct, RecordBytes, Trail};

/// An event on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// No event: an axis begins with it.
    Nothing,
    /// A step.
    Step,
    /// DIR turns.
    Turn,
    /// The axis rests from here on.
    End,
}

/// An event and its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// The time, in 2⁻⁸ ticks since the start.
    pub at: u64,
    /// The event.
    pub what: What,
}

/// The terms of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FitTerms {
    /// The largest deviation of a step from its time, in 2⁻⁸ ticks. Only a step that is due too soon after
    /// the last may deviate by more.
    pub tolerance: u32,
    /// The longest duration of a record of groups, in 2⁻⁸ ticks. A record of steps at one interval may last
    /// twice as long.
    pub longest: u32,
    /// The shortest wait, in ticks.
    pub shortest: Ticks,
    /// The longest wait of one record for a next step, in 2⁻⁸ ticks. Other waits last
    /// [`longest`](FitTerms::longest) at most, so that an axis that rests can soon get other orders.
    pub patience: u32,
}

/// The longest part of a wait, and the longest wait of a record, in 2⁻⁸ ticks.
const PART: u64 = 0x7D00 << 8;
const MOST: u64 = PART << 7;

/// Makes records from the moments of an axis.
#[derive(Clone, Debug)]
pub struct EntryFitter {
    terms: FitTerms,
    /// When the due event is played, in 2⁻⁸ ticks since the start.
    played: u64,
    trail: Trail,
    /// The due event has happened, and a remainder of its wait is left.
    waits: bool,
}

impl EntryFitter {
    /// A fitter at the start of a stream.
    pub const fn new(terms: FitTerms) -> EntryFitter {
        EntryFitter { terms, played: 0, trail: Trail::NONE, waits: false }
    }

    /// Changes the terms for the records to come.
    pub const fn set_terms(&mut self, terms: FitTerms) {
        self.terms = terms;
    }

    /// The start of the next record, in 2⁻⁸ ticks since the start of the stream.
    pub const fn played(&self) -> u64 {
        self.played
    }

    /// Whether the due event has happened, and a remainder of its wait is left.
    pub const fn waits(&self) -> bool {
        self.waits
    }

    /// The next record, and the number of moments that it plays. `moments` begins with the due moment. It has
    /// all moments up to twice [`longest`](FitTerms::longest) after that and one more, or all up to the end.
    /// `None` at the end, and while there is no second moment.
    pub fn next(&mut self, moments: &[Moment]) -> Option<(Record, usize)> {
        let [first, second, ..] = moments else { return None };
        if first.what == What::End {
            return None;
        }
        let shortest = u64::from(self.terms.shortest) << 8;
        let wait = second.at.saturating_sub(self.played).max(shortest);
        // The last step is not played by this record: the record ends with the wait before it.
        let steps = moments.iter().take_while(|moment| moment.what == What::Step).count();
        let steps = steps.saturating_sub(1);
        if self.waits || steps == 0 || wait >= PART {
            let steps = first.what == What::Step && !self.waits;
            let most = if steps { self.terms.patience } else { self.terms.longest };
            let most = MOST.min(most.into()).max(shortest);
            return Some(self.single([first.what, second.what], wait, most, round_up(shortest)));
        }
        let record = self.best(moments, steps).unwrap_or(Record {
            // A single step, at any cost.
            act: RecordAct::Steps(1),
            interval: (wait.wrapping_add(8) as u32 & !15).max(round_up(shortest)),
            growth: 0,
        });
        self.pass(&record);
        Some((record, record.act.steps() as usize))
    }

    fn pass(&mut self, record: &Record) {
        self.played = self.played.saturating_add(record.time());
        self.trail.pass(record);
    }

    /// A record of one event and a wait of any length.
    fn single(&mut self, events: [What; 2], wait: u64, most: u64, least: u32) -> (Record, usize) {
        let ([what, next], whole) = (events, wait <= most);
        // A wait longer than `most` is divided: at most half of it now.
        let (mut part, mut halvings) = (if whole { wait } else { most.min(wait >> 1) }, 0u8);
        while part >= PART && halvings < 7 {
            part >>= 1;
            halvings = halvings.wrapping_add(1);
        }
        let turn = what == What::Turn && !self.waits;
        let act = if what == What::Step && !self.waits {
            RecordAct::Step { halvings, goes_on: whole && next == What::Step }
        } else {
            RecordAct::Wait { halvings, turn }
        };
        let interval = (part as u32).wrapping_add(8) & !15;
        let record = Record { act, interval: interval.max(least), growth: 0 };
        self.pass(&record);
        self.waits = !whole;
        (record, usize::from(whole))
    }

    /// The cheapest record of one or more steps within the tolerance. Records whose groups leave a chip the
    /// time to prepare the next group are preferred.
    fn best(&self, moments: &[Moment], steps: usize) -> Option<Record> {
        self.cheapest(moments, steps, true).or_else(|| self.cheapest(moments, steps, false))
    }

    fn cheapest(&self, moments: &[Moment], steps: usize, calm: bool) -> Option<Record> {
        let mut best: Option<(u64, u64, Record)> = None;
        for bits in
            [None, Some(0), Some(1), Some(2), Some(3), Some(4), Some(5), Some(6), Some(7), Some(8)]
        {
            let Some(record) = self.longest(moments, steps, bits) else { continue };
            if calm && !is_calm(&record) {
                continue;
            }
            let Some(bytes) = RecordBytes::new(0, &record, &self.trail) else { continue };
            let groups = match record.act {
                RecordAct::Groups { count, .. } => u64::from(count),
                _ => 1,
            };
            let cost = 400 + 200 * bytes.as_bytes().len() as u64 + 200 * groups;
            let made = u64::from(record.act.steps());
            if best.is_none_or(|(least, of, _)| cost * of < least * made) {
                best = Some((cost, made, record));
            }
        }
        best.map(|(_, _, record)| record)
    }

    /// The record with the most steps of a form: at one interval, or in groups of 2^bits. The count is found
    /// by doubling and halving: with few exceptions a record longer than one that does not fit does not fit
    /// either.
    fn longest(&self, moments: &[Moment], steps: usize, bits: Option<u8>) -> Option<Record> {
        let (unit, least, most) = match bits {
            None => (1, 1, 65_535),
            Some(bits) => (1usize << bits, 2, 255),
        };
        let most = most.min(steps / unit);
        let fit = |count: usize| if count > most { None } else { self.fit(moments, bits, count) };
        let mut best = fit(least)?;
        let (mut count, mut stride, mut grows) = (least, 1, true);
        while stride > 0 {
            match fit(count + stride) {
                Some(record) => {
                    (count, best) = (count + stride, record);
                    stride = if grows { stride * 2 } else { stride / 2 };
                }
                None => (grows, stride) = (false, stride / 2),
            }
        }
        Some(best)
    }

    /// A record of `count` steps or groups; `None` if one of the steps is beyond the tolerance.
    fn fit(&self, moments: &[Moment], bits: Option<u8>, count: usize) -> Option<Record> {
        let group = 1usize << bits.unwrap_or(0);
        let n = group * count;
        let played = self.played as i64;
        let time = |k: usize| moments.get(k).map(|moment| moment.at as i64);
        let whole = time(n)?.wrapping_sub(played);
        // At one interval twice as long: a fast axis has few cycles for the end of a record.
        let longest = i64::from(self.terms.longest) << u8::from(bits.is_none());
        if n > 1 && whole > longest {
            return None;
        }
        let act = match bits {
            None => RecordAct::Steps(count as u16),
            Some(bits) => RecordAct::Groups { bits, count: count as u8 },
        };
        let unit: i64 = if n < 64 { 16 } else { 1 };
        let mut growth = 0;
        if bits.is_some() {
            let half = n / 2;
            let apart = time(n)? - time(n - half)? - (time(half)? - played);
            growth = divided(apart * group as i64, (half * (n - half)) as i64 * unit) * unit;
            if growth == 0 || growth.abs() >= 1 << 21 {
                return None;
            }
        }
        let (m, steps) = (count as i64, n as i64);
        let grown = if bits.is_some() { steps * growth * (m - 1) } else { 0 };
        let interval = divided(2 * whole - grown, 2 * steps * unit) * unit;
        let record = Record { act, interval: u32::try_from(interval).ok()?, growth: growth as i32 };
        if !record.is_playable(self.terms.shortest) {
            return None;
        }
        let (mut at, mut wait, mut left) = (played, interval, group);
        for k in 1..=n {
            at += wait;
            left -= 1;
            if left == 0 && bits.is_some() {
                (wait, left) = (wait + growth, group);
            } else if left == 0 {
                left = group;
            }
            if (at - time(k)?).unsigned_abs() > u64::from(self.terms.tolerance) {
                return None;
            }
        }
        Some(record)
    }
}

/// Whether a group leaves time to prepare the next group: some 220 cycles besides the 70 of each step.
const fn is_calm(record: &Record) -> bool {
    let group = match record.act {
        RecordAct::Steps(count) => count as u32,
        RecordAct::Groups { bits, .. } => 1 << (bits & 15),
        _ => return true,
    };
    let (first, last) = (record.interval >> 8, record.last() >> 8);
    let interval = if first < last { first } else { last };
    interval >= 1_024 || group * interval.saturating_sub(70) >= 400
}

/// A quotient rounded to the nearest integer.
const fn divided(by: i64, of: i64) -> i64 {
    (2 * by + of).div_euclid(2 * of)
}

/// Rounds up to a multiple of 16.
const fn round_up(wait: u64) -> u32 {
    (wait as u32).wrapping_add(15) & !15
}

// The longest part fits into the wait of one event.
const _: () = assert!(PART < FAR as u64);
