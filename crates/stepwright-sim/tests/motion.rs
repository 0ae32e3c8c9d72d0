//! Random orders and stops: every pulse is on an independent curve, every position is the sum of the edges, and
//! the drivers' times are kept.

use crate::curve::Curve;
use crate::edges::{check_timing, steps_of};
use proptest::prelude::*;
use stepwright::profile::{Fit, Ramp};
use stepwright::timer::Count;
use stepwright::{Accel, Axis, AxisLimits, Order, Rate, Speed, Travel};

use stepwright_sim::{Description, Edge, Queues, VirtualBoard, virtual_steppers};

#[derive(Clone, Debug)]
struct Job {
    axis: u8,
    order: Order,
    /// When to brake, in ms after the order; `None`: not at all.
    brake: Option<u32>,
    /// Ticks before the next job.
    pause: u32,
}

fn spread(low: u32, high: u32) -> impl Strategy<Value = u32> {
    (0.0f64..1.0).prop_map(move |x| {
        let (l, h) = (f64::from(low).ln(), f64::from(high).ln());
        ((l + x * (h - l)).exp().round() as u32).clamp(low, high)
    })
}

fn job() -> impl Strategy<Value = Job> {
    let ramp = || {
        prop_oneof![
            spread(1, 999).prop_map(|n| Ramp::Steps(n as u16)),
            spread(50, 1_000_000).prop_map(|a| Ramp::Accel(Accel::from_steps(a).unwrap())),
        ]
    };
    let travel = prop_oneof![
        4 => (spread(1, 4_000), any::<bool>())
            .prop_map(|(n, forward)| Travel::By(if forward { n as i32 } else { -(n as i32) })),
        1 => any::<bool>().prop_map(Travel::Endless),
        1 => Just(Travel::By(0)),
    ];
    (
        0u8..3,
        prop_oneof![Just(0u32), spread(1_000, 2_000_000)],
        spread(20_000, 30_000_000),
        ramp(),
        ramp(),
        travel,
        prop_oneof![Just(None), (0u32..2_000).prop_map(Some)],
        0u32..3_000_000,
    )
        .prop_map(|(axis, start, top, up, down, travel, brake, pause)| {
            let v = |m| Speed::from_millisteps(m).unwrap();
            let order = Order { start: v(start), top: v(top), up, down, jerk: None, travel };
            // An endless travel has to be stopped.
            let brake = match travel {
                Travel::Endless(_) => brake.or(Some(300)),
                Travel::By(_) => brake,
            };
            Job { axis, order, brake, pause }
        })
}

/// The curve of an order, from the values that the core holds. The slopes of its ramps are given in 10⁻⁶
/// (steps/s)² per step.
fn curve(order: &Order, rate: Rate, (a2, d2): (u64, u64)) -> Curve {
    Curve {
        hz: f64::from(rate.hz()),
        start: f64::from(order.start.millisteps()) / 1e3,
        top: f64::from(order.top.millisteps()) / 1e3,
        a: a2 as f64 / 2e6,
        d: d2 as f64 / 2e6,
        length: match order.travel {
            Travel::By(steps) => f64::from(steps.unsigned_abs().max(1) - 1),
            Travel::Endless(_) => f64::INFINITY,
        },
    }
}

/// The curves that an order may follow.
///
/// A slope is a whole number of 10⁻⁶ (steps/s)² per step. For a ramp in steps it is (top² − start²)/steps,
/// rounded. The planner's numbers have 32 bits, so a quotient near a half may be rounded to either side. Over
/// some seconds that is more than a tick.
fn curves(order: &Order, rate: Rate) -> Vec<Curve> {
    let squared = |speed: Speed| f64::from(speed.millisteps()).powi(2);
    let sides = |ramp, slope: u64| match ramp {
        Ramp::Accel(_) => vec![slope],
        Ramp::Steps(steps) => {
            let quotient = (squared(order.top) - squared(order.start)) / f64::from(steps);
            let error = squared(order.top) / f64::from(steps) * 2f64.powi(-31);
            match (quotient.fract() - 0.5).abs() <= error {
                true => vec![slope, quotient.floor() as u64, quotient.ceil() as u64],
                false => vec![slope],
            }
        }
    };
    let (a2, d2) = order.path(rate).unwrap().slopes();
    let falls = sides(order.down, d2);
    let both = |a| falls.iter().map(move |d| (a, *d));
    sides(order.up, a2).into_iter().flat_map(both).map(|s| curve(order, rate, s)).collect()
}

