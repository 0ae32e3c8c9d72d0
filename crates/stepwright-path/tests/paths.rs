//! Lines and circles, judged only by their steps.

use std::f64::consts::TAU;

use proptest::prelude::*;
use stepwright::Rate;
use stepwright_cycle as cycle;
use stepwright_path::{Arc, Line, Pace, Steps, Unplannable};

const LEAD: u32 = 10_000;

/// The time of each step in s after the lead, and the position after it.
fn played(steps: Steps, rate: Rate) -> Vec<(f64, i64)> {
    let (mut ticks, mut at) = (0u64, 0i64);
    let mut all = Vec::new();
    for pace in steps {
        let (cycle::Pace::Step { ticks: more, .. } | cycle::Pace::Wait { ticks: more }) = pace;
        ticks += u64::from(more);
        if let cycle::Pace::Step { forward, .. } = pace {
            at += if forward { 1 } else { -1 };
            all.push(((ticks as f64 - f64::from(LEAD)) / f64::from(rate.hz()), at));
        }
    }
    all
}

fn rate(hz: u32) -> Rate {
    Rate::from_hz(hz).unwrap()
}

/// The time and the distance from rest to `v`, or back, within the jerk, by the cases of a textbook.
fn ramp(v: f64, a: f64, j: f64) -> (f64, f64) {
    let time = if v * j >= a * a { v / a + a / j } else { 2.0 * (v / j).sqrt() };
    (time, v * time / 2.0)
}

/// The distance from rest at the time `t` of the ramp up to `v`.
fn risen(v: f64, a: f64, j: f64, t: f64) -> f64 {
    let (whole, way) = ramp(v, a, j);
    let bend = if v * j >= a * a { a / j } else { whole / 2.0 };
    let most = j * bend;
    if j.is_infinite() {
        a * t * t / 2.0
    } else if t <= bend {
        j * t.powi(3) / 6.0
    } else if t <= whole - bend {
        let u = t - bend;
        j * bend.powi(3) / 6.0 + most * bend / 2.0 * u + most * u * u / 2.0
    } else {
        // From the end of the ramp: the speed there, less the gain until then.
        let u = whole - t;
        way - v * u + j * u.powi(3) / 6.0
    }
}

/// The place at a time from rest to rest. The highest speed is searched for, and both ramps are computed from
/// their slow ends. This is independent of the library.
fn place(length: f64, pace: Pace) -> impl Fn(f64) -> f64 {
    let Pace { speed, accel, decel, jerk } = pace;
    let ramps = |v: f64| (ramp(v, accel, jerk), ramp(v, decel, jerk));
    let long = |v: f64| ramps(v).0.1 + ramps(v).1.1 > length;
    let (mut low, mut high) = (0.0, speed);
    for _ in 0..200 {
        let middle = (low + high) / 2.0;
        if long(middle) { high = middle } else { low = middle }
    }
    let peak = if long(speed) { low } else { speed };
    let ((up, rise), (down, fall)) = ramps(peak);
    let level = ((length - rise - fall) / peak).max(0.0);
    let end = up + level + down;
    move |t| {
        if t < up {
            risen(peak, accel, jerk, t)
        } else if t < up + level {
            rise + peak * (t - up)
        } else {
            length - risen(peak, decel, jerk, (end - t).max(0.0))
        }
    }
}

/// `None` for a trapezoid, or the time in s in which the acceleration is reached.
fn bend() -> impl Strategy<Value = Option<f64>> {
    prop::option::of(0.002f64..0.5)
}

fn bent(pace: Pace, bend: Option<f64>) -> Pace {
    bend.map_or(pace, |bend| pace.with_jerk(pace.accel.max(pace.decel) / bend))
}

