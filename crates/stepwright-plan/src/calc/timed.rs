//! A speed that changes with the clock (the Arduino driver, sections 7 and 8).
//!
//! ```text
//!   linear      modification = ⌊|start − end| / updates⌋
//!   doubling    modification = ⌊(end − start) / (2^n − 1)⌋          slower
//!   halving     modification = ⌊(start − end) / (2 − 2^(1−n))⌋      faster
//! ```
//!
//! start and end are virtual tops. After each update the modification doubles or halves (rounded down), so
//! that the speed changes more evenly.

use stepwright::Geometry;
use stepwright_plot::{Curve, Figure, PALETTE, Panel};
use stepwright_timed::fit::Hardware;

use super::CalcError;
use crate::sheet::{Cell, Sheet};

/// A speed that changes with the clock.
#[derive(Clone, Debug)]
pub struct TimedTable {
    /// The name of the speed at the start.
    pub from: String,
    /// The name of the speed at the end.
    pub to: String,
    /// The virtual top at the start.
    pub start: u32,
    /// The wanted virtual top at the end.
    pub end: u32,
    /// How many times the speed changes, at least once.
    pub updates: u16,
    /// Whether the modification doubles (slower) or halves (faster).
    pub doubling: bool,
    /// The modification if it is given; the speed at the end follows from it.
    pub modification: Option<u32>,
    /// Seconds from update to update.
    pub every: Option<f64>,
}

/// A change: from a virtual top on, by a modification.
#[derive(Clone, Copy, Debug)]
pub struct TopChange {
    /// The virtual top at the start.
    pub start: u32,
    /// Whether the virtual top gets smaller.
    pub faster: bool,
    /// Whether the modification doubles or halves.
    pub doubling: bool,
    /// The first change, in clocks.
    pub modification: u32,
    /// The number of updates.
    pub updates: u16,
}

/// The state after an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopUpdate {
    /// The virtual top.
    pub top: u32,
    /// The change by this update.
    pub by: i64,
}

impl TopChange {
    /// Every state from the start on. Ends before a top that the timer can't make, as the driver does.
    pub fn states(self, hardware: Hardware) -> impl Iterator<Item = TopUpdate> {
        let (mut top, mut modification) = (self.start, self.modification);
        let changes = (0..self.updates).map_while(move |_| {
            let by = modification;
            let next = match self.faster {
                true => top.checked_sub(by),
                false => top.checked_add(by),
            };
            top = next.filter(|&top| hardware.check(top).is_ok())?;
            if self.doubling {
                // A modification that exceeds 32 bits exceeds the timer's range too, at the next update.
                modification = if self.faster { by / 2 } else { by.saturating_mul(2) };
            }
            let by = i64::from(by);
            Some(TopUpdate { top, by: if self.faster { -by } else { by } })
        });
        std::iter::once(TopUpdate { top: self.start, by: 0 }).chain(changes)
    }
}

/// The modification for a change of `way` clocks.
fn modification(way: u32, updates: u16, doubling: bool, faster: bool) -> u32 {
    let (way, n) = (u128::from(way), u32::from(updates));
    let value = match doubling {
        false => way / u128::from(n),
        // 2 − 2^(1−n) = (2^n − 1) / 2^(n−1); more than 64 updates change no digit.
        true if faster => (way << (n.min(64) - 1)) / ((1 << n.min(64)) - 1),
        true => way / ((1 << n.min(64)) - 1),
    };
    value as u32 // at most the way itself
}

impl TimedTable {
    /// The change.
    ///
    /// # Errors
    /// There is nothing to change, or less than a clock for each update.
    pub fn change(&self) -> Result<TopChange, CalcError> {
        let TimedTable { start, end, updates, doubling, .. } = *self;
        let (faster, way) = (end < start, start.abs_diff(end));
        let found = modification(way, updates, doubling, faster);
        if way == 0 && self.modification.is_none() {
            let (from, to) = (self.from.clone(), self.to.clone());
            return Err(CalcError::SameTop { from, to, top: start });
        }
        if found == 0 && self.modification.is_none() {
            // Slower and doubling, the sum of n modifications is 2^n − 1 of the first.
            let most = if doubling { (u64::from(way) + 1).ilog2() } else { way };
            return Err(CalcError::TooManyUpdates { updates, way, most });
        }
        let modification = self.modification.unwrap_or(found);
        Ok(TopChange { start, faster, doubling, modification, updates })
    }

    fn title(&self, change: TopChange) -> String {
        let way = match (change.doubling, change.faster) {
            (false, _) => "by the same each time",
            (true, true) => "by half as much each time",
            (true, false) => "by twice as much each time",
        };
        format!("{} to {} in {} updates, {way}", self.from, self.to, self.updates)
    }

