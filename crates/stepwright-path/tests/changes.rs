//! Overrides, pauses and new ends at random times, judged only by the steps.

use std::f64::consts::TAU;

use proptest::prelude::*;
use stepwright::Rate;
use stepwright_cycle as cycle;
use stepwright_path::{Arc, Line, LivePath, Pace, Steps, Unplannable};

const LEAD: u32 = 10_000;
const HZ: f64 = 1e8;
const TICK: f64 = 1.0 / HZ;

/// A change that is ordered while the axes move.
#[derive(Clone, Copy, Debug)]
enum Act {
    Scale(f64),
    Pause,
    Resume,
    /// A new end: this multiple of the line's direction.
    On(i32),
    /// A new end anywhere, in steps from the beginning.
    Elsewhere([i32; 3]),
    Finish,
}

/// An act, the answer to it, which is the time at which it takes effect, and the time at which the path rests
/// after it or at its end.
type Taken = (Act, Result<f64, Unplannable>, f64);

fn ask<const N: usize>(path: &LivePath, act: Act, at: f64, unit: [i32; N]) -> Taken {
    let held = match act {
        Act::Scale(part) => path.scale(at, part),
        Act::Pause => Ok(path.pause(at)),
        Act::Resume => Ok(path.resume(at)),
        Act::On(times) => path.retarget(at, &unit.map(|n| n * times)),
        Act::Elsewhere(to) => path.retarget(at, &to[..N]),
        Act::Finish => match path.end() {
            Some(end) if end <= at => Err(Unplannable::Over),
            _ => Ok(path.finish(at)),
        },
    };
    let law = path.now();
    let mut rest = held.unwrap_or(at);
    while law.speed(rest) > 1.0 || law.speed(rest + 1e-4) < law.speed(rest) {
        rest += 1e-4;
    }
    (act, held, rest)
}

/// A step: the time in s after the lead, the axis, and its position then.
type Event = (f64, usize, i64);

/// Asks the axes as a cycle does: each when its last step or wait is over. Acts are made in between, each this
/// many s after the one before, to take effect at once. Returns the steps in the order of their times.
fn play<const N: usize>(
    steps: [Steps; N],
    acts: &[(f64, Act)],
    unit: [i32; N],
) -> (Vec<Event>, Vec<Taken>) {
    let path = steps[0].law();
    let mut axes = steps.map(|steps| (steps, 0u64, None::<bool>, 0i64));
    let (mut events, mut taken) = (Vec::new(), Vec::new());
    let mut acts = acts.iter().scan(0.0, |at, (later, act)| {
        *at += later;
        Some((*at, *act))
    });
    let mut next = acts.next();
    let mut live = [true; N];
    while let Some(axis) = (0..N).filter(|axis| live[*axis]).min_by_key(|axis| axes[*axis].1) {
        let now = axes[axis].1 as f64 * TICK;
        if let Some((at, act)) = next.filter(|(at, _)| *at <= now) {
            taken.push(ask(&path, act, (at - f64::from(LEAD) * TICK).max(0.0), unit));
            next = acts.next();
            continue;
        }
        let (steps, at, pending, position) = &mut axes[axis];
        if let Some(forward) = pending.take() {
            *position += if forward { 1 } else { -1 };
            events.push((*at as f64 * TICK - f64::from(LEAD) * TICK, axis, *position));
        }
        match steps.next() {
            None => live[axis] = false,
            Some(cycle::Pace::Step { ticks, forward }) => {
                *at += u64::from(ticks);
                *pending = Some(forward);
            }
            Some(cycle::Pace::Wait { ticks }) => {
                assert!(ticks > 0, "a wait of nothing");
                *at += u64::from(ticks);
            }
        }
    }
    (events, taken)
}

/// The highest speed allowed at each time: the scaled speed, or the rest of the earlier speed while it
/// decreases.
struct Envelope {
    pace: Pace,
    /// The time from which a part counts, its target speed, and the highest speed at that time.
    parts: Vec<(f64, f64, f64)>,
}

