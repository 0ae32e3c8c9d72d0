//! The S-curve against the ideal of `stepwright-oracle`, and against the time-optimal curve of the
//! crate `rsruckig`.
//!
//! The oracle describes ramps by their two speeds and finds the peak speed by bisection; the core
//! finds the moment at which to begin to stop. They share only the stored values.

use proptest::prelude::*;
use rsruckig::prelude::*;
use stepwright::profile::{Curve, Fit, Phase, SCurve, Tracer, Trapezoid, Unfit};
use stepwright::run::Steps;
use stepwright::{Accel, Jerk, Rate, Speed};
use stepwright_oracle::{IdealSCurve, JerkLimits};

/// The ideal: pulses at 0 … m − 1 of a continuous curve.
struct Ideal {
    curve: IdealSCurve<f64>,
    hz: f64,
}

/// An order in steps and seconds.
#[derive(Clone, Copy, Debug)]
struct Order {
    hz: u32,
    start: u32,
    top: u32,
    accel: u64,
    decel: u64,
    jerk: u64,
    pulses: u32,
}

impl Order {
    fn law(&self) -> SCurve {
        SCurve::new(
            Rate::from_hz(self.hz).unwrap(),
            Speed::from_millisteps(self.start).unwrap(),
            Speed::from_millisteps(self.top).unwrap(),
            Accel::from_millisteps(self.accel).unwrap(),
            Jerk::from_millisteps(self.jerk).unwrap(),
        )
        .with_decel(Accel::from_millisteps(self.decel).unwrap())
    }

    /// Start and top speed, acceleration, deceleration, jerk.
    fn real(&self) -> [f64; 5] {
        let [v, top] = [self.start.min(self.top), self.top].map(|v| f64::from(v) / 1e3);
        let [a, d, j] = [self.accel, self.decel, self.jerk].map(|x| x as f64 / 1e3);
        [v, top, a, d, j]
    }

    fn ideal(&self) -> Ideal {
        let [start, top, accel, decel, jerk] = self.real();
        let limits = JerkLimits { start, top, accel, decel, jerk };
        let curve = IdealSCurve::new(limits, f64::from(self.pulses.saturating_sub(1)));
        Ideal { curve, hz: self.hz.into() }
    }
}

impl Ideal {
    /// Ticks from the first pulse to pulse n.
    fn time(&self, n: u32) -> f64 {
        self.curve.time(n.into()) * self.hz
    }
}

/// Checks that `got` is off by at most a tick, or 2⁻⁴⁰ of the time.
fn check(what: &str, n: u32, got: f64, ideal: f64) -> Result<(), TestCaseError> {
    let allowed = (ideal / 2f64.powi(40)).max(1.0);
    let off = (got - ideal).abs();
    prop_assert!(off <= allowed, "{what}: pulse {n} at {got}, ideal {ideal:.3}, off by {off:.3}");
    Ok(())
}

/// Checks that a refusal is due: the first or the last interval takes 2³¹ ticks.
fn refused(why: Unfit, order: Order) -> Result<(), TestCaseError> {
    let (ideal, last) = (order.ideal(), order.pulses.saturating_sub(1));
    let ends = [ideal.time(last.min(1)), ideal.time(last) - ideal.time(last.saturating_sub(1))];
    let slowest = ends[0].max(ends[1]);
    prop_assert!(
        why == Unfit::TooSlow && slowest > 2f64.powi(31) * (1.0 - 1e-6),
        "{why:?}: {slowest}"
    );
    Ok(())
}

/// Whole numbers spread evenly over the orders of magnitude.
fn spread(low: u64, high: u64) -> impl Strategy<Value = u64> {
    (0.0f64..1.0).prop_map(move |x| {
        let (l, h) = ((low.max(1) as f64).ln(), (high as f64).ln());
        ((l + x * (h - l)).exp().round() as u64).clamp(low, high)
    })
}

prop_compose! {
    fn order(least: u64, most: u64)(
        hz in spread(100_000, 200_000_000),
        start in prop_oneof![1 => Just(0), 2 => spread(1_000, 1_000_000_000)],
        top in spread(1_000, 1_000_000_000),
        accel in spread(100, 100_000_000_000),
        decel in spread(100, 100_000_000_000),
        jerk in spread(100, 1_000_000_000_000_000_000),
        pulses in spread(least, most),
    ) -> Order {
        Order {
            hz: hz as u32,
            start: start as u32,
            top: top as u32,
            accel,
            decel,
            jerk,
            pulses: pulses as u32,
        }
    }
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(4_000)
}

