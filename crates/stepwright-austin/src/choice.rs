//! Any of the laws with its constants: sent to a board, which follows it.

#![cfg_attr(
    not(all(feature = "constant", feature = "transitions", feature = "power")),
    allow(unused_imports, unused_variables, dead_code, reason = "what the other laws need")
)]

use super::carried::LONGEST;
use super::count::Pulses;
use super::fixed::Fixed;
use super::general::{Divisor, RampConstants, Ramps};
use super::linear::{Corners, Factor, FactorConstants};
use super::piecewise::{StageConstants, Stages};
use super::power::{Knee, POWERS, PowerConstants};
use super::travel::{Shadowed, Travel};
use stepwright::fixed::Q32;
use stepwright::units::{Accel, Ticks};

/// The laws by their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawName {
    /// The general form, and c/2n.
    Austin,
    /// The published listing.
    AustinFixed,
    /// The linear factor.
    LinearFactor,
    /// The power term.
    Power,
    /// The piecewise ramp.
    Piecewise,
}

impl LawName {
    /// All laws.
    pub const ALL: [LawName; 5] = [
        LawName::Austin,
        LawName::AustinFixed,
        LawName::LinearFactor,
        LawName::Power,
        LawName::Piecewise,
    ];

    /// The laws in this build's [`Recipe`].
    pub const HERE: &[LawName] = &[
        #[cfg(feature = "constant")]
        LawName::Austin,
        #[cfg(feature = "constant")]
        LawName::AustinFixed,
        #[cfg(feature = "transitions")]
        LawName::LinearFactor,
        #[cfg(feature = "power")]
        LawName::Power,
        #[cfg(feature = "transitions")]
        LawName::Piecewise,
    ];

    /// The name, as in the command and on the line.
    pub const fn name(self) -> &'static str {
        match self {
            LawName::Austin => "austin",
            LawName::AustinFixed => "austin-fixed",
            LawName::LinearFactor => "linear-factor",
            LawName::Power => "power",
            LawName::Piecewise => "piecewise",
        }
    }
}

/// A law with its constants: delays in 2⁻³² ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recipe {
    /// The general form, and c/2n.
    #[cfg(feature = "constant")]
    Austin(RampConstants),
    /// The published listing: the first delay and the shortest one.
    #[cfg(feature = "constant")]
    AustinFixed(Ticks, Ticks),
    /// The linear factor.
    #[cfg(feature = "transitions")]
    LinearFactor(FactorConstants),
    /// The power term.
    #[cfg(feature = "power")]
    Power(PowerConstants),
    /// The piecewise ramp.
    #[cfg(feature = "transitions")]
    Piecewise(StageConstants),
}

/// The most breaks of a piecewise ramp: with more, the search of its way down takes more steps at
/// once than a chip has time for.
const BREAKS: u8 = 8;
/// The longest ramp in steps.
const FAR: u32 = 1 << 30;

impl Recipe {
    /// The law's name.
    pub const fn law(&self) -> LawName {
        match self {
            #[cfg(feature = "constant")]
            Recipe::Austin(_) => LawName::Austin,
            #[cfg(feature = "constant")]
            Recipe::AustinFixed(..) => LawName::AustinFixed,
            #[cfg(feature = "transitions")]
            Recipe::LinearFactor(_) => LawName::LinearFactor,
            #[cfg(feature = "power")]
            Recipe::Power(_) => LawName::Power,
            #[cfg(feature = "transitions")]
            Recipe::Piecewise(_) => LawName::Piecewise,
        }
    }

    /// Whether a board can follow it: delays of 1 to 2²² − 1 ticks, ramps of at most 2³⁰ steps, and
    /// for laws with a second ramp one that begins as fast as the first, or faster: with a
    /// deceleration of at least the acceleration. Piecewise has at most 8 breaks.
    pub fn is_sound(&self) -> bool {
        let fits = |delay: Q32| ((delay >> 32) as u32).wrapping_sub(1) < LONGEST;
        match self {
            #[cfg(feature = "constant")]
            Recipe::Austin(c) => fits(c.lead) && fits(c.count) && fits(c.shortest),
            #[cfg(feature = "constant")]
            Recipe::AustinFixed(c0, c_min) => {
                c0.wrapping_sub(1) < LONGEST && c_min.wrapping_sub(1) < LONGEST
            }
            #[cfg(feature = "transitions")]
            Recipe::LinearFactor(c) => {
                let Corners { n1, n2, j1, j2 } = c.corners;
                let ordered = n1 <= n2 && n2 <= FAR && j1 <= j2 && j2 <= FAR;
                ordered && fits(c.lead) && fits(c.count) && fits(c.shortest)
            }
            #[cfg(feature = "power")]
            Recipe::Power(c) => {
                let parts = c.rise.1 <= 1 << 63 && c.fall.1 <= 1 << 63;
                let delays = fits(c.lead) && fits(c.rise.0) && fits(c.fall.0) && fits(c.shortest);
                delays && parts && POWERS.contains(&c.power) && c.fall.0 <= c.rise.0
            }
            #[cfg(feature = "transitions")]
            Recipe::Piecewise(c) => {
                let delays = fits(c.lead) && fits(c.rise) && fits(c.fall) && fits(c.shortest);
                delays && c.breaks <= BREAKS && c.fall <= c.rise
            }
        }
    }

