//! Fits a wanted interval to a hardware timer: its prescaler and its count.
//!
//! ```text
//!   I/O clock   = oscillator / divider                  divider = 2^CLKPS
//!   virtual top = ⌊I/O clock / steps per second⌋        32 bits
//!   shift       = the first of the timer's with virtual top / 2^shift < 2^bits
//!   top         = ⌊virtual top / 2^shift⌋               what the register holds
//!   interval    = top · 2^shift                         clocks between two steps
//! ```
//!
//! Source: the Arduino driver, sections 4 and 6 ("how we fit a 32bit virtual timer in the
//! 16bit hardware timer"). Its rule shifts by 3, 3, 2 and 2 while the upper 16 bits are
//! not zero; a shift of a shift rounds down as one shift does, so this is the same.
//!
//! **Error.** The interval is never longer than the virtual top, and shorter by less than 2^shift
//! clocks: by at most one part in 2^(bits − 3), 0.0122 % with 16 bits, because a prescaler is at
//! most 8 times the one before it. (With 8 bits 3.1 %.) Rates are exact quotients, rounded to the
//! nearest 10⁻⁹.
//!
//! The article loads its register with the top itself, so on its chip the interval lasts top + 1
//! counts; the article's arithmetic, and this code, use the top.

use core::fmt;
use stepwright::units::{OutOfRange, Speed, Ticks};

/// The source of an AVR's clock, as selected by its fuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Oscillator {
    /// 16 MHz, as on every Arduino of the article.
    Crystal,
    /// The chip's own 8 MHz.
    Rc,
    /// The chip's own 128 kHz.
    Slow,
}

impl Oscillator {
    /// The frequency in Hz.
    pub const fn hz(self) -> u32 {
        match self {
            Oscillator::Crystal => 16_000_000,
            Oscillator::Rc => 8_000_000,
            Oscillator::Slow => 128_000,
        }
    }

    /// The oscillator selected by the low fuse byte of an ATmega328P or ATmega2560: CKSEL 2 and 3
    /// are the chip's own oscillators, the others a crystal or an external clock.
    pub const fn from_low_fuse(fuse: u8) -> Oscillator {
        match fuse & 0x0F {
            2 => Oscillator::Rc,
            3 => Oscillator::Slow,
            _ => Oscillator::Crystal,
        }
    }
}

/// The I/O clock in Hz, which a timer's prescaler divides.
///
/// ```
/// use stepwright_timed::fit::{Oscillator, io_clock};
/// assert_eq!(io_clock(Oscillator::Crystal.hz(), 1), Ok(16_000_000));
/// assert_eq!(io_clock(Oscillator::Rc.hz(), 256), Ok(31_250));
/// assert!(io_clock(16_000_000, 3).is_err());
/// ```
///
/// # Errors
/// [`OutOfRange`] unless `divider` is a power of two from 1 to 256.
pub const fn io_clock(oscillator: u32, divider: u16) -> Result<u32, OutOfRange> {
    if !divider.is_power_of_two() || divider > 256 {
        let what = "clock divider (CLKPR)";
        return Err(OutOfRange { what, min: 1, max: 256, unit: "as a power of two" });
    }
    Ok(oscillator >> divider.trailing_zeros())
}

/// The divider of a value of the register CLKPR; `None` for a reserved value.
pub const fn divider_of(clkpr: u8) -> Option<u16> {
    let select = clkpr & 0x0F;
    if select <= 8 { Some(1 << select) } else { None }
}

/// The shortest virtual top of the Arduino driver: the interrupt takes time, so no more than 25,000
/// steps/s at 16 MHz.
pub const MIN_TOP: u32 = 640;

