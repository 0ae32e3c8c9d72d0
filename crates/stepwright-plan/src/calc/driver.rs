//! The settings of a driver chip: reference voltage and jumpers (stepper_h).

use super::{CalcError, fraction};
use crate::sheet::{Cell, Sheet};

/// Drivers with step and direction inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum StepDriver {
    /// TI: current = Vref / (5 · Rsense), microsteps to 1/32
    Drv8825,
    /// Allegro: current = Vref / (8 · Rsense), microsteps to 1/16
    A4988,
}

impl StepDriver {
    fn name(self) -> &'static str {
        match self {
            StepDriver::Drv8825 => "DRV8825",
            StepDriver::A4988 => "A4988",
        }
    }

    /// The highest current that the data sheet allows with cooling, in A.
    fn most(self) -> f64 {
        match self {
            StepDriver::Drv8825 => 2.5,
            StepDriver::A4988 => 2.0,
        }
    }

    /// The ratio of Vref to the voltage at the sense resistor.
    fn gain(self) -> f64 {
        match self {
            StepDriver::Drv8825 => 5.0,
            StepDriver::A4988 => 8.0,
        }
    }

    /// The names of the jumpers, and which of them are set for each kind of microsteps.
    fn jumpers(self) -> ([&'static str; 3], &'static [(u32, [u8; 3])]) {
        match self {
            StepDriver::Drv8825 => (
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
            StepDriver::A4988 => (
                ["MS1", "MS2", "MS3"],
                &[(1, [0, 0, 0]), (2, [1, 0, 0]), (4, [0, 1, 0]), (8, [1, 1, 0]), (16, [1, 1, 1])],
            ),
        }
    }

    /// The reference voltage for each current, in A, with sense resistors of this many Ω.
    pub fn vref(self, currents: &[f64], sense: f64) -> Sheet {
        let name = self.name();
        let mut sheet = Sheet {
            columns: vec![
                ("current_a", "current, A"),
                ("vref_v", "Vref at most, V"),
                ("from_v", "set to, V"),
                ("to_v", "to, V"),
            ],
            ..Sheet::new(format!("{name}, sense resistors of {} Ω", sense))
        };
        for &current in currents {
            let vref = current * sense * self.gain();
            let set = |less: f64| Cell::fixed((vref - less).max(0.0), 3);
            let row = [Cell::digits(current, 6), Cell::fixed(vref, 3), set(0.1), set(0.05)];
            sheet.rows.push(row.into());
            if current > self.most() {
                let most = self.most();
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

    /// The jumpers for all microsteps, or for `only` these.
    ///
    /// # Errors
    /// [`CalcError::NoMicrosteps`]
    pub fn microsteps(self, only: Option<u32>, steps_per_rev: u32) -> Result<Sheet, CalcError> {
        let (name, (pins, table)) = (self.name(), self.jumpers());
        let wanted = |micro: u32| only.is_none_or(|only| only == micro);
        let rows = table.iter().filter(|(micro, _)| wanted(*micro)).map(|&(micro, set)| {
            let steps = i64::from(steps_per_rev) * i64::from(micro);
            let jumpers = set.map(Cell::from);
            [fraction(micro)].into_iter().chain(jumpers).chain([steps.into()]).collect()
        });
        let rows: Vec<Vec<Cell>> = rows.collect();
        if rows.is_empty() {
            let kinds: Vec<_> = table.iter().map(|(micro, _)| format!("1/{micro}")).collect();
            let only = only.unwrap_or_default();
            return Err(CalcError::NoMicrosteps { driver: name, only, kinds: kinds.join(", ") });
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
