//! `--law`: the ramp law, and the parameters of some laws.

use clap::ValueEnum;
use stepwright::fixed::Q32;
use stepwright::{Accel, Geometry, Rate, Speed};
use stepwright_austin::{Austin, C0, Divisor, LawName, LinearFactor, Piecewise, PowerTerm, Recipe};
use stepwright_plan::{Divide, First, RampChange};

use super::motion::RampArgs;
use crate::failure::Failure;
use crate::plan::change::{ChangeArg, changes};
use crate::plan::laws::thousandths;
use crate::quantity::whole_in;

/// The help heading of the options of a ramp law.
pub const LAW: &str = "Ramp law";

/// The laws that move a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LawArg {
    /// Constant acceleration, planned by the board
    Trapezoid,
    /// Limited jerk, planned by the board: with --jerk
    SCurve,
    /// Austin's general form
    Austin,
    /// His published listing
    AustinFixed,
    /// His linear factor
    LinearFactor,
    /// His power term
    Power,
    /// His piecewise ramp
    Piecewise,
}

impl LawArg {
    /// Whether a program for Austin's laws carries it out, not a controller.
    pub fn is_austin(self) -> bool {
        !matches!(self, LawArg::Trapezoid | LawArg::SCurve)
    }
}

/// The options.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = LAW)]
pub struct LawArgs {
    /// Ramp law [default: trapezoid, with --jerk s-curve]
    #[arg(long, value_enum, value_name = "LAW", hide_possible_values = true)]
    #[arg(long_help = "\
Ramp law: trapezoid, s-curve (with --jerk), or one of Austin's,
from rest: austin, austin-fixed, linear-factor, power, piecewise [default: trapezoid, with
--jerk s-curve]. Austin's are for a board with the program `laws`, on an Uno also
`transitions` and `power-term`")]
    law: Option<LawArg>,
    /// austin, linear-factor, power, piecewise: the first delay [default: 0.676]
    #[arg(long, value_enum, requires = "law")]
    c0: Option<First>,
    /// austin: divisor of the change from one delay to the next [default: 4n+1]
    #[arg(long, value_enum, requires = "law", conflicts_with = "c0")]
    divisor: Option<Divide>,
    /// austin: change the acceleration after this many steps, like 100:500; up to four times
    #[arg(long = "change", value_name = "STEPS:ACCEL", requires = "law")]
    changes: Vec<ChangeArg>,
    /// linear-factor: speed where the acceleration begins to fall, as a part of the top speed: 0 to 0.9 [default: 0]
    #[arg(long, value_name = "PART", requires = "law", value_parser = thousandths)]
    knee: Option<u16>,
    /// power: the exponent p, 2 to 9 [default: 4]
    #[arg(long, value_name = "P", requires = "law")]
    #[arg(value_parser = whole_in::<u8>(2..=9))]
    power: Option<u8>,
    /// piecewise: how often the acceleration is reduced, 0 to 8 [default: 7]
    #[arg(long, value_name = "N", requires = "law")]
    #[arg(value_parser = whole_in::<u8>(0..=8))]
    breaks: Option<u8>,
}

