//! Changes on the S-curve, in random sequences, against a simulation in `f64` that goes from event
//! to event.
//!
//! At every event the simulation decides like a driver: more or less acceleration, or no change. It
//! keeps its own speed, acceleration and time from the first change to the last and uses nothing of
//! the core. The test asserts that its curve obeys the limits; `rsruckig` confirms that it is
//! time-optimal.

use proptest::prelude::*;
use rsruckig::prelude::*;
use stepwright::profile::{Fit, SCurve, State, Tracer};
use stepwright::{Accel, Jerk, Rate, Speed};

/// In steps and seconds.
#[derive(Clone, Copy, Debug)]
struct Limits {
    top: f64,
    up: f64,
    down: f64,
    jerk: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Point {
    t: f64,
    s: f64,
    v: f64,
    a: f64,
}

impl Point {
    fn after(self, j: f64, t: f64) -> Point {
        Point {
            t: self.t + t,
            s: self.s + t * (self.v + t * (self.a / 2.0 + t * j / 6.0)),
            v: self.v + t * (self.a + t * j / 2.0),
            a: self.a + j * t,
        }
    }

    fn flipped(self, sign: f64) -> Point {
        Point { s: sign * self.s, v: sign * self.v, a: sign * self.a, ..self }
    }
}

/// Phases: where each begins, and its jerk; the last one is the end.
type Course = Vec<(Point, f64)>;

/// The aim of a part.
#[derive(Clone, Copy, PartialEq)]
enum Aim {
    Top,
    Rest,
}

impl Limits {
    /// The speed at which a stop may creep: a power of two that is the cube root of the jerk or up
    /// to four times that; and the speed that the accelerations reach in half a step.
    fn crawl(&self) -> f64 {
        let bits = (self.jerk.log2().floor() as i32 + 3).div_euclid(3);
        2f64.powi(bits).min(self.up.min(self.down).sqrt())
    }

    /// The speed when the acceleration has gone to 0.
    fn bound(&self, p: Point) -> f64 {
        p.v + p.a * p.a.abs() / (2.0 * self.jerk)
    }

    /// From `p` as fast as allowed, until the aim is reached or `until` has come.
    fn go(&self, mut p: Point, aim: Aim, until: f64, course: &mut Course) -> Point {
        let j = self.jerk;
        for _ in 0..40 {
            let bound = self.bound(p);
            // Backward on the way to the top speed: first to rest, with an acceleration that is
            // allowed on both sides of it.
            let back = aim == Aim::Top && (p.v < 0.0 || bound < -1e-12 * self.top);
            let gentle = self.up.min(self.down);
            let (to, up) = match aim {
                Aim::Rest => (0.0, self.down),
                Aim::Top if back => ((gentle * gentle / (2.0 * j)).min(self.top), self.down),
                Aim::Top => (self.top, self.up),
            };
            let gap = to - bound;
            let sign = if gap < 0.0 { -1.0 } else { 1.0 };
            let most = if gap < 0.0 { self.down } else { up };
            let (a, gap) = (p.a * sign, gap.abs());
            // The jerk, and its longest time.
            let (jerk, mut time) = if gap <= 1e-13 * self.top.max(p.v.abs()) {
                if p.a == 0.0 {
                    break;
                }
                (-p.a.signum() * j, p.a.abs() / j)
            } else if a > most * (1.0 + 1e-13) {
                (-sign * j, (a - most) / j)
            } else if a >= most * (1.0 - 1e-13) {
                (0.0, gap / most)
            } else if a < 0.0 {
                (sign * j, -a / j)
            } else {
                // Until half of the gap is gained, or the limit is reached: the bound rises by
                // a²/J.
                let peak = (a * a + gap * j).sqrt().min(most);
                (sign * j, (peak - a) / j)
            };
            let mut rest = false;
            if back {
                // Check whether rest comes in between.
                if let Some(at) = rise(p, jerk).filter(|&at| at < time) {
                    (time, rest) = (at, true);
                }
            }
            if p.t + time >= until {
                (time, rest) = (until - p.t, false);
                if time <= 0.0 {
                    return p;
                }
            }
            let mut next = p.after(jerk, time);
            if rest {
                next.v = 0.0;
            }
            if next.a.abs() <= 1e-13 * self.up.max(self.down).max(p.a.abs()) {
                next.a = 0.0;
            }
            if time > 0.0 {
                course.push((p, jerk));
            }
            p = next;
            if p.t >= until {
                return p;
            }
        }
        p.a = 0.0;
        p.v = if aim == Aim::Rest { 0.0 } else { self.top };
        p
    }