/// A hardware timer: its clock, its prescalers, its width.
///
/// ```
/// use stepwright_timed::fit::{Hardware, Misfit};
/// let timer = Hardware::avr16(16_000_000);
/// let fit = timer.fit(timer.virtual_top_of(180)?)?;
/// assert_eq!((fit.top(), fit.prescaler(), fit.interval()), (11_111, 8, 88_888));
/// assert_eq!(fit.nanosteps(), 180_001_800_018); // 10⁻⁹ steps/s
/// assert_eq!(timer.fit(0x400_0000), Err(Misfit::TooSlow { max: 0x3FF_FFFF }));
/// # Ok::<(), Misfit>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hardware {
    hz: u32,
    /// log₂ of each prescaler, from the smallest on.
    shifts: &'static [u8],
    bits: u8,
    min_top: u32,
    /// The largest count and the largest virtual top, computed beforehand, because a chip fits in
    /// its step interrupt.
    full: u32,
    max_top: u32,
}

/// log₂ of 1, 8, 64, 256, 1024.
const AVR: &[u8] = &[0, 3, 6, 8, 10];

impl Hardware {
    const fn make(hz: u32, shifts: &'static [u8], bits: u8, min_top: u32) -> Hardware {
        let full = if bits >= 32 { u32::MAX } else { (1 << bits) - 1 };
        let largest = match shifts.last() {
            Some(shift) => *shift,
            None => 0,
        };
        let span = 1u64 << (bits + largest);
        let most = i32::MAX as u32;
        let max_top = if span > most as u64 { most } else { span as u32 - 1 };
        Hardware { hz, shifts, bits, min_top, full, max_top }
    }

    /// A 16-bit timer of an AVR: 1, 3, 4, 5. Prescalers 1, 8, 64, 256, 1024.
    pub const fn avr16(io_clock: u32) -> Hardware {
        Hardware::make(io_clock, AVR, 16, MIN_TOP)
    }

    /// The 8-bit timer 0 of an AVR with the same prescalers.
    pub const fn avr8(io_clock: u32) -> Hardware {
        Hardware::make(io_clock, AVR, 8, MIN_TOP)
    }

    /// The 8-bit timer 2 of an AVR, which also has prescalers of 32 and 128.
    pub const fn avr8_timer2(io_clock: u32) -> Hardware {
        Hardware::make(io_clock, &[0, 3, 5, 6, 7, 8, 10], 8, MIN_TOP)
    }

    /// A 16-bit capture/compare module, as Austin uses one, whose counter has prescalers 1, 2, 4,
    /// 8. `clock` is the input of the counter: 1 MHz there.
    pub const fn capture16(clock: u32) -> Hardware {
        Hardware::make(clock, &[0, 1, 2, 3], 16, 1)
    }

    /// A 32-bit timer, which needs no prescaler: intervals up to 2³¹ − 1 clocks.
    pub const fn wide32(clock: u32) -> Hardware {
        Hardware::make(clock, &[0], 32, 1)
    }

    /// Any other timer: log₂ of its prescalers from the smallest on, and its width in bits.
    ///
    /// # Errors
    /// [`OutOfRange`] unless there are 1 to 32 bits and increasing prescalers up to 2¹⁶.
    pub const fn new(clock: u32, shifts: &'static [u8], bits: u8) -> Result<Hardware, OutOfRange> {
        if bits == 0 || bits > 32 {
            return Err(OutOfRange { what: "timer width", min: 1, max: 32, unit: "bits" });
        }
        let mut rest = shifts;
        let mut least = 0;
        while let [shift, more @ ..] = rest {
            if *shift < least || *shift > 16 {
                let what = "prescaler (rising, as a power of two)";
                return Err(OutOfRange { what, min: 0, max: 16, unit: "bits" });
            }
            (least, rest) = (*shift + 1, more);
        }
        if shifts.is_empty() {
            return Err(OutOfRange { what: "prescalers", min: 1, max: 17, unit: "in number" });
        }
        Ok(Hardware::make(clock, shifts, bits, 1))
    }

