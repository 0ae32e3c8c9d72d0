//! `calc vref` and `calc microstep`: the settings of a driver (stepper_h).

use stepwright_plan::calc::StepDriver;
use stepwright_plan::sheet::Sheet;
use stepwright_units::measure::{ampere, ohm};

use super::Calculator;
use crate::failure::Failure;
use crate::quantity::whole_in;

/// A driver, and a motor's current.
#[derive(clap::Args)]
pub struct VrefArgs {
    /// Current of the motor, one or several: 1.7A, 600mA
    #[arg(value_name = "CURRENT", required = true, value_parser = ampere)]
    currents: Vec<f64>,
    /// Which driver
    #[arg(long, value_enum, default_value_t = StepDriver::Drv8825)]
    driver: StepDriver,
    /// Its sense resistors: 0.1, 68mOhm
    #[arg(long, value_name = "OHM", default_value = "0.1", value_parser = ohm)]
    sense: f64,
}

impl Calculator for VrefArgs {
    fn sheet(&self) -> Result<Sheet, Failure> {
        Ok(self.driver.vref(&self.currents, self.sense))
    }
}

/// A driver, and microsteps.
#[derive(clap::Args)]
pub struct MicrostepArgs {
    /// Show only these microsteps: 16 or 1/16
    #[arg(value_name = "N", value_parser = stepwright_units::measure::microsteps)]
    only: Option<u32>,
    /// Which driver
    #[arg(long, value_enum, default_value_t = StepDriver::Drv8825)]
    driver: StepDriver,
    /// Full steps of one turn: 200 for 1.8°
    #[arg(long, value_name = "N", default_value_t = 200, help_heading = "Motor")]
    #[arg(value_parser = whole_in::<u32>(1..=1_000_000))]
    steps_per_rev: u32,
}

impl Calculator for MicrostepArgs {
    fn sheet(&self) -> Result<Sheet, Failure> {
        Ok(self.driver.microsteps(self.only, self.steps_per_rev)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use stepwright_plan::sheet::Cell;

    #[derive(Parser)]
    enum Line {
        Vref(VrefArgs),
        Microstep(MicrostepArgs),
    }

    fn sheet(line: &str) -> Result<Sheet, Failure> {
        match Line::parse_from(format!("calc {line}").split_whitespace()) {
            Line::Vref(args) => args.sheet(),
            Line::Microstep(args) => args.sheet(),
        }
    }

    fn shown(row: &[Cell]) -> Vec<String> {
        let text = |cell: &Cell| match cell {
            Cell::Real(_, text) | Cell::Text(text) => text.clone(),
            Cell::Whole(value) => value.to_string(),
            Cell::Empty => String::new(),
        };
        row.iter().map(text).collect()
    }

    /// stepper_h: half the current, set a little lower.
    #[test]
    fn reference_voltages() {
        let rows = sheet("vref 1.7A 600mA 1.3").unwrap().rows;
        assert_eq!(shown(&rows[0]), ["1.7", "0.850", "0.750", "0.800"]);
        assert_eq!(shown(&rows[1]), ["0.6", "0.300", "0.200", "0.250"]);
        assert_eq!(shown(&rows[2]), ["1.3", "0.650", "0.550", "0.600"]);
        // Data sheet of the A4988: Vref = 8 · I · R.
        let rows = sheet("vref 1A --driver a4988 --sense 68mOhm").unwrap().rows;
        assert_eq!(shown(&rows[0])[1], "0.544");
    }

    /// stepper_h: the jumpers of a DRV8825, and steps of a turn.
    #[test]
    fn jumpers() {
        let rows = sheet("microstep").unwrap().rows;
        let want = [
            "1/1 0 0 0 200",
            "1/2 1 0 0 400",
            "1/4 0 1 0 800",
            "1/8 1 1 0 1600",
            "1/16 0 0 1 3200",
            "1/32 1 1 1 6400",
        ];
        let rows: Vec<_> = rows.iter().map(|row| shown(row).join(" ")).collect();
        assert_eq!(rows, want);
        assert_eq!(sheet("microstep 1/16 --driver a4988").unwrap().rows.len(), 1);
        assert!(sheet("microstep 32 --driver a4988").is_err());
    }
}
