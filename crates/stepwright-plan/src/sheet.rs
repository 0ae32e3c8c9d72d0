//! Results as a sheet: one fact a line, then a table, as text, CSV or JSON.
//!
//! Figures, comparisons and calculators make sheets. A number in the text has the digits that a reader
//! needs, in CSV and JSON all its digits.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, Write};

use serde_json::{Value, json};

use crate::tidy;
use crate::tidy::unsigned_zero;

/// How a sheet is printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum SheetFormat {
    /// In columns, for reading
    #[default]
    Table,
    /// Comma-separated values, with all digits: of the table alone, if there is one
    Csv,
    /// One object, with all digits
    Json,
}

/// The results of a command.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// The heading.
    pub title: String,
    /// Single results.
    pub facts: Vec<Fact>,
    /// The columns of the table: a key for CSV and JSON, and a heading for the text.
    pub columns: Vec<(&'static str, &'static str)>,
    /// The rows of the table, with one cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// Other tables, each with a key for JSON. CSV has only the first table.
    pub parts: Vec<(&'static str, Sheet)>,
    /// Further notes for the reader.
    pub notes: Vec<String>,
}

/// A single result.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// The name in CSV and JSON: `virtual_top`.
    pub key: &'static str,
    /// The name in the text: `virtual top`.
    pub name: &'static str,
    /// The value.
    pub value: Cell,
    /// The unit; empty for a bare number.
    pub unit: &'static str,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// No value.
    Empty,
    /// A text.
    Text(String),
    /// A whole number.
    Whole(i64),
    /// A number, and its text.
    Real(f64, String),
}

impl Cell {
    /// A number with this many digits after the point.
    pub fn fixed(value: f64, decimals: usize) -> Cell {
        // Never "-0.0".
        let shown = format!("{value:.decimals$}");
        let bare =
            shown.strip_prefix('-').filter(|s| !s.bytes().any(|b| (b'1'..=b'9').contains(&b)));
        Cell::Real(value, bare.map_or(shown.clone(), str::to_owned))
    }

    /// A number with at most this many digits in all.
    pub fn digits(value: f64, digits: usize) -> Cell {
        // As floats: log10 of 0 is infinite.
        let whole = value.abs().log10().floor() + 1.0;
        let decimals = (digits as f64 - whole).clamp(0.0, 12.0) as usize;
        let mut shown = format!("{value:.decimals$}");
        if shown.contains('.') {
            shown.truncate(shown.trim_end_matches('0').trim_end_matches('.').len());
        }
        Cell::Real(value, shown)
    }

    /// The cell as text.
    pub fn shown(&self) -> String {
        match self {
            Cell::Empty => String::new(),
            Cell::Text(text) | Cell::Real(_, text) => text.clone(),
            Cell::Whole(value) => value.to_string(),
        }
    }

    fn csv(&self) -> String {
        match self {
            Cell::Real(value, _) => unsigned_zero(*value).to_string(),
            Cell::Text(text) => quoted(text).into_owned(),
            cell => cell.shown(),
        }
    }

    fn json(&self) -> Value {
        match self {
            Cell::Empty => Value::Null,
            Cell::Text(text) => json!(text),
            Cell::Whole(value) => json!(value),
            Cell::Real(value, _) => tidy(json!(value)),
        }
    }

    fn is_number(&self) -> bool {
        matches!(self, Cell::Whole(_) | Cell::Real(..))
    }
}

/// A text as a field of CSV (RFC 4180), in quotes if necessary.
pub fn quoted(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::Text(text)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(cell: Option<T>) -> Cell {
        cell.map_or(Cell::Empty, Into::into)
    }
}

macro_rules! whole {
    ($($type:ty)*) => {
        $(impl From<$type> for Cell {
            fn from(value: $type) -> Cell {
                Cell::Whole(value.into())
            }
        })*
    };
}

whole!(u8 u16 u32 i32 i64);

impl Sheet {
    /// An empty sheet.
    pub fn new(title: impl Into<String>) -> Sheet {
        Sheet { title: title.into(), ..Sheet::default() }
    }