    /// This timer with another shortest interval in clocks, which is the time of the step
    /// interrupt. At least 1.
    pub const fn with_min_top(self, min_top: u32) -> Hardware {
        Hardware { min_top: if min_top == 0 { 1 } else { min_top }, ..self }
    }

    /// The clock in Hz.
    pub const fn hz(&self) -> u32 {
        self.hz
    }

    /// The width in bits.
    pub const fn bits(&self) -> u8 {
        self.bits
    }

    /// log₂ of the prescalers.
    pub const fn shifts(&self) -> &'static [u8] {
        self.shifts
    }

    /// The shortest virtual top.
    pub const fn min_top(&self) -> u32 {
        self.min_top
    }

    /// The longest virtual top: 0x3FFFFFF on an AVR's 16-bit timer, and at most 2³¹ − 1, the limit
    /// of the engine.
    pub const fn max_top(&self) -> u32 {
        self.max_top
    }

    /// Clocks in one period of the counter at its largest prescaler: 2²⁶ on an AVR's 16-bit timer.
    pub const fn span(&self) -> u64 {
        let largest = match self.shifts.last() {
            Some(shift) => *shift,
            None => 0,
        };
        1u64 << (self.bits + largest)
    }

    /// The lowest rate as the Arduino driver computes it, one step per period of the counter, in
    /// 10⁻⁹ steps/s: 0.238418579 at 16 MHz.
    pub const fn slowest_nanosteps(&self) -> u64 {
        per_second(self.hz, self.span())
    }

    /// The rate at the shortest virtual top, in 10⁻⁹ steps/s.
    pub const fn fastest_nanosteps(&self) -> u64 {
        per_second(self.hz, self.min_top as u64)
    }

    /// The virtual top of a rate in whole steps per second, rounded down.
    ///
    /// # Errors
    /// [`Misfit`] if the timer can't make it; 0 steps/s is [`Misfit::TooSlow`].
    pub const fn virtual_top_of(&self, steps_per_second: u32) -> Result<u32, Misfit> {
        match self.hz.checked_div(steps_per_second) {
            Some(top) => self.check(top),
            None => Err(Misfit::TooSlow { max: self.max_top() }),
        }
    }

    /// The virtual top of a speed in thousandths of a step per second, rounded down.
    ///
    /// # Errors
    /// Those of [`virtual_top_of`](Hardware::virtual_top_of).
    pub const fn virtual_top_of_speed(&self, speed: Speed) -> Result<u32, Misfit> {
        match (self.hz as u64 * 1000).checked_div(speed.millisteps() as u64) {
            Some(top) if top <= u32::MAX as u64 => self.check(top as u32),
            _ => Err(Misfit::TooSlow { max: self.max_top() }),
        }
    }

    /// Returns the virtual top if the timer can make it.
    ///
    /// # Errors
    /// [`Misfit`], with the limit.
    pub const fn check(&self, virtual_top: u32) -> Result<u32, Misfit> {
        if virtual_top < self.min_top {
            Err(Misfit::TooFast { min: self.min_top })
        } else if virtual_top > self.max_top() {
            Err(Misfit::TooSlow { max: self.max_top() })
        } else {
            Ok(virtual_top)
        }
    }

    /// Fits a virtual top: chooses the smallest prescaler with which it fits in the counter's bits.
    ///
    /// # Errors
    /// [`Misfit`] if the timer can't make it.
    pub const fn fit(&self, virtual_top: u32) -> Result<Fitted, Misfit> {
        match self.check(virtual_top) {
            Ok(wanted) => {
                // Each prescaler shifts the result of the previous one, as in the document: a small
                // chip shifts bit by bit.
                let (mut top, mut by, mut rest) = (wanted, 0, self.shifts);
                while let [shift, more @ ..] = rest {
                    top >>= *shift - by;
                    by = *shift;
                    if top <= self.full {
                        return Ok(Fitted { hz: self.hz, wanted, top, shift: by });
                    }
                    rest = more;
                }
                Err(Misfit::TooSlow { max: self.max_top() })
            }
            Err(misfit) => Err(misfit),
        }
    }
}