/// The error that the planner's 32-bit numbers may add to a time: a part in 2²⁹.
fn drift(time: f64) -> f64 {
    time * 2f64.powi(-29)
}

/// Whether every pulse is within `slack` ticks (and the [`drift`]) of the curve, or of the curve up to some
/// pulse between `asked` and a horizon later, and from there on of its shortest stop.
///
/// # Errors
/// By how much the pulses are off.
fn on_curve(
    pulses: &[u64],
    curve: &Curve,
    asked: Option<u64>,
    horizon: u64,
    slack: f64,
) -> Result<(), String> {
    let Some(&first) = pulses.first() else { return Ok(()) };
    let time = |n: usize| (pulses[n] - first) as f64;
    let follows = |upto: usize| {
        (0..upto).all(|n| (time(n) - curve.time(n as f64)).abs() <= slack + drift(time(n)))
    };
    let whole = curve.length.is_finite() && pulses.len() == curve.length as usize + 1;
    if whole && follows(pulses.len()) {
        return Ok(());
    }
    let asked = asked.ok_or_else(|| format!("{} pulses, {curve:?}", pulses.len()))?;
    // The last pulse that was committed when the brake took effect.
    let early = pulses.partition_point(|&t| t <= asked).saturating_sub(1);
    // Within the horizon, which begins with the first pulse. If steps are slow, the steps of three runs.
    let late = pulses.partition_point(|&t| t <= asked.max(first) + horizon).max(early + 4);
    let late = late.min(pulses.len() - 1);
    let mut why = String::new();
    for last in early..=late {
        let steps = (pulses.len() - 1 - last) as u32;
        if !curve.stop_steps(last as f64).contains(&steps) {
            continue;
        }
        let begin = curve.time(last as f64);
        let off = |i: u32| time(last + i as usize) - begin - curve.stop_time(last as f64, steps, i);
        // A fall omits a part in 2²⁸ of v²: it begins earlier by this part of half its time.
        let early = drift(curve.stop_time(last as f64, steps, steps));
        let over = |i: u32| off(i).abs() - drift(time(last + i as usize)) - early;
        let worst = (0..=steps).map(over).fold(0.0, f64::max);
        if worst <= slack && follows(last + 1) {
            return Ok(());
        }
        why += &format!("from {last}: {steps} steps, {worst:.2} ticks off; ");
    }
    Err(format!("no stop fits: {} pulses, {early}..={late}, {why}{curve:?}", pulses.len()))
}

fn play<C: Count>(description: Description, jobs: &[Job], slack: f64) {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<C, Vec<Edge>> =
        VirtualBoard::new(&mut queues, description, Vec::new());
    let rate = description.board.rate;
    let timing = description.board.timing;
    let mut wanted = [0i64; 3];
    let mut seen = [0usize; 3];
    for job in jobs {
        let axis = Axis::new(job.axis.into()).unwrap();
        let refused = board.motors().start([(axis, job.order)]).is_err();
        let begun = board.now();
        let mut asked = None;
        if let Some(ms) = job.brake {
            board.run_until(begun + u64::from(rate.micros(ms * 1000)));
            asked = Some(board.now());
            board.motors().stop(axis);
        }
        board.run_to_rest();
        board.run_until(board.now() + u64::from(job.pause));
        let steps = steps_of(board.recorder(), job.axis);
        let fresh = &steps[seen[usize::from(job.axis)]..];
        seen[usize::from(job.axis)] = steps.len();
        if refused {
            assert!(fresh.is_empty(), "a refused order moved");
            continue;
        }
        let sign = if job.order.travel.forward() { 1 } else { -1 };
        let count = fresh.len() as i64;
        if job.brake.is_none() {
            let Travel::By(n) = job.order.travel else { unreachable!() };
            assert_eq!(count, i64::from(n.unsigned_abs()));
        }
        wanted[usize::from(job.axis)] += sign * count;
        assert_eq!(board.position(job.axis), Some(wanted[usize::from(job.axis)]));
        assert_eq!(steps.last().map_or(0, |s| s.1), wanted[usize::from(job.axis)]);
        let pulses: Vec<u64> = fresh.iter().map(|s| s.0).collect();
        // Committed: the queue, the run that plays and one more run.
        let horizon = u64::from(description.board.horizon + rate.micros(2 * 8_000));
        let curves = curves(&job.order, rate);
        let tried = curves.iter().map(|c| on_curve(&pulses, c, asked, horizon, slack));
        let off: Vec<String> = tried.map_while(Result::err).collect();
        assert!(off.len() < curves.len(), "{off:?}");
    }
    assert_eq!(board.late(), 0);
    let min = u64::from(timing.min_interval) - 1;
    let t = |ticks: u32| u64::from(ticks);
    check_timing(board.recorder(), t(timing.pulse), t(timing.setup), t(timing.hold), min);
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(300)
}

