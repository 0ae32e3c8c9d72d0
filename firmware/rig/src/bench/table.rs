//! The table: rows, what they must reach, and the file that keeps them.

use std::fmt;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::{Value, json};

/// What each figure must reach, whatever was stored: name, axes, feed, bound.
const BOUNDS: &[(&str, u8, &str, Bound)] = &[
    ("back_to_back_constant", 1, "queued", Bound::AtMost(85.0)),
    ("back_to_back_ramp", 1, "queued", Bound::AtMost(100.0)),
    ("isolated", 1, "queued", Bound::AtMost(110.0)),
    ("rate_ramps", 1, "queued", Bound::AtLeast(120_000.0)),
    ("rate_ramps", 2, "queued", Bound::AtLeast(60_000.0)),
    ("rate_constant", 3, "queued", Bound::AtLeast(45_000.0)),
    ("rate_ramps", 3, "queued", Bound::AtLeast(35_000.0)),
    ("rate_ramps", 1, "direct", Bound::AtLeast(40_000.0)),
    ("planning_burst", 3, "queued", Bound::AtMost(3_200.0)),
    ("interval_rms", 1, "queued", Bound::AtMost(0.05)),
    ("accel_peak_deadlines", 1, "queued", Bound::AtMost(1.4)),
    ("accel_peak", 1, "queued", Bound::AtMost(2.5)),
    ("late_steps", 3, "queued", Bound::AtMost(0.0)),
    ("flash", 3, "queued", Bound::AtMost(20_480.0)),
    ("ram", 3, "queued", Bound::AtMost(1_229.0)),
];

/// What a figure may worsen before it counts: 2 %.
const SLACK: f64 = 0.02;

#[derive(Clone, Copy, Debug)]
enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Bound::AtMost(value) => write!(f, "≤ {value}"),
            Bound::AtLeast(value) => write!(f, "≥ {value}"),
        }
    }
}

/// One figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was measured, as in the documentation.
    pub name: String,
    /// Axes that move, 1 … 3.
    pub axes: u8,
    /// `queued`: the foreground plans; `direct`: the interrupt does.
    pub feed: String,
    /// The figure.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

impl Row {
    pub(crate) fn queued(name: &str, axes: u8, value: f64, unit: &str) -> Row {
        let (name, feed, unit) = (name.into(), "queued".into(), unit.into());
        // Three significant digits behind what is compared: a file to read.
        let value = (value * 1e4).round() / 1e4;
        Row { name, axes, feed, value, unit }
    }

    fn is(&self, name: &str, axes: u8, feed: &str) -> bool {
        self.name == name && self.axes == axes && self.feed == feed
    }

    fn bound(&self) -> Option<Bound> {
        let row = BOUNDS.iter().find(|(name, axes, feed, _)| self.is(name, *axes, feed));
        row.map(|row| row.3)
    }

    /// Whether it is outside its bound.
    fn misses(&self) -> bool {
        match self.bound() {
            Some(Bound::AtMost(most)) => self.value > most,
            Some(Bound::AtLeast(least)) => self.value < least,
            None => false,
        }
    }

    /// Whether more is better; of all others less is.
    fn is_a_rate(&self) -> bool {
        self.unit == "steps/s"
    }

    fn is_worse_than(&self, stored: &Row) -> bool {
        if self.is_a_rate() {
            self.value < stored.value * (1.0 - SLACK)
        } else {
            self.value > stored.value * (1.0 + SLACK)
        }
    }
}

/// All figures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table(Vec<Row>);

impl Table {
    pub(crate) fn new(mut rows: Vec<Row>) -> Table {
        rows.sort_by(|a, b| (&a.feed, &a.name, a.axes).cmp(&(&b.feed, &b.name, b.axes)));
        Table(rows)
    }

