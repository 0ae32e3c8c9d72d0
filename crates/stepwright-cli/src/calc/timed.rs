//! `calc timed`: a speed that changes with the clock (the Arduino driver, sections 7 and 8).
//!
//! ```text
//!   linear      modification = ⌊|start − end| / updates⌋
//!   doubling    modification = ⌊(end − start) / (2^n − 1)⌋          slower
//!   halving     modification = ⌊(start − end) / (2 − 2^(1−n))⌋      faster
//! ```
//!
//! start and end are virtual tops. After each update the modification doubles or
//! halves (rounded down), so that the speed changes more evenly.

use stepwright_timed::fit::Hardware;

use super::Output;
use super::clock::{ClockArgs, misfit, virtual_top};
use super::measure::{micros, whole};
use crate::failure::Failure;
use crate::plot::{Curve, Figure, PALETTE, Panel, PlotFile};
use crate::quantity::{GeometryArgs, SpeedArg};
use crate::sheet::{Cell, Sheet};

/// A speed that changes with the clock: the modification, and a table of it
///
/// At every update the virtual top grows or shrinks by the modification; with
/// --doubling that one doubles (slower) or halves (faster) each time, which makes
/// the change of speed more even.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  The example of the manual, 29 updates from 6 to 800 steps/s:
    stepwright calc timed 6 800 --updates 29 --every 250ms
  Case 2, and its curve:
    stepwright calc timed 1rpm 500 --updates 11 --doubling --modification 2385000 \\
      --every 1s --plot case-2.png
  Both curves of section 8:
    stepwright calc timed 1000 51000 --tops --updates 50 --plot linear.png
    stepwright calc timed 1000 65536000 --tops --updates 16 --doubling --plot doubling.png")]
pub struct Args {
    /// Speed at the start: 6, 1rpm … (a bare number is steps/s)
    #[arg(value_name = "FROM")]
    from: String,
    /// Speed at the end: 800, 150rpm …
    #[arg(value_name = "TO")]
    to: String,
    /// FROM and TO are virtual tops
    #[arg(long)]
    tops: bool,
    /// How many times the speed changes, 1 to 65535
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    updates: u16,
    /// The modification doubles (slower) or halves (faster): VARIABLE_PWR
    #[arg(long, visible_alias = "halving")]
    doubling: bool,
    /// Take this modification; the speed at the end follows
    #[arg(long, value_name = "CLOCKS", value_parser = whole)]
    modification: Option<u32>,
    /// Time from update to update: 1s, 250ms
    #[arg(long, value_name = "TIME", value_parser = |text: &str| micros_or_ms(text))]
    every: Option<f64>,
    #[command(flatten)]
    clock: ClockArgs,
    #[command(flatten)]
    geometry: GeometryArgs,
    /// Draw the speed over the updates (.svg, .png or .html)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Vec<PlotFile>,
    #[command(flatten)]
    pub(super) output: Output,
}

/// Seconds; a bare number is in milliseconds, as the Arduino driver has them.
fn micros_or_ms(text: &str) -> Result<f64, String> {
    let bare = text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let micros = micros(&if bare { format!("{text}ms") } else { text.to_owned() })?;
    Ok(micros / 1e6)
}

/// A change: from a virtual top on, by a modification.
#[derive(Clone, Copy, Debug)]
struct Change {
    start: u32,
    faster: bool,
    doubling: bool,
    modification: u32,
    updates: u16,
}

/// The state after an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Update {
    top: u32,
    /// What it was changed by.
    by: i64,
}

impl Change {
    /// Every state, from the start on; ends before a top that the timer can't make,
    /// as the driver does.
    fn states(self, hardware: Hardware) -> impl Iterator<Item = Update> {
        let (mut top, mut modification) = (self.start, self.modification);
        let changes = (0..self.updates).map_while(move |_| {
            let by = modification;
            let next = match self.faster {
                true => top.checked_sub(by),
                false => top.checked_add(by),
            };
            top = next.filter(|&top| hardware.check(top).is_ok())?;
            if self.doubling {
                // What leaves 32 bits leaves the timer's too, at the next update.
                modification = if self.faster { by / 2 } else { by.saturating_mul(2) };
            }
            let by = i64::from(by);
            Some(Update { top, by: if self.faster { -by } else { by } })
        });
        std::iter::once(Update { top: self.start, by: 0 }).chain(changes)
    }
}

/// The modification for a way of this many clocks.
fn modification(way: u32, updates: u16, doubling: bool, faster: bool) -> u32 {
    let (way, n) = (u128::from(way), u32::from(updates));
    let value = match doubling {
        false => way / u128::from(n),
        // 2 − 2^(1−n) = (2^n − 1) / 2^(n−1); beyond 64 updates no digit changes.
        true if faster => (way << (n.min(64) - 1)) / ((1 << n.min(64)) - 1),
        true => way / ((1 << n.min(64)) - 1),
    };
    value as u32 // at most the way itself
}

