//! The ideals against other formulas in 160 bits: times by differences of speeds, ramps by their
//! three pieces, every place found by bisection.

use dashu_float::{FBig, round::mode::HalfEven};
use proptest::prelude::*;
use stepwright_oracle::{Double, IdealSCurve, IdealTrapezoid, JerkLimits, Number};

type Real = FBig<HalfEven, 2>;

fn real(n: u64) -> Real {
    Real::from(n).with_precision(160).value()
}

/// A time of the oracle, exactly: its high part, and the rest.
fn exact(time: Double) -> Real {
    let high = time.to_f64();
    let low = (time - Double::from_f64(high)).to_f64();
    let [high, low] = [high, low].map(|x| Real::try_from(x).unwrap().with_precision(160).value());
    high + low
}

/// Whether the relative difference of two times is at most 2 to minus this power.
fn near(time: Double, right: &Real, power: u64) -> bool {
    let off = exact(time) - right;
    let off = if off < Real::ZERO { -off } else { off };
    let allowed = right / real(1 << (power / 2)) / real(1 << (power - power / 2));
    off <= allowed
}

/// Whole numbers spread evenly over the orders of magnitude.
fn spread(low: u64, high: u64) -> impl Strategy<Value = u64> {
    (0.0f64..1.0).prop_map(move |x| {
        let (l, h) = ((low.max(1) as f64).ln(), (high as f64).ln());
        ((l + x * (h - l)).exp().round() as u64).clamp(low, high)
    })
}

fn start() -> impl Strategy<Value = u64> {
    prop_oneof![1 => Just(0), 3 => spread(1_000, 1_000_000_000)]
}

/// A trapezoid on the line of speeds: a ramp takes the difference of its speeds over the
/// acceleration.
fn trapezoid([start, top, a2, d2, length]: [u64; 5], at: u64) -> Real {
    let start = real(start.min(top));
    let (mut top, length, s) = (real(top), real(length), real(at));
    let (a, d) = (real(a2) / real(2), real(d2) / real(2));
    let gain = &top * &top - &start * &start;
    let mut s1 = &gain / (real(2) * &a);
    let mut s2 = &length - &gain / (real(2) * &d);
    if s1 > s2 {
        s1 = &length * &d / (&a + &d);
        s2 = s1.clone();
        top = (&start * &start + real(2) * &a * &s1).sqrt();
    }
    if s <= s1 {
        return ((&start * &start + real(2) * &a * s).sqrt() - &start) / &a;
    }
    let up = (&top - &start) / &a;
    if s <= s2 {
        return up + (s - &s1) / &top;
    }
    let level = (&s2 - &s1) / &top;
    let v = (&start * &start + real(2) * &d * (&length - s)).sqrt();
    up + level + (&top - v) / &d
}

/// Three pieces of a ramp from `from` to `to`: durations, and the jerk's direction in each.
struct Pieces {
    from: Real,
    jerk: Real,
    bend: Real,
    straight: Real,
}

impl Pieces {
    fn new(from: &Real, to: &Real, most: &Real, jerk: &Real) -> Pieces {
        let gain = to - from;
        let (bend, straight) = if &gain * jerk <= most * most {
            ((&gain / jerk).sqrt(), real(0))
        } else {
            (most / jerk, &gain / most - most / jerk)
        };
        Pieces { from: from.clone(), jerk: jerk.clone(), bend, straight }
    }

    fn time(&self) -> Real {
        &self.bend + &self.bend + &self.straight
    }

    /// The distance after a time, piece by piece.
    fn way(&self, mut t: Real) -> Real {
        let (mut x, mut v, mut a) = (real(0), self.from.clone(), real(0));
        let signs = [self.jerk.clone(), real(0), -self.jerk.clone()];
        for (jerk, whole) in signs.into_iter().zip([&self.bend, &self.straight, &self.bend]) {
            let u = if &t < whole { t.clone() } else { whole.clone() };
            let rest = &a / real(2) + &jerk * &u / real(6);
            x += &u * (&v + &u * rest);
            v += &u * (&a + &jerk * &u / real(2));
            a += &jerk * &u;
            t -= u;
        }
        x
    }

    fn when(&self, way: &Real) -> Real {
        halve(real(0), self.time(), |t| &self.way(t.clone()) < way)
    }
}

/// Where `below` ends between two numbers, by 200 bisections.
fn halve(mut low: Real, mut high: Real, below: impl Fn(&Real) -> bool) -> Real {
    for _ in 0..200 {
        let middle = (&low + &high) / real(2);
        if below(&middle) { low = middle } else { high = middle }
    }
    high
}