impl Envelope {
    fn new(pace: Pace, taken: &[Taken]) -> Envelope {
        let mut all = Envelope { pace, parts: vec![(f64::NEG_INFINITY, pace.speed, pace.speed)] };
        for (act, held, _) in taken {
            if let (Act::Scale(part), Ok(at)) = (act, held) {
                let was = all.at(*at);
                all.parts.push((*at, pace.speed * part.clamp(0.1, 2.0), was));
            }
        }
        all
    }

    fn at(&self, t: f64) -> f64 {
        let Pace { accel, decel, jerk, .. } = self.pace;
        let &(from, to, was) = self.parts.iter().rev().find(|part| part.0 <= t).unwrap();
        if was <= to {
            return to;
        }
        // The speed that it may still gain while it speeds up, and the time of the whole change.
        let gain = accel * accel / 2.0 / jerk;
        if jerk.is_infinite() {
            return to.max(was - decel * (t - from));
        }
        let time = accel / jerk + (was + gain - to) / decel + decel / jerk;
        if t < from + time { was } else { to }
    }

    /// The highest speed allowed between two times.
    fn within(&self, from: f64, to: f64) -> f64 {
        let inside = self.parts.iter().map(|part| part.0).filter(|t| from <= *t && *t <= to);
        let ends = [from, to].into_iter().chain(inside);
        ends.map(|t| self.at(t)).fold(0.0, f64::max)
    }
}

/// The divided difference of places over times, and its error by half a tick of each time at this speed.
fn difference(points: &[(f64, f64)], speed: f64) -> (f64, f64) {
    let mut sum = (0.0, 0.0);
    for (n, (t, s)) in points.iter().enumerate() {
        let others = points.iter().enumerate().filter(|(m, _)| *m != n);
        let product: f64 = others.map(|(_, (u, _))| t - u).product();
        sum.0 += s / product;
        sum.1 += (speed * TICK + 1e-9) / product.abs();
    }
    sum
}

/// Whether a position is within a step of the line from `begin` to `end`: a single point of the line is that
/// near on all axes.
fn on_line(at: [i64; 3], begin: [i64; 3], end: [i64; 3]) -> bool {
    let (mut low, mut high) = (0.0f64, 1.0f64);
    for axis in 0..3 {
        let (way, at) = ((end[axis] - begin[axis]) as f64, (at[axis] - begin[axis]) as f64);
        let near = 1.0 + 1e-6;
        if way == 0.0 {
            if at.abs() > near {
                return false;
            }
            continue;
        }
        let (a, b) = ((at - near) / way, (at + near) / way);
        low = low.max(a.min(b));
        high = high.min(a.max(b));
    }
    low <= high
}

/// Whether these positions lead along straight lines: the first from `begin` to the first end, each of the
/// others from the corner before it, or from the same beginning if it is on the same line. All positions before
/// `from` are checked already.
fn straight(
    positions: &[(f64, [i64; 3])],
    ends: &[([i64; 3], [f64; 2])],
    begin: usize,
    from: usize,
) -> bool {
    let [(end, _), rest @ ..] = ends else { return true };
    let on = |at: &[i64; 3]| on_line(*at, positions[begin].1, *end);
    let on = positions[from..].iter().take_while(|p| on(&p.1)).count();
    let Some((_, [held, stands])) = rest.first() else { return from + on == positions.len() };
    // Either the same line continues, or a corner follows: a step around the time at which the path rests.
    let near = |time: f64| positions.partition_point(|p| p.0 <= time).max(1) - 1;
    let along = near(*held).max(from);
    let corners = near(stands - 0.02).max(from)..(near(stands + 0.02) + 1).min(from + on);
    along < from + on && straight(positions, rest, begin, along)
        || corners.into_iter().rev().any(|corner| straight(positions, rest, corner, corner))
}

/// A line, as a direction and its multiple, so that new ends can be on it.
fn line() -> impl Strategy<Value = ([i32; 3], i32, [f64; 3])> {
    (prop::array::uniform3(-12i32..12), 10i32..150, prop::array::uniform3(0.5f64..2.0))
        .prop_filter("it leads somewhere", |(unit, ..)| unit.iter().any(|n| *n != 0))
}

