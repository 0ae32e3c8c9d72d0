//! `calc range`: the rates that a timer can make (the Arduino driver, section 6).

use stepwright_plan::calc::range;
use stepwright_plan::sheet::Sheet;

use super::Calculator;
use super::clock::ClockArgs;
use crate::failure::Failure;
use crate::quantity::GeometryArgs;

/// A timer.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    clock: ClockArgs,
    #[command(flatten)]
    geometry: GeometryArgs,
}

impl Calculator for Args {
    fn sheet(&self) -> Result<Sheet, Failure> {
        Ok(range(&self.clock.hardware()?, &self.geometry.geometry()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use stepwright_plan::sheet::Cell;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn sheet(line: &str) -> Sheet {
        Line::parse_from(format!("calc {line}").split_whitespace()).args.sheet().unwrap()
    }

    fn real(cell: &Cell) -> f64 {
        match cell {
            Cell::Real(value, _) => *value,
            other => panic!("{other:?}"),
        }
    }

    fn fact(sheet: &Sheet, key: &str) -> f64 {
        real(&sheet.facts.iter().find(|fact| fact.key == key).expect(key).value)
    }

    /// Section 6, with 16 bits; "~90 RPM" is 73.2, and "12 RPM" 9.16.
    #[test]
    fn an_unos_timer_1() {
        let sheet = sheet("");
        assert_eq!(format!("{:.9}", fact(&sheet, "lowest_steps_s")), "0.238418579");
        assert_eq!(format!("{:.4}", fact(&sheet, "turn_s")), "838.8608");
        assert_eq!(fact(&sheet, "highest_steps_s"), 25_000.0);
        let rows = &sheet.rows;
        assert_eq!((rows.len(), &rows[0][0]), (5, &Cell::Whole(1)));
        assert_eq!(real(&rows[0][1]), 244.140_625);
        assert_eq!(format!("{:.1}", real(&rows[0][2])), "73.2");
        assert_eq!(format!("{:.2}", real(&rows[1][2])), "9.16");
        assert_eq!(real(&rows[0][5]), 25_000.0);
    }

    /// Section 6, timer 2: its largest top, 255.
    #[test]
    fn timer_2() {
        let sheet = sheet("--timer avr8-timer2");
        let last = &sheet.rows[sheet.rows.len() - 1];
        assert_eq!(format!("{:.5}", real(&last[3])), "61.27451");
        assert_eq!(format!("{:.5}", real(&last[4])), "18.38235");
    }

    /// No prescaler makes an interval below the shortest.
    #[test]
    fn the_highest_rate_is_kept() {
        for line in ["", "--timer avr8", "--timer capture16", "--timer wide32"] {
            let sheet = sheet(line);
            let highest = fact(&sheet, "highest_steps_s");
            assert!(sheet.rows.iter().all(|row| real(&row[5]) <= highest), "{line}");
        }
    }

    /// The timer accepts the lowest rate, however slow its clock is.
    #[test]
    fn the_lowest_rate_is_kept() {
        for (line, hz, longest) in [
            ("", 16e6, 67_108_864.0),
            ("--timer avr8 --oscillator 1Hz", 1.0, 262_144.0),
            ("--timer wide32", 16e6, 2_147_483_647.0),
            ("--timer wide32 --oscillator 100Hz", 100.0, 2_147_483_647.0),
        ] {
            let sheet = sheet(line);
            let [lowest, turn] = ["lowest_steps_s", "turn_s"].map(|key| fact(&sheet, key));
            assert!((lowest * longest / hz - 1.0).abs() < 1e-12, "{line}: {lowest}");
            assert!((turn * lowest / 200.0 - 1.0).abs() < 1e-12, "{line}: {turn}");
            assert!(sheet.rows.iter().all(|row| real(&row[1]) >= lowest), "{line}");
            assert!(sheet.rows.iter().all(|row| real(&row[3]) >= lowest), "{line}");
        }
    }
}
