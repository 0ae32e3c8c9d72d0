//! Constant speed: every interval is f/v.
//!
//! The interval is kept to 2⁻³² ticks and the fraction is carried, so pulse n is within one tick of
//! n·f/v, up to 2³¹ pulses.

use super::path::{Bounds, Path, slope_of};
use super::{Delays, Unfit};
use crate::units::{Accel, Rate, Speed};

/// The path of `pulses` pulses at `speed`, without a ramp.
///
/// ```
/// use stepwright::{Rate, Speed, profile::constant};
/// let path = constant::path(Rate::MHZ, Speed::from_steps(300)?, 4)?;
/// assert_eq!(path.time_of(3), 10_000);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Unfit`] if the timer can't represent it.
pub fn path(rate: Rate, speed: Speed, pulses: u32) -> Result<Path, Unfit> {
    // The path starts at the top speed: the slopes are never used.
    let any = slope_of(Accel::MAX);
    Path::new(&Bounds { rate, start: speed, top: speed, a2: any, d2: any }, pulses)
}

/// The delay before each of `pulses` pulses at `speed`; the first is 0.
///
/// ```
/// use stepwright::{Rate, Speed, profile::constant};
/// let delays: Vec<u32> = constant::delays(Rate::MHZ, Speed::from_steps(300)?, 4)?.collect();
/// assert_eq!(delays, [0, 3333, 3334, 3333]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Unfit`] if the timer can't represent it.
pub fn delays(rate: Rate, speed: Speed, pulses: u32) -> Result<Delays, Unfit> {
    Ok(Delays::new(path(rate, speed, pulses)?))
}