    /// To rest, `way` steps further.
    fn course(&self, from: Point, way: f64) -> Course {
        let stopping = self.go(from, Aim::Rest, f64::MAX, &mut Vec::new()).s;
        // If a stop leads there except for rounding, do not drive on.
        let exact = (stopping - way).abs() <= 1e-9;
        let sign = if stopping > way && !exact { -1.0 } else { 1.0 };
        let (from, way) = (from.flipped(sign), way * sign);
        let stop = |p| self.go(p, Aim::Rest, f64::MAX, &mut Vec::new());
        let mut course = Vec::new();
        let top = self.go(from, Aim::Top, f64::MAX, &mut course);
        let left = way - stop(top).s;
        let at = if exact {
            course.clear();
            from
        } else if left >= 0.0 {
            course.push((top, 0.0));
            let time = left / self.top;
            Point { t: top.t + time, s: top.s + left, ..top }
        } else {
            let (mut low, mut high) = (0.0, top.t);
            for _ in 0..200 {
                let x = (low + high) / 2.0;
                if x <= low || x >= high {
                    break;
                }
                let there = self.go(from, Aim::Top, x, &mut Vec::new());
                *(if stop(there).s < way { &mut low } else { &mut high }) = x;
            }
            course.clear();
            if high > 0.0 { self.go(from, Aim::Top, high, &mut course) } else { from }
        };
        let end = self.go(at, Aim::Rest, f64::MAX, &mut course);
        course.push((end, 0.0));
        course.into_iter().map(|(p, j)| (p.flipped(sign), j * sign)).collect()
    }

    /// No limit is exceeded, except by values that were beyond it and come back.
    fn check(&self, course: &Course) -> Result<(), TestCaseError> {
        for (&(p, j), &(q, _)) in course.iter().zip(&course[1..]) {
            for x in [0.001, 0.25, 0.5, 0.75, 0.999] {
                let p = p.after(j, x * (q.t - p.t));
                let slows = p.a * p.v < 0.0;
                let most = if slows { self.down } else { self.up };
                // A time in f64 can't represent a bend that is shorter than its last place.
                let place = 2.0 * f64::EPSILON * q.t.abs();
                if p.a.abs() > most * (1.0 + 1e-6) + self.jerk * place {
                    prop_assert!(j * p.a < 0.0, "{p:?} {j} {self:?}");
                }
                if p.v.abs() > self.top * (1.0 + 1e-6) {
                    // Slowing, or about to.
                    prop_assert!(slows || j * p.v < 0.0, "{p:?} {j} {self:?}");
                }
                prop_assert!(j == 0.0 || (j.abs() / self.jerk - 1.0).abs() < 1e-9);
            }
        }
        Ok(())
    }
}

/// The time at which the speed rises through 0, if it does so while the jerk is `j`.
fn rise(p: Point, j: f64) -> Option<f64> {
    if p.v == 0.0 && p.a > 0.0 {
        return None;
    }
    if j == 0.0 {
        return (p.v < 0.0 && p.a > 0.0).then(|| -p.v / p.a);
    }
    let root = p.a * p.a - 2.0 * j * p.v;
    if root < 0.0 {
        return None;
    }
    // a = +√: there the speed rises.
    let t = if p.a > 0.0 { -2.0 * p.v / (p.a + root.sqrt()) } else { (root.sqrt() - p.a) / j };
    (t > 0.0).then_some(t)
}

fn at(course: &Course, t: f64) -> Point {
    let n = course.partition_point(|(p, _)| p.t <= t).max(1) - 1;
    let (p, j) = course[n];
    p.after(j, t - p.t)
}

/// An order in the core's representation.
#[derive(Clone, Copy, Debug)]
struct Order {
    top: u32,
    accel: u64,
    decel: u64,
    jerk: u64,
}

impl Order {
    fn law(&self, rate: Rate) -> SCurve {
        SCurve::new(
            rate,
            Speed::ZERO,
            Speed::from_millisteps(self.top).unwrap(),
            Accel::from_millisteps(self.accel).unwrap(),
            Jerk::from_millisteps(self.jerk).unwrap(),
        )
        .with_decel(Accel::from_millisteps(self.decel).unwrap())
    }