    /// Adds a result.
    pub fn fact(
        &mut self,
        key: &'static str,
        name: &'static str,
        value: impl Into<Cell>,
        unit: &'static str,
    ) {
        self.facts.push(Fact { key, name, value: value.into(), unit });
    }

    /// Writes the sheet.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write(&self, out: &mut impl Write, format: SheetFormat) -> io::Result<()> {
        match format {
            SheetFormat::Table => self.text(out),
            SheetFormat::Csv => self.csv(out),
            SheetFormat::Json => writeln!(out, "{}", self.json(0)),
        }
    }

    fn text(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "{}", self.title)?;
        if !self.facts.is_empty() {
            writeln!(out)?;
        }
        let wide = self.facts.iter().map(|fact| width(fact.name)).max().unwrap_or(0).max(16) + 2;
        for Fact { name, value, unit, .. } in &self.facts {
            line(out, format_args!("  {name:<wide$}{} {unit}", value.shown()))?;
        }
        if !self.rows.is_empty() {
            writeln!(out)?;
            self.table(out)?;
        }
        for (_, part) in self.parts.iter().filter(|(_, part)| !part.is_empty()) {
            writeln!(out)?;
            part.text(out)?;
        }
        if !self.notes.is_empty() {
            writeln!(out)?;
        }
        self.notes.iter().try_for_each(|note| writeln!(out, "  {note}"))
    }

    /// Whether the sheet has a title only.
    fn is_empty(&self) -> bool {
        self.facts.is_empty() && self.rows.is_empty() && self.parts.is_empty()
    }

    /// Columns as wide as their widest cell, numbers right-aligned.
    fn table(&self, out: &mut impl Write) -> io::Result<()> {
        let column = |i: usize| self.rows.iter().filter_map(move |row| row.get(i));
        let shape: Vec<(usize, bool)> = (self.columns.iter().enumerate())
            .map(|(i, (_, heading))| {
                let cells = column(i).map(|cell| width(&cell.shown()));
                (cells.max().unwrap_or(0).max(width(heading)), column(i).any(Cell::is_number))
            })
            .collect();
        let print = |out: &mut dyn Write, cells: &mut dyn Iterator<Item = String>| {
            let mut text = String::new();
            for (cell, (wide, right)) in cells.zip(&shape) {
                let gap = " ".repeat(wide.saturating_sub(width(&cell)));
                let (before, after) =
                    if *right { (gap, String::new()) } else { (String::new(), gap) };
                text += &format!("  {before}{cell}{after}");
            }
            line(out, text)
        };
        print(out, &mut self.columns.iter().map(|(_, heading)| (*heading).to_owned()))?;
        self.rows.iter().try_for_each(|row| print(out, &mut row.iter().map(Cell::shown)))
    }

    /// The table, or the facts if there is no table.
    fn csv(&self, out: &mut impl Write) -> io::Result<()> {
        let list = |cells: Vec<String>| cells.join(",");
        if self.columns.is_empty() {
            writeln!(out, "quantity,value,unit")?;
            return self.facts.iter().try_for_each(|fact| {
                writeln!(out, "{},{},{}", fact.key, fact.value.csv(), Cell::from(fact.unit).csv())
            });
        }
        writeln!(out, "{}", list(self.columns.iter().map(|(key, _)| (*key).to_owned()).collect()))?;
        self.rows
            .iter()
            .try_for_each(|row| writeln!(out, "{}", list(row.iter().map(Cell::csv).collect())))
    }

    /// One member a line and one row a line, with `indent` blanks before each.
    pub fn json(&self, indent: usize) -> String {
        let pad = " ".repeat(indent);
        let mut members = vec![format!("\"title\": {}", json!(self.title))];
        members.extend(self.facts.iter().map(|f| format!("\"{}\": {}", f.key, f.value.json())));
        if !self.columns.is_empty() {
            let row = |row: &Vec<Cell>| {
                let cells = self.columns.iter().zip(row);
                let cells = cells.map(|((key, _), cell)| format!("\"{key}\": {}", cell.json()));
                format!("\n{pad}    {{{}}}", cells.collect::<Vec<_>>().join(", "))
            };
            let rows: Vec<_> = self.rows.iter().map(row).collect();
            members.push(format!("\"rows\": [{}\n{pad}  ]", rows.join(",")));
        }
        let part = |(key, part): &(&str, Sheet)| format!("\"{key}\": {}", part.json(indent + 2));
        members.extend(self.parts.iter().map(part));
        members.push(format!("\"notes\": {}", json!(self.notes)));
        format!("{{\n{pad}  {}\n{pad}}}", members.join(&format!(",\n{pad}  ")))
    }
}