proptest! {
    /// All axes begin from rest and end together, and the steps of each are evenly spaced along the path. Its
    /// first interval, from the beginning of the path, is that of its own ramp.
    #[test]
    fn lines_are_straight_and_even(
        steps in prop::array::uniform3(-3_000i32..3_000),
        step in prop::array::uniform3(0.5f64..3.0),
        speed in 50.0f64..5_000.0,
        accel in 100.0f64..50_000.0,
        decel in 100.0f64..50_000.0,
        bend in bend(),
        hz in 1_000_000u32..100_000_000,
    ) {
        prop_assume!(steps.iter().any(|n| *n != 0));
        let line = Line { steps, step };
        let pace = bent(Pace::new(speed, accel).with_decel(decel), bend);
        let all = Steps::line(&line, pace, rate(hz), LEAD).unwrap();
        let tick = 1.0 / f64::from(hz);
        let place = place(line.length(), pace);
        let all = all.map(|steps| played(steps, rate(hz)));
        let last = all.iter().filter_map(|axis| axis.last()).map(|s| s.0).fold(0.0, f64::max);
        for (axis, wanted) in all.iter().zip(steps) {
            prop_assert_eq!(axis.len() as u32, wanted.unsigned_abs());
            let Some(&(_, at)) = axis.last() else { continue };
            prop_assert_eq!(at, i64::from(wanted));
            prop_assert!((axis[axis.len() - 1].0 - last).abs() <= tick);
            for (n, (t, _)) in axis.iter().enumerate() {
                let part = (n as f64 + 1.0) / axis.len() as f64;
                let off = place(*t) - part * line.length();
                // The distance of half a tick, and rounding near rest.
                prop_assert!(off.abs() <= speed * tick + 1e-6 * line.length(), "{n}: {off}");
            }
        }
    }

    /// A circle stays within a step of the true circle. Its speed along the path, by the steps, is within 1 %
    /// over 32 steps.
    #[test]
    fn circles_are_round_and_even(
        radius in 100.0f64..3_000.0,
        begin in 0.0f64..TAU,
        turns in prop_oneof![Just(1.0f64), Just(-1.0), -2.5f64..-0.2, 0.2f64..2.5],
        step in prop::array::uniform2(0.5f64..1.0),
        speed in 200.0f64..4_000.0,
        bend in bend(),
    ) {
        let centre = [-radius * begin.cos(), -radius * begin.sin()];
        let arc = Arc { centre, sweep: turns * TAU, step };
        let pace = bent(Pace::new(speed, 20_000.0), bend);
        let hz = rate(16_000_000);
        let [x, y] = Steps::arc(&arc, pace, hz, LEAD).unwrap();
        let axes = [played(x, hz), played(y, hz)];
        // The place of the path at the end of the steps.
        let end = begin + arc.sweep;
        let wanted = [radius * end.cos() + centre[0], radius * end.sin() + centre[1]];
        for (axis, (wanted, step)) in axes.iter().zip(wanted.into_iter().zip(step)) {
            let at = axis.last().map_or(0, |s| s.1) as f64;
            prop_assert!((at - wanted / step).abs() <= 0.76, "{at} {}", wanted / step);
        }
        let mut events: Vec<(f64, usize, i64)> = Vec::new();
        for (n, axis) in axes.iter().enumerate() {
            events.extend(axis.iter().map(|&(t, at)| (t, n, at)));
        }
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut at = [0i64; 2];
        for &(t, n, to) in &events {
            at[n] = to;
            let p = [at[0] as f64 * step[0] - centre[0], at[1] as f64 * step[1] - centre[1]];
            let off = (p[0].hypot(p[1]) - radius).abs();
            prop_assert!(off <= step[0].max(step[1]), "{off} from the circle at {t}");
        }
        // Where an axis steps, it is in the middle between two positions. Together with the direction, that
        // gives the place on the circle.
        for (n, axis) in axes.iter().enumerate() {
            let places: Vec<(f64, f64)> = angles(axis, n, centre, radius, step[n], begin, turns);
            let (ramp, _) = ramp(speed, pace.accel, pace.jerk);
            let last = places.last().map_or(0.0, |p| p.0);
            let cruise: Vec<_> = places
                .iter()
                .filter(|p| p.0 > ramp + 1e-3 && p.0 < last - ramp - 2.0 * radius / speed * 0.2)
                .collect();
            for pair in cruise.windows(33) {
                let way = (pair[32].1 - pair[0].1).abs() * radius;
                let v = way / (pair[32].0 - pair[0].0);
                prop_assert!((v / speed - 1.0).abs() <= 0.01, "{v}, not {speed}");
            }
        }
    }
}

