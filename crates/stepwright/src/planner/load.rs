//! What a travel asks of its board: its highest speed, and how many runs a second its ramps take.
//!
//! A run is as long as the [`Fit`](crate::profile::Fit) allows, and a step at least. On a ramp of
//! a steps/s², at v steps/s and with an error of ε = 1 µs, that is
//!
//! ```text
//!   N = v²/2a · √(32·ε·v/3) steps        v/N = K·a / v^1.5 runs a second, K = 612
//! ```
//!
//! and v runs a second where N is less than 1. Most are asked for where both meet:
//!
//! ```text
//!   v* = (K·a)^0.4        runs a second = min(v*, v_top)
//! ```
//!
//! A travel that starts above v* takes fewer in the steady course, and is judged alike: its ramps are
//! short, a few runs from start to end, and a stop on the way has as many more to plan in that time.
//!
//! A straight ramp of less than four steps asks for none: it and the other one wait in the queue as
//! a whole. With a limit of jerk a run takes twice the time, and near rest is shorter: four times as
//! many are counted. There the acceleration is √(2J·v) at most, so that both meet no later than at
//!
//! ```text
//!   v* = (K·√(2J))^0.5
//! ```
//!
//! An axis ramps while it is slow. Once it is fast its steps take the time from the ramps of others:
//! 65.536 of them count as a run.
//!
//! **Error.** Logarithms and powers to base 2 are straight lines between whole powers: −6 … +16 %.

use super::Planner;
use crate::num::{Num, hand, whole};

/// What a travel asks of its board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Load {
    /// The highest speed from now on, in 0.001 steps/s; 0 if nothing is left.
    pub(crate) peak: u32,
    /// Runs a second that its steepest ramp asks for.
    pub(crate) runs: u16,
}

impl Load {
    pub(crate) const NONE: Load = Load { peak: 0, runs: 0 };

    /// Runs a second whose time it takes from the ramps of another axis: of its own ramps, or of
    /// its steps once it is fast.
    pub(crate) fn takes(&self) -> u16 {
        self.runs.max((self.peak >> 16) as u16)
    }
}

/// A logarithm to base 2, in 1/256.
type Log = i16;

/// From a slope, 2a in 10⁻⁶ (steps/s)², to K·a in steps/s^2.5.
const K: Log = 2_989;
/// From 0.001 steps/s to steps/s.
const MILLI: Log = 2_551;
/// From a quarter of that of half a jerk, in steps per (1000 s)³, to v* in steps/s.
const BEND: Log = -600;

impl Planner {
    /// What is left of the travel asks for.
    pub(crate) fn load(&self) -> Load {
        let peak = self.peak();
        Load { peak, runs: self.runs(peak) }
    }

    /// Runs a second on its steepest ramp, up to this speed.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn runs(&self, peak: u32) -> u16 {
        let steepest = if self.a2.at_least(&self.d2) { &self.a2 } else { &self.d2 };
        if peak == 0 || steepest.is_zero() {
            return 0;
        }
        let top = whole(peak).number();
        let least = hand(&self.v_end).square().number();
        let steps = hand(&top).square().minus(&least).over(steepest);
        if steps.below(2) && (self.is_straight() || self.v_end.at_least(&top)) {
            return 0;
        }
        let (slope, top) = (log(steepest), log(&top));
        let slope = slope.wrapping_sub(K).max(0);
        // · 0.4, within 16 bits.
        let meeting = ((slope as u16 >> 3).wrapping_mul(51) >> 4) as Log;
        let mut runs = meeting.min(top.wrapping_sub(MILLI));
        if !self.is_straight() {
            runs = runs.min((log(self.curve.half_jerk()) >> 2).wrapping_add(BEND));
        }
        let runs = power(runs);
        if self.is_straight() { runs } else { runs.saturating_mul(4) }
    }
}

/// Of a number of 2⁻⁶⁰ to 2⁶⁰.
fn log(n: &Num) -> Log {
    n.exponent().wrapping_shl(8) | n.fraction() as Log
}