    /// The modification, and the table.
    ///
    /// # Errors
    /// As for [`change`](TimedTable::change).
    pub fn sheet(&self, hardware: &Hardware, geometry: &Geometry) -> Result<Sheet, CalcError> {
        let turn = f64::from(geometry.steps_per_turn());
        let (change, wanted) = (self.change()?, self.end);
        let states: Vec<TopUpdate> = change.states(*hardware).collect();
        let end = states[states.len() - 1].top;
        let rate = |top: u32| f64::from(hardware.hz()) / f64::from(top);
        let mut sheet = Sheet::new(self.title(change));
        sheet.fact("start_top", "start, virtual top", change.start, "clocks");
        sheet.fact(
            "start_rpm",
            "… speed",
            Cell::digits(rate(change.start) * 60.0 / turn, 7),
            "rpm",
        );
        sheet.fact("wanted_top", "wanted end", wanted, "clocks");
        sheet.fact("modification", "modification", change.modification, "clocks");
        sheet.fact("end_top", "real end", end, "clocks");
        sheet.fact("end_rpm", "… speed", Cell::digits(rate(end) * 60.0 / turn, 7), "rpm");
        if let Some(every) = self.every {
            // A FAULT ends the change early.
            let seconds = (states.len() - 1) as f64 * every;
            sheet.fact("seconds", "takes", Cell::digits(seconds, 6), "s");
        }
        sheet.columns = vec![("update", "update"), ("top", "virtual top"), ("by", "changed by")];
        if self.every.is_some() {
            sheet.columns.insert(1, ("time_s", "time, s"));
        }
        sheet.columns.extend([
            ("rate_steps_s", "steps/s"),
            ("rpm", "rpm"),
            ("prescaler", "prescaler"),
            ("timer_top", "top"),
        ]);
        for (&TopUpdate { top, by }, k) in states.iter().zip(0u32..) {
            let fit = hardware
                .fit(top)
                .map_err(|why| CalcError::Misfit { what: "the virtual top".into(), why })?;
            let mut row: Vec<Cell> = vec![k.into()];
            row.extend(self.every.map(|every| Cell::digits(f64::from(k) * every, 9)));
            row.extend([top.into(), if k == 0 { Cell::Empty } else { by.into() }]);
            row.extend([Cell::digits(rate(top), 7), Cell::digits(rate(top) * 60.0 / turn, 7)]);
            row.extend([fit.prescaler().into(), fit.top().into()]);
            sheet.rows.push(row);
        }
        if states.len() <= self.updates.into() {
            sheet.notes.push(format!(
                "Update {} would leave what the timer can make, {} to {}: FAULT, and the speed stays.",
                states.len(),
                hardware.min_top(),
                hardware.max_top(),
            ));
        }
        Ok(sheet)
    }

    /// The speed over the updates, beside the curve of the other kind of change.
    ///
    /// # Errors
    /// As for [`change`](TimedTable::change).
    pub fn figure(&self, hardware: &Hardware, geometry: &Geometry) -> Result<Figure, CalcError> {
        let turn = f64::from(geometry.steps_per_turn());
        let (change, wanted) = (self.change()?, self.end);
        let name = |change: TopChange| match (change.doubling, change.faster) {
            (false, _) => "linear",
            (true, true) => "halving",
            (true, false) => "doubling",
        };
        let step = self.every.unwrap_or(1.0);
        let curve = |change: TopChange, colour: usize| {
            let rpm = |top: u32| f64::from(hardware.hz()) / f64::from(top) * 60.0 / turn;
            let states = change.states(*hardware).zip(0u32..);
            let dots: Vec<_> = states.map(|(s, k)| (f64::from(k) * step, rpm(s.top))).collect();
            let mut points: Vec<(f64, f64)> = Vec::new();
            for &(x, y) in &dots {
                points.extend(points.last().map(|&(_, before)| (x, before)));
                points.push((x, y));
            }
            // After a FAULT the speed stays.
            let end = (f64::from(change.updates) + 1.0) * step;
            points.extend(dots.last().map(|&(_, y)| (end, y)));
            let dots = if dots.len() <= 60 && colour == 0 { dots } else { Vec::new() };
            let dashed = colour != 0;
            let colour = PALETTE[if dashed { 5 } else { 0 }];
            Curve { name: name(change).into(), colour, points, dots, dashed, ..Curve::default() }
        };
        let way = change.start.abs_diff(wanted);
        let doubling = !change.doubling;
        let modification = modification(way, change.updates, doubling, change.faster);
        let mut curves = vec![curve(change, 0)];
        if modification > 0 {
            curves.insert(0, curve(TopChange { doubling, modification, ..change }, 1));
        }
        let x = match self.every {
            Some(_) => ("time".to_owned(), "s".to_owned()),
            None => ("update".to_owned(), String::new()),
        };
        let panel = Panel { y: ("Speed".into(), "rpm".into()), x, curves, ..Panel::default() };
        Ok(Figure {
            title: self.title(change),
            notes: vec![format!(
                "from virtual top {}, by {} clocks at first, on a timer of {} Hz",
                change.start,
                change.modification,
                hardware.hz()
            )],
            rows: vec![(440.0, vec![panel])],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The highest number of updates that an error names is the highest possible one.
    #[test]
    fn too_many_updates() {
        for (way, doubling) in [(10, false), (1000, true), (1023, true), (1022, true)] {
            let most = if doubling { u32::ilog2(way + 1) } else { way } as u16;
            assert!(modification(way, most, doubling, false) > 0, "{way}");
            assert_eq!(modification(way, most + 1, doubling, false), 0, "{way}");
        }
    }
}