/// The time and the continuous angle of each step of one axis.
fn angles(
    axis: &[(f64, i64)],
    n: usize,
    centre: [f64; 2],
    radius: f64,
    step: f64,
    begin: f64,
    turns: f64,
) -> Vec<(f64, f64)> {
    let mut at = 0i64;
    let mut places = Vec::new();
    let mut last = begin;
    for &(t, to) in axis {
        let forward = to > at;
        let middle = (at + to) as f64 / 2.0 * step - centre[n];
        at = to;
        let part = (middle / radius).clamp(-1.0, 1.0).acos();
        let base = if n == 0 { 0.0 } else { TAU / 4.0 };
        // Of the two angles with this cosine, take the one with this direction; of all its turns, the next one.
        let next = [part, -part]
            .into_iter()
            .filter(|angle| (-angle.sin() * turns > 0.0) == forward)
            .map(|angle| {
                let way = (angle + base - last) * turns.signum();
                last + (way + 1e-9).rem_euclid(TAU) * turns.signum()
            })
            .min_by(|a, b| (a - last).abs().total_cmp(&(b - last).abs()))
            .unwrap();
        last = next;
        places.push((t, next));
    }
    places
}

/// A hold on the way: the path brakes and continues along the line, without losing a step.
#[test]
fn a_hold_loses_no_step() {
    let line = Line { steps: [2_000, -700], step: [1.0, 1.0] };
    let pace = Pace::new(1_000.0, 4_000.0);
    let free = Steps::line(&line, pace, Rate::MHZ, LEAD).unwrap();
    let held = Steps::line(&line, pace, Rate::MHZ, LEAD).unwrap();
    held[0].law().pause(1.0);
    held[0].law().resume(3.0);
    let (free, held) = (free.map(|s| played(s, Rate::MHZ)), held.map(|s| played(s, Rate::MHZ)));
    for (free, held) in free.iter().zip(&held) {
        assert_eq!(free.len(), held.len());
        for (a, b) in free.iter().zip(held) {
            assert_eq!(a.1, b.1);
            // The same until the hold; at rest between; later after it.
            assert!(a.0 > 1.0 || (a.0 - b.0).abs() < 2e-6);
            assert!(!(1.26..3.0).contains(&b.0));
        }
    }
    assert!((held[0].last().unwrap().0 - held[1].last().unwrap().0).abs() < 2e-6);
    // After a finish, the remaining steps are not made.
    let [x, _] = Steps::line(&line, pace, Rate::MHZ, LEAD).unwrap();
    x.law().finish(1.0);
    let x = played(x, Rate::MHZ);
    assert!(x.len() < 1_200 && x.last().unwrap().0 < 1.26);
}

/// The time from the start to the first step, or to the end without one, in s.
fn first(steps: Steps, rate: Rate) -> f64 {
    let mut ticks = 0u64;
    for pace in steps {
        let (cycle::Pace::Step { ticks: more, .. } | cycle::Pace::Wait { ticks: more }) = pace;
        ticks += u64::from(more);
        if matches!(pace, cycle::Pace::Step { .. }) {
            break;
        }
    }
    ticks as f64 / f64::from(rate.hz())
}

/// However soon a path begins after another one, the motors stand, and the first step comes no sooner than from
/// rest. 10,000 steps/s²: √(2/10,000) s.
#[test]
fn a_path_begins_with_the_first_interval_of_its_ramp() {
    let pace = Pace::new(2_000.0, 10_000.0);
    let rest = |way: f64| (2.0 * way / 10_000.0).sqrt() - 1e-6;
    let line = Line { steps: [400, -3], step: [1.0; 2] };
    let [x, y] = Steps::line(&line, pace, Rate::MHZ, 0).unwrap();
    assert!(first(x, Rate::MHZ) >= rest(1.0));
    // Y has its share of the motion: its first step is at a third of the path.
    assert!(first(y, Rate::MHZ) >= 0.1);
    for centre in [[0.0, 90.0], [90.0, 0.0], [60.0, -60.0], [-0.7, 0.8]] {
        for sweep in [TAU, -1.0] {
            let arc = Arc { centre, sweep, step: [1.0, 0.5] };
            let axes = Steps::arc(&arc, pace, Rate::MHZ, 0).unwrap();
            for (steps, step) in axes.into_iter().zip(arc.step) {
                let (first, least) = (first(steps, Rate::MHZ), rest(step));
                assert!(first >= least, "{centre:?} {sweep}: {first}, not {least}");
            }
        }
    }
}

