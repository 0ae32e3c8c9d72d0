//! The delays that fit the period of a timer, and the range of its counters (stepper_h).
//!
//! A step takes three periods (bounds, STEP up, STEP down), and a delay must be a
//! whole number of them:
//!
//! ```text
//!   fitting delay = max(3, ⌈delay / period⌉) · period
//! ```

#[cfg(feature = "clap")]
use stepwright_units::measure::{micros, microsteps, millimetres, whole_in};

use super::linear::{paired, turns};
use super::{CalcError, fraction};
use crate::sheet::{Cell, Sheet};

/// Wanted delays on a timer whose interrupt serves all motors.
///
/// The comments of its fields are the help of the command's options; numbers are in µs and mm.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct DelayFit {
    /// Time between two interrupts: 200us, 20 …
    #[cfg_attr(feature = "clap", arg(long, value_name = "TIME", value_parser = micros))]
    pub period: f64,
    /// Microsteps of a step, one or several: 1,2,4 or 1/16
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_delimiter = ','))]
    #[cfg_attr(feature = "clap", arg(value_parser = microsteps, default_value = "1,2,4,8,16,32"))]
    pub microsteps: Vec<u32>,
    /// Wanted delays, one for all or one for each of --microsteps
    // None: those of stepper_h's motor, for six kinds of microsteps.
    #[cfg_attr(feature = "clap", arg(long, value_name = "TIME", value_delimiter = ','))]
    #[cfg_attr(feature = "clap", arg(value_parser = micros))]
    pub delays: Vec<f64>,
    /// Distance of a step: 7500nm, 12.5um
    #[cfg_attr(feature = "clap", arg(long, value_name = "LENGTH", value_parser = millimetres))]
    pub distance: Option<f64>,
    /// Full steps of one turn: 200 for 1.8°
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 200))]
    #[cfg_attr(feature = "clap", arg(help_heading = "Motor", value_parser = whole_in::<u32>(1..=1_000_000)))]
    pub steps_per_rev: u32,
}

/// The delays that stepper_h's motor wants, from 1/1 to 1/32, in µs.
const WANTED: [f64; 6] = [1500.0, 650.0, 330.0, 180.0, 80.0, 40.0];

/// The smallest fitting delay that is no shorter than `delay`.
fn fitting(delay: f64, period: f64) -> f64 {
    // Up to 10⁻⁹ of the periods is rounding, but at most 10⁻⁶ of a period: 0.3 is three times 0.1.
    let periods = delay / period;
    (periods - (periods * 1e-9).min(1e-6)).ceil().max(3.0) * period
}

impl DelayFit {
    /// The fitting delays as a sheet.
    ///
    /// # Errors
    /// Fails if the number of delays matches no microsteps.
    pub fn sheet(&self) -> Result<Sheet, CalcError> {
        let DelayFit { period, ref microsteps, ref delays, .. } = *self;
        let defaults = delays.is_empty() && microsteps.len() == WANTED.len();
        let wanted = if defaults { &WANTED } else { &delays[..] };
        if wanted.is_empty() {
            return Err(CalcError::NoDelays);
        }
        let mut sheet = Sheet::new(format!("Delays on a timer of {period} µs"));
        let least = 3.0 * period;
        sheet.fact("period_us", "period", Cell::digits(period, 9), "µs");
        sheet.fact("rate_hz", "… a second", Cell::digits(1e6 / period, 9), "Hz");
        sheet.fact("least_us", "smallest delay", Cell::digits(least, 9), "µs");
        self.counting(&mut sheet);

        sheet.columns = vec![
            ("microsteps", "microsteps"),
            ("wanted_us", "wanted, µs"),
            ("delay_us", "fits, µs"),
            ("wanted_turns_s", "wanted, rev/s"),
            ("turns_s", "fits, rev/s"),
            ("percent", "% of the speed"),
        ];
        for (i, &micro) in microsteps.iter().enumerate() {
            let steps = f64::from(self.steps_per_rev) * f64::from(micro);
            let Some(delay) = paired(wanted, i, microsteps.len())? else { continue };
            let fits = fitting(delay, period);
            sheet.rows.push(vec![
                fraction(micro),
                Cell::digits(delay, 9),
                Cell::digits(fits, 9),
                Cell::fixed(turns(delay, steps), 3),
                Cell::fixed(turns(fits, steps), 3),
                Cell::fixed(delay / fits * 100.0, 1),
            ]);
        }
        Ok(sheet)
    }

    /// The ranges of positions, delays and steps in 32 and 64 bits.
    fn counting(&self, sheet: &mut Sheet) {
        let (narrow, wide) = (2f64.powi(31), 2f64.powi(63));
        let mut fact =
            |key, name, value, unit| sheet.fact(key, name, Cell::digits(value, 10), unit);
        fact("nm_64_km", "positions, 64 bits of nm", wide / 1e12, "km either way");
        fact("nm_32_m", "… 32 bits of nm", narrow / 1e9, "m either way");
        fact("um_32_km", "… 32 bits of µm", narrow / 1e9, "km either way");
        if let Some(mm) = self.distance {
            let nm = mm * 1e6;
            fact("steps_64", "… steps, 64 bits", (wide / nm).floor(), "either way");
            fact("steps_32", "… steps, 32 bits", (narrow / nm).floor(), "either way");
        }
        fact("step_32_m", "longest step, 2^32 nm", 2.0 * narrow / 1e9, "m");
        fact("delay_32_s", "longest delay, 2^32 µs", 2.0 * narrow / 1e6, "s");
        let travel = narrow * 3.0 * self.period / 1e6 / 3600.0;
        fact("steps_32_h", "2^31 steps take at least", travel, "h");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fitting delay is never shorter than the wanted delay, for any number of periods.
    #[test]
    fn a_delay_is_never_cut() {
        assert_eq!(fitting(0.3, 0.1), 3.0 * 0.1);
        assert_eq!(fitting(1105.0, 200.0), 1200.0);
        assert_eq!(fitting(0.1, 0.1), 3.0 * 0.1);
        for wanted in [1e9 + 0.5, 4e9 + 0.25, 1e12 + 0.125] {
            assert_eq!(fitting(wanted, 1.0), wanted.ceil(), "{wanted}");
        }
    }
}