/// Every pulse of a short travel, and every run of it under random fits.
fn every_pulse(curve: Curve, ideal: &Ideal, micro: u32) -> Result<(), TestCaseError> {
    let m = curve.pulses();
    let mut times = vec![0u64];
    for delay in Steps::new(Tracer::new(curve, Fit::EXACT)) {
        times.push(times[times.len() - 1] + u64::from(delay));
    }
    prop_assert_eq!(times.len(), m.max(1) as usize);
    for n in (0..m).filter(|n| m < 64 || n % (m / 37) == 0 || *n + 3 > m) {
        let want = ideal.time(n);
        check("delays", n, times[n as usize] as f64, want)?;
        check("time_of", n, curve.time_of(n) as f64, want)?;
    }
    // Runs for a board: every step within the stated error of the delays,
    // which are within a tick of the ideal.
    let (mut t, mut n) = (0u64, 0);
    for delay in Steps::new(Tracer::new(curve, Fit::within(micro, 200_000))) {
        t += u64::from(delay);
        n += 1;
        let want = times[n];
        let allowed = u64::from(micro) + 1 + (want >> 40);
        prop_assert!(
            t.abs_diff(want) <= allowed,
            "run step {n} of {m} at {t}, wanted {want}, fit {micro}"
        );
    }
    prop_assert_eq!(n as u32, m.saturating_sub(1));
    Ok(())
}

/// The time that `rsruckig` needs from rest to rest, in seconds; without a jerk limit that of the
/// trapezoid.
fn optimum(top: f64, accel: f64, decel: f64, jerk: Option<f64>, length: f64) -> f64 {
    let mut otg = Ruckig::<1, ThrowErrorHandler>::new(None, 0.01);
    let mut input = InputParameter::<1>::new(None);
    // Its tolerances are absolute: use a unit of length in which the speed is 1.
    input.max_velocity[0] = 1.0;
    input.max_acceleration[0] = accel / top;
    input.min_acceleration = Some(daov_stack![-decel / top; 1]);
    input.max_jerk[0] = jerk.map_or(f64::INFINITY, |jerk| jerk / top);
    input.target_position[0] = length / top;
    let mut trajectory = Trajectory::<1>::new(None);
    otg.calculate(&input, &mut trajectory).unwrap();
    trajectory.get_duration()
}