    fn limits(&self) -> Limits {
        let [up, down, jerk] = [self.accel, self.decel, self.jerk].map(|x| x as f64 / 1e3);
        Limits { top: f64::from(self.top) / 1e3, up, down, jerk }
    }
}

/// The next change.
#[derive(Clone, Copy, Debug)]
enum Wish {
    /// This far from here.
    Go(i32),
    /// To where the motion first stood.
    Home,
    Stop,
}

#[derive(Clone, Copy, Debug)]
struct Change {
    /// Other limits, if they change.
    order: Option<Order>,
    wish: Wish,
    /// How far the motion gets, as a part of the rest.
    after: f64,
}

fn spread(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn order() -> impl Strategy<Value = Order> {
    let accel = spread(100.0, 1e6);
    (
        spread(5.0, 50_000.0),
        accel,
        prop_oneof![1 => Just(1.0), 2 => spread(0.1, 10.0)],
        spread(1e3, 1e8),
    )
        .prop_map(|(top, accel, ratio, jerk)| Order {
            top: (top * 1e3) as u32,
            accel: (accel * 1e3) as u64,
            decel: (accel * ratio * 1e3) as u64,
            jerk: (jerk * 1e3) as u64,
        })
}

fn change() -> impl Strategy<Value = Change> {
    let far = (spread(0.6, 30_000.0), any::<bool>())
        .prop_map(|(d, back)| Wish::Go((if back { -d } else { d }).round() as i32));
    let wish = prop_oneof![8 => far, 1 => Just(Wish::Home), 1 => Just(Wish::Stop)];
    (prop::option::of(order()), wish, prop_oneof![4 => 0.0..1.0, 1 => Just(1.0)])
        .prop_map(|(order, wish, after)| Change { order, wish, after })
}

/// The number of changes in a sequence.
const CHANGES: usize = 25;

/// Walks a sequence; every pulse is compared with the simulation, from the first on.
fn walk(hz: u32, first: Order, changes: &[Change]) -> Result<(), TestCaseError> {
    let rate = Rate::from_hz(hz).unwrap();
    let tick = 1.0 / f64::from(hz);
    let mut order = first;
    let (mut state, mut home) = (State::REST, 0i64);
    let mut tracer: Option<Tracer> = None;
    // Speed and acceleration of the simulation, and its time at the last change.
    let (mut ours, mut base) = (Point::default(), 0.0);
    // The time played, in ticks and 2⁻¹⁶ ticks.
    let mut played = 0u64;
    for change in changes {
        order = change.order.unwrap_or(order);
        let (law, mut limits) = (order.law(rate), order.limits());
        let from = Point { v: ours.v, a: ours.a, ..Point::default() };
        let stopping = limits.go(from, Aim::Rest, f64::MAX, &mut Vec::new()).s;
        let way = match change.wish {
            Wish::Go(way) => way,
            Wish::Home => i32::try_from(home).unwrap_or(1000),
            Wish::Stop => 0,
        };
        let curve = match change.wish {
            Wish::Stop => law.stop(state),
            _ => law.from_state(state, way),
        };
        let Ok(curve) = curve else { continue };
        let end = curve.place_of(curve.pulses());
        if let Wish::Stop = change.wish {
            let off = (end as f64 - stopping).abs();
            prop_assert!(off <= 1.0 + 1e-6, "a stop led to {end}, not {stopping}");
            limits.top = limits.bound(from).abs().max(limits.crawl());
        } else {
            prop_assert_eq!(end, i64::from(way));
        }
        let course = limits.course(from, end as f64);
        limits.check(&course)?;

        // No target is passed if the motion can stop at it.
        let sign = if end < 0 { -1.0 } else { 1.0 };
        let ahead = limits.bound(from) * sign >= 0.0 && from.v * sign >= 0.0;
        let reachable = ahead && stopping * sign <= end as f64 * sign - 1e-6;
        if reachable {
            prop_assert_eq!(curve.pulses() as u64, end.unsigned_abs() + 1);
        }

        // A part of it, or all.
        let most = if change.after == 1.0 { 3_000 } else { 400 };
        let goal = (change.after * f64::from((curve.pulses() - 1).min(most))).round() as u32;
        let mut walker = match tracer.take() {
            Some(mut tracer) => {
                tracer.change(curve);
                tracer
            }
            None => Tracer::new(curve, Fit::EXACT),
        };
        let (mut place, mut met, mut sure) = (0, from, true);
        while walker.pulse() < goal || walker.state().is_none() || !sure {
            let n = walker.pulse();
            let Some(run) = walker.next() else { break };
            let mut interval = run.interval();
            if run.turns().is_some() {
                played += interval;
            }
            for k in 1..=u32::from(run.count()) {
                played += interval;
                interval = interval.wrapping_add_signed(run.add().into());
                place = curve.place_of(n + k);
                let t = (played >> 16) as f64 * tick - base;
                let passed = meets(&course, place as f64, t, tick).map_err(|error| {
                    let what =
                        format!("{error}, {change:?} from {from:?} of {limits:?}: {course:?}");
                    TestCaseError::fail(what)
                })?;
                if n + k == walker.pulse() && n + k >= goal {
                    met = moment(&course, place as f64, t, passed);
                    // At the very point where the curve turns, a rounding in the last place makes a
                    // different time: the next pulse is a better one for a change.
                    sure = passed.is_some() && met.v.abs() > 1e-3;
                }
            }
        }
        if walker.pulse() + 1 == curve.pulses() {
            prop_assert_eq!((place, curve.place_of(u32::MAX)), (end, end));
            let total = course[course.len() - 1].0.t;
            let off = (played >> 16) as f64 * tick - base - total;
            if off.abs() <= tick * (1.0 + 1e-3) + 1e-9 {
                // At rest, on the target.
                met = Point { t: total, s: end as f64, v: 0.0, a: 0.0 };
            } else if !sure {
                return Ok(());
            } else {
                // It turns back to the target within a step of it: no further pulse.
                for x in 0..100 {
                    let t = met.t + (total - met.t) * f64::from(x) / 100.0;
                    let far = (at(&course, t).s - place as f64).abs();
                    prop_assert!(
                        off < 0.0 && far < 1.0,
                        "ends {off} s late, {far} off: {change:?} {order:?} from {from:?} met {met:?} {course:?}"
                    );
                }
            }
        }
        home -= place;
        state = walker.state().unwrap();
        let near = |got: i64, want: f64, scale: f64| (got as f64 / 1e3 - want).abs() <= scale;
        prop_assert!(near(state.speed(), met.v, 0.002 + 1e-6 * limits.top));
        base += met.t;
        ours = met;
        tracer = Some(walker);
    }
    Ok(())
}

/// Checks that the curve is at `place` within a tick of `t`. Returns the times before and after, if
/// it passes there.
fn meets(
    course: &Course,
    place: f64,
    t: f64,
    tick: f64,
) -> Result<Option<(f64, f64)>, TestCaseError> {
    let width = tick * (1.0 + 1e-3) + 1e-9;
    let off = |t: f64| at(course, t).s - place;
    let (before, after) = (off(t - width), off(t + width));
    if before * after <= 0.0 {
        let (low, high) = (t - width, t + width);
        return Ok(Some(if after > before { (low, high) } else { (high, low) }));
    }
    // Where the curve turns or comes to rest, it may reach a place without passing it.
    let slack = 1e-9 * (1.0 + place.abs() * 1e-3);
    let least = before.abs().min(after.abs()).min(off(t).abs());
    prop_assert!(least <= slack, "{place} at {t}: {before} {} {after}", off(t));
    Ok(None)
}

/// The moment at which the curve is at `place`.
fn moment(course: &Course, place: f64, t: f64, passed: Option<(f64, f64)>) -> Point {
    let Some((mut low, mut high)) = passed else { return at(course, t) };
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        *(if at(course, middle).s >= place { &mut high } else { &mut low }) = middle;
    }
    at(course, high)
}

/// A soft stop that ended on a step except for 10⁻¹⁵ of it once drove for that distance: the
/// remaining acceleration was negligible under its own jerk, and four ticks under a jerk 3,000
/// times as gentle.
#[test]
fn a_gentle_motion_after_a_stop() {
    let first = Order { top: 3_230_405, accel: 1_305_406, decel: 1_305_406, jerk: 2_779_057_444 };
    let gentle = Order { top: 4_999, accel: 100_000, decel: 100_000, jerk: 999_999 };
    let change = |order, wish, after| Change { order, wish, after };
    let story = [
        change(None, Wish::Go(-164), 0.5655806443554819),
        change(None, Wish::Stop, 1.0),
        change(None, Wish::Go(1), 0.0),
        change(Some(gentle), Wish::Go(71), 0.8037453658205556),
        change(None, Wish::Go(1), 0.0),
    ];
    walk(16_000_000, first, &story).unwrap();
}

/// A braking that came to rest on a step except for rounding: the speed left there was forward, the
/// motion backward. The next change began at rest, not at 119 steps/s.
#[test]
fn a_rest_on_a_step_that_is_driven_through() {
    let first = Order { top: 4999, accel: 100_000, decel: 100_000, jerk: 999_999 };
    let quick = Order { top: 981_862, accel: 78_826_742, decel: 78_826_742, jerk: 375_886_248 };
    let change = |order, wish, after| Change { order, wish, after };
    let story = [
        change(None, Wish::Go(1), 0.0),
        change(Some(quick), Wish::Home, 0.0),
        change(None, Wish::Go(13), 0.14880902225021583),
        change(None, Wish::Go(7), 0.7816716434667343),
        change(None, Wish::Go(2), 0.4035772611801931),
        change(None, Wish::Home, 0.689846905657301),
        change(None, Wish::Home, 0.7124257050432806),
        change(None, Wish::Home, 0.0),
        change(None, Wish::Go(-3), 0.0),
    ];
    walk(16_000_000, first, &story).unwrap();
}

fn config() -> ProptestConfig {
    let cases = std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok());
    ProptestConfig::with_cases(cases.unwrap_or(4_000))
}