    /// Reads a stored table.
    ///
    /// # Errors
    /// The file can't be read, or is no table.
    pub fn read(path: &Path) -> Result<Table> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("no stored table at {}", path.display()))?;
        let list: Value = serde_json::from_str(&text)?;
        let row = |row: &Value| {
            Some(Row {
                name: row["name"].as_str()?.into(),
                axes: row["axes"].as_u64()?.try_into().ok()?,
                feed: row["feed"].as_str()?.into(),
                value: row["value"].as_f64()?,
                unit: row["unit"].as_str()?.into(),
            })
        };
        let rows: Option<Vec<Row>> = list.as_array().into_iter().flatten().map(row).collect();
        Ok(Table(rows.with_context(|| format!("{} is no table", path.display()))?))
    }

    /// Writes it, a row a line.
    ///
    /// # Errors
    /// The file can't be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let line = |row: &Row| {
            // In the order of the documentation; serde_json would sort.
            format!(
                "  {{\"name\": {}, \"axes\": {}, \"feed\": {}, \"value\": {}, \"unit\": {}}}",
                json!(row.name),
                row.axes,
                json!(row.feed),
                row.value,
                json!(row.unit)
            )
        };
        let lines: Vec<String> = self.0.iter().map(line).collect();
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        std::fs::write(path, format!("[\n{}\n]\n", lines.join(",\n")))
            .with_context(|| format!("writing {}", path.display()))
    }

    /// A figure, if it is there.
    pub fn get(&self, name: &str, axes: u8, feed: &str) -> Option<f64> {
        self.0.iter().find(|row| row.is(name, axes, feed)).map(|row| row.value)
    }

    /// What is wrong: bounds that are missed, and, against `stored`, figures
    /// that have worsened by more than 2 % or are gone.
    pub fn complaints(&self, stored: Option<&Table>) -> Vec<String> {
        let mut complaints = Vec::new();
        for row in &self.0 {
            if let Some(bound) = row.bound().filter(|_| row.misses()) {
                complaints.push(format!("{row}: the bound is {bound}"));
            }
        }
        for (name, axes, feed, bound) in BOUNDS {
            // Nothing is fed directly yet.
            if *feed == "queued" && self.get(name, *axes, feed).is_none() {
                complaints.push(format!("{name} of {axes} is not measured: the bound is {bound}"));
            }
        }
        for old in stored.into_iter().flat_map(|table| &table.0) {
            match self.0.iter().find(|row| row.is(&old.name, old.axes, &old.feed)) {
                None => complaints.push(format!("{old} was stored and is not measured")),
                Some(new) if new.is_worse_than(old) => {
                    complaints.push(format!("{new}: {} was stored", old.value));
                }
                Some(_) => {}
            }
        }
        complaints
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Row { name, axes, feed, value, unit } = self;
        write!(f, "{name:<24}{axes}  {feed:<8}{value:>12} {unit}")
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in &self.0 {
            write!(f, "{:<60}", row.to_string())?;
            match row.bound() {
                Some(bound) if row.misses() => writeln!(f, "{bound}  MISSED")?,
                Some(bound) => writeln!(f, "{bound}")?,
                None => writeln!(f)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rate: f64, cycles: f64) -> Table {
        Table::new(vec![
            Row::queued("rate_ramps", 2, rate, "steps/s"),
            Row::queued("isolated", 1, cycles, "cycles"),
        ])
    }

    /// Those that name a stored figure or a bound that is missed.
    fn worse(table: &Table, stored: &Table) -> usize {
        let complaints = table.complaints(Some(stored));
        complaints.iter().filter(|text| !text.contains("is not measured: the bound")).count()
    }

    #[test]
    fn two_per_cent_are_let_pass_and_more_is_not() {
        let stored = table(70_000.0, 100.0);
        assert_eq!(worse(&table(68_700.0, 101.9), &stored), 0);
        assert_eq!(worse(&table(68_500.0, 100.0), &stored), 1);
        assert_eq!(worse(&table(70_000.0, 102.1), &stored), 1);
        assert_eq!(worse(&Table::default(), &stored), 2);
    }

    #[test]
    fn bounds_hold_whatever_was_stored() {
        let poor = table(59_000.0, 111.0);
        assert_eq!(worse(&poor, &poor), 2);
        // And a row that has a bound must be there.
        assert_eq!(Table::default().complaints(None).len(), 14);
    }

    #[test]
    fn a_table_reads_back() {
        let path = std::env::temp_dir().join(format!("stepwright-{}.json", std::process::id()));
        table(70_000.0, 99.5).write(&path).unwrap();
        let back = Table::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(back, table(70_000.0, 99.5));
    }
}
