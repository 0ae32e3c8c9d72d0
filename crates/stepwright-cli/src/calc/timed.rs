//! `calc timed`: a speed that changes with the clock (the Arduino driver, sections 7 and 8).

use stepwright_plan::calc::{TimedTable, virtual_top};
use stepwright_plan::sheet::Sheet;
use stepwright_plot::PlotFile;
use stepwright_timed::fit::Hardware;
use stepwright_units::measure::{micros, whole};

use super::Calculator;
use super::clock::{ClockArgs, misfit};
use crate::failure::Failure;
use crate::plot;
use crate::quantity::{GeometryArgs, SpeedArg, whole_in};

/// A speed that changes at fixed intervals.
#[derive(clap::Args)]
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
}

impl Calculator for Args {
    fn sheet(&self) -> Result<Sheet, Failure> {
        let (hardware, geometry) = (self.clock.hardware()?, self.geometry.geometry()?);
        Ok(self.table(&hardware)?.sheet(&hardware, &geometry)?)
    }

    fn draw(&self) -> Result<(), Failure> {
        let (hardware, geometry) = (self.clock.hardware()?, self.geometry.geometry()?);
        let table = self.table(&hardware)?;
        self.plot.iter().try_for_each(|file| plot::save(file, &table.figure(&hardware, &geometry)?))
    }
}

#[cfg(test)]
mod tests;
