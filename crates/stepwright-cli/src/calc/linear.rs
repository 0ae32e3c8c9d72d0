//! `calc belt` and `calc screw`: length of a step and linear speed (stepper_h).

use stepwright_plan::calc::Gearing;
use stepwright_plan::sheet::Sheet;
use stepwright_units::measure::millimetres;

use super::Calculator;
use crate::failure::Failure;
use crate::quantity::whole_in;

/// A belt.
#[derive(clap::Args)]
pub struct BeltArgs {
    /// Teeth of the pulley
    #[arg(long, value_name = "N", value_parser = whole_in::<u32>(1..=10_000))]
    teeth: u32,
    /// Distance between two teeth: 2mm (GT2), 3mm, 0.2in …
    #[arg(long, value_name = "LENGTH", default_value = "2mm", value_parser = millimetres)]
    pitch: f64,
    #[command(flatten)]
    motor: Gearing,
}

/// A screw.
#[derive(clap::Args)]
pub struct ScrewArgs {
    /// Distance between two threads: 2mm, 0.1in …
    #[arg(long, value_name = "LENGTH", value_parser = millimetres)]
    pitch: f64,
    /// Number of threads: with 4 threads of 2 mm a turn is 8 mm
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = whole_in::<u32>(1..=100))]
    starts: u32,
    #[command(flatten)]
    motor: Gearing,
}

impl Calculator for BeltArgs {
    fn sheet(&self) -> Result<Sheet, Failure> {
        Ok(self.motor.belt(self.teeth, self.pitch)?)
    }
}

impl Calculator for ScrewArgs {
    fn sheet(&self) -> Result<Sheet, Failure> {
        Ok(self.motor.screw(self.pitch, self.starts)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use stepwright_plan::sheet::Cell;

    #[derive(Parser)]
    enum Line {
        Belt(BeltArgs),
        Screw(ScrewArgs),
    }

    fn sheet(line: &str) -> Result<Sheet, Failure> {
        match Line::parse_from(format!("calc {line}").split_whitespace()) {
            Line::Belt(args) => args.sheet(),
            Line::Screw(args) => args.sheet(),
        }
    }

    fn real(cell: &Cell) -> f64 {
        match cell {
            Cell::Real(value, _) => *value,
            other => panic!("{other:?}"),
        }
    }

    /// stepper_h: 2 mm · 20 teeth = 40 mm, and the step of each kind in nm. (Its
    /// "300 · 32 = 6400" is 200 · 32.)
    #[test]
    fn steps_of_a_gt2_belt() {
        let sheet = sheet("belt --teeth 20").unwrap();
        assert_eq!(real(&sheet.facts[0].value), 40.0);
        let steps: Vec<_> = sheet.rows.iter().map(|row| (real(&row[1]), real(&row[3]))).collect();
        let want = [
            (200.0, 200_000.0),
            (400.0, 100_000.0),
            (800.0, 50_000.0),
            (1600.0, 25_000.0),
            (3200.0, 12_500.0),
            (6400.0, 6250.0),
        ];
        assert_eq!(steps, want);
        assert_eq!(real(&sheet.rows[5][2]), 6.25);
    }

    /// The travel of a turn is that of the belt, in millimetres per second too.
    #[test]
    fn a_speed_of_the_belt() {
        let sheet = sheet("belt --teeth 20 --speed 60mm/s").unwrap();
        let facts: Vec<_> = sheet.facts.iter().map(|fact| real(&fact.value)).collect();
        assert_eq!(facts, [40.0, 1.5, 60.0]);
    }

    /// stepper_h's speeds: it cuts rev/s after a digit, and computes mm/s from that.
    #[test]
    fn speeds_of_a_gt2_belt() {
        let cases = [
            (1, 1500, 3.3, 132.0),
            (1, 1000, 5.0, 200.0),
            (2, 650, 3.8, 152.0),
            (4, 330, 3.8, 152.0), // 3.788, rounded this time
            (8, 180, 3.5, 140.0), // it prints 3.8 and 152 for 1/0.288
            (16, 80, 3.9, 156.0),
            (32, 60, 2.6, 104.0),
            (32, 40, 3.9, 156.0),
            (32, 30, 5.2, 208.0),
        ];
        for (micro, delay, turns, mm) in cases {
            let line = format!("belt --teeth 20 --microsteps {micro} --delays {delay}us");
            let row = &sheet(&line).unwrap().rows[0];
            let tenth = 0.1 + 1e-9;
            assert!((real(&row[5]) - turns).abs() < tenth, "{line}: {row:?}");
            assert!((real(&row[7]) - mm).abs() < 40.0 * tenth, "{line}: {row:?}");
            let cut = format!("belt --teeth 20 --speed {turns}rev/s");
            let facts = sheet(&cut).unwrap().facts;
            assert!((real(&facts[2].value) - mm).abs() < 1e-9, "{cut}");
        }
    }

    #[test]
    fn a_screw() {
        let sheet = sheet("screw --pitch 2mm --starts 4 --speed 300rpm --microsteps 1/8").unwrap();
        assert_eq!(real(&sheet.facts[0].value), 8.0);
        assert_eq!(real(&sheet.facts[2].value), 40.0);
        assert_eq!(real(&sheet.rows[0][3]), 5000.0);
    }

    #[test]
    fn delays_go_with_microsteps() {
        assert!(sheet("belt --teeth 20 --delays 1500,650,330,180,80,40").is_ok());
        assert!(sheet("belt --teeth 20 --delays 1500,650").is_err());
    }
}
