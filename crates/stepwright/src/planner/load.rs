//! The load of a travel on its board: its highest speed, and the runs a second that its ramps need.
//!
//! A run is as long as the [`Fit`](crate::profile::Fit) allows, and at least a step. On a ramp of a
//! steps/s², at v steps/s and with an error of ε = 1 µs, that is
//!
//! ```text
//!   N = v²/2a · √(32·ε·v/3) steps        v/N = K·a / v^1.5 runs a second, K = 612
//! ```
//!
//! and v runs a second where N is less than 1. The most runs are needed where both meet:
//!
//! ```text
//!   v* = (K·a)^0.4        runs a second = min(v*, v_top)
//! ```
//!
//! A travel that starts above v* needs fewer runs at its steady speed, but counts the same: its
//! ramps are short, a few runs from start to end, and a stop during the travel needs as many more
//! in that time.
//!
//! A straight ramp of fewer than four steps waits in the queue as a whole; then the gentler ramp of
//! the travel counts, if that has more steps. If it has not, half of the travel's runs are queued
//! before it starts, and it needs v/2 a second, or v if it is changed during the travel. It needs
//! none if all of it waits in the queue, or if its level lasts long enough to plan the fall, 15 ms.
//! With a jerk limit a run takes twice the time, and near rest runs are shorter: four times as many
//! are counted. There the acceleration is √(2J·v) at most, so that both meet no later than at
//!
//! ```text
//!   v* = (K·√(2J))^0.5
//! ```
//!
//! A bend may be over before the next run is planned, and a stop leads through two bends and two
//! corners, with a run for each step: that is a burst, for which one axis has the time. Beside
//! other axes a bend counts in full, however short it is:
//!
//! ```text
//!   runs a second = 4·min(⅝·(K·√(2J))^0.5, v_top)        (measured on a Mega)
//! ```
//!
//! An axis ramps while it is slow. Once it is fast its steps take time from the ramps of others:
//! 65.536 steps count as a run.
//!
//! **Error.** Logarithms and powers to base 2 are linear between whole powers: −6 … +5 % up to
//! 3,000,000 steps/s², and as much again with a jerk limit.

use super::Planner;
use super::bent::Bends;
use crate::num::{Num, hand, whole};

/// The load of a travel on its board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Load {
    /// The highest speed from now on, in 0.001 steps/s; 1 for queued steps, 0 at rest.
    pub(crate) peak: u32,
    /// Runs a second that the ramps need.
    pub(crate) runs: u16,
    /// Runs a second that their bends need beside other axes.
    pub(crate) bends: Bends,
}

impl Load {
    pub(crate) const NONE: Load = Load { peak: 0, runs: 0, bends: Bends::NONE };
    /// Nothing is left to plan, but queued steps still move.
    pub(crate) const QUEUED: Load = Load { peak: 1, ..Load::NONE };

    /// Runs a second whose time the axis takes from the ramps of other axes, and needs beside them:
    /// for its ramps and their bends, or for its steps once it is fast.
    pub(crate) fn takes(&self) -> u16 {
        self.runs.max(self.bends.runs()).max((self.peak >> 16) as u16)
    }
}

/// A logarithm to base 2, in 1/256.
type Log = i16;

/// A ramp of fewer steps is short; the first four steps after the beginning fit in any queue.
const FEW: u32 = 4;
/// The steps of two ramps that are not short.
pub(super) const RAMPS: u32 = 2 * FEW;

/// Converts a slope, 2a in 10⁻⁶ (steps/s)², to K·a in steps/s^2.5.
const K: Log = 2_980;
/// Converts 0.001 steps/s to steps/s.
const MILLI: Log = 2_551;
/// A factor of a half.
const HALF: Log = 256;
/// Converts the fourth root of half a jerk, in steps per (1000 s)³, to v* in steps/s.
const BEND: Log = -600;
/// A factor of five eighths.
const BURST: Log = 174;

