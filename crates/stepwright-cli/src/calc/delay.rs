//! `calc delay`: which delays fit the period of a timer, and how far one can count
//! (stepper_h).
//!
//! A step takes three periods (bounds, STEP up, STEP down), and a delay must be a
//! whole number of them:
//!
//! ```text
//!   fitting delay = max(3, ⌈delay / period⌉) · period
//! ```

use super::Output;
use super::linear::{paired, turns};
use super::measure::{fraction, micros, microsteps, millimetres};
use crate::failure::Failure;
use crate::sheet::{Cell, Sheet};

/// Which delays fit the period of a timer, and how far one can count
///
/// For a driver with one interrupt for all motors: a step takes three periods of the
/// timer, and its delay must be a whole number of them. Without --delays, those of
/// stepper_h's motor.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright calc delay --period 200us                   three motors on a 16 MHz AVR
  stepwright calc delay --period 20us --microsteps 16 --delays 80us
  stepwright calc delay --period 20us --distance 7500nm  how far positions reach")]
pub struct Args {
    /// From interrupt to interrupt: 200us, 20 …
    #[arg(long, value_name = "TIME", value_parser = micros)]
    period: f64,
    /// Microsteps of a step, one or several: 1,2,4 or 1/16
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = microsteps)]
    #[arg(default_value = "1,2,4,8,16,32")]
    microsteps: Vec<u32>,
    /// Delays that are wanted, one for all or one for each of --microsteps
    #[arg(long, value_name = "TIME", value_delimiter = ',', value_parser = micros)]
    delays: Vec<f64>,
    /// Distance of a step: 7500nm, 12.5um
    #[arg(long, value_name = "LENGTH", value_parser = millimetres)]
    distance: Option<f64>,
    /// Full steps of one turn: 200 for 1.8°
    #[arg(long, value_name = "N", default_value_t = 200, help_heading = "Motor")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps_per_rev: u32,
    #[command(flatten)]
    pub(super) output: Output,
}

/// What stepper_h's motor wants, from 1/1 to 1/32: in µs.
const WANTED: [f64; 6] = [1500.0, 650.0, 330.0, 180.0, 80.0, 40.0];

/// The smallest delay that fits and is no shorter.
fn fitting(delay: f64, period: f64) -> f64 {
    // A part of 10⁹ is rounding: 0.3 is three times 0.1.
    let periods = (delay / period * (1.0 - 1e-9)).ceil().max(3.0);
    periods * period
}

impl Args {
    /// What fits.
    pub fn sheet(&self) -> Result<Sheet, Failure> {
        let Args { period, ref microsteps, ref delays, .. } = *self;
        let defaults = delays.is_empty() && microsteps.len() == WANTED.len();
        let wanted = if defaults { &WANTED } else { &delays[..] };
        if wanted.is_empty() {
            return Err(Failure::usage("--microsteps without --delays")
                .hint("add the delays that the motor wants, for example --delays 80us"));
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

    /// How far positions, delays and steps reach, in this many bits.
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
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn sheet(line: &str) -> Result<Sheet, Failure> {
        Line::parse_from(format!("calc {line}").split_whitespace()).args.sheet()
    }

    fn real(cell: &Cell) -> f64 {
        match cell {
            Cell::Real(value, _) => *value,
            other => panic!("{other:?}"),
        }
    }

    fn fits(line: &str) -> Vec<f64> {
        sheet(line).unwrap().rows.iter().map(|row| real(&row[2])).collect()
    }

    fn fact(line: &str, key: &str) -> f64 {
        let facts = sheet(line).unwrap().facts;
        real(&facts.iter().find(|fact| fact.key == key).expect(key).value)
    }

    /// stepper_h's recommended delays, for a PIC32 and for an AVR with three motors.
    #[test]
    fn recommended_delays() {
        let want = [1500.0, 660.0, 340.0, 180.0, 80.0, 60.0];
        assert_eq!(fits("--period 20us"), want);
        let want = [1600.0, 800.0, 600.0, 600.0, 600.0, 600.0];
        assert_eq!(fits("--period 200us"), want);
    }

    /// Its smallest delays: three periods.
    #[test]
    fn smallest_delays() {
        for (period, least) in [(10, 30.0), (20, 60.0), (50, 150.0), (100, 300.0), (200, 600.0)] {
            assert_eq!(fact(&format!("--period {period}"), "least_us"), least);
        }
        assert_eq!(fact("--period 200", "rate_hz"), 5000.0);
    }

    /// Its turns per second, each cut or rounded to a digit.
    #[test]
    fn turns_per_second() {
        let cases = [
            (1, 1500, "3.333"),
            (1, 1000, "5.000"),
            (2, 650, "3.846"),
            (4, 330, "3.788"),
            (8, 180, "3.472"), // printed as 3.8, but 1/0.288 is 3.47
            (16, 80, "3.906"),
            (32, 60, "2.604"),
            (32, 40, "3.906"),
            (32, 30, "5.208"),
        ];
        for (micro, delay, want) in cases {
            let turns = turns(f64::from(delay), 200.0 * f64::from(micro));
            assert_eq!(format!("{turns:.3}"), want, "1/{micro}, {delay} µs");
        }
    }

    /// Its ranges: 9 million km, 2.15 m, 4294 mm, 4294 s; 18 h at 30 µs.
    #[test]
    fn how_far_one_can_count() {
        let line = "--period 10us";
        assert_eq!(format!("{:.0}", fact(line, "nm_64_km")), "9223372");
        assert_eq!(format!("{:.2}", fact(line, "nm_32_m")), "2.15");
        assert_eq!(format!("{:.2}", fact(line, "um_32_km")), "2.15");
        assert_eq!(fact(line, "step_32_m"), 4.294_967_296);
        assert_eq!(fact(line, "delay_32_s"), 4_294.967_296);
        // 64425 s = 1074 min = 17.9 h.
        assert_eq!(format!("{:.0}", fact(line, "steps_32_h") * 3600.0), "64425");
        let steps = fact("--period 10us --distance 7500nm", "steps_32");
        assert_eq!(steps, 286_331.0);
    }

    #[test]
    fn a_delay_that_fits_is_kept() {
        assert_eq!(fits("--period 0.1us --microsteps 1 --delays 0.3us"), [3.0 * 0.1]);
        assert_eq!(fits("--period 200us --microsteps 1 --delays 1105us"), [1200.0]);
        assert!(sheet("--period 200us --microsteps 1").is_err());
        assert!(sheet("--period 200us --delays 1,2").is_err());
    }
}
