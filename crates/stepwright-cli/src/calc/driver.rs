//! `calc vref` and `calc microstep`: how a driver is set (stepper_h).

use clap::ValueEnum;

use super::Output;
use super::measure::{ampere, fraction, ohm};
use crate::failure::Failure;
use crate::sheet::{Cell, Sheet};

/// Drivers with step and direction inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Driver {
    /// TI: current = Vref / (5 · Rsense), microsteps to 1/32
    Drv8825,
    /// Allegro: current = Vref / (8 · Rsense), microsteps to 1/16
    A4988,
}

impl Driver {
    fn name(self) -> &'static str {
        match self {
            Driver::Drv8825 => "DRV8825",
            Driver::A4988 => "A4988",
        }
    }

    /// The most current that its data sheet allows with cooling, in A.
    fn most(self) -> f64 {
        match self {
            Driver::Drv8825 => 2.5,
            Driver::A4988 => 2.0,
        }
    }

    /// Vref over the voltage at the sense resistor.
    fn gain(self) -> f64 {
        match self {
            Driver::Drv8825 => 5.0,
            Driver::A4988 => 8.0,
        }
    }

    /// The jumpers' names, and for each kind of microsteps which of them are set.
    fn jumpers(self) -> ([&'static str; 3], &'static [(u32, [u8; 3])]) {
        match self {
            Driver::Drv8825 => (
                ["M0", "M1", "M2"],
                &[
                    (1, [0, 0, 0]),
                    (2, [1, 0, 0]),
                    (4, [0, 1, 0]),
                    (8, [1, 1, 0]),
                    (16, [0, 0, 1]),
                    (32, [1, 1, 1]),
                ],
            ),
            Driver::A4988 => (
                ["MS1", "MS2", "MS3"],
                &[(1, [0, 0, 0]), (2, [1, 0, 0]), (4, [0, 1, 0]), (8, [1, 1, 0]), (16, [1, 1, 1])],
            ),
        }
    }
}

/// The reference voltage of a driver for a motor's current
///
/// With sense resistors of 0.1 Ω a DRV8825's is half the current. Set it 0.05 to
/// 0.1 V lower: a motor must not whine or grow hot. Never unplug a motor from a driver
/// that is on.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright calc vref 1.7A
  stepwright calc vref 1.7 600mA 1.3
  stepwright calc vref 1A --driver a4988 --sense 68mOhm")]
pub struct VrefArgs {
    /// Current of the motor, one or several: 1.7A, 600mA
    #[arg(value_name = "CURRENT", required = true, value_parser = ampere)]
    currents: Vec<f64>,
    /// Which driver
    #[arg(long, value_enum, default_value_t = Driver::Drv8825)]
    driver: Driver,
    /// Its sense resistors: 0.1, 68mOhm
    #[arg(long, value_name = "OHM", default_value = "0.1", value_parser = ohm)]
    sense: f64,
    #[command(flatten)]
    pub(super) output: Output,
}

impl VrefArgs {
    /// Each current.
    pub fn sheet(&self) -> Sheet {
        let name = self.driver.name();
        let mut sheet = Sheet {
            columns: vec![
                ("current_a", "current, A"),
                ("vref_v", "Vref at most, V"),
                ("from_v", "set to, V"),
                ("to_v", "to, V"),
            ],
            ..Sheet::new(format!("{name}, sense resistors of {} Ω", self.sense))
        };
        for &current in &self.currents {
            let vref = current * self.sense * self.driver.gain();
            let set = |less: f64| Cell::fixed((vref - less).max(0.0), 3);
            let row = [Cell::digits(current, 6), Cell::fixed(vref, 3), set(0.1), set(0.05)];
            sheet.rows.push(row.into());
            if current > self.driver.most() {
                let most = self.driver.most();
                let todo = match current < 100.0 {
                    true => "take a driver for more current, or a motor for less.".to_owned(),
                    false => format!("is it in mA? Then write {current}mA."),
                };
                sheet
                    .notes
                    .push(format!("{current} A is more than the {most} A of a {name}: {todo}"));
            }
        }
        sheet
    }
}

/// The jumpers of a driver for microsteps
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright calc microstep                     all of a DRV8825
  stepwright calc microstep 16
  stepwright calc microstep --driver a4988 --steps-per-rev 400")]
pub struct MicrostepArgs {
    /// Only this: 16 or 1/16
    #[arg(value_name = "N", value_parser = super::measure::microsteps)]
    only: Option<u32>,
    /// Which driver
    #[arg(long, value_enum, default_value_t = Driver::Drv8825)]
    driver: Driver,
    /// Full steps of one turn: 200 for 1.8°
    #[arg(long, value_name = "N", default_value_t = 200, help_heading = "Motor")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps_per_rev: u32,
    #[command(flatten)]
    pub(super) output: Output,
}

impl MicrostepArgs {
    /// The table, or one line of it.
    pub fn sheet(&self) -> Result<Sheet, Failure> {
        let (name, (pins, table)) = (self.driver.name(), self.driver.jumpers());
        let wanted = |micro: u32| self.only.is_none_or(|only| only == micro);
        let rows = table.iter().filter(|(micro, _)| wanted(*micro)).map(|&(micro, set)| {
            let steps = i64::from(self.steps_per_rev) * i64::from(micro);
            let jumpers = set.map(Cell::from);
            [fraction(micro)].into_iter().chain(jumpers).chain([steps.into()]).collect()
        });
        let rows: Vec<Vec<Cell>> = rows.collect();
        if rows.is_empty() {
            let kinds: Vec<_> = table.iter().map(|(micro, _)| format!("1/{micro}")).collect();
            let only = self.only.unwrap_or_default();
            return Err(Failure::new(format!("{name}: no steps of 1/{only}"))
                .hint(format!("it has {}", kinds.join(", "))));
        }
        let [first, second, third] = pins;
        Ok(Sheet {
            columns: vec![
                ("microsteps", "microsteps"),
                (first, first),
                (second, second),
                (third, third),
                ("steps_rev", "steps/rev"),
            ],
            rows,
            notes: vec!["1: the jumper is set, the input high.".into()],
            ..Sheet::new(format!("{name}: jumpers for microsteps"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    enum Line {
        Vref(VrefArgs),
        Microstep(MicrostepArgs),
    }

    fn sheet(line: &str) -> Result<Sheet, Failure> {
        match Line::parse_from(format!("calc {line}").split_whitespace()) {
            Line::Vref(args) => Ok(args.sheet()),
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