impl Planner {
    /// Raises a load to that of the rest of the travel.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn load(&self, load: &mut Load) {
        let peak = self.peak();
        load.peak = load.peak.max(peak);
        load.runs = load.runs.max(self.runs(peak, false));
        load.bends = load.bends.max(self.bends(peak));
    }

    /// Runs a second in a bend of its ramps, up to this speed; beside other axes.
    #[inline(always)]
    pub(crate) fn bends(&self, peak: u32) -> Bends {
        if self.is_straight() { Bends::NONE } else { Bends::new(self.runs_of_bends(peak)) }
    }

    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn runs_of_bends(&self, peak: u32) -> u16 {
        let top = whole(peak).number();
        if peak <= Load::QUEUED.peak || self.v_end.at_least(&top) {
            return 0;
        }
        let meeting = self.bend().wrapping_sub(BURST);
        power(log(&top).wrapping_sub(MILLI).min(meeting)).saturating_mul(4)
    }

    /// The speed from which on a run of a bend is longer than a step.
    fn bend(&self) -> Log {
        (log(self.curve.half_jerk()) >> 2).wrapping_add(BEND)
    }

    /// Runs a second on the steepest ramp that counts, up to this speed. `begins`: the travel has
    /// not begun yet. A travel that is changed on the way can't rely on a full queue.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn runs(&self, peak: u32, begins: bool) -> u16 {
        let (a2, d2) = (&self.a2, &self.d2);
        let (mut slope, gentle) = if a2.at_least(d2) { (a2, d2) } else { (d2, a2) };
        if peak <= Load::QUEUED.peak || slope.is_zero() {
            return 0;
        }
        let straight = self.is_straight();
        let top = whole(peak).number();
        let mut runs = log(&top).wrapping_sub(MILLI);
        // The growth of speed² per step in a ramp of four steps. (A division takes too long for a
        // piece of an order.)
        let mut four = hand(&self.v_end).square().number();
        hand(&top).square().minus(&four).scaled(-2).to(&mut four);
        let mut short = !four.at_least(slope);
        if short {
            if self.v_end.at_least(&top) {
                return 0;
            }
            // The other ramp counts, unless it is as short.
            if straight {
                slope = gentle;
                short = slope.is_zero() || !four.at_least(slope);
            }
        }
        // The rest of a changed travel may be too short for the top speed with which it is judged.
        if straight && (short || !begins && self.steps_left() < RAMPS) {
            // Its runs are single steps, however gentle it is. 0.001 steps/s over 2¹⁶ are the steps
            // of 15 ms.
            if begins && self.steps_left() <= FEW || self.level >= peak >> 16 {
                return 0;
            }
            if begins {
                runs = runs.wrapping_sub(HALF);
            }
        } else {
            let slope = log(slope).wrapping_sub(K).max(0);
            // · 0.4, within 16 bits.
            let meeting = ((slope as u16 >> 4).wrapping_mul(51) >> 3) as Log;
            runs = runs.min(meeting);
        }
        if !straight {
            runs = runs.min(self.bend());
        }
        let runs = power(runs);
        if straight { runs } else { runs.saturating_mul(4) }
    }
}

/// The logarithm of a number of 2⁻⁶⁰ to 2⁶⁰.
fn log(n: &Num) -> Log {
    n.exponent().wrapping_shl(8) | n.fraction() as Log
}