/// A bend whose gain a 64-bit speed can't represent: its ramps had any length, and the pulse
/// between them was 55 ticks late.
#[test]
fn a_bend_too_gentle_to_tell() {
    let (start, top) = (409_133_349, 412_269_665);
    let order = Order { hz: 175_562_924, start, top, accel: 100, decel: 100, jerk: 100, pulses: 3 };
    every_pulse(order.law().curve(3).unwrap(), &order.ideal(), 1).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn curves_keep_the_ideal(order in order(0, 3_000), micro in 1u32..300) {
        let curve = match order.law().curve(order.pulses) {
            Ok(curve) => curve,
            Err(why) => return refused(why, order),
        };
        every_pulse(curve, &order.ideal(), micro)?;
    }

    #[test]
    fn long_travels_keep_the_ideal(
        order in order(3_000, 1 << 31),
        at in prop::collection::vec(0.0f64..1.0, 6),
    ) {
        let curve = match order.law().curve(order.pulses) {
            Ok(curve) => curve,
            Err(why) => return refused(why, order),
        };
        let ideal = order.ideal();
        let last = order.pulses - 1;
        let somewhere = at.iter().map(|x| (x * f64::from(last)) as u32);
        for n in somewhere.chain([0, 1, last - 1, last]) {
            let begin = ideal.time(n);
            check("time_of", n, curve.time_of(n) as f64, begin)?;
            let (mut m, mut t) = (n, 0);
            for run in Tracer::at(curve, Fit::EXACT, n).take(4) {
                m += u32::from(run.count());
                t += run.duration();
                // The difference of two large times is less exact than each.
                let lost = begin / 2f64.powi(48);
                let off = ((t >> 16) as f64 - (ideal.time(m) - begin)).abs() - lost;
                check("run from n", m, off.max(0.0), 0.0)?;
            }
        }
    }

    /// Fast, and bent so gently over so few steps that a speed hardly changes.
    #[test]
    fn what_gains_next_to_nothing_keeps_the_ideal(
        hz in 1_000_000u32..200_000_000,
        start in 1_000_000u32..1_000_000_000,
        accel in 100u64..10_000_000,
        jerk in 100u64..10_000_000,
        pulses in 2u32..200,
    ) {
        let top = start.saturating_add(start / 100).min(1_000_000_000);
        let order = Order { hz, start, top, accel, decel: accel, jerk, pulses };
        let curve = match order.law().curve(order.pulses) {
            Ok(curve) => curve,
            Err(why) => return refused(why, order),
        };
        every_pulse(curve, &order.ideal(), 1)?;
    }

    #[test]
    fn limits_are_kept_between_pulses(order in order(3, 2_000)) {
        let curve = match order.law().curve(order.pulses) {
            Ok(curve) => curve,
            Err(why) => return refused(why, order),
        };
        prop_assert!(curve.peak() <= order.top);
        // An interval is a mean: no faster than the top speed, except for rounding.
        let least = (u64::from(order.hz) * 1000 / u64::from(order.top)) as u32;
        for delay in order.law().delays(order.pulses).unwrap().skip(1) {
            prop_assert!(delay + 1 >= least);
        }
    }

    /// From rest, 100 steps and more: within 0.5 % of the time-optimal motion.
    #[test]
    fn no_time_is_lost(
        top in 100.0f64..100_000.0,
        rise in 0.05f64..5.0,
        fall in 0.05f64..5.0,
        bend in 0.01f64..2.0,
        length in 100u32..1_000_000,
    ) {
        let milli = |x: f64| (x * 1e3).round().max(1.0) as u64;
        let order = Order {
            hz: 1_000_000,
            start: 0,
            top: milli(top) as u32,
            accel: milli(top / rise),
            decel: milli(top / fall),
            jerk: milli(top / rise / bend),
            pulses: length + 1,
        };
        let curve = match order.law().curve(order.pulses) {
            Ok(curve) => curve,
            Err(why) => return refused(why, order),
        };
        let [_, top, a, d, j] = order.real();
        let best = optimum(top, a, d, Some(j), length.into());
        let got = curve.time_of(length) as f64 / 1e6;
        prop_assert!((got - best).abs() <= best * 0.005, "{got} s, optimum {best} s");

        let law = Trapezoid::new(
            Rate::MHZ,
            Speed::ZERO,
            Speed::from_millisteps(order.top).unwrap(),
            Accel::from_millisteps(order.accel).unwrap(),
        )
        .with_decel(Accel::from_millisteps(order.decel).unwrap());
        let path = law.path(order.pulses).unwrap();
        let best = optimum(top, a, d, None, length.into());
        let got = path.time_of(length) as f64 / 1e6;
        prop_assert!((got - best).abs() <= best * 0.005, "{got} s, optimum {best} s");
    }

    /// At the largest jerk the curve is the trapezoid: A/J and D/J longer.
    #[test]
    fn a_large_jerk_is_the_trapezoid(order in order(0, 3_000)) {
        let order = Order { jerk: Jerk::MAX.millisteps(), ..order };
        let law = Trapezoid::new(
            Rate::from_hz(order.hz).unwrap(),
            Speed::from_millisteps(order.start).unwrap(),
            Speed::from_millisteps(order.top).unwrap(),
            Accel::from_millisteps(order.accel).unwrap(),
        )
        .with_decel(Accel::from_millisteps(order.decel).unwrap());
        let (Ok(curve), Ok(path)) = (order.law().curve(order.pulses), law.path(order.pulses)) else {
            return Ok(());
        };
        let bends = (order.accel + order.decel) as f64 / order.jerk as f64 * f64::from(order.hz);
        for n in (0..order.pulses).step_by(97) {
            let (t, want) = (curve.time_of(n) as f64, path.time_of(n) as f64);
            prop_assert!((t - want).abs() <= bends + 2.0 + want * 1e-11, "{n}: {t} {want}");
        }
    }
}

fn law(top: u32, accel: u32, jerk: u64) -> SCurve {
    SCurve::new(
        Rate::MHZ,
        Speed::ZERO,
        Speed::from_steps(top).unwrap(),
        Accel::from_steps(accel).unwrap(),
        Jerk::from_steps(jerk).unwrap(),
    )
}

/// The phases of a curve, in their order, with their pulses.
fn phases(curve: &Curve) -> Vec<(Phase, u32)> {
    let mut phases: Vec<(Phase, u32)> = Vec::new();
    for n in 0..curve.pulses() {
        match phases.last_mut() {
            Some((phase, count)) if *phase == curve.phase_of(n) => *count += 1,
            _ => phases.push((curve.phase_of(n), 1)),
        }
    }
    phases
}