fn pace() -> impl Strategy<Value = Pace> {
    let bend = prop::option::of(0.01f64..0.3);
    (200.0f64..3_000.0, 500.0f64..20_000.0, 500.0f64..20_000.0, bend).prop_map(
        |(speed, accel, decel, bend)| {
            let pace = Pace::new(speed, accel).with_decel(decel);
            bend.map_or(pace, |bend| pace.with_jerk(accel.max(decel) / bend))
        },
    )
}

fn feeds() -> impl Strategy<Value = Vec<(f64, Act)>> {
    let act = prop_oneof![
        3 => (0.05f64..2.5).prop_map(Act::Scale),
        1 => Just(Act::Pause),
        2 => Just(Act::Resume),
    ];
    prop::collection::vec((0.0f64..0.4, act), 0..8)
}

fn changes() -> impl Strategy<Value = Vec<(f64, Act)>> {
    let act = prop_oneof![
        2 => (0.05f64..2.5).prop_map(Act::Scale),
        1 => Just(Act::Pause),
        2 => Just(Act::Resume),
        3 => (1i32..200).prop_map(Act::On),
        3 => prop::array::uniform3(-800i32..800).prop_map(Act::Elsewhere),
        1 => Just(Act::Finish),
    ];
    prop::collection::vec((0.0f64..0.4, act), 0..8)
}

