//! Table 1, the accuracy of the approximation, and Table 2, changes of acceleration.

use super::Drawing;
use super::printed::Printed;
use crate::equations::{MOTOR, exact_ratio, next, ratio, renumber};
use crate::sheet::{Cell, Sheet};

/// c_n / c_{n−1} by Eq 9 and by Eq 11.
pub fn accuracy() -> Drawing {
    // The article's three columns.
    const TABLE: [(u32, [&str; 3]); 9] = [
        (1, ["0.4142", "0.6000", "0.4485"]),
        (2, ["0.7673", "0.7778", "0.0136"]),
        (3, ["0.8430", "0.8462", "0.00370"]),
        (4, ["0.8810", "0.8824", "0.00152"]),
        (5, ["0.9041", "0.9048", "7.66E-4"]),
        (6, ["0.9196", "0.9200", "4.41E-4"]),
        (10, ["0.9511", "0.9512", "9.42E-5"]),
        (100, ["0.9950", "0.9950", "9.38E-8"]),
        (1000, ["0.9995", "0.9995", "9.37E-11"]),
    ];
    const TWICE: &str = "it is 0.0036948: rounded twice, over 0.003695";
    const LOST: &str = "it is 9.375005E-11: (9) as printed subtracts roots, which loses digits";
    let mut drawing = Drawing::new(Sheet {
        columns: vec![
            ("n", "step n"),
            ("exact_published", "exact (9), published"),
            ("exact", "computed"),
            ("approx_published", "approx (11), published"),
            ("approx", "computed"),
            ("error_published", "relative error, published"),
            ("error", "computed"),
            ("remark", "remark"),
        ],
        notes: vec!["Eq 9's left side must read c_n / c_(n−1), as in Eq 11.".into()],
        ..Sheet::new("Table 1: accuracy of the step-delay approximation, c_n / c_(n−1)")
    });
    for (n, texts) in TABLE {
        let (exact, approx) = (exact_ratio(n.into()), ratio(n.into()));
        let values = [exact, approx, approx / exact - 1.0];
        let mut row: Vec<Cell> = vec![n.into()];
        let mut remark = None;
        for (text, value) in texts.into_iter().zip(values) {
            let printed = match text {
                "0.00370" => Printed::wrong(text, value, TWICE),
                "9.37E-11" => Printed::wrong(text, value, LOST),
                _ => Printed::right(text, value),
            };
            row.extend([printed.published(), printed.computed()]);
            remark = remark.or(printed.remark());
            drawing.printed.push(printed);
        }
        row.push(remark.into());
        drawing.sheet.rows.push(row);
    }
    drawing
}

/// Changes from 10 to 5 and to −20 rad/s² at step 200.
pub fn changes() -> Drawing {
    let (before, slower, brake) = (10.0, 5.0, -20.0);
    let c198 = MOTOR.exact(before, 198.0);
    let c199 = next(c198, 199.0);
    let mut drawing = Drawing::new(Sheet {
        columns: vec![
            ("i", "step i"),
            ("n_published", "n_i, published"),
            ("n", "computed"),
            ("c_published", "c_i (13), published"),
            ("c", "computed"),
            ("accel_published", "ω′ (3), published"),
            ("accel", "computed"),
            ("remark", "remark"),
        ],
        notes: vec![
            "c198 is exact, by Eq 8; n changes at step 199 by Eq 18: 10 · 199.5 = 5 · 399 = \
             −20 · −99.75."
                .into(),
            "\"499.25+1\" in the notes of the printed table is 4·(−99.25)+1.".into(),
        ],
        ..Sheet::new("Table 2: acceleration changes from 10 to 5 and to −20 rad/s² at step 200")
    });
    let mut row = |i: u32, n: Printed, c: Printed, accel: Option<Printed>| {
        let accels = accel.as_ref();
        drawing.sheet.rows.push(vec![
            i.into(),
            n.published(),
            n.computed(),
            c.published(),
            c.computed(),
            accels.map_or(Cell::Empty, Printed::published),
            accels.map_or(Cell::Empty, Printed::computed),
            c.remark().into(),
        ]);
        drawing.printed.extend([n, c].into_iter().chain(accel));
    };
    let whole = Printed::right("198", 198.0);
    row(198, whole, Printed::right("2813.067", c198), None);
    let accel = |text, c1, c2| Some(Printed::right(text, MOTOR.accel(c1, c2)));
    let n = Printed::right("199", 199.0);
    row(199, n, Printed::right("2806.008", c199), accel("10", c198, c199));

    let n199 = renumber(199.0, before, slower);
    let (n200, n201) = (n199 + 1.0, n199 + 2.0);
    let c200 = next(c199, n200);
    let c201 = next(c200, n201);
    row(199, Printed::right("398.5", n199), Printed::none(c199, 3), None);
    const MISPRINT: &str = "a misprint: the next row follows from 2802.498 only";
    let c = Printed::wrong("2803.498", c200, MISPRINT);
    row(200, Printed::right("399.5", n200), c, accel("5", c199, c200));
    let c = Printed::right("2799.001", c201);
    row(201, Printed::right("400.5", n201), c, accel("5", c200, c201));

    let n199 = renumber(199.0, before, brake);
    let (n200, n201) = (n199 + 1.0, n199 + 2.0);
    let c200 = next(c199, n200);
    let c201 = next(c200, n201);
    row(199, Printed::right("-100.25", n199), Printed::none(c199, 3), None);
    const ROUNDED: &str = "the last digit: from c199 as printed, 2806.008, it is 2820.180";
    let c = Printed::wrong("2820.180", c200, ROUNDED);
    row(200, Printed::right("-99.25", n200), c, accel("-20", c199, c200));
    let c = Printed::right("2834.568", c201);
    row(201, Printed::right("-98.25", n201), c, accel("-20", c200, c201));
    drawing
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The remarks of Table 1 and Table 2 are right.
    #[test]
    fn the_misprints_are_such() {
        let shown = |c: f64| format!("{c:.3}");
        let error = ratio(3.0) / exact_ratio(3.0) - 1.0;
        assert_eq!(format!("{error:.5} {error:.6}"), "0.00369 0.003695");
        // Eq 9 as it is printed, in the 53 bits of a spreadsheet.
        let n = 1000.0f64;
        let printed = ((1.0 + 1.0 / n).sqrt() - 1.0) / (1.0 - (1.0 - 1.0 / n).sqrt());
        assert_eq!(format!("{:.2E}", ratio(n) / printed - 1.0), "9.37E-11");
        assert_eq!(format!("{:.5E}", ratio(n) / exact_ratio(n) - 1.0), "9.37503E-11");
        // 2799.001 follows from 2802.498, but not from the printed 2803.498.
        assert_eq!(shown(next(2802.498, 400.5)), "2799.001");
        assert_eq!(shown(next(2803.498, 400.5)), "2800.000");
        assert_eq!(shown(next(2806.008, -99.25)), "2820.180");
        assert_eq!(shown(next(next(MOTOR.exact(10.0, 198.0), 199.0), -99.25)), "2820.179");
    }

    /// The error falls with n³, as the article says.
    #[test]
    fn the_error_falls_with_the_cube() {
        let error = |n: f64| ratio(n) / exact_ratio(n) - 1.0;
        for n in [10.0, 100.0, 1000.0] {
            let factor = error(n) / error(2.0 * n);
            assert!((factor - 8.0).abs() < 8.0 / n, "{n}: {factor}");
        }
    }
}