impl Args {
    fn top(&self, text: &str, hardware: &Hardware) -> Result<u32, Failure> {
        let wrong = |message: String| Failure::usage(format!("{text}: {message}"));
        if self.tops {
            let top = whole(text).map_err(wrong)?;
            return hardware.check(top).map_err(|error| misfit(text, error));
        }
        let speed: SpeedArg = text.parse().map_err(wrong)?;
        virtual_top(hardware, speed.steps(&self.geometry.geometry()?, text)?, text)
    }

    fn change(&self, hardware: &Hardware) -> Result<(Change, u32), Failure> {
        let (start, end) = (self.top(&self.from, hardware)?, self.top(&self.to, hardware)?);
        let (faster, way, updates) = (end < start, start.abs_diff(end), self.updates);
        let found = modification(way, updates, self.doubling, faster);
        if way == 0 && self.modification.is_none() {
            let (from, to) = (&self.from, &self.to);
            return Err(Failure::new(format!("{from} and {to} are the same virtual top, {start}"))
                .hint("give another TO, or a --modification"));
        }
        if found == 0 && self.modification.is_none() {
            // Slower and doubling, the sum of n modifications is 2^n − 1 of the first.
            let most = if self.doubling { (u64::from(way) + 1).ilog2() } else { way };
            return Err(Failure::new(format!(
                "{updates} updates are too many for a change of {way} clocks: less than one each"
            ))
            .hint(format!("give at most {most} --updates")));
        }
        let modification = self.modification.unwrap_or(found);
        Ok((Change { start, faster, doubling: self.doubling, modification, updates }, end))
    }

    /// The modification, and the table.
    pub fn sheet(&self) -> Result<Sheet, Failure> {
        let hardware = self.clock.hardware()?;
        let turn = f64::from(self.geometry.geometry()?.steps_per_turn());
        let (change, wanted) = self.change(&hardware)?;
        let states: Vec<Update> = change.states(hardware).collect();
        let end = states[states.len() - 1].top;
        let rate = |top: u32| f64::from(hardware.hz()) / f64::from(top);
        let way = match (change.doubling, change.faster) {
            (false, _) => "by the same each time",
            (true, true) => "by half as much each time",
            (true, false) => "by twice as much each time",
        };
        let title = format!("{} to {} in {} updates, {way}", self.from, self.to, self.updates);
        let mut sheet = Sheet::new(title);
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
            let seconds = f64::from(self.updates) * every;
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
        for (&Update { top, by }, k) in states.iter().zip(0u32..) {
            let fit = hardware.fit(top).map_err(|error| misfit("the virtual top", error))?;
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
        for file in &self.plot {
            file.save(&self.figure(&sheet.title, change, wanted, hardware, turn))?;
        }
        Ok(sheet)
    }

    /// The speed over the updates, beside what the other way would make of it.
    fn figure(
        &self,
        title: &str,
        change: Change,
        wanted: u32,
        hardware: Hardware,
        turn: f64,
    ) -> Figure {
        let name = |change: Change| match (change.doubling, change.faster) {
            (false, _) => "linear",
            (true, true) => "halving",
            (true, false) => "doubling",
        };
        let step = self.every.unwrap_or(1.0);
        let curve = |change: Change, colour: usize| {
            let rpm = |top: u32| f64::from(hardware.hz()) / f64::from(top) * 60.0 / turn;
            let states = change.states(hardware).zip(0u32..);
            let dots: Vec<_> = states.map(|(s, k)| (f64::from(k) * step, rpm(s.top))).collect();
            let mut points: Vec<(f64, f64)> = Vec::new();
            for &(x, y) in &dots {
                points.extend(points.last().map(|&(_, before)| (x, before)));
                points.push((x, y));
            }
            points.extend(dots.last().map(|&(x, y)| (x + step, y)));
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
            curves.insert(0, curve(Change { doubling, modification, ..change }, 1));
        }
        let x = match self.every {
            Some(_) => ("time".to_owned(), "s".to_owned()),
            None => ("update".to_owned(), String::new()),
        };
        let panel = Panel { y: ("Speed".into(), "rpm".into()), x, curves, ..Panel::default() };
        Figure {
            title: title.into(),
            notes: vec![format!(
                "from virtual top {}, by {} clocks at first, on a timer of {} Hz",
                change.start,
                change.modification,
                hardware.hz()
            )],
            rows: vec![(440.0, vec![panel])],
        }
    }
}

#[cfg(test)]
mod tests;
