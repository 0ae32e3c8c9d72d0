//! The laws of `stepwright plan`: the delays that a plan prints.

use stepwright::profile::{RampSteps, SCurve, Trapezoid};
use stepwright_austin::{Austin, Fixed, LinearFactor, Piecewise, PowerTerm};

use crate::planned::{BOARD, BOARD_JERK};
use crate::{Law, Sum};

/// All laws, in order.
pub const LAWS: [Law; 10] = [
    TRAPEZOID,
    S_CURVE,
    RAMP,
    AUSTIN,
    AUSTIN_FIXED,
    LINEAR_FACTOR,
    POWER,
    PIECEWISE,
    BOARD,
    BOARD_JERK,
];

/// Constant acceleration and deceleration.
pub const TRAPEZOID: Law = Law {
    name: "trapezoid",
    place: 0,
    sum: |t| {
        let law = Trapezoid::new(t.rate, t.start, t.top, t.accel).with_decel(t.decel);
        Sum::of(law.delays(t.pulses))
    },
};

/// A limited jerk.
pub const S_CURVE: Law = Law {
    name: "s-curve",
    place: 1,
    sum: |t| {
        let law = SCurve::new(t.rate, t.start, t.top, t.accel, t.jerk).with_decel(t.decel);
        Sum::of(law.delays(t.pulses))
    },
};

/// A ramp counted in steps.
pub const RAMP: Law = Law {
    name: "ramp",
    place: 2,
    sum: |t| {
        let law = RampSteps::new(t.rate, t.start, t.top, t.ramp).ok()?;
        Sum::of(law.delays(t.pulses))
    },
};

/// Austin's general form.
pub const AUSTIN: Law = Law {
    name: "austin",
    place: 3,
    sum: |t| {
        let law = Austin::new(t.rate, t.top, t.accel).with_decel(t.decel).with_c0(t.c0);
        Sum::of(law.with_divisor(t.divisor).delays(t.pulses))
    },
};

/// Austin's published listing.
pub const AUSTIN_FIXED: Law = Law {
    name: "austin-fixed",
    place: 4,
    sum: |t| Some(Sum::over(Fixed::new(t.pulses, t.listed.0, t.listed.1))),
};

/// Austin's linear factor.
pub const LINEAR_FACTOR: Law = Law {
    name: "linear-factor",
    place: 5,
    sum: |t| {
        let law = LinearFactor::new(t.rate, t.top, t.accel).with_decel(t.decel);
        Sum::of(law.with_c0(t.c0).with_knee(t.knee).delays(t.pulses))
    },
};

/// Austin's power term.
pub const POWER: Law = Law {
    name: "power",
    place: 6,
    sum: |t| {
        let law = PowerTerm::new(t.rate, t.top, t.accel, t.power).with_decel(t.decel);
        Sum::of(law.with_c0(t.c0).delays(t.pulses))
    },
};

/// Austin's piecewise ramp.
pub const PIECEWISE: Law = Law {
    name: "piecewise",
    place: 7,
    sum: |t| {
        let law = Piecewise::new(t.rate, t.top, t.accel).with_decel(t.decel);
        Sum::of(law.with_c0(t.c0).with_breaks(t.breaks).delays(t.pulses))
    },
};
