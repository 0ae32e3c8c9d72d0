//! The kinds of timers, and the virtual top of a speed on them.

use stepwright_timed::fit::{Hardware, Misfit};

use super::CalcError;

/// Timers, by width and prescalers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum TimerKind {
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

impl TimerKind {
    /// The timer at this clock in Hz, at least 1.
    pub fn hardware(self, hz: u32) -> Hardware {
        match self {
            TimerKind::Avr16 => Hardware::avr16(hz),
            TimerKind::Avr8 => Hardware::avr8(hz),
            TimerKind::Avr8Timer2 => Hardware::avr8_timer2(hz),
            TimerKind::Capture16 => Hardware::capture16(hz),
            TimerKind::Wide32 => Hardware::wide32(hz),
        }
    }
}

/// The virtual top of a speed in steps/s, rounded down; `what` is the speed, for the message.
///
/// # Errors
/// [`CalcError::Misfit`]: the timer can't make this speed.
pub fn virtual_top(hardware: &Hardware, steps: f64, what: &str) -> Result<u32, CalcError> {
    let top = f64::from(hardware.hz()) / steps;
    // The rounding of decimals must not cost a whole clock: 1 rpm is 4800000, not 4799999.
    let top = (top * (1.0 + 1e-14)).floor();
    // A speed of 0 gives an infinite top.
    let checked = if top > f64::from(u32::MAX) {
        Err(Misfit::TooSlow { max: hardware.max_top() })
    } else {
        hardware.check(top as u32)
    };
    checked.map_err(|why| CalcError::Misfit { what: what.to_owned(), why })
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
