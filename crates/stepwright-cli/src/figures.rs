//! `stepwright figures`: the figures and tables of Austin's article, recomputed.

use std::io::{self, Write};

use clap::builder::{PossibleValue, PossibleValuesParser};
use stepwright_plan::figures::ArticleFigure;
use stepwright_plan::sheet::{Sheet, SheetFormat};
use stepwright_plot::{Figure, PlotFile};

use crate::failure::{Failure, unless_closed};
use crate::plot;

/// The name of all of them.
const ALL: &str = "all";

/// The figures and tables of David Austin's article, recomputed
///
/// "Generate stepper-motor speed profiles in real time": each figure from its
/// equations, in floating point, beside the numbers that are printed there.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright figures                          what there is
  stepwright figures table-1                  the approximation's accuracy
  stepwright figures 8 --plot figure-8.png    and its picture
  stepwright figures 7 --points --format csv  every delay of its curves
  stepwright figures all --plot figure.svg    figure-2.svg … figure-8.svg")]
pub struct Args {
    /// Which figure or table; without it, a list of them
    #[arg(value_parser = names(), hide_possible_values = true)]
    #[arg(value_name = "2…8|table-1|table-2|all")]
    which: Option<String>,
    /// How to print it; csv of all has a line `# TITLE` before each table, and an empty one behind it
    #[arg(long, value_enum, default_value_t = SheetFormat::Table, help_heading = "Output")]
    format: SheetFormat,
    /// Draw it (.svg, .png or .html)
    #[arg(long, value_name = "FILE", requires = "which", help_heading = "Output")]
    plot: Vec<PlotFile>,
    /// Print every delay of its curves instead
    #[arg(long, requires = "which", help_heading = "Output")]
    points: bool,
}

/// The names of the figures and tables, in the order of their letters, and `all`.
fn names() -> PossibleValuesParser {
    let mut names = ArticleFigure::EACH.map(ArticleFigure::name);
    names.sort_unstable();
    let value = |name: &'static str| match name.parse::<u8>() {
        Ok(_) => PossibleValue::new(name).alias(format!("figure-{name}")),
        Err(_) => PossibleValue::new(name),
    };
    PossibleValuesParser::new(names.into_iter().chain([ALL]).map(value))
}

/// Prints the figure. Draws it if requested.
pub fn run(args: Args) -> Result<(), Failure> {
    let Some(which) = &args.which else { return list(args.format) };
    let name = which.strip_prefix("figure-").unwrap_or(which);
    let wanted = ArticleFigure::EACH.into_iter().filter(|one| [one.name(), ALL].contains(&name));
    let drawings: Vec<_> = wanted.map(|one| (one, one.draw())).collect();
    let pictures: Vec<(ArticleFigure, &Figure)> = drawings
        .iter()
        .filter_map(|(kind, drawing)| Some((*kind, drawing.figure.as_ref()?)))
        .collect();
    if pictures.is_empty() && (args.points || !args.plot.is_empty()) {
        return Err(Failure::usage(format!("{name} has no curves: it is a table"))
            .hint("the figures have, 2 to 8"));
    }
    let drawn = drawings.iter().filter(|(_, drawing)| !args.points || !drawing.traces.is_empty());
    let sheets: Vec<Sheet> = drawn
        .map(|(_, drawing)| if args.points { drawing.points() } else { drawing.sheet.clone() })
        .collect();
    let mut out = io::stdout().lock();
    unless_closed(write(&mut out, &sheets, args.format).and_then(|()| out.flush()))?;
    for file in &args.plot {
        for (kind, figure) in &pictures {
            let one = file.numbered(kind.name());
            let file = if name == ALL { &one } else { file };
            plot::save(file, figure)?;
        }
    }
    Ok(())
}

fn write(out: &mut impl Write, sheets: &[Sheet], format: SheetFormat) -> io::Result<()> {
    if let [sheet] = sheets {
        return sheet.write(out, format);
    }
    if format == SheetFormat::Json {
        let all: Vec<_> = sheets.iter().map(|sheet| format!("  {}", sheet.json(2))).collect();
        return writeln!(out, "[\n{}\n]", all.join(",\n"));
    }
    for (i, sheet) in sheets.iter().enumerate() {
        if i > 0 {
            writeln!(out)?;
        }
        if format == SheetFormat::Csv {
            writeln!(out, "# {}", sheet.title)?;
        }
        sheet.write(out, format)?;
    }
    Ok(())
}

/// Prints the list of figures and tables.
fn list(format: SheetFormat) -> Result<(), Failure> {
    let row = |kind: ArticleFigure| vec![kind.name().into(), kind.draw().sheet.title.into()];
    let sheet = Sheet {
        columns: vec![("which", "which"), ("what", "what it is")],
        rows: ArticleFigure::EACH.into_iter().map(row).collect(),
        notes: vec!["Give one of them, or all: stepwright figures 8 --plot figure-8.png".into()],
        ..Sheet::new("Figures and tables of \"Generate stepper-motor speed profiles in real time\"")
    };
    let mut out = io::stdout().lock();
    unless_closed(sheet.write(&mut out, format).and_then(|()| out.flush()))
}
