//! `calc timed`: a speed that changes with the clock (the Arduino driver, sections 7 and 8).

use stepwright_plan::calc::{TimedTable, virtual_top};
use stepwright_plan::sheet::Sheet;
use stepwright_plot::PlotFile;
use stepwright_timed::fit::Hardware;
use stepwright_units::measure::{micros, whole};

use super::Output;
use super::clock::{ClockArgs, misfit};
use crate::failure::Failure;
use crate::plot;
use crate::quantity::{GeometryArgs, SpeedArg, whole_in};

/// A speed that changes at fixed intervals: the modification, and a table of it
///
/// At every update the virtual top grows or shrinks by the modification. With
/// --doubling the modification itself doubles (slower) or halves (faster) each time, which
/// makes the change of speed more even.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  The example of the manual, 29 updates from 6 to 800 steps/s:
    stepwright calc timed 6 800 --updates 29 --every 250ms
  Case 2, and its curve:
    stepwright calc timed 1rpm 500 --updates 11 --doubling --modification 2385000 \\
      --every 1s --plot case-2.png
  Both curves of section 8:
    stepwright calc timed 1000 51000 --tops --updates 50 --plot linear.png
    stepwright calc timed 1000 65536000 --tops --updates 16 --doubling --plot doubling.png")]
pub struct Args {
    /// Speed at the start: 6, 1rpm … (a bare number is steps/s)
    #[arg(value_name = "FROM", allow_hyphen_values = true)]
    from: String,
    /// Speed at the end: 800, 150rpm …
    #[arg(value_name = "TO", allow_hyphen_values = true)]
    to: String,
    /// FROM and TO are virtual tops
    #[arg(long)]
    tops: bool,
    /// How many times the speed changes, 1 to 65535
    #[arg(long, value_name = "N", value_parser = whole_in::<u16>(1..=u16::MAX))]
    updates: u16,
    /// The modification doubles (slower) or halves (faster): VARIABLE_PWR
    #[arg(long, visible_alias = "halving")]
    doubling: bool,
    /// Use this modification; it determines the speed at the end
    #[arg(long, value_name = "CLOCKS", value_parser = whole)]
    modification: Option<u32>,
    /// Time from update to update: 1s, 250ms (a bare number is ms)
    #[arg(long, value_name = "TIME", value_parser = |text: &str| seconds_or_ms(text))]
    every: Option<f64>,
    #[command(flatten)]
    clock: ClockArgs,
    #[command(flatten)]
    geometry: GeometryArgs,
    /// Draw the speed over the updates (.svg, .png or .html)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    plot: Vec<PlotFile>,
    #[command(flatten)]
    pub(super) output: Output,
}

/// Parses seconds; a bare number is in milliseconds, as in the Arduino driver.
fn seconds_or_ms(text: &str) -> Result<f64, String> {
    let bare = text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let micros = micros(&if bare { format!("{text}ms") } else { text.to_owned() })?;
    Ok(micros / 1e6)
}

impl Args {
    fn top(&self, text: &str, hardware: &Hardware) -> Result<u32, Failure> {
        let wrong = |message: String| Failure::usage(format!("{text}: {message}"));
        if self.tops {
            let top = whole(text).map_err(wrong)?;
            return hardware.check(top).map_err(|error| misfit(text, error));
        }
        let speed: SpeedArg = text.parse().map_err(wrong)?;
        Ok(virtual_top(hardware, speed.steps(&self.geometry.geometry()?, text)?, text)?)
    }

    fn table(&self, hardware: &Hardware) -> Result<TimedTable, Failure> {
        Ok(TimedTable {
            from: self.from.clone(),
            to: self.to.clone(),
            start: self.top(&self.from, hardware)?,
            end: self.top(&self.to, hardware)?,
            updates: self.updates,
            doubling: self.doubling,
            modification: self.modification,
            every: self.every,
        })
    }

    /// The modification and the table.
    pub fn sheet(&self) -> Result<Sheet, Failure> {
        let (hardware, geometry) = (self.clock.hardware()?, self.geometry.geometry()?);
        Ok(self.table(&hardware)?.sheet(&hardware, &geometry)?)
    }

    /// Draws the curve into the files that the command line names.
    pub fn draw(&self) -> Result<(), Failure> {
        let (hardware, geometry) = (self.clock.hardware()?, self.geometry.geometry()?);
        let table = self.table(&hardware)?;
        self.plot.iter().try_for_each(|file| plot::save(file, &table.figure(&hardware, &geometry)?))
    }
}

#[cfg(test)]
mod tests;
