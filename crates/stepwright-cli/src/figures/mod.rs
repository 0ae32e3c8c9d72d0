//! `stepwright figures`: the figures and tables of Austin's article, recomputed.
//!
//! Made from its equations in f64 ([`law`]), beside the numbers that it prints
//! ([`printed`]). One figure or a few that belong together are a file:
//!
//! | module | what |
//! | --- | --- |
//! | `tables` | Table 1, accuracy; Table 2, changes of acceleration |
//! | `ramp` | Figures 2 to 4, the linear ramp |
//! | `piecewise`, `power`, `factor` | Figures 5 to 7, ways to approach the top speed ([`smooth`]) |
//! | `dual` | Figure 8, transitions up and down |

mod dual;
mod factor;
pub mod law;
mod piecewise;
mod power;
mod printed;
mod ramp;
mod smooth;
mod tables;
mod trace;

use std::io::{self, Write};

use clap::ValueEnum;

use crate::failure::{Failure, unless_closed};
use crate::plot::{Figure, PlotFile};
use crate::sheet::{Cell, Format, Sheet};
use law::{MOTOR, Motor};
use printed::Printed;
use trace::Trace;

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
    /// Which; without it, what there is
    #[arg(value_enum, hide_possible_values = true, value_name = "2…8|table-1|table-2|all")]
    which: Option<Which>,
    /// How to print it
    #[arg(long, value_enum, default_value_t = Format::Table, help_heading = "Output")]
    format: Format,
    /// Draw it (.svg, .png or .html)
    #[arg(long, value_name = "FILE", requires = "which", help_heading = "Output")]
    plot: Vec<PlotFile>,
    /// Print every delay of its curves instead
    #[arg(long, requires = "which", help_heading = "Output")]
    points: bool,
}

/// The figures and tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Which {
    #[value(name = "2", alias = "figure-2")]
    Figure2,
    #[value(name = "3", alias = "figure-3")]
    Figure3,
    #[value(name = "4", alias = "figure-4")]
    Figure4,
    #[value(name = "5", alias = "figure-5")]
    Figure5,
    #[value(name = "6", alias = "figure-6")]
    Figure6,
    #[value(name = "7", alias = "figure-7")]
    Figure7,
    #[value(name = "8", alias = "figure-8")]
    Figure8,
    #[value(name = "table-1")]
    Table1,
    #[value(name = "table-2")]
    Table2,
    All,
}

impl Which {
    /// In the article's order.
    const EACH: [Which; 9] = [
        Which::Table1,
        Which::Figure2,
        Which::Figure3,
        Which::Figure4,
        Which::Table2,
        Which::Figure5,
        Which::Figure6,
        Which::Figure7,
        Which::Figure8,
    ];

    fn name(self) -> String {
        self.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
    }

    fn draw(self) -> Vec<Drawing> {
        vec![match self {
            Which::Figure2 => ramp::whole(),
            Which::Figure3 => ramp::start(),
            Which::Figure4 => ramp::end(),
            Which::Figure5 => piecewise::draw(),
            Which::Figure6 => power::draw(),
            Which::Figure7 => factor::draw(),
            Which::Figure8 => dual::draw(),
            Which::Table1 => tables::accuracy(),
            Which::Table2 => tables::changes(),
            Which::All => return Which::EACH.into_iter().flat_map(Which::draw).collect(),
        }]
    }
}

/// A figure or a table.
struct Drawing {
    /// Its numbers.
    sheet: Sheet,
    /// Its picture; tables have none.
    figure: Option<Figure>,
    /// Its curves, delay by delay.
    traces: Vec<Trace>,
    /// Every number that has, or could have, one of the article beside it.
    printed: Vec<Printed>,
}

impl Drawing {
    /// Numbers only.
    fn new(sheet: Sheet) -> Drawing {
        Drawing { sheet, figure: None, traces: Vec::new(), printed: Vec::new() }
    }

    /// Its delays as a sheet.
    fn points(&self) -> Sheet {
        Sheet {
            columns: Trace::COLUMNS.to_vec(),
            rows: self.traces.iter().flat_map(Trace::rows).collect(),
            ..Sheet::new(self.sheet.title.clone())
        }
    }
}

/// Puts what a figure is of above its table: speeds and accelerations in radians.
fn given(sheet: &mut Sheet, accel: f64, decel: Option<f64>, top: f64) {
    let Motor { hz, step } = MOTOR;
    sheet.fact("timer_hz", "timer", Cell::fixed(hz, 0), "Hz");
    sheet.fact("step_deg", "step", Cell::digits(step.to_degrees(), 3), "°");
    sheet.fact("top_speed_rad_s", "top speed", Cell::digits(top, 5), "rad/s");
    sheet.fact("accel_rad_s2", "acceleration", Cell::digits(accel, 5), "rad/s²");
    if let Some(decel) = decel {
        sheet.fact("decel_rad_s2", "deceleration", Cell::digits(decel, 5), "rad/s²");
    }
}