impl LawArgs {
    /// The selected law, if it is one of Austin's; `None` for those that a controller plans.
    ///
    /// # Errors
    /// An option belongs to another law.
    pub fn austin(&self, ramps: &RampArgs) -> Result<Option<LawName>, Failure> {
        use LawArg as L;
        let (law, has_jerk) = (self.law, ramps.has_jerk());
        let is = |laws: &[L]| law.is_some_and(|law| laws.contains(&law));
        let owned = [
            ("--c0", self.c0.is_some(), &[L::Austin, L::LinearFactor, L::Power, L::Piecewise][..]),
            ("--divisor", self.divisor.is_some(), &[L::Austin]),
            ("--change", !self.changes.is_empty(), &[L::Austin]),
            ("--knee", self.knee.is_some(), &[L::LinearFactor]),
            ("--power", self.power.is_some(), &[L::Power]),
            ("--breaks", self.breaks.is_some(), &[L::Piecewise]),
            ("--jerk", has_jerk && law.is_some(), &[L::SCurve]),
            // Austin's laws begin at rest.
            ("--start-speed", ramps.has_start() && law.is_some(), &[L::Trapezoid, L::SCurve]),
            ("--ramp", ramps.has_length() && law.is_some(), &[L::Trapezoid, L::SCurve]),
        ];
        for (option, given, laws) in owned {
            if given && !is(laws) {
                let names: Vec<_> = laws.iter().filter_map(ValueEnum::to_possible_value).collect();
                let names: Vec<_> =
                    names.iter().map(clap::builder::PossibleValue::get_name).collect();
                return Err(Failure::usage(format!("{option} is for --law {}", names.join(", ")))
                    .hint(format!("leave {option} out, or choose that law")));
            }
        }
        if law == Some(L::SCurve) && !has_jerk {
            return Err(Failure::usage("--law s-curve needs a jerk")
                .hint("give --jerk, like twenty times the acceleration: it is there in 50 ms"));
        }
        Ok(match law {
            None | Some(L::Trapezoid | L::SCurve) => None,
            Some(L::Austin) => Some(LawName::Austin),
            Some(L::AustinFixed) => Some(LawName::AustinFixed),
            Some(L::LinearFactor) => Some(LawName::LinearFactor),
            Some(L::Power) => Some(LawName::Power),
            Some(L::Piecewise) => Some(LawName::Piecewise),
        })
    }

    /// The changes on the way.
    pub fn changes(&self, geometry: &Geometry) -> Result<Vec<RampChange>, Failure> {
        if self.changes.len() > stepwright_austin::station::CHANGES {
            return Err(Failure::usage("a board holds four --change of a travel")
                .hint("`plan austin` takes any number"));
        }
        changes(&self.changes, geometry)
    }

    /// The constants of a law for a travel of `pulses` steps.
    pub fn recipe(
        &self,
        law: LawName,
        pulses: u32,
        top: Speed,
        accel: Accel,
        decel: Accel,
    ) -> Result<Recipe, Failure> {
        let rate = Rate::MHZ;
        let c0 = self.c0.map_or(C0::default(), First::core);
        let two_n = self.divisor == Some(Divide::TwoN);
        let divisor = if two_n { Divisor::TwoN } else { Divisor::FourN };
        let general = Austin::new(rate, top, accel).with_decel(decel).with_c0(c0);
        Ok(match law {
            LawName::Austin => Recipe::Austin(general.with_divisor(divisor).constants(pulses)?),
            LawName::AustinFixed => {
                if accel != decel {
                    return Err(Failure::usage("the listing goes down as it came up")
                        .hint("leave --decel out, or take --law austin"));
                }
                // Eq 15 and Eq 2, to the nearest tick.
                let whole = general.constants(pulses)?;
                let ticks = |delay: Q32| ((delay + (1 << 31)) >> 32) as u32;
                Recipe::AustinFixed(ticks(whole.lead), ticks(whole.shortest))
            }
            LawName::LinearFactor => {
                let law = LinearFactor::new(rate, top, accel).with_decel(decel).with_c0(c0);
                let law = law.with_knee(self.knee.unwrap_or(0));
                Recipe::LinearFactor(law.constants(pulses)?)
            }
            LawName::Power => {
                let law = PowerTerm::new(rate, top, accel, self.power.unwrap_or(4));
                Recipe::Power(law.with_decel(decel).with_c0(c0).constants(pulses)?)
            }
            LawName::Piecewise => {
                let law = Piecewise::new(rate, top, accel).with_decel(decel).with_c0(c0);
                let law = law.with_breaks(self.breaks.unwrap_or(7));
                Recipe::Piecewise(law.constants(pulses)?)
            }
        })
    }
}
