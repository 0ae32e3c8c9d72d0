//! The closed-form laws against the ideal of `stepwright-oracle`, in 104 bits.

use proptest::prelude::*;
use stepwright::profile::{Cursor, Delays, Fit, Path, RampSteps, Trapezoid, Unfit};
use stepwright::run::Steps;
use stepwright::{Accel, Rate, Speed};
use stepwright_oracle::{Double, IdealTrapezoid, Number};

fn real(n: u64) -> Double {
    Double::whole(n)
}

/// The ideal: m pulses at positions 0 … m − 1 of a continuous profile.
struct Ideal {
    /// In steps and thousandths of a step/s: its times are in 1000 s.
    profile: IdealTrapezoid<Double>,
    ticks: Double,
}

impl Ideal {
    /// Speeds in 0.001 steps/s, slopes as 2a in 10⁻⁶ (steps/s)² per step.
    fn new(hz: u32, start: u32, top: u32, (a2, d2): (u64, u64), pulses: u32) -> Ideal {
        let [start, top] = [start, top].map(|speed| real(speed.into()));
        let length = real(pulses.saturating_sub(1).into());
        let profile = IdealTrapezoid::new((start, start), top, (real(a2), real(d2)), length);
        Ideal { profile, ticks: real(1000 * u64::from(hz)) }
    }

    /// Ticks from the first pulse to pulse n.
    fn time(&self, n: u32) -> Double {
        self.profile.time(real(n.into())) * self.ticks
    }
}

/// Checks that `got` is off by at most a tick, or 2⁻⁴⁰ of the time.
fn check(what: &str, n: u32, got: u64, ideal: Double) -> Result<(), TestCaseError> {
    let off = (real(got) - ideal).to_f64().abs();
    let allowed = (ideal.to_f64() * 2f64.powi(-40)).max(1.0);
    let wanted = ideal.to_f64();
    prop_assert!(off <= allowed, "{what}: pulse {n} at {got}, ideal {wanted:.3}, off by {off:.3}");
    Ok(())
}

