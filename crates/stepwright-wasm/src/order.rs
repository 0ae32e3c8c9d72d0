//! The numbers of a travel, and their ranges.

use stepwright::profile::Unfit;
use stepwright::{Accel, Jerk, Rate, Speed};
use stepwright_austin::{C0, Divisor};

/// The laws, in the order of their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanLaw {
    /// Constant acceleration.
    Trapezoid,
    /// Limited jerk.
    SCurve,
    /// Austin's general form.
    Austin,
    /// Austin's published listing.
    AustinFixed,
    /// Austin's linear factor.
    LinearFactor,
    /// Austin's power term.
    Power,
    /// Austin's piecewise ramp.
    Piecewise,
}

impl PlanLaw {
    /// All laws.
    pub const ALL: [PlanLaw; 7] = [
        PlanLaw::Trapezoid,
        PlanLaw::SCurve,
        PlanLaw::Austin,
        PlanLaw::AustinFixed,
        PlanLaw::LinearFactor,
        PlanLaw::Power,
        PlanLaw::Piecewise,
    ];

    /// The name, as in the command.
    pub const fn name(self) -> &'static str {
        match self {
            PlanLaw::Trapezoid => "trapezoid",
            PlanLaw::SCurve => "s-curve",
            PlanLaw::Austin => "austin",
            PlanLaw::AustinFixed => "austin-fixed",
            PlanLaw::LinearFactor => "linear-factor",
            PlanLaw::Power => "power",
            PlanLaw::Piecewise => "piecewise",
        }
    }
}

/// Why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanRefusal {
    /// The reason.
    pub what: &'static str,
    /// What is allowed, or what to do.
    pub remedy: &'static str,
}

impl PlanRefusal {
    /// There is no law of that number.
    pub const NO_LAW: PlanRefusal =
        PlanRefusal { what: "there is no law of that number", remedy: "give 0 to 6" };
    /// No timer makes two pulses in one tick.
    pub(crate) const TOO_FAST: PlanRefusal = PlanRefusal {
        what: "more than one step a tick of the timer",
        remedy: "lower the top speed, or take a faster timer",
    };
}

impl core::fmt::Display for PlanRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: {}", self.what, self.remedy)
    }
}

impl core::error::Error for PlanRefusal {}

impl From<Unfit> for PlanRefusal {
    fn from(unfit: Unfit) -> PlanRefusal {
        PlanRefusal { what: unfit.what(), remedy: unfit.remedy() }
    }
}

/// The range of a number of a travel, with both ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanField {
    /// The smallest number.
    pub low: f64,
    /// The largest number.
    pub high: f64,
    /// The refusal of any other number.
    pub refusal: PlanRefusal,
}

const fn field(low: f64, high: f64, what: &'static str, remedy: &'static str) -> PlanField {
    PlanField { low, high, refusal: PlanRefusal { what, remedy } }
}

/// The number of fields of a travel.
pub const FIELDS: usize = 14;

/// The fields, in order.
#[rustfmt::skip]
static ALLOWED: [PlanField; FIELDS] = [
    field(1e5, 2e8, "the timer's rate is out of its range", "give 100000 to 200000000 Hz"),
    field(0.0, 1e7, "the number of steps is out of its range", "give 0 to 10000000 steps"),
    field(0.0, 1e6, "the start speed is out of its range", "give 0 to 1000000 steps/s"),
    field(1e-3, 1e6, "the top speed is out of its range", "give 0.001 to 1000000 steps/s"),
    field(1e-3, 1e8, "the acceleration is out of its range", "give 0.001 to 100000000 steps/s²"),
    field(1e-3, 1e8, "the deceleration is out of its range", "give 0.001 to 100000000 steps/s²"),
    field(1e-3, 1e15, "the jerk is out of its range", "give 0.001 to 10¹⁵ steps/s³"),
    field(0.0, 2.0, "the kind of first delay is out of its range", "give 0 exact, 1 for 0.676, 2 for c1"),
    field(0.0, 1.0, "the divisor is out of its range", "give 0 for 4n+1, 1 for 2n"),
    field(0.0, 0.9, "the knee is out of its range", "give 0 to 0.9 of the top speed"),
    field(2.0, 9.0, "the power is out of its range", "give 2 to 9"),
    field(0.0, 16.0, "the number of breaks is out of its range", "give 0 to 16"),
    field(0.0, 1e12, "the window's begin is out of its range", "give 0 s or more"),
    field(0.0, 1e12, "the window's end is out of its range", "give 0 s or more"),
];

