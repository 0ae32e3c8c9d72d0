//! The table: rows, their faults, and the file that stores them.

use std::fmt;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::Way;
use super::bounds::{BOUNDS, Bound, open};

/// One figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The measured quantity, as in the documentation.
    pub name: String,
    /// The moving axes, 1 … 3.
    pub axes: u8,
    /// `queued`: the foreground plans; `cycle`: the interrupt reads programs.
    pub feed: String,
    /// The figure.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

impl Row {
    pub(super) fn queued(name: &str, axes: u8, value: f64, unit: &str) -> Row {
        Row::of(Way::Queued, name, axes, value, unit)
    }

    pub(super) fn of(way: Way, name: &str, axes: u8, value: f64, unit: &str) -> Row {
        let (name, feed, unit) = (name.into(), way.name().into(), unit.into());
        // Four decimals, more than the comparison needs, so that the file is readable.
        let value = (value * 1e4).round() / 1e4;
        Row { name, axes, feed, value, unit }
    }

    fn is(&self, name: &str, axes: u8, feed: &str) -> bool {
        self.name == name && self.axes == axes && self.feed == feed
    }

    fn bound(&self) -> Option<Bound> {
        Bound::of(&self.name, self.axes, &self.feed)
    }

    /// Why its bound is known to be missed, if it is.
    fn open(&self) -> Option<&'static str> {
        open(&self.name, self.axes, &self.feed)
    }

    /// How it violates its bound.
    fn complaint(&self) -> Option<String> {
        let bound = self.bound()?;
        match (bound.holds(self.value), self.open()) {
            (false, None) => Some(format!("{self}: the bound is {bound}")),
            (true, Some(_)) => Some(format!("{self}: {bound} is met, take it off the list OPEN")),
            _ => None,
        }
    }

    /// Whether a higher value is better; for all others a lower one is.
    fn is_a_rate(&self) -> bool {
        self.unit.starts_with("steps/s")
    }

    fn is_worse_than(&self, stored: &Row) -> bool {
        !Bound::near(stored.value, self.is_a_rate()).holds(self.value)
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
    /// The file can't be read, or is not a table.
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

    /// Writes the table, one row per line.
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

    /// A figure, if the table has it.
    pub fn get(&self, name: &str, axes: u8, feed: &str) -> Option<f64> {
        self.0.iter().find(|row| row.is(name, axes, feed)).map(|row| row.value)
    }

    /// The faults: bounds that are unexpectedly missed, or unexpectedly met; and, against `stored`,
    /// figures that have worsened by more than allowed or are missing.
    pub fn complaints(&self, stored: Option<&Table>) -> Vec<String> {
        let mut complaints: Vec<String> = self.0.iter().filter_map(Row::complaint).collect();
        for (name, axes, feed, bound) in BOUNDS {
            if self.get(name, *axes, feed).is_none() && open(name, *axes, feed).is_none() {
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
            match (row.bound(), row.open()) {
                (Some(bound), Some(why)) => writeln!(f, "{bound}  open: {why}")?,
                (Some(bound), _) if bound.holds(row.value) => writeln!(f, "{bound}")?,
                (Some(bound), _) => writeln!(f, "{bound}  MISSED")?,
                (None, _) => writeln!(f)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::OPEN;
    use super::*;

    /// A rate that is open below its bound of 45,000 steps/s, and cycles that may be 110.
    fn table(rate: f64, cycles: f64) -> Table {
        Table::new(vec![
            Row::queued("rate_constant", 3, rate, "steps/s"),
            Row::queued("isolated", 1, cycles, "cycles"),
        ])
    }

    /// The complaints about rows that are present.
    fn wrong(table: &Table, stored: &Table) -> usize {
        let complaints = table.complaints(Some(stored));
        complaints.iter().filter(|text| !text.contains("is not measured: the bound")).count()
    }

    #[test]
    fn a_little_is_let_pass_and_more_is_not() {
        let stored = table(30_000.0, 100.0);
        assert_eq!(wrong(&table(28_600.0, 101.9), &stored), 0);
        assert_eq!(wrong(&table(28_400.0, 100.0), &stored), 1);
        assert_eq!(wrong(&table(30_000.0, 102.1), &stored), 1);
        assert_eq!(wrong(&Table::default(), &stored), 2);
    }

    #[test]
    fn bounds_hold_whatever_was_stored() {
        let poor = table(30_000.0, 111.0);
        assert_eq!(wrong(&poor, &poor), 1);
        // A row with a bound must be present, unless it is open.
        let absent = Table::default().complaints(None).len();
        assert_eq!(absent, BOUNDS.len() - OPEN.len());
    }

    #[test]
    fn an_open_row_that_meets_its_bound_is_open_no_more() {
        let good = table(45_000.0, 100.0);
        assert_eq!(wrong(&good, &good), 1);
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