/// Checks a path that is refused for its speed, and the same path at the highest speed allowed, which is
/// returned.
fn refused<const N: usize>(
    steps: impl Fn(f64) -> [Steps; N],
    fastest: [f64; N],
    slowest: usize,
) -> f64 {
    let most = match steps(1e5)[0].law().within(&fastest) {
        Err(Unplannable::TooFast { axis, most }) if axis == slowest => most,
        other => panic!("{other:?}"),
    };
    assert!(steps(most * 1.001)[0].law().within(&fastest).is_err());
    let axes = steps(most);
    let path = axes[0].law();
    assert_eq!(path.within(&fastest), Ok(()));
    // An override does not make it faster.
    path.scale(0.3, 2.0).unwrap();
    assert!((path.now().peak() - most).abs() <= most * 1e-9);
    for (steps, fastest) in axes.into_iter().zip(fastest) {
        let times: Vec<f64> = played(steps, Rate::MHZ).iter().map(|step| step.0).collect();
        let closest = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        // No interval is too short, not even by the rounding of a tick.
        assert!(closest * 1e6 >= (1e6 / fastest).floor() - 1e-3, "{closest} of {fastest}");
    }
    most
}

/// The slowest axis decides, not the fastest.
#[test]
fn a_path_is_as_fast_as_its_slowest_axis() {
    // X has 0.6 of the speed along the line, Y 0.8. Z does not move, so its low limit does not count.
    let line = Line { steps: [3_000, 4_000, 0], step: [1.0; 3] };
    let steps = |speed| Steps::line(&line, Pace::new(speed, 1e4), Rate::MHZ, 1_000).unwrap();
    for (fastest, slowest, most) in
        [([625.0, 4_000.0, 1.0], 0, 625.0 / 0.6), ([8_000.0, 800.0, 1.0], 1, 1_000.0)]
    {
        let found = refused(steps, fastest, slowest);
        assert!((found - most).abs() <= 1e-6, "{found}, not {most}");
    }
    // A line too short for its ordered speed is not refused for that speed.
    let short = Line { steps: [3, 4, 0], step: [1.0; 3] };
    let [x, ..] = Steps::line(&short, Pace::new(1e6, 1e4), Rate::MHZ, 1_000).unwrap();
    assert_eq!(x.law().within(&[625.0; 3]), Ok(()));

    // Over a quarter of a circle or more, each axis has all of the speed for a moment. On 30° from the X axis
    // on, X has half of it.
    let round = |sweep: f64| {
        let arc = Arc { centre: [-500.0, 0.0], sweep, step: [1.0, 0.5] };
        move |speed| Steps::arc(&arc, Pace::new(speed, 1e4), Rate::MHZ, 1_000).unwrap()
    };
    let sixth = TAU / 12.0;
    for (sweep, fastest, slowest, most) in [
        (TAU, [800.0, 8_000.0], 0, 800.0),
        (-TAU, [8_000.0, 800.0], 1, 400.0),
        (sixth, [800.0, 8_000.0], 0, 1_600.0),
        (sixth, [8_000.0, 800.0], 1, 400.0),
    ] {
        let found = refused(round(sweep), fastest, slowest);
        assert!((found - most).abs() <= 1e-6 * most, "{sweep}: {found}, not {most}");
    }
}

/// At the highest speed that an axis can follow, no interval is a tick too short, wherever the times are
/// between ticks.
#[test]
fn rounding_makes_no_step_too_soon() {
    for n in 0..200 {
        // At constant speed step k comes k·400 + v/2a µs after the beginning: at half a tick.
        let accel = 2_500.0 / 2.0 / ((10_000.5 + f64::from(n)) / 1e6);
        let line = Line { steps: [700], step: [1.0] };
        let [x] = Steps::line(&line, Pace::new(2_500.0, accel), Rate::MHZ, 1_000).unwrap();
        x.law().within(&[2_500.0]).unwrap();
        let times: Vec<_> = played(x, Rate::MHZ).iter().map(|s| (s.0 * 1e6).round()).collect();
        let early = times.windows(2).find(|pair| pair[1] - pair[0] < 400.0);
        assert_eq!(early, None, "{accel}");
    }
}

/// A new end in another direction has its own slowest axis.
#[test]
fn a_new_end_is_as_fast_as_its_slowest_axis() {
    let line = Line { steps: [4_000, 0], step: [1.0; 2] };
    let [x, y] = Steps::line(&line, Pace::new(1_000.0, 1e4), Rate::MHZ, 1_000).unwrap();
    let path = x.law();
    path.within(&[1_000.0, 250.0]).unwrap();
    let at = path.retarget(1.0, &[3_000, 1_000]).unwrap();
    drop((x, y));
    // 950 steps by then, and 50 of braking. From there the direction is (2, 1), of which Y has 1/√5.
    let most = 250.0 * 5f64.sqrt();
    let speed = path.now().speed(at + 1.0);
    assert!((speed - most).abs() <= 1e-6, "{speed}, not {most}");
}