/// A travel, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanOrder {
    /// The rate of the step timer.
    pub rate: Rate,
    /// The number of pulses.
    pub steps: u32,
    /// The speed at both ends, for laws in closed form; Austin's laws begin at rest.
    pub start: Speed,
    /// The speed between the ramps.
    pub top: Speed,
    /// Acceleration.
    pub accel: Accel,
    /// Deceleration.
    pub decel: Accel,
    /// The jerk of the S-curve.
    pub jerk: Jerk,
    /// How Austin's ramps begin.
    pub c0: C0,
    /// The divisor of Austin's general form.
    pub divisor: Divisor,
    /// The knee of the linear factor, in thousandths of the top speed.
    pub knee: u16,
    /// The power of the power term.
    pub power: u8,
    /// The breaks of the piecewise ramp.
    pub breaks: u8,
    /// The window of the curves, from and to, in s.
    pub window: (f64, f64),
}

impl PlanOrder {
    /// 4000 steps at 2000 steps/s² and at most 1000 steps/s, on a timer of 16 MHz.
    pub const EXAMPLE: [f64; FIELDS] =
        [16e6, 4000.0, 0.0, 1000.0, 2000.0, 2000.0, 4e4, 1.0, 0.0, 0.0, 4.0, 7.0, 0.0, 1e12];

    /// The range of number `i`.
    pub fn field(i: usize) -> Option<&'static PlanField> {
        ALLOWED.get(i)
    }

    /// The travel of these numbers: timer rate in Hz, steps, start and top speed in steps/s, acceleration and
    /// deceleration in steps/s², jerk in steps/s³, the kind of first delay (0 exact, 1 for 0.676, 2 for c1),
    /// the divisor (0 for 4n+1, 1 for 2n), the knee as a part of the top speed, the power, the breaks, and the
    /// window of the curves, from and to, in s.
    ///
    /// # Errors
    /// A number is out of its range, or is NaN.
    pub fn check(numbers: &[f64; FIELDS]) -> Result<PlanOrder, PlanRefusal> {
        for (number, field) in numbers.iter().zip(&ALLOWED) {
            if !(field.low..=field.high).contains(number) {
                return Err(field.refusal);
            }
        }
        let [
            rate,
            steps,
            start,
            top,
            accel,
            decel,
            jerk,
            c0,
            divisor,
            knee,
            power,
            breaks,
            from,
            to,
        ] = *numbers;
        let refused = |i: usize| {
            let refusal = ALLOWED.get(i).map_or(PlanRefusal::NO_LAW, |field| field.refusal);
            move |_| refusal
        };
        Ok(PlanOrder {
            rate: Rate::from_hz(whole(rate) as u32).map_err(refused(0))?,
            steps: whole(steps) as u32,
            start: Speed::from_millisteps(whole(start * 1e3) as u32).map_err(refused(2))?,
            top: Speed::from_millisteps(whole(top * 1e3) as u32).map_err(refused(3))?,
            accel: Accel::from_millisteps(whole(accel * 1e3)).map_err(refused(4))?,
            decel: Accel::from_millisteps(whole(decel * 1e3)).map_err(refused(5))?,
            jerk: Jerk::from_millisteps(whole(jerk * 1e3)).map_err(refused(6))?,
            c0: match whole(c0) {
                0 => C0::Exact,
                1 => C0::Reduced,
                _ => C0::FirstStep,
            },
            divisor: if whole(divisor) == 0 { Divisor::FourN } else { Divisor::TwoN },
            knee: whole(knee * 1e3) as u16,
            power: whole(power) as u8,
            breaks: whole(breaks) as u8,
            window: (from, to.max(from)),
        })
    }

    /// Ticks per second.
    pub(crate) fn hz(&self) -> f64 {
        f64::from(self.rate.hz())
    }
}

/// The nearest whole number to a number that is not negative.
fn whole(x: f64) -> u64 {
    (x + 0.5) as u64
}