/// The steps of the axes of a line.
fn axes(line: &Line<3>, pace: Pace) -> [Steps; 3] {
    let rate = Rate::from_hz(HZ as u32).unwrap();
    Steps::line(line, pace, rate, LEAD).unwrap()
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(150)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    /// Whatever is ordered, at any time: the end is exact and reached by all axes together, the axes stay on
    /// the line, the speed stays below the scaled feed, and acceleration and jerk stay within their limits.
    #[test]
    fn feeds_and_pauses_keep_the_line_and_the_limits(
        (unit, times, step) in line(),
        pace in pace(),
        acts in feeds(),
    ) {
        let line = Line { steps: unit.map(|n| n * times), step };
        let mut acts = acts;
        acts.push((5.0, Act::Resume));
        let (events, taken) = play(axes(&line, pace), &acts, unit);
        let envelope = Envelope::new(pace, &taken);
        let end = line.steps.map(i64::from);
        let mut at = [0; 3];
        for &(t, axis, to) in &events {
            at[axis] = to;
            prop_assert!(on_line(at, [0; 3], end), "{at:?} at {t}");
        }
        prop_assert_eq!(at, end);
        let over = events.last().unwrap().0;
        for axis in 0..3 {
            let times: Vec<f64> = events.iter().filter(|e| e.1 == axis).map(|e| e.0).collect();
            if times.len() < 2 {
                continue;
            }
            prop_assert!((times[times.len() - 1] - over).abs() <= 2.0 * TICK);
            // The place of each step along the line.
            let part = line.length() / times.len() as f64;
            let places: Vec<_> = times.iter().zip(1..).map(|(t, n)| (*t, f64::from(n) * part)).collect();
            for pair in places.windows(2) {
                let most = envelope.within(pair[0].0, pair[1].0);
                let (v, slack) = difference(pair, most);
                prop_assert!(v <= most * (1.0 + 1e-9) + slack, "{v}, not {most}, at {}", pair[0].0);
            }
            let fastest = pace.speed * 2.0;
            let apart = |gap: f64| {
                let mut last = f64::NEG_INFINITY;
                let far = |point: &(f64, f64)| {
                    let far = point.0 - last >= gap;
                    if far { last = point.0 }
                    far
                };
                places.iter().copied().filter(far).collect::<Vec<_>>()
            };
            for three in apart(0.001).windows(3) {
                let (a, slack) = difference(three, fastest);
                let (a, slack) = (2.0 * a, 2.0 * slack + 1e-6 * pace.accel.max(pace.decel));
                prop_assert!(a <= pace.accel + slack, "{a} at {}", three[0].0);
                prop_assert!(a >= -pace.decel - slack, "{a} at {}", three[0].0);
            }
            if pace.jerk.is_finite() {
                for four in apart(0.004).windows(4) {
                    let (j, slack) = difference(four, fastest);
                    prop_assert!(6.0 * j.abs() <= pace.jerk * 1.000_001 + 6.0 * slack, "{j}");
                }
            }
        }
    }

    /// New ends on the line and elsewhere, and finishes: the path ends exactly at the last new end, on straight
    /// lines from corner to corner.
    #[test]
    fn new_ends_are_reached_along_straight_lines(
        (unit, times, step) in line(),
        pace in pace(),
        acts in changes(),
    ) {
        let line = Line { steps: unit.map(|n| n * times), step };
        let mut acts = acts;
        acts.push((5.0, Act::Resume));
        let (events, taken) = play(axes(&line, pace), &acts, unit);
        let envelope = Envelope::new(pace, &taken);
        // The ends in their order, the times around which each may make a corner, and whether the path was
        // finished early.
        let mut ends = vec![(line.steps.map(i64::from), [0.0; 2])];
        let mut finished = false;
        for (act, held, rest) in &taken {
            match (act, held) {
                (Act::On(times), Ok(at)) => {
                    ends.push((unit.map(|n| i64::from(n * times)), [*at, *rest]));
                }
                (Act::Elsewhere(to), Ok(at)) => ends.push((to.map(i64::from), [*at, *rest])),
                (Act::Finish, Ok(_)) => finished = true,
                _ => {}
            }
        }
        let mut positions = vec![(f64::NEG_INFINITY, [0i64; 3])];
        for &(t, axis, to) in &events {
            let mut at = positions.last().unwrap().1;
            prop_assert_eq!((to - at[axis]).abs(), 1);
            at[axis] = to;
            positions.push((t, at));
        }
        if !finished {
            prop_assert_eq!(positions.last().unwrap().1, ends.last().unwrap().0);
        }
        prop_assert!(straight(&positions, &ends, 0, 0), "{ends:?}");
        // The distance over 50 ms, to a step of each axis.
        let slack = step.iter().map(|step| step * step).sum::<f64>().sqrt() * 2.0;
        let mut from = 0;
        for n in 0..positions.len() {
            let (t, at) = positions[n];
            while positions[from].0 < t - 0.05 {
                from += 1;
            }
            let (u, was) = positions[from];
            if !u.is_finite() {
                continue;
            }
            let way = (0..3).map(|a| ((at[a] - was[a]) as f64 * step[a]).powi(2)).sum::<f64>().sqrt();
            let most = envelope.within(u, t);
            prop_assert!(way <= most * (t - u) + slack, "{way} in {} at {t}: {most}", t - u);
        }
    }

    /// On a circle it is the same: the path stays round, with the same steps as without changes.
    #[test]
    fn feeds_and_pauses_keep_the_circle(
        radius in 100.0f64..600.0,
        begin in 0.0f64..TAU,
        sweep in prop_oneof![Just(TAU), Just(-TAU), -4.0f64..-0.5, 0.5f64..4.0],
        step in prop::array::uniform2(0.5f64..1.0),
        pace in pace(),
        acts in feeds(),
    ) {
        let centre = [-radius * begin.cos(), -radius * begin.sin()];
        let arc = Arc { centre, sweep, step };
        let rate = Rate::from_hz(HZ as u32).unwrap();
        let axes = || Steps::arc(&arc, pace, rate, LEAD).unwrap();
        let mut acts = acts;
        acts.push((5.0, Act::Resume));
        let ((events, _), (free, _)) = (play(axes(), &acts, [0; 2]), play(axes(), &[], [0; 2]));
        for axis in 0..2 {
            let of = |all: &[Event]| all.iter().filter(|e| e.1 == axis).map(|e| e.2).collect::<Vec<_>>();
            prop_assert_eq!(of(&events), of(&free));
        }
        let mut at = [0i64; 2];
        for (t, axis, to) in events {
            at[axis] = to;
            let p = [0, 1].map(|n| at[n] as f64 * step[n] - centre[n]);
            let off = (p[0].hypot(p[1]) - radius).abs();
            prop_assert!(off <= step[0].max(step[1]), "{off} from the circle at {t}");
        }
    }
}
