//! Which timer: the options that `timer`, `range` and `timed` share.

use clap::ValueEnum;
use stepwright_timed::fit::{Hardware, Misfit, io_clock};

use super::measure::hertz;
use crate::failure::Failure;

/// A hardware timer and its clock.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Timer")]
pub struct ClockArgs {
    /// Clock of the chip: 16MHz, 8MHz, 128kHz …
    #[arg(long, value_name = "HZ", default_value = "16MHz", value_parser = hertz)]
    oscillator: u32,
    /// What CLKPR divides it by: 1, 2, 4, 8, 16, 32, 64, 128 or 256
    #[arg(long, value_name = "N", default_value_t = 1)]
    clkpr: u16,
    /// Which timer
    #[arg(long, value_enum, default_value_t = Kind::Avr16)]
    timer: Kind,
}

/// Timers, by width and prescalers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// 16 bits, 1 to 1024: timers 1, 3, 4 and 5 of an AVR
    Avr16,
    /// 8 bits, 1 to 1024: timer 0 of an AVR
    Avr8,
    /// 8 bits, 1 to 1024 with 32 and 128: timer 2 of an AVR
    Avr8Timer2,
    /// 16 bits, 1 to 8: a capture/compare module
    Capture16,
    /// 32 bits, no prescaler
    Wide32,
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
        Ok(match self.timer {
            Kind::Avr16 => Hardware::avr16(hz),
            Kind::Avr8 => Hardware::avr8(hz),
            Kind::Avr8Timer2 => Hardware::avr8_timer2(hz),
            Kind::Capture16 => Hardware::capture16(hz),
            Kind::Wide32 => Hardware::wide32(hz),
        })
    }
}

/// What the core says of an interval that can't be, with `what` it was.
pub fn misfit(what: &str, misfit: Misfit) -> Failure {
    // The core says "what is wrong; what to do".
    let text = misfit.to_string();
    match text.split_once("; ") {
        Some((wrong, todo)) => Failure::new(format!("{what}: {wrong}")).hint(todo),
        None => Failure::new(format!("{what}: {text}")),
    }
}

/// The virtual top of a speed in steps/s, rounded down.
pub fn virtual_top(hardware: &Hardware, steps: f64, what: &str) -> Result<u32, Failure> {
    let top = f64::from(hardware.hz()) / steps;
    // What decimals lose must not cost a whole clock: 1 rpm is 4800000, not 4799999.
    let top = (top * (1.0 + 1e-14)).floor();
    // A speed of 0 makes it infinite.
    let checked = if top > f64::from(u32::MAX) {
        Err(Misfit::TooSlow { max: hardware.max_top() })
    } else {
        hardware.check(top as u32)
    };
    checked.map_err(|error| misfit(what, error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tops_are_rounded_down() {
        let timer = Hardware::avr16(16_000_000);
        let top = |steps: f64| virtual_top(&timer, steps, "it").ok();
        assert_eq!(top(180.0), Some(88_888));
        assert_eq!(top(6.0), Some(2_666_666));
        assert_eq!(top(200.0 / 60.0), Some(4_800_000));
        assert_eq!(top(500.0), Some(32_000));
        assert_eq!((top(0.0), top(25_001.0), top(0.2)), (None, None, None));
        assert_eq!(top(25_000.0), Some(640));
        assert!(virtual_top(&Hardware::wide32(1000), 0.0, "it").is_err());
    }
}
