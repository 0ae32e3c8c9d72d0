//! The bounds of the figures, those that are not met yet, and the allowed worsening of each.

use std::fmt;

/// The bound of each figure, whatever was stored: name, axes, feed, bound.
pub(super) const BOUNDS: &[(&str, u8, &str, Bound)] = &[
    ("back_to_back_constant", 1, "queued", Bound::AtMost(85.0)),
    ("back_to_back_ramp", 1, "queued", Bound::AtMost(100.0)),
    ("isolated", 1, "queued", Bound::AtMost(110.0)),
    ("rate_ramps", 1, "queued", Bound::AtLeast(120_000.0)),
    ("rate_ramps", 2, "queued", Bound::AtLeast(60_000.0)),
    ("rate_constant", 3, "queued", Bound::AtLeast(45_000.0)),
    ("rate_ramps", 3, "queued", Bound::AtLeast(35_000.0)),
    ("planning_burst", 3, "queued", Bound::AtMost(3_200.0)),
    ("order_burst", 3, "queued", Bound::AtMost(3_200.0)),
    ("interrupts_off", 3, "queued", Bound::AtMost(300.0)),
    ("interval_rms", 1, "queued", Bound::AtMost(0.05)),
    ("steepest", 1, "queued", Bound::AtLeast(800_000.0)),
    ("steepest", 2, "queued", Bound::AtLeast(150_000.0)),
    ("steepest", 3, "queued", Bound::AtLeast(52_000.0)),
    ("accel_peak_deadlines", 1, "queued", Bound::AtMost(1.4)),
    ("accel_peak", 1, "queued", Bound::AtMost(2.5)),
    ("flash", 3, "queued", Bound::AtMost(20_480.0)),
    ("ram", 3, "queued", Bound::AtMost(1_229.0)),
];

/// Rows known to miss their bound: name, axes, feed, reason. They fail only by worsening, or by
/// meeting their bound: then they must leave this list. `docs/benchmarks.md` says more.
pub(super) const OPEN: &[(&str, u8, &str, &str)] = &[
    ("rate_constant", 3, "queued", "an axis waits for the others' next groups to be prepared"),
    ("ram", 3, "queued", "what the guards keep: settings, places, errors"),
    ("flash", 3, "queued", "what the compiler makes of wide numbers"),
];

/// The allowed worsening of a figure: 2 %.
const SLACK: f64 = 0.02;
/// The same firmware gives the same rates, but one late step decides, and the phase of the traffic
/// changes with every change of the firmware: 5 %.
const RATE_SLACK: f64 = 0.05;

/// The good side of a figure, and its limit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

impl Bound {
    pub(super) fn of(name: &str, axes: u8, feed: &str) -> Option<Bound> {
        let row = BOUNDS.iter().find(|row| (row.0, row.1, row.2) == (name, axes, feed));
        row.map(|row| row.3)
    }

    pub(super) fn holds(self, value: f64) -> bool {
        match self {
            Bound::AtMost(most) => value <= most,
            Bound::AtLeast(least) => value >= least,
        }
    }

    /// The bound of a figure when `stored` was reached before.
    pub(super) fn near(stored: f64, is_a_rate: bool) -> Bound {
        if is_a_rate {
            Bound::AtLeast(stored * (1.0 - RATE_SLACK))
        } else {
            Bound::AtMost(stored * (1.0 + SLACK))
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Bound::AtMost(value) => write!(f, "≤ {value}"),
            Bound::AtLeast(value) => write!(f, "≥ {value}"),
        }
    }
}

/// Why a bound is known to be missed, if it is.
pub(super) fn open(name: &str, axes: u8, feed: &str) -> Option<&'static str> {
    let row = OPEN.iter().find(|row| (row.0, row.1, row.2) == (name, axes, feed));
    row.map(|row| row.3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_bound_is_open() {
        for (name, axes, feed, _) in OPEN {
            assert!(Bound::of(name, *axes, feed).is_some(), "{name} of {axes} has no bound");
        }
    }
}
