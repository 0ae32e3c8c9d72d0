//! Belts and screws: from turns to millimetres (stepper_h).
//!
//! ```text
//!   travel of a turn = pitch · teeth, or pitch · starts
//!   step             = travel / (steps of a turn · microsteps)
//!   linear speed     = travel / (delay · steps of a turn · microsteps)
//! ```

use stepwright::Geometry;
#[cfg(feature = "clap")]
use stepwright_units::measure::{micros, microsteps, whole_in};
use stepwright_units::{MmArg, SpeedArg};

use super::{CalcError, fraction};
use crate::sheet::{Cell, Sheet};

/// A motor behind a belt or a screw.
///
/// The comments of its fields are the help of the command's options; numbers are in µs.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Gearing {
    /// Microsteps of a step, one or several: 1,2,4 or 1/16
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_delimiter = ','))]
    #[cfg_attr(feature = "clap", arg(value_parser = microsteps, default_value = "1,2,4,8,16,32"))]
    pub microsteps: Vec<u32>,
    /// Delay from step to step, one for all or one for each of --microsteps: 80, 1.5ms
    #[cfg_attr(feature = "clap", arg(long, value_name = "TIME", value_delimiter = ','))]
    #[cfg_attr(feature = "clap", arg(value_parser = micros))]
    pub delays: Vec<f64>,
    /// A speed: 3.3rev/s, 120rpm, 60mm/s (a bare number is full steps/s)
    #[cfg_attr(feature = "clap", arg(long, value_name = "SPEED", allow_hyphen_values = true))]
    pub speed: Option<SpeedArg>,
    /// Full steps of one turn: 200 for 1.8°
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = 200))]
    #[cfg_attr(feature = "clap", arg(help_heading = "Motor", value_parser = whole_in::<u32>(1..=1_000_000)))]
    pub steps_per_rev: u32,
}

impl Gearing {
    /// A belt: the teeth of the pulley, and the pitch in mm from tooth to tooth.
    ///
    /// # Errors
    /// The number of delays matches no microsteps; the unit of a speed is not known.
    pub fn belt(&self, teeth: u32, pitch: f64) -> Result<Sheet, CalcError> {
        let what = format!("A belt of {pitch} mm pitch on a pulley of {teeth}");
        self.sheet(what, pitch * f64::from(teeth))
    }

    /// A screw: the pitch in mm from thread to thread, and the number of starts (threads side by side).
    ///
    /// # Errors
    /// As for [`belt`](Gearing::belt).
    pub fn screw(&self, pitch: f64, starts: u32) -> Result<Sheet, CalcError> {
        let threads = if starts == 1 { String::new() } else { format!(", {starts} starts") };
        let what = format!("A screw of {pitch} mm pitch{threads}");
        self.sheet(what, pitch * f64::from(starts))
    }

    fn sheet(&self, what: String, travel: f64) -> Result<Sheet, CalcError> {
        let mut sheet = Sheet::new(what);
        sheet.fact("mm_rev", "travel of a turn", Cell::digits(travel, 9), "mm");
        if let Some(speed) = &self.speed {
            // The travel of a turn is known here, so mm/s need no other option.
            let geometry = Geometry::new(self.steps_per_rev).map_err(CalcError::Range)?;
            // Above 4 m a turn the geometry holds no millimetres.
            let geometry = match MmArg::of(travel) {
                Some(mm) => geometry.travelling_nm(mm.nm()).map_err(CalcError::Range)?,
                None => geometry,
            };
            let steps = speed.steps(&geometry, "--speed").map_err(|_| CalcError::LongTurn {
                speed: speed.given().to_owned(),
                travel: Cell::digits(travel, 9).shown(),
            })?;
            let turns = steps / f64::from(self.steps_per_rev);
            sheet.fact("turns_s", "speed", Cell::digits(turns, 6), "rev/s");
            sheet.fact("mm_s", "… linear", Cell::digits(turns * travel, 6), "mm/s");
        }
        sheet.columns = vec![
            ("microsteps", "microsteps"),
            ("steps_rev", "steps/rev"),
            ("step_um", "step, µm"),
            ("step_nm", "nm"),
        ];
        if !self.delays.is_empty() {
            sheet.columns.extend([
                ("delay_us", "delay, µs"),
                ("turns_s", "rev/s"),
                ("rpm", "rpm"),
                ("mm_s", "mm/s"),
            ]);
        }
        for (i, &micro) in self.microsteps.iter().enumerate() {
            let steps = f64::from(self.steps_per_rev) * f64::from(micro);
            let mut row = vec![
                fraction(micro),
                Cell::digits(steps, 12),
                Cell::digits(travel * 1e3 / steps, 9),
                Cell::digits(travel * 1e6 / steps, 9),
            ];
            if let Some(delay) = paired(&self.delays, i, self.microsteps.len())? {
                let turns = turns(delay, steps);
                row.extend([
                    Cell::digits(delay, 9),
                    Cell::fixed(turns, 3),
                    Cell::fixed(turns * 60.0, 1),
                    Cell::fixed(turns * travel, 1),
                ]);
            }
            sheet.rows.push(row);
        }
        Ok(sheet)
    }
}

/// Turns per second of a delay in µs.
pub(super) fn turns(delay: f64, steps_per_turn: f64) -> f64 {
    1e6 / (delay * steps_per_turn)
}

/// The delay for microsteps number `i` of `of`.
pub(super) fn paired(delays: &[f64], i: usize, of: usize) -> Result<Option<f64>, CalcError> {
    match delays.len() {
        0 => Ok(None),
        1 => Ok(delays.first().copied()),
        n if n == of => Ok(delays.get(i).copied()),
        delays => Err(CalcError::Delays { delays, kinds: of }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The turns per second that stepper_h prints, each cut or rounded to a digit.
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
}