#[test]
fn phases_come_in_their_order() {
    use Phase::{Cruise, Down, JerkDown, JerkUp, Up};
    let names = |law: SCurve, pulses| -> Vec<Phase> {
        phases(&law.curve(pulses).unwrap()).into_iter().map(|(phase, _)| phase).collect()
    };
    let all = [JerkUp, Up, JerkDown, Cruise, JerkUp, Down, JerkDown];
    assert_eq!(names(law(1000, 4000, 48_000), 2001), all);
    // Too short for the top speed: no cruise.
    assert_eq!(
        names(law(1_000_000, 4000, 48_000), 2001),
        [JerkUp, Up, JerkDown, JerkUp, Down, JerkDown]
    );
    // No time for the full acceleration.
    assert_eq!(
        names(law(1000, 40_000, 48_000), 2001),
        [JerkUp, JerkDown, Cruise, JerkUp, JerkDown]
    );
    // Neither of both.
    assert_eq!(names(law(100_000, 100_000, 48_000), 201), [JerkUp, JerkDown, JerkUp, JerkDown]);
    // Starting at the top speed: only a cruise.
    let level = SCurve::new(
        Rate::MHZ,
        Speed::from_steps(2000).unwrap(),
        Speed::from_steps(1000).unwrap(),
        Accel::from_steps(4000).unwrap(),
        Jerk::from_steps(48_000).unwrap(),
    );
    assert_eq!(names(level, 100), [Cruise]);
    assert!(level.delays(100).unwrap().skip(1).all(|delay| delay == 1000));
    let law = law(1000, 4000, 48_000);
    assert_eq!((law.curve(0).unwrap().pulses(), names(law, 0)), (0, vec![]));
    assert_eq!(names(law, 1).len(), 1);
}

#[test]
fn few_pulses() {
    let law = law(1000, 4000, 48_000);
    let delays = |pulses| law.delays(pulses).unwrap().collect::<Vec<_>>();
    assert_eq!(delays(0), []);
    assert_eq!(delays(1), [0]);
    // One step: four changes of the acceleration of T/4 each, in which s = J·T³/32 (for a constant
    // jerk that changes its sign at T/4 and 3T/4).
    assert_eq!(delays(2), [0, ((32.0f64 / 48_000.0).cbrt() * 1e6).round() as u32]);
    assert_eq!(law.delays(777).unwrap().len(), 777);
    assert_eq!(law.curve(2).unwrap().time_of(9), law.curve(2).unwrap().time_of(1));
}

#[test]
fn what_a_timer_cannot_hold_is_refused() {
    let slow = law(1000, 1, 1);
    assert!(slow.curve(10).is_ok());
    let never =
        SCurve::new(Rate::MAX, Speed::ZERO, Speed::from_steps(10).unwrap(), Accel::MIN, Jerk::MIN);
    assert_eq!(never.curve(10), Err(Unfit::TooSlow));
    assert_eq!(law(0, 1, 1).curve(10), Err(Unfit::Standstill));
    assert_eq!(slow.curve((1 << 31) + 1), Err(Unfit::TooLong));
    assert!(slow.curve(1 << 31).is_ok());
}

/// All 2³¹ − 1 steps in one walk: errors must not add up.
#[test]
fn the_longest_travel_ends_on_time() {
    let order = Order {
        hz: 16_000_000,
        start: 0,
        top: 777_777_777,
        accel: 3_000,
        decel: 5_000,
        jerk: 10,
        pulses: 1 << 31,
    };
    let curve = order.law().curve(order.pulses).unwrap();
    let mut steps = 0u64;
    let total: u64 = Tracer::new(curve, Fit::EXACT)
        .map(|run| {
            steps += u64::from(run.count());
            run.duration()
        })
        .sum();
    assert_eq!(steps, (1 << 31) - 1);
    check("longest", order.pulses - 1, (total >> 16) as f64, order.ideal().time(order.pulses - 1))
        .unwrap();
}

/// A profile is its runs, and they are few.
#[test]
fn a_curve_is_few_runs() {
    let curve = law(20_000, 100_000, 2_000_000).curve(40_001).unwrap();
    let runs = |fit| Tracer::new(curve, fit).count();
    let (loose, tight) = (runs(Fit::within(2, 1 << 24)), runs(Fit::EXACT));
    println!("{loose} {tight}");
    assert!(loose < 300, "{loose}");
    assert!(tight < 800, "{tight}");
}