/// 2 to the power `log`, rounded down; less than 2¹⁶.
fn power(log: Log) -> u16 {
    let [fraction, exponent] = log.max(0).to_le_bytes();
    ((0x100 | u32::from(fraction)) << exponent.min(15) >> 8) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::order::{Order, Travel};
    use crate::planner::Clock;
    use crate::profile::{Fit, Ramp};
    use crate::units::{Accel, Jerk, Rate, Speed};
    use core::ops::RangeInclusive;
    use proptest::prelude::*;

    const CLOCK: Clock = Clock::new(Rate::MHZ, &Fit::board(Rate::MHZ));

    fn load(start: u32, top: u32, accel: u32, jerk: Option<u64>) -> Load {
        let jerk = jerk.map(|jerk| Jerk::from_steps(jerk).unwrap());
        load_of(start, top, [accel; 2], jerk, Travel::Endless(true))
    }

    fn load_of(start: u32, top: u32, slopes: [u32; 2], jerk: Option<Jerk>, travel: Travel) -> Load {
        let [up, down] = slopes.map(|accel| Ramp::Accel(Accel::from_steps(accel).unwrap()));
        let speed = |steps| Speed::from_steps(steps).unwrap();
        let (start, top) = (speed(start), speed(top));
        load_now(&laid(&Order { start, top, up, down, jerk, travel }))
    }

    fn load_now(planner: &Planner) -> Load {
        let mut load = Load::NONE;
        planner.load(&mut load);
        load
    }

    fn laid(order: &Order) -> Planner {
        let mut planner = Planner::IDLE;
        planner.lay_out(&CLOCK, order).unwrap();
        planner
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
            let Load { peak, runs, .. } = load(start, top, accel, None);
            prop_assert_eq!(peak, 1000 * top);
            let exact = if steps < 4.0 { 0.0 } else { meeting(a).min(v) };
            let runs = f64::from(runs);
            prop_assert!(near(exact).contains(&runs), "{} {}", runs, exact);
        }
    }

    /// Runs a second at the speed from which on a run is longer than a step.
    fn meeting(accel: f64) -> f64 {
        let k = 2.0 / (32e-6f64 / 3.0).sqrt();
        (k * accel).powf(0.4)
    }

    /// Within the error that the module states, and one run for rounding.
    fn near(exact: f64) -> RangeInclusive<f64> {
        0.94 * exact - 1.0..=1.05 * exact + 1.0
    }

    #[test]
    fn a_logarithm_that_is_low_twice_is_near_enough() {
        let runs = f64::from(load(0, 2_189, 365_806, None).runs);
        assert!(near(meeting(365_806.0)).contains(&runs), "{runs}");
    }

    /// Each value of the logarithm many times.
    #[test]
    fn runs_a_second_are_near_those_of_the_formula_all_the_way() {
        let mut accel = 500.0f64;
        while accel < 3_000_000.0 {
            let runs = f64::from(load(0, 200_000, accel as u32, None).runs);
            assert!(near(meeting(accel.floor())).contains(&runs), "{accel}: {runs}");
            accel *= 1.0002;
        }
    }

    #[test]
    fn an_s_curve_counts_four_times_and_what_has_no_ramp_not_at_all() {
        let sharp = Some(100_000_000);
        assert_eq!(load(0, 5_000, 20_000, sharp).runs, 4 * load(0, 5_000, 20_000, None).runs);
        let none = Load { peak: 5_000_000, ..Load::NONE };
        assert_eq!(load(5_000, 5_000, 20_000, None), none);
        assert_eq!(load(5_000, 5_000, 20_000, sharp), none);
        assert_eq!(load(0, 1_000, 200_000, None), Load { peak: 1_000_000, ..Load::NONE });
    }

    /// However gentle the ramps are that they bend. By the formula of the module.
    #[test]
    fn bends_count_in_full_beside_other_axes() {
        for jerk in [1_000, 10_000, 270_922, 10_000_000, 1_000_000_000u64] {
            let exact = 4.0 * (0.625 * (612.37 * (2.0 * jerk as f64).sqrt()).sqrt()).min(771.0);
            let bent = load(603, 771, 577, Some(jerk));
            let runs = f64::from(bent.bends.runs());
            assert!((0.94 * exact..=1.16 * exact).contains(&runs), "{jerk}: {runs} {exact}");
            assert_eq!(bent.takes(), bent.runs.max(bent.bends.runs()));
            // 4 · (612 · 577)^0.4
            assert!((500..=700).contains(&bent.runs), "{jerk}: {}", bent.runs);
        }
        assert_eq!(load(603, 771, 577, None).takes(), load(603, 771, 577, None).runs);
    }

    /// The steep ramp has less than four steps, up or down.
    #[test]
    fn the_gentler_ramp_counts_where_the_steeper_one_is_short() {
        for slopes in [[100_000_000, 826_814], [826_814, 100_000_000]] {
            let Load { peak, runs, .. } = load_of(0, 113_952, slopes, None, Travel::By(18));
            assert!((5_200_000..5_300_000).contains(&peak), "{peak}");
            // (612 · 826,814)^0.4
            assert!((2_850..=3_520).contains(&runs), "{runs}");
        }
        let gentle = load(0, 2_000, 20_000, None);
        assert_eq!(load_of(0, 2_000, [20_000, 90_000_000], None, Travel::Endless(true)), gentle);
        let both = load_of(0, 2_000, [600_000, 90_000_000], None, Travel::Endless(true));
        assert_eq!(both.runs, 0);
    }

    /// Ramps of three steps each way up to 5,055 steps/s, and what lies between them.
    #[test]
    fn short_ramps_count_where_the_queue_does_not_hold_them() {
        let runs = |pulses, begins| {
            let (start, top) = (Speed::ZERO, Speed::from_steps(5_055).unwrap());
            let (up, travel) = (Ramp::Steps(3), Travel::By(pulses));
            let planner = laid(&Order { start, top, up, down: up, jerk: None, travel });
            f64::from(planner.runs(planner.peak(), begins))
        };
        for (pulses, begins, exact) in
            [(10, true, 2_527.0), (83, true, 2_527.0), (10, false, 5_055.0)]
        {
            let near = 0.94 * exact..=1.16 * exact;
            assert!(near.contains(&runs(pulses, begins)), "{pulses}: {}", runs(pulses, begins));
        }
        // All steps wait in the queue, but not during the travel; or the level is long.
        assert_eq!(runs(5, true), 0.0);
        assert!(runs(5, false) > 2_900.0);
        assert_eq!((runs(90, true), runs(90, false)), (0.0, 0.0));
    }

    /// As steep as 2 steps from rest to 262,566 steps/s: no number wraps.
    #[test]
    fn the_steepest_ramp_counts_by_its_jerk() {
        let (start, top) = (Speed::from_steps(50).unwrap(), Speed::from_steps(262_566).unwrap());
        let jerk = Some(Jerk::from_steps(31_488_493).unwrap());
        let (up, travel) = (Ramp::Steps(2), Travel::By(-409));
        let runs = load_now(&laid(&Order { start, top, up, down: up, jerk, travel })).runs;
        // 4 · (612 · √2J)^0.5
        assert!((8_200..=10_300).contains(&runs), "{runs}");
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