/// Writes a line without blanks at its end.
fn line(out: &mut dyn Write, text: impl Display) -> io::Result<()> {
    writeln!(out, "{}", text.to_string().trim_end())
}

/// The width in letters, not bytes: "ω′" is two wide.
fn width(text: &str) -> usize {
    text.chars().count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet() -> Sheet {
        let mut sheet = Sheet::new("A sheet");
        sheet.fact("virtual_top", "virtual top", 88_888u32, "");
        sheet.fact("rate", "real rate", Cell::fixed(16e6 / 88_888.0, 4), "steps/s");
        sheet.columns = vec![("step", "step"), ("speed", "ω, rad/s"), ("remark", "remark")];
        sheet.rows = vec![
            vec![1u32.into(), Cell::fixed(0.1 + 0.2, 2), Cell::Empty],
            vec![10u32.into(), Cell::fixed(-0.001, 2), "a, \"b\"".into()],
        ];
        sheet.notes.push("That is all.".into());
        sheet
    }

    fn written(format: SheetFormat) -> String {
        let mut out = Vec::new();
        sheet().write(&mut out, format).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn text_is_in_columns() {
        let text = "A sheet\n\n  virtual top       88888\n  real rate         180.0018 steps/s\n\n  \
                    step  ω, rad/s  remark\n     1      0.30\n    10      0.00  a, \"b\"\n\n  That is all.\n";
        assert_eq!(written(SheetFormat::Table), text);
    }

    #[test]
    fn csv_has_all_digits() {
        let csv = "step,speed,remark\n1,0.30000000000000004,\n10,-0.001,\"a, \"\"b\"\"\"\n";
        assert_eq!(written(SheetFormat::Csv), csv);
        let mut facts = Vec::new();
        Sheet { columns: Vec::new(), rows: Vec::new(), ..sheet() }.csv(&mut facts).unwrap();
        let facts = String::from_utf8(facts).unwrap();
        assert!(
            facts.starts_with("quantity,value,unit\nvirtual_top,88888,\nrate,180.001"),
            "{facts}"
        );
    }

    #[test]
    fn json_is_json() {
        let value: Value = serde_json::from_str(&written(SheetFormat::Json)).unwrap();
        assert_eq!((&value["virtual_top"], &value["title"]), (&json!(88_888), &json!("A sheet")));
        assert_eq!(value["rows"][1], json!({"step": 10, "speed": -0.001, "remark": "a, \"b\""}));
        assert_eq!(value["rows"][0]["remark"], Value::Null);
    }

    #[test]
    fn a_sheet_has_other_tables() {
        let whole = Sheet { parts: vec![("more", sheet())], ..Sheet::new("All") };
        let written = |format| {
            let mut out = Vec::new();
            whole.write(&mut out, format).unwrap();
            String::from_utf8(out).unwrap()
        };
        let part = self::written(SheetFormat::Table);
        assert_eq!(written(SheetFormat::Table), format!("All\n\n{part}"));
        let value: Value = serde_json::from_str(&written(SheetFormat::Json)).unwrap();
        assert_eq!(value["more"]["rows"][0]["step"], json!(1));
    }

    #[test]
    fn digits_are_counted_from_the_first() {
        let shown = |value, digits| Cell::digits(value, digits).shown();
        assert_eq!(shown(54.000_540_01, 8), "54.00054");
        assert_eq!(shown(0.238_418_579, 9), "0.238418579");
        assert_eq!(shown(16_000.0, 3), "16000");
        assert_eq!(shown(0.0, 3), "0");
        assert_eq!(shown(f64::INFINITY, 3), "inf");
    }
}
