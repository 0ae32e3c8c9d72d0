//! The changes of a laser's power, and the records made of them.
//!
//! A board has room for few changes, so records are at least [`APART`] apart: of changes that come faster the
//! latest counts, and none is more than that late. Where the power stays the same for longer than one record
//! can say, another record repeats it.

use std::collections::VecDeque;

use stepwright_stream::power::{LONGEST, UNIT_BITS};

/// Units between two records, at least: 0.5 ms at 16 MHz.
const APART: u64 = 31;

/// 2⁻⁸ ticks of a unit, as a power of two.
const BITS: u32 = UNIT_BITS + 8;

/// The laser of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct LaserFeed {
    /// The times of the changes in 2⁻⁸ ticks, and their powers. The first `made` are in records; they are
    /// kept in case a cut takes these records back.
    changes: VecDeque<(u64, u8)>,
    made: usize,
    /// The number of changes that were dropped.
    gone: u64,
    /// The last record: its time in units, and its power.
    last: (u64, u8),
}

/// The state of a laser between two records.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaserMark {
    /// The number of the next change.
    change: u64,
    last: (u64, u8),
}

/// A record that is due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LaserRecord {
    /// The time in 2⁻⁸ ticks.
    pub at: u64,
    /// Units since the last record.
    pub wait: u16,
    pub power: u8,
    /// Changes that it makes.
    makes: usize,
}

impl LaserFeed {
    /// Adds a change. Times must not decrease.
    pub(crate) fn add(&mut self, at: u64, power: u8) {
        self.changes.push_back((at, power));
    }

    /// Switches the laser off at the end, if it is on.
    pub(crate) fn end(&mut self, at: u64) {
        if self.changes.back().map_or(self.last.1, |change| change.1) != 0 {
            self.add(at, 0);
        }
    }

    /// The next record that is due by `until`, if all changes up to then are known.
    pub(crate) fn due(&self, until: u64) -> Option<LaserRecord> {
        let (last, power) = self.last;
        let left = self.changes.iter().skip(self.made);
        let mut makes = 0;
        let mut due = None;
        for &(at, next) in left {
            let unit = (at + (1 << (BITS - 1))) >> BITS;
            match due {
                None if next == power => {}
                None => due = Some((unit.max(last + APART), next)),
                Some((known, _)) if unit <= known => due = Some((known, next)),
                Some(_) => break,
            }
            makes += 1;
        }
        let (unit, power, makes) = match due {
            Some((unit, next)) if unit <= last + u64::from(LONGEST) => (unit, next, makes),
            // It stays the same for longer than a record says.
            _ => (last + u64::from(LONGEST), power, 0),
        };
        let record = LaserRecord { at: unit << BITS, wait: (unit - last) as u16, power, makes };
        (record.at <= until).then_some(record)
    }

    /// Makes a record that is due.
    pub(crate) fn make(&mut self, record: &LaserRecord) {
        self.made += record.makes;
        self.last = (self.last.0 + u64::from(record.wait), record.power);
    }

    /// The present state, to come back to.
    pub(crate) fn mark(&self) -> LaserMark {
        LaserMark { change: self.gone + self.made as u64, last: self.last }
    }

    /// Drops changes that are in records before this mark.
    pub(crate) fn forget(&mut self, mark: &LaserMark) {
        let count = (mark.change.saturating_sub(self.gone) as usize).min(self.made);
        self.changes.drain(..count);
        (self.made, self.gone) = (self.made - count, self.gone + count as u64);
    }

    /// Returns to this mark, and forgets the changes at `end` and later.
    pub(crate) fn rewind(&mut self, mark: &LaserMark, end: u64) {
        (self.made, self.last) = (mark.change.saturating_sub(self.gone) as usize, mark.last);
        let kept = self.changes.partition_point(|(at, _)| *at < end).max(self.made);
        self.changes.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All records up to a time, as times in units and powers.
    fn records(laser: &mut LaserFeed, until: u64) -> Vec<(u64, u8)> {
        let mut all = Vec::new();
        while let Some(record) = laser.due(until << BITS) {
            laser.make(&record);
            all.push((record.at >> BITS, record.power));
        }
        all
    }

    #[test]
    fn a_change_is_a_record_at_its_time() {
        let mut laser = LaserFeed::default();
        for (unit, power) in [(100, 5), (400, 0), (700, 0), (1_000, 255)] {
            laser.add(unit << BITS, power);
        }
        assert_eq!(records(&mut laser, 1_500), [(100, 5), (400, 0), (1_000, 255)]);
        laser.end(1_600 << BITS);
        assert_eq!(records(&mut laser, 1_600), [(1_600, 0)]);
    }

    /// A short pulse stays one; where more changes come than records the last one counts.
    #[test]
    fn records_keep_apart() {
        let mut laser = LaserFeed::default();
        for (unit, power) in [(100, 5), (110, 0), (200, 1), (205, 2), (210, 3), (215, 4), (300, 9)]
        {
            laser.add(unit << BITS, power);
        }
        let expected = [(100, 5), (131, 0), (200, 1), (231, 4), (300, 9)];
        assert_eq!(records(&mut laser, 1_000), expected);
    }

    #[test]
    fn a_long_wait_is_several_records() {
        let mut laser = LaserFeed::default();
        laser.add(10_000 << BITS, 7);
        assert_eq!(records(&mut laser, 10_100), [(4_095, 0), (8_190, 0), (10_000, 7)]);
        assert_eq!(records(&mut laser, 15_000), [(14_095, 7)]);
    }

    #[test]
    fn a_cut_takes_records_back() {
        let mut laser = LaserFeed::default();
        for unit in 1..=10 {
            laser.add((unit * 100) << BITS, unit as u8);
        }
        records(&mut laser, 350);
        let mark = laser.mark();
        records(&mut laser, 850);
        laser.rewind(&mark, 600 << BITS);
        laser.add(620 << BITS, 99);
        assert_eq!(records(&mut laser, 900), [(400, 4), (500, 5), (620, 99)]);
        laser.forget(&laser.mark());
        assert!(laser.changes.is_empty());
    }
}