/// 2 to that power, rounded down; at most 2¹⁵.
fn power(log: Log) -> u16 {
    let [fraction, exponent] = log.max(0).to_le_bytes();
    match exponent {
        0..=7 => (0x100 | u16::from(fraction)) >> (8 - exponent),
        8..=14 => (0x100 | u16::from(fraction)) << (exponent - 8),
        _ => 1 << 15,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::order::{Order, Travel};
    use crate::planner::Clock;
    use crate::profile::{Fit, Ramp};
    use crate::units::{Accel, Jerk, Rate, Speed};
    use proptest::prelude::*;

    const CLOCK: Clock = Clock::new(Rate::MHZ, &Fit::board(Rate::MHZ));

    fn load(start: u32, top: u32, accel: u32, jerk: Option<u64>) -> Load {
        let ramp = Ramp::Accel(Accel::from_steps(accel).unwrap());
        let speed = |steps| Speed::from_steps(steps).unwrap();
        let jerk = jerk.map(|jerk| Jerk::from_steps(jerk).unwrap());
        let travel = Travel::Endless(true);
        let (start, top) = (speed(start), speed(top));
        let mut planner = Planner::IDLE;
        let order = Order { start, top, up: ramp, down: ramp, jerk, travel };
        planner.lay_out(&CLOCK, &order).unwrap();
        planner.load()
    }

    proptest! {
        /// By the formulas of the module, in floating point.
        #[test]
        fn runs_a_second_are_near_those_of_the_formula(
            start in prop_oneof![Just(0), 1u32..20_000],
            more in 1u32..200_000,
            accel in 500u32..3_000_000,
        ) {
            let top = start + more;
            let (v, a) = (f64::from(top), f64::from(accel));
            let steps = (v * v - f64::from(start).powi(2)) / (2.0 * a);
            prop_assume!((steps / 4.0 - 1.0).abs() > 0.001);
            let Load { peak, runs } = load(start, top, accel, None);
            prop_assert_eq!(peak, 1000 * top);
            let k = 2.0 / (32e-6f64 / 3.0).sqrt();
            let exact = (k * a).powf(0.4).min(v);
            let exact = if steps < 4.0 { 0.0 } else { exact };
            let runs = f64::from(runs);
            prop_assert!((0.94 * exact - 1.0..=1.16 * exact + 1.0).contains(&runs), "{} {}", runs, exact);
        }
    }

    #[test]
    fn an_s_curve_counts_four_times_and_what_has_no_ramp_not_at_all() {
        let sharp = Some(100_000_000);
        assert_eq!(load(0, 5_000, 20_000, sharp).runs, 4 * load(0, 5_000, 20_000, None).runs);
        assert_eq!(load(5_000, 5_000, 20_000, None), Load { peak: 5_000_000, runs: 0 });
        assert_eq!(load(5_000, 5_000, 20_000, sharp), Load { peak: 5_000_000, runs: 0 });
        assert_eq!(load(0, 1_000, 200_000, None), Load { peak: 1_000_000, runs: 0 });
    }

    /// The acceleration, steep as it may be, is not reached in the steps of the first runs.
    #[test]
    fn a_gentle_jerk_asks_for_fewer_runs() {
        for jerk in [10_000, 100_000, 1_000_000, 10_000_000, 100_000_000u64] {
            let exact = 4.0 * (612.37 * (2.0 * jerk as f64).sqrt()).sqrt();
            let runs = f64::from(load(0, 10_000, 10_000_000, Some(jerk)).runs);
            assert!((0.94 * exact..=1.16 * exact).contains(&runs), "{jerk}: {runs} {exact}");
        }
        // As fast as it steps; it takes more than four steps, though its acceleration alone would not.
        let runs = load(0, 300, 50_000, Some(1_000_000)).runs;
        assert!((1_120..=1_400).contains(&runs), "{runs}");
    }
}