/// Checks that a refusal is due: from rest, the first step, the last and one at the top speed take 2³¹ ticks
/// together; with a start speed, one step at it does. `slopes` are 2a in 10⁻⁶ (steps/s)² per step.
fn refused(
    why: Unfit,
    hz: u32,
    start: u32,
    top: u32,
    slopes: [f64; 2],
) -> Result<(), TestCaseError> {
    let interval = |speed: u32| 1e3 / f64::from(speed);
    let ends: f64 = slopes.iter().map(|slope| 2e3 / slope.sqrt()).sum();
    let slowest = if start == 0 { ends + interval(top) } else { interval(start.min(top)) };
    let slowest = slowest * f64::from(hz);
    prop_assert!(
        why == Unfit::TooSlow && slowest > 2f64.powi(31) * (1.0 - 1e-9),
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

fn start_speed() -> impl Strategy<Value = u64> {
    prop_oneof![1 => Just(0), 3 => spread(1_000, 1_000_000_000)]
}

/// Every pulse of a short travel, and every run of it under random fits.
fn every_pulse(path: Path, ideal: &Ideal, delays: Delays, micro: u32) -> Result<(), TestCaseError> {
    let m = path.pulses();
    let times: Vec<u64> = delays
        .scan(0u64, |t, delay| {
            *t += u64::from(delay);
            Some(*t)
        })
        .collect();
    prop_assert_eq!(times.len(), m as usize);
    for n in (0..m).filter(|n| m < 64 || n % (m / 37) == 0 || *n + 3 > m) {
        let want = ideal.time(n);
        check("delays", n, times[n as usize], want)?;
        check("time_of", n, path.time_of(n), want)?;
    }
    // Runs for a board: every step within the stated error of the delays,
    // which are within a tick of the ideal.
    let fit = Fit::within(micro, 200_000);
    let mut t = 0u64;
    let mut n = 0;
    for delay in Steps::new(Cursor::new(path, fit)) {
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

/// The runs that begin at pulse n of a travel of any length.
fn from_pulse(path: Path, ideal: &Ideal, n: u32) -> Result<(), TestCaseError> {
    check("time_of", n, path.time_of(n), ideal.time(n))?;
    let mut cursor = Cursor::at(path, Fit::EXACT, n);
    let mut t = 0u64;
    let begin = ideal.time(n);
    // One run at a time would drop a fraction each; played together the runs carry them.
    let mut n_of_run = n;
    let mut ends = Vec::new();
    for run in cursor.by_ref().take(4).collect::<Vec<_>>() {
        n_of_run += u32::from(run.count());
        t += run.duration();
        ends.push((n_of_run, t >> 16));
    }
    for (at, t) in ends {
        // The ideal's own start is between ticks: no second rounding here.
        check("run from n", at, t, ideal.time(at) - begin)?;
    }
    Ok(())
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(4_000)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn trapezoids_keep_the_ideal(
        hz in spread(100_000, 200_000_000),
        start in start_speed(),
        top in spread(1_000, 1_000_000_000),
        accel in spread(100, 100_000_000_000),
        decel in spread(100, 100_000_000_000),
        pulses in spread(0, 3_000),
        micro in 1u32..300,
    ) {
        let (hz, start, top) = (hz as u32, start as u32, top as u32);
        let law = Trapezoid::new(
            Rate::from_hz(hz).unwrap(),
            Speed::from_millisteps(start).unwrap(),
            Speed::from_millisteps(top).unwrap(),
            Accel::from_millisteps(accel).unwrap(),
        )
        .with_decel(Accel::from_millisteps(decel).unwrap());
        let slopes = [accel, decel].map(|slope| slope as f64 * 2e3);
        let path = match law.path(pulses as u32) {
            Ok(path) => path,
            Err(why) => return refused(why, hz, start, top, slopes),
        };
        prop_assert_eq!(path.slopes(), (accel * 2000, decel * 2000));
        let ideal = Ideal::new(hz, start, top, path.slopes(), pulses as u32);
        every_pulse(path, &ideal, law.delays(pulses as u32).unwrap(), micro)?;
    }

    #[test]
    fn ramps_in_steps_keep_the_ideal(
        hz in spread(100_000, 200_000_000),
        start in start_speed(),
        top in spread(1_000, 1_000_000_000),
        ramp in spread(1, 65_535),
        pulses in spread(0, 3_000),
        micro in 1u32..300,
    ) {
        let (hz, start, top) = (hz as u32, start as u32, top as u32);
        let law = RampSteps::new(
            Rate::from_hz(hz).unwrap(),
            Speed::from_millisteps(start).unwrap(),
            Speed::from_millisteps(top).unwrap(),
            ramp as u16,
        )
        .unwrap();
        // a = (v_t² − v_s²) / 2R, at least the smallest.
        let squared = |speed: u32| f64::from(speed).powi(2);
        let slope = ((squared(top) - squared(start)) / ramp as f64).max(2e3);
        let path = match law.path(pulses as u32) {
            Ok(path) => path,
            Err(why) => return refused(why, hz, start, top, [slope; 2]),
        };
        if top > start {
            // a = (v_t² − v_s²) / 2R, rounded to the nearest stored value.
            let exact = (u128::from(top).pow(2) - u128::from(start).pow(2)) / u128::from(ramp);
            prop_assert!(u128::from(path.slopes().0).abs_diff(exact.max(2_000)) <= 1);
        }
        let ideal = Ideal::new(hz, start, top, path.slopes(), pulses as u32);
        every_pulse(path, &ideal, law.delays(pulses as u32).unwrap(), micro)?;
    }

    #[test]
    fn long_travels_keep_the_ideal(
        hz in spread(100_000, 200_000_000),
        start in start_speed(),
        top in spread(1_000, 1_000_000_000),
        accel in spread(100, 100_000_000_000),
        decel in spread(100, 100_000_000_000),
        pulses in spread(3_000, 1 << 31),
        at in prop::collection::vec(0.0f64..1.0, 6),
    ) {
        let (hz, start, top) = (hz as u32, start as u32, top as u32);
        let law = Trapezoid::new(
            Rate::from_hz(hz).unwrap(),
            Speed::from_millisteps(start).unwrap(),
            Speed::from_millisteps(top).unwrap(),
            Accel::from_millisteps(accel).unwrap(),
        )
        .with_decel(Accel::from_millisteps(decel).unwrap());
        let slopes = [accel, decel].map(|slope| slope as f64 * 2e3);
        let path = match law.path(pulses as u32) {
            Ok(path) => path,
            Err(why) => return refused(why, hz, start, top, slopes),
        };
        let ideal = Ideal::new(hz, start, top, path.slopes(), pulses as u32);
        let last = pulses as u32 - 1;
        for x in at {
            from_pulse(path, &ideal, (x * f64::from(last)) as u32)?;
        }
        for n in [0, 1, last - 1, last] {
            from_pulse(path, &ideal, n)?;
        }
    }
}

/// All 2³¹ − 1 steps in one walk: hours of motion, in which errors must not add up.
#[test]
fn the_longest_travel_ends_on_time() {
    let law = Trapezoid::new(
        Rate::from_hz(16_000_000).unwrap(),
        Speed::ZERO,
        Speed::from_millisteps(777_777_777).unwrap(),
        Accel::from_steps(3).unwrap(),
    );
    let pulses = 1 << 31;
    let path = law.path(pulses).unwrap();
    let mut steps = 0u64;
    let total: u64 = Cursor::new(path, Fit::EXACT)
        .map(|run| {
            steps += u64::from(run.count());
            run.duration()
        })
        .sum();
    assert_eq!(steps, (1 << 31) - 1);
    let ideal = Ideal::new(16_000_000, 0, 777_777_777, path.slopes(), pulses);
    check("longest", pulses - 1, total >> 16, ideal.time(pulses - 1)).unwrap();
}
