//! The options that select a timer, shared by `timer`, `range` and `timed`.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use stepwright_plan::calc::TimerKind;
use stepwright_timed::fit::{Hardware, Misfit, io_clock};
use stepwright_units::measure::hertz;

use crate::failure::Failure;

/// The parser of the divisors of CLKPR.
fn dividers() -> impl TypedValueParser<Value = u16> {
    let each = ["1", "2", "4", "8", "16", "32", "64", "128", "256"];
    PossibleValuesParser::new(each).try_map(|text| text.parse::<u16>())
}

/// A hardware timer and its clock.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Timer")]
pub struct ClockArgs {
    /// Clock of the chip: 16MHz, 8MHz, 128kHz …
    #[arg(long, value_name = "HZ", default_value = "16MHz", value_parser = hertz)]
    oscillator: u32,
    /// Divisor of the clock in CLKPR
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = dividers())]
    clkpr: u16,
    /// Which timer
    #[arg(long, value_enum, default_value_t = TimerKind::Avr16)]
    timer: TimerKind,
}

impl ClockArgs {
    /// The timer.
    pub fn hardware(&self) -> Result<Hardware, Failure> {
        let hz = io_clock(self.oscillator, self.clkpr)?;
        if hz == 0 {
            let (oscillator, clkpr) = (self.oscillator, self.clkpr);
            return Err(Failure::new(format!("{oscillator} Hz / {clkpr} is less than 1 Hz"))
                .hint("raise --oscillator or lower --clkpr"));
        }
        Ok(self.timer.hardware(hz))
    }
}

/// The failure for an interval that the core refuses. `what` names the value that was given.
pub fn misfit(what: &str, misfit: Misfit) -> Failure {
    // The core's message is "what is wrong; what to do".
    let text = misfit.to_string();
    match text.split_once("; ") {
        Some((wrong, todo)) => Failure::new(format!("{what}: {wrong}")).hint(todo),
        None => Failure::new(format!("{what}: {text}")),
    }
}
