//! `calc delay`: which delays fit the period of a timer, and the ranges of its counters
//! (stepper_h).

use stepwright_plan::calc::DelayFit;
use stepwright_plan::sheet::Sheet;

use super::Calculator;
use crate::failure::Failure;

impl Calculator for DelayFit {
    fn sheet(&self) -> Result<Sheet, Failure> {
        Ok(DelayFit::sheet(self)?)
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
        args: DelayFit,
    }

    fn sheet(line: &str) -> Result<Sheet, Failure> {
        Line::parse_from(format!("calc {line}").split_whitespace())
            .args
            .sheet()
            .map_err(Failure::from)
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

    /// stepper_h's smallest delays: three periods.
    #[test]
    fn smallest_delays() {
        for (period, least) in [(10, 30.0), (20, 60.0), (50, 150.0), (100, 300.0), (200, 600.0)] {
            assert_eq!(fact(&format!("--period {period}"), "least_us"), least);
        }
        assert_eq!(fact("--period 200", "rate_hz"), 5000.0);
    }

    /// stepper_h's ranges: 9 million km, 2.15 m, 4294 mm, 4294 s; 18 h at 30 µs.
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