fn s_curve([start, top, a, d, j, length]: [u64; 6], at: u64) -> Real {
    let (start, mut top, length, s) = (real(start.min(top)), real(top), real(length), real(at));
    let ramps = |top: &Real| {
        (Pieces::new(&start, top, &real(a), &real(j)), Pieces::new(&start, top, &real(d), &real(j)))
    };
    let ways = |top: &Real| {
        let (rise, fall) = ramps(top);
        rise.way(rise.time()) + fall.way(fall.time())
    };
    if ways(&top) > length {
        top = halve(start.clone(), top, |top| ways(top) < length);
    }
    let (rise, fall) = ramps(&top);
    let (up, down) = (rise.way(rise.time()), fall.way(fall.time()));
    let left = &length - &s;
    if s < up {
        rise.when(&s)
    } else if left < down {
        let level = (&length - &up - &down) / &top;
        rise.time() + level + fall.time() - fall.when(&left)
    } else {
        rise.time() + (s - up) / top
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn trapezoids(
        start in start(),
        top in spread(1_000, 1_000_000_000),
        up in spread(200_000, 200_000_000_000_000),
        down in spread(200_000, 200_000_000_000_000),
        length in spread(1, 1 << 31),
        part in 0.0f64..=1.0,
    ) {
        let at = (length as f64 * part) as u64;
        let right = trapezoid([start, top, up, down, length], at);
        let [v, w, a, d, l, n] = [start, top, up, down, length, at].map(Double::whole);
        let ideal = IdealTrapezoid::new((v, v), w, (a, d), l);
        prop_assert!(near(ideal.time(n), &right, 88), "{} {right}", ideal.time(n).to_f64());
        let [v, w, a, d, l, n] = [v, w, a, d, l, n].map(Number::to_f64);
        let rough = IdealTrapezoid::new((v, v), w, (a, d), l);
        prop_assert!(near(Double::from_f64(rough.time(n)), &right, 40));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn s_curves(
        start in start(),
        top in spread(1_000, 1_000_000_000),
        accel in spread(100_000, 100_000_000_000),
        decel in spread(100_000, 100_000_000_000),
        jerk in spread(100_000, 1_000_000_000_000_000),
        length in spread(1_000, 1 << 41),
        part in 0.0f64..=1.0,
    ) {
        let at = (length as f64 * part) as u64;
        let right = s_curve([start, top, accel, decel, jerk, length], at);
        let all = [start, top, accel, decel, jerk, length, at].map(Double::whole);
        let [start, top, accel, decel, jerk, l, n] = all;
        let ideal = IdealSCurve::new(JerkLimits { start, top, accel, decel, jerk }, l);
        prop_assert!(near(ideal.time(n), &right, 76), "{} {right}", ideal.time(n).to_f64());
        let [start, top, accel, decel, jerk, l, n] = all.map(Number::to_f64);
        let rough = IdealSCurve::new(JerkLimits { start, top, accel, decel, jerk }, l);
        prop_assert!(near(Double::from_f64(rough.time(n)), &right, 34));
    }
}

/// Fast, and bent so gently over so few steps that the gain of speed is less than its last bit: as
/// long as a level at the start speed, except for the gain, which is `JT²/4` in a travel of T.
#[test]
fn a_gain_of_less_than_a_bit() {
    let limits = JerkLimits { start: 1e6, top: 1.1e6, accel: 0.1, decel: 0.1, jerk: 0.1 };
    let ideal = IdealSCurve::new(limits, 40.0);
    assert_eq!(ideal.peak(), 1e6);
    for at in 0..=40 {
        let level = f64::from(at) / 1e6;
        assert!((ideal.time(f64::from(at)) - level).abs() < 1e-12, "{at}");
    }
}

/// Two speeds at the ends: 30 to 50 steps/s, up at 10 steps/s² and down at 20, by hand.
#[test]
fn unequal_ends() {
    let ideal = IdealTrapezoid::new((30.0, 50.0), 70.0, (20.0, 40.0), 500.0);
    // 200 steps and 4 s up, 60 steps and 1 s down, 240 steps between.
    assert_eq!((ideal.peak(), ideal.speed(100.0)), (70.0, f64::sqrt(2900.0)));
    assert!((ideal.total() - (4.0 + 240.0 / 70.0 + 1.0)).abs() < 1e-12);
    assert!((ideal.time(200.0) - 4.0).abs() < 1e-12);
    // 30² + 20x = 50² + 40(230 − x): x = 180, 4500 = v².
    let short = IdealTrapezoid::new((30.0, 50.0), 70.0, (20.0, 40.0), 230.0);
    assert!((short.peak() - f64::sqrt(4500.0)).abs() < 1e-12);
}

/// An endless travel has times everywhere, but no end.
#[test]
fn an_endless_travel() {
    let ideal = IdealTrapezoid::new((0.0, 0.0), 10.0, (2.0, 2.0), f64::INFINITY);
    for (at, time) in [(25.0, f64::sqrt(50.0)), (50.0, 10.0), (150.0, 20.0)] {
        assert!((ideal.time(at) - time).abs() < 1e-12, "{at}");
    }
    assert_eq!(ideal.speed(1e9), 10.0);
}