proptest! {
    #![proptest_config(config())]

    /// 100,000 changes in CI.
    #[test]
    fn every_pulse_after_every_change(
        hz in prop_oneof![Just(1_000_000u32), Just(16_000_000)],
        first in order(),
        changes in prop::collection::vec(change(), CHANGES),
    ) {
        walk(hz, first, &changes)?;
    }

    /// With the same acceleration in both directions: as fast as the time-optimal motion from the
    /// same state.
    #[test]
    fn no_time_is_lost_by_a_change(
        top in spread(100.0, 20_000.0),
        rise in 0.05f64..2.0,
        bend in 0.02f64..1.0,
        there in 100i32..20_000,
        part in 0.0f64..1.0,
        faster in prop_oneof![Just(1.0), 0.3f64..3.0],
        way in 100i32..20_000,
        back: bool,
    ) {
        let milli = |x: f64| (x * 1e3).round();
        let order = |top: f64| Order {
            top: milli(top) as u32,
            accel: milli(top / rise) as u64,
            decel: milli(top / rise) as u64,
            jerk: milli(top / rise / bend) as u64,
        };
        let curve = order(top).law(Rate::MHZ).from_state(State::REST, there).unwrap();
        let state = curve.state_at((part * f64::from(there)) as u32);
        let order = order(top * faster);
        let limits = order.limits();
        let way = if back { -way } else { way };
        let Ok(curve) = order.law(Rate::MHZ).from_state(state, way) else { return Ok(()) };

        let mut otg = Ruckig::<1, ThrowErrorHandler>::new(None, 0.01);
        let mut input = InputParameter::<1>::new(None);
        // Its tolerances are absolute: use a unit of length in which the speed is 1.
        let unit = limits.top;
        input.max_velocity[0] = 1.0;
        input.max_acceleration[0] = limits.up / unit;
        input.max_jerk[0] = limits.jerk / unit;
        input.current_velocity[0] = state.speed() as f64 / 1e3 / unit;
        input.current_acceleration[0] = state.accel() as f64 / 1e3 / unit;
        input.target_position[0] = f64::from(way) / unit;
        let mut trajectory = Trajectory::<1>::new(None);
        prop_assert!(otg.calculate(&input, &mut trajectory).is_ok());
        let best = trajectory.get_duration();
        let last = curve.pulses();
        if curve.state_at(last).speed() != 0 {
            return Ok(()); // it comes back to its last step, without a pulse
        }
        let got = curve.time_of(last) as f64 / 1e6;
        // From beyond a limit the core first comes back under it, even where another way is
        // shorter: then it may be the slower of the two.
        let slower = got - best;
        let off = if faster < 1.0 { slower } else { slower.abs() };
        prop_assert!(
            off <= best * 0.005 + 1e-3,
            "{got} s, optimum {best} s, from {} {}",
            state.speed(),
            state.accel()
        );
    }
}
