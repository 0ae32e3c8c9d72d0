//! The figures and tables of Austin's article, recomputed.
//!
//! They are computed from its equations in f64 ([`equations`](crate::equations)) and shown beside the
//! numbers that it prints (`printed`). Each file has one figure, or a few that belong together:
//!
//! | module | what |
//! | --- | --- |
//! | `tables` | Table 1, accuracy; Table 2, changes of acceleration |
//! | `ramp` | Figures 2 to 4, the linear ramp |
//! | `piecewise`, `power`, `factor` | Figures 5 to 7, ways to approach the top speed (`smooth`) |
//! | `dual` | Figure 8, transitions up and down |

mod dual;
mod factor;
mod piecewise;
mod power;
mod printed;
mod ramp;
mod smooth;
mod tables;
mod trace;

use stepwright_plot::Figure;

use crate::equations::{Counter, MOTOR};
use crate::sheet::{Cell, Sheet};
pub use printed::Printed;
pub use trace::Trace;

/// A figure or a table of "Generate stepper-motor speed profiles in real time".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArticleFigure {
    /// c_n / c_(n−1), exact and approximated.
    Table1,
    /// The linear ramp.
    Figure2,
    /// Its first steps.
    Figure3,
    /// Its last steps.
    Figure4,
    /// Changes of acceleration.
    Table2,
    /// Piecewise linear.
    Figure5,
    /// Power term.
    Figure6,
    /// Linear factor.
    Figure7,
    /// Linear factors up and down.
    Figure8,
}

impl ArticleFigure {
    /// In the article's order.
    pub const EACH: [ArticleFigure; 9] = [
        ArticleFigure::Table1,
        ArticleFigure::Figure2,
        ArticleFigure::Figure3,
        ArticleFigure::Figure4,
        ArticleFigure::Table2,
        ArticleFigure::Figure5,
        ArticleFigure::Figure6,
        ArticleFigure::Figure7,
        ArticleFigure::Figure8,
    ];

    /// Its name: `8`, `table-1`.
    pub fn name(self) -> &'static str {
        match self {
            ArticleFigure::Table1 => "table-1",
            ArticleFigure::Figure2 => "2",
            ArticleFigure::Figure3 => "3",
            ArticleFigure::Figure4 => "4",
            ArticleFigure::Table2 => "table-2",
            ArticleFigure::Figure5 => "5",
            ArticleFigure::Figure6 => "6",
            ArticleFigure::Figure7 => "7",
            ArticleFigure::Figure8 => "8",
        }
    }

    /// Recomputes the figure or table.
    pub fn draw(self) -> Drawing {
        match self {
            ArticleFigure::Figure2 => ramp::whole(),
            ArticleFigure::Figure3 => ramp::start(),
            ArticleFigure::Figure4 => ramp::end(),
            ArticleFigure::Figure5 => piecewise::draw(),
            ArticleFigure::Figure6 => power::draw(),
            ArticleFigure::Figure7 => factor::draw(),
            ArticleFigure::Figure8 => dual::draw(),
            ArticleFigure::Table1 => tables::accuracy(),
            ArticleFigure::Table2 => tables::changes(),
        }
    }
}

/// A recomputed figure or table.
pub struct Drawing {
    /// Its numbers.
    pub sheet: Sheet,
    /// Its picture; tables have none.
    pub figure: Option<Figure>,
    /// Its curves, delay by delay.
    pub traces: Vec<Trace>,
    /// Every number that has, or could have, a number of the article beside it.
    pub printed: Vec<Printed>,
}

impl Drawing {
    /// A drawing of numbers only.
    fn new(sheet: Sheet) -> Drawing {
        Drawing { sheet, figure: None, traces: Vec::new(), printed: Vec::new() }
    }

    /// The delays as a sheet.
    pub fn points(&self) -> Sheet {
        Sheet {
            columns: Trace::COLUMNS.to_vec(),
            rows: self.traces.iter().flat_map(Trace::rows).collect(),
            ..Sheet::new(self.sheet.title.clone())
        }
    }
}

/// Writes the constants of a figure above its table: speeds and accelerations in radians.
fn given(sheet: &mut Sheet, accel: f64, decel: Option<f64>, top: f64) {
    let Counter { hz, step } = MOTOR;
    sheet.fact("timer_hz", "timer", Cell::fixed(hz, 0), "Hz");
    sheet.fact("step_deg", "step", Cell::digits(step.to_degrees(), 3), "°");
    sheet.fact("top_speed_rad_s", "top speed", Cell::digits(top, 5), "rad/s");
    sheet.fact("accel_rad_s2", "acceleration", Cell::digits(accel, 5), "rad/s²");
    if let Some(decel) = decel {
        sheet.fact("decel_rad_s2", "deceleration", Cell::digits(decel, 5), "rad/s²");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every printed number agrees to its last digit, except for the four that can't be right.
    #[test]
    fn every_printed_digit() {
        let mut right = 0;
        let mut wrong = Vec::new();
        for drawing in ArticleFigure::EACH.map(ArticleFigure::draw) {
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
        for drawing in ArticleFigure::EACH.map(ArticleFigure::draw) {
            for sheet in [&drawing.sheet, &drawing.points()] {
                let columns = sheet.columns.len();
                assert!(sheet.rows.iter().all(|row| row.len() == columns), "{}", sheet.title);
            }
        }
    }

    /// Curves hold finite numbers in the order of time.
    #[test]
    fn curves_can_be_drawn() {
        for figure in ArticleFigure::EACH
            .map(ArticleFigure::draw)
            .into_iter()
            .filter_map(|drawing| drawing.figure)
        {
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