/// Prints, and draws if asked to.
pub fn run(args: Args) -> Result<(), Failure> {
    let Some(which) = args.which else { return list(args.format) };
    let drawings = which.draw();
    let pictures: Vec<(Which, &Figure)> = (kinds(which).zip(&drawings))
        .filter_map(|(kind, drawing)| Some((kind, drawing.figure.as_ref()?)))
        .collect();
    if pictures.is_empty() && (args.points || !args.plot.is_empty()) {
        let name = which.name();
        return Err(Failure::usage(format!("{name} has no curves: it is a table"))
            .hint("the figures have, 2 to 8"));
    }
    let drawn = drawings.iter().filter(|drawing| !args.points || !drawing.traces.is_empty());
    let sheets: Vec<Sheet> = drawn
        .map(|drawing| if args.points { drawing.points() } else { drawing.sheet.clone() })
        .collect();
    let mut out = io::stdout().lock();
    unless_closed(write(&mut out, &sheets, args.format).and_then(|()| out.flush()))?;
    for file in &args.plot {
        for (kind, figure) in &pictures {
            let one = file.numbered(&kind.name());
            let file = if which == Which::All { &one } else { file };
            file.save(figure)?;
        }
    }
    Ok(())
}

/// One, or all of them.
fn kinds(which: Which) -> impl Iterator<Item = Which> {
    let each = if which == Which::All { Which::EACH.to_vec() } else { vec![which] };
    each.into_iter()
}

fn write(out: &mut impl Write, sheets: &[Sheet], format: Format) -> io::Result<()> {
    if let [sheet] = sheets {
        return sheet.write(out, format);
    }
    if format == Format::Json {
        let all: Vec<_> = sheets.iter().map(|sheet| format!("  {}", sheet.json(2))).collect();
        return writeln!(out, "[\n{}\n]", all.join(",\n"));
    }
    for (i, sheet) in sheets.iter().enumerate() {
        if i > 0 {
            writeln!(out)?;
        }
        if format == Format::Csv {
            writeln!(out, "# {}", sheet.title)?;
        }
        sheet.write(out, format)?;
    }
    Ok(())
}

/// What there is.
fn list(format: Format) -> Result<(), Failure> {
    let row = |kind: Which| {
        let titles = kind.draw().into_iter().map(|drawing| drawing.sheet.title);
        vec![kind.name().into(), titles.collect::<String>().into()]
    };
    let sheet = Sheet {
        columns: vec![("which", "which"), ("what", "what it is")],
        rows: Which::EACH.into_iter().map(row).collect(),
        notes: vec!["Give one of them, or all: stepwright figures 8 --plot figure-8.png".into()],
        ..Sheet::new("Figures and tables of \"Generate stepper-motor speed profiles in real time\"")
    };
    let mut out = io::stdout().lock();
    unless_closed(sheet.write(&mut out, format).and_then(|()| out.flush()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every printed number to its last digit, but for the four that can't be right.
    #[test]
    fn every_printed_digit() {
        let mut right = 0;
        let mut wrong = Vec::new();
        for drawing in Which::All.draw() {
            for printed in &drawing.printed {
                let agrees = printed.agrees();
                assert_eq!(
                    agrees,
                    printed.remark().is_none(),
                    "{}: {printed:?}",
                    drawing.sheet.title
                );
                right += u32::from(agrees && printed.published() != Cell::Empty);
                wrong.extend(printed.remark());
            }
        }
        // 25 of Table 1, 17 of Table 2, 6 of Figure 2 and its text, 4 of Figure 8.
        assert_eq!((right, wrong.len()), (25 + 17 + 6 + 4, 4));
    }

    #[test]
    fn tables_have_as_many_cells_as_columns() {
        for drawing in Which::All.draw() {
            for sheet in [&drawing.sheet, &drawing.points()] {
                let columns = sheet.columns.len();
                assert!(sheet.rows.iter().all(|row| row.len() == columns), "{}", sheet.title);
            }
        }
    }

    /// Curves hold finite numbers, in the order of time.
    #[test]
    fn curves_can_be_drawn() {
        for figure in Which::All.draw().into_iter().filter_map(|drawing| drawing.figure) {
            for panel in figure.rows.iter().flat_map(|(_, panels)| panels) {
                for curve in &panel.curves {
                    let points = &curve.points;
                    assert!(points.len() > 1, "{}: {}", figure.title, curve.name);
                    assert!(points.iter().all(|(x, y)| x.is_finite() && y.is_finite()));
                    assert!(points.is_sorted_by_key(|p| p.0), "{}: {}", figure.title, curve.name);
                }
            }
        }
    }
}