/// A virtual top fitted to a timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fitted {
    hz: u32,
    wanted: u32,
    top: u32,
    shift: u8,
}

impl Fitted {
    /// The count in the compare register.
    pub const fn top(&self) -> u32 {
        self.top
    }

    /// The prescaler: 1, 8, 64 …
    pub const fn prescaler(&self) -> u32 {
        1 << self.shift
    }

    /// log₂ of the prescaler.
    pub const fn shift(&self) -> u8 {
        self.shift
    }

    /// The virtual top that was fitted.
    pub const fn virtual_top(&self) -> u32 {
        self.wanted
    }

    /// The actual clocks between two steps: at most the virtual top.
    pub const fn interval(&self) -> Ticks {
        self.top << self.shift
    }

    /// The actual rate in 10⁻⁹ steps/s, rounded to nearest.
    pub const fn nanosteps(&self) -> u64 {
        per_second(self.hz, self.interval() as u64)
    }

    /// The actual speed of a motor with this many steps per turn, in 10⁻⁹ turns per minute. 0 steps
    /// per turn count as 1.
    pub const fn nanorpm(&self, steps_per_turn: u32) -> u64 {
        let steps = if steps_per_turn == 0 { 1 } else { steps_per_turn } as u128;
        let down = self.interval() as u128 * steps;
        saturated((self.hz as u128 * (60 * NANO as u128) + down / 2) / down)
    }

    /// The deviation of the actual rate from a wanted one (negative if below), in 10⁻⁹ of the
    /// wanted rate: 180.0018 instead of 180 steps/s is 10,000. Rates are in 10⁻⁹ steps/s; for 0
    /// steps/s the result is 0.
    pub const fn deviation_ppb(&self, wanted_nanosteps: u64) -> i64 {
        deviation_ppb(self.nanosteps(), wanted_nanosteps)
    }
}

const NANO: u64 = 1_000_000_000;

/// The rate of steps of this many clocks, in 10⁻⁹ steps/s, rounded to nearest.
const fn per_second(hz: u32, interval: u64) -> u64 {
    let interval = if interval == 0 { 1 } else { interval };
    (hz as u64 * NANO + interval / 2) / interval
}

/// (real − wanted) / wanted in 10⁻⁹, rounded to nearest; 0 for a `wanted` of 0.
pub const fn deviation_ppb(real: u64, wanted: u64) -> i64 {
    if wanted == 0 {
        return 0;
    }
    let difference = real.abs_diff(wanted) as u128 * NANO as u128;
    let parts = (difference + wanted as u128 / 2) / wanted as u128;
    let parts = if parts > i64::MAX as u128 { i64::MAX } else { parts as i64 };
    if real < wanted { -parts } else { parts }
}

const fn saturated(value: u128) -> u64 {
    if value > u64::MAX as u128 { u64::MAX } else { value as u64 }
}

/// Why a timer can't make an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Misfit {
    /// The virtual top is longer than the timer counts at its largest prescaler: `TIMER_DIV_ERROR`
    /// of the Arduino driver. Also for a standstill.
    TooSlow {
        /// The longest virtual top.
        max: u32,
    },
    /// The virtual top is shorter than the step interrupt takes.
    TooFast {
        /// The shortest virtual top.
        min: u32,
    },
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Misfit::TooSlow { max } => write!(
                f,
                "too slow for this timer: the virtual top may be {max} at most; raise the speed, \
                 or use a slower clock"
            ),
            Misfit::TooFast { min } => write!(
                f,
                "too fast for this timer: the virtual top must be {min} at least; lower the speed"
            ),
        }
    }
}

impl core::error::Error for Misfit {}

#[cfg(test)]
mod tests;