/// Fitted to a quarter of a tick and played exactly: within a tick of the curve.
fn exact(mut description: Description) -> Description {
    let rate = description.board.rate;
    description.board.fit = Fit::EXACT.lasting(rate.micros(8_000));
    (description.grid, description.assembly) = ([1; 3], false);
    description
}

/// A fall of 861 steps that takes 8 s. Its slope is 48,543,050.505 before rounding.
#[test]
fn a_slope_near_a_half_may_be_rounded_either_way() {
    let v = |m| Speed::from_millisteps(m).unwrap();
    let order = Order {
        start: v(15_322),
        top: v(205_013),
        up: Ramp::Steps(1),
        down: Ramp::Steps(861),
        jerk: None,
        travel: Travel::Endless(false),
    };
    assert!(curves(&order, Description::uno().board.rate).len() > 1);
    let job = Job { axis: 0, order, brake: Some(300), pause: 0 };
    play::<u16>(exact(Description::uno()), &[job], 1.0);
}

/// Ramps of 8 and 15 steps that meet at their top speed, in 23 steps. Rounded, the two parts of the step
/// between them are a little more than a step; the remainder must not be taken for a whole step.
#[test]
fn ramps_that_meet_at_the_top_have_no_level_step() {
    let v = |m| Speed::from_millisteps(m).unwrap();
    let (up, down) = (Ramp::Steps(8), Ramp::Steps(15));
    let travel = Travel::By(-24);
    let order = Order { start: v(0), top: v(68_938), up, down, jerk: None, travel };
    let job = Job { axis: 0, order, brake: None, pause: 0 };
    play::<u16>(exact(Description::uno()), std::slice::from_ref(&job), 1.0);
    play::<u16>(Description::uno(), &[job], 17.0);
}

/// An AVR has 24 bits for a wait of up to 268 s: the next step makes up for the lost bits.
#[test]
fn a_step_behind_a_wait_of_minutes_lacks_a_part_of_it_at_most() {
    for milli in [4, 11, 19, 100, 333, 2_000] {
        let mut queues = Queues::default();
        let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::<Edge>::new());
        let (top, accel) = (Speed::from_millisteps(milli), Accel::from_steps(10_000));
        let limits = AxisLimits::new(top.unwrap(), accel.unwrap()).start_speed(top.unwrap());
        motors.set_limits(Axis::X, limits);
        motors.move_by(Axis::X, 12).unwrap();
        while motors.is_moving(Axis::X) {
            let wait = motors.poll().unwrap_or(16_000_000);
            motors.engine().pass(wait);
        }
        let steps = steps_of(motors.engine().recorder(), 0);
        let times: Vec<f64> = steps.iter().map(|(time, _)| *time as f64).collect();
        let interval = 16e9 / f64::from(milli);
        // 1 µs, the rounding to a tick, and 2⁻²² of the wait.
        let bound = 17.0 + interval / f64::from(1 << 22);
        for (n, time) in (0u32..).zip(&times) {
            let off = time - times[0] - f64::from(n) * interval;
            assert!(off.abs() <= bound, "{milli} millisteps/s: step {n} is {off} ticks off");
        }
        assert_eq!(times.len(), 12);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn pulses_keep_the_curve_on_an_uno(jobs in prop::collection::vec(job(), 1..4)) {
        play::<u16>(exact(Description::uno()), &jobs, 1.0);
    }

    #[test]
    fn pulses_keep_the_stated_error(jobs in prop::collection::vec(job(), 1..4)) {
        // 1 µs at 16 MHz, and the rounding to a tick.
        play::<u16>(Description::uno(), &jobs, 17.0);
    }

    #[test]
    fn pulses_keep_the_curve_on_32_bits(
        hz in spread(100_000, 200_000_000),
        jobs in prop::collection::vec(job(), 1..4),
    ) {
        let rate = Rate::from_hz(hz).unwrap();
        let cost = [(hz / 200_000).max(1); 3];
        play::<u32>(exact(Description::quick(rate, cost)), &jobs, 1.0);
    }
}