    /// Whether the acceleration can be changed during a travel.
    pub fn changes(&self) -> bool {
        match self {
            #[cfg(feature = "constant")]
            Recipe::Austin(c) => c.divisor == Divisor::FourN,
            #[allow(unreachable_patterns, reason = "with one feature alone")]
            _ => false,
        }
    }

    /// The shortest delay in whole ticks, rounded down.
    pub fn shortest(&self) -> Ticks {
        let exact = match self {
            #[cfg(feature = "constant")]
            Recipe::AustinFixed(_, c_min) => return *c_min,
            #[cfg(feature = "constant")]
            Recipe::Austin(c) => c.shortest,
            #[cfg(feature = "transitions")]
            Recipe::LinearFactor(c) => c.shortest,
            #[cfg(feature = "power")]
            Recipe::Power(c) => c.shortest,
            #[cfg(feature = "transitions")]
            Recipe::Piecewise(c) => c.shortest,
        };
        (exact >> 32) as Ticks
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    pub fn delays(&self, pulses: u32) -> AnyLaw {
        match self {
            #[cfg(feature = "constant")]
            Recipe::Austin(c) => AnyLaw::Austin(c.delays(pulses)),
            #[cfg(feature = "constant")]
            Recipe::AustinFixed(c0, c_min) => AnyLaw::AustinFixed(Fixed::new(pulses, *c0, *c_min)),
            #[cfg(feature = "transitions")]
            Recipe::LinearFactor(c) => AnyLaw::LinearFactor(c.delays(pulses)),
            #[cfg(feature = "power")]
            Recipe::Power(c) => AnyLaw::Power(c.delays(pulses)),
            #[cfg(feature = "transitions")]
            Recipe::Piecewise(c) => AnyLaw::Piecewise(c.delays(pulses)),
        }
    }
}

/// The pulses of a travel under any of the laws, as delays in ticks. The first is 0.
#[derive(Clone, Debug)]
pub enum AnyLaw {
    /// The general form, and c/2n.
    #[cfg(feature = "constant")]
    Austin(Pulses<Travel<Ramps>>),
    /// The published listing.
    #[cfg(feature = "constant")]
    AustinFixed(Fixed),
    /// The linear factor.
    #[cfg(feature = "transitions")]
    LinearFactor(Pulses<Factor>),
    /// The power term.
    #[cfg(feature = "power")]
    Power(Pulses<Travel<Shadowed<Knee>>>),
    /// The piecewise ramp.
    #[cfg(feature = "transitions")]
    Piecewise(Pulses<Travel<Shadowed<Stages>>>),
}

impl AnyLaw {
    /// Brakes from the next delay on.
    pub fn stop(&mut self) {
        match self {
            #[cfg(feature = "constant")]
            AnyLaw::Austin(delays) => delays.stop(),
            #[cfg(feature = "constant")]
            AnyLaw::AustinFixed(delays) => delays.stop(),
            #[cfg(feature = "transitions")]
            AnyLaw::LinearFactor(delays) => delays.stop(),
            #[cfg(feature = "power")]
            AnyLaw::Power(delays) => delays.stop(),
            #[cfg(feature = "transitions")]
            AnyLaw::Piecewise(delays) => delays.stop(),
        }
    }

    /// Sets another acceleration from the next delay on (Eq 18). Returns false and does nothing
    /// after the end of the way up, and for all laws but the general form.
    pub fn set_accel(&mut self, accel: Accel) -> bool {
        match self {
            #[cfg(feature = "constant")]
            AnyLaw::Austin(delays) => delays.set_accel(accel),
            #[allow(unreachable_patterns, reason = "with one feature alone")]
            _ => false,
        }
    }
}

impl Iterator for AnyLaw {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        match self {
            #[cfg(feature = "constant")]
            AnyLaw::Austin(delays) => delays.next(),
            #[cfg(feature = "constant")]
            AnyLaw::AustinFixed(delays) => delays.next(),
            #[cfg(feature = "transitions")]
            AnyLaw::LinearFactor(delays) => delays.next(),
            #[cfg(feature = "power")]
            AnyLaw::Power(delays) => delays.next(),
            #[cfg(feature = "transitions")]
            AnyLaw::Piecewise(delays) => delays.next(),
        }
    }
}
