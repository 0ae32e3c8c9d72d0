//! Random cycles: for any ends, pauses, cancels and callbacks, the edges add up to the reported
//! position, and no motor moves the edges of another.

use crate::rig::{PULSE, Rig, What};
use proptest::prelude::*;
use stepwright_cycle::{
    AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, Calibration, Clock, Leg, Motor, NextDelay,
    Program, Strategies,
};

/// A program that owns its data.
#[derive(Clone, Debug)]
enum Plan {
    Nothing,
    Steps(i32, u32),
    Whirl(bool, u32),
    List(Vec<u32>, u32, bool),
    Series(Vec<Leg>),
    /// A callback: count, seed; no count means without end.
    Dynamic(Option<i32>, u32),
}

/// Delays around the smallest of 600 µs; some too small, some 0.
fn delay() -> impl Strategy<Value = u32> {
    prop_oneof![6 => 600u32..2_500, 1 => Just(0u32), 1 => 1u32..600, 1 => 2_500u32..40_000]
}

fn count() -> impl Strategy<Value = i32> {
    -40i32..40
}

fn plan() -> impl Strategy<Value = Plan> {
    let leg = prop_oneof![
        3 => (count(), delay()).prop_map(|(count, delay)| Leg::Steps { count, delay }),
        1 => (0u32..4, delay()).prop_map(|(count, delay)| Leg::Wait { count, delay }),
    ];
    prop_oneof![
        Just(Plan::Nothing),
        (count(), delay()).prop_map(|(count, delay)| Plan::Steps(count, delay)),
        (any::<bool>(), delay()).prop_map(|(forward, delay)| Plan::Whirl(forward, delay)),
        (prop::collection::vec(delay(), 0..12), 0u32..5, any::<bool>())
            .prop_map(|(delays, each, forward)| Plan::List(delays, each, forward)),
        prop::collection::vec(leg, 0..8).prop_map(Plan::Series),
        (prop::option::of(count()), any::<u32>())
            .prop_map(|(count, seed)| Plan::Dynamic(count, seed)),
    ]
}

fn motor() -> impl Strategy<Value = Motor> {
    let bound = || prop::option::of(-30i64..30);
    (prop_oneof![Just(1u32), 2u32..9], any::<bool>(), bound(), bound(), 10_000u32..2_000_000)
        .prop_map(|(distance, inverted, min, max, decel)| {
            let scaled = |bound: Option<i64>| bound.map(|b| b * i64::from(distance));
            Motor {
                inverted,
                min: scaled(min),
                max: scaled(max),
                decel,
                ..Motor::new(distance, 600)
            }
        })
}

fn strategies() -> impl Strategy<Value = Strategies> {
    let soft = prop_oneof![Just(AtSoftEnd::StopMotor), Just(AtSoftEnd::Cancel)];
    let hard = prop_oneof![
        Just(AtHardEnd::StopMotor),
        Just(AtHardEnd::BrakeMotor),
        Just(AtHardEnd::Cancel),
        Just(AtHardEnd::BrakeAll)
    ];
    let small = prop_oneof![
        2 => Just(AtSmallDelay::Fix),
        1 => Just(AtSmallDelay::StopMotor),
        1 => Just(AtSmallDelay::Cancel)
    ];
    (hard, soft, small).prop_map(|(hard_end, soft_end, small_delay)| Strategies {
        hard_end,
        soft_end,
        small_delay,
        timing: AtTiming::Cancel,
    })
}

/// An external event.
#[derive(Clone, Copy, Debug)]
enum Act {
    Pause,
    Resume,
    Finish,
    Close(u8, u8),
    Look,
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        4 => Just(Act::Pause),
        4 => Just(Act::Resume),
        1 => Just(Act::Finish),
        2 => (any::<u8>(), any::<u8>()).prop_map(|(min, max)| Act::Close(min & 5, max & 3)),
        3 => Just(Act::Close(0, 0)),
        2 => Just(Act::Look),
    ]
}

#[derive(Clone, Debug)]
struct Round {
    plans: [(Plan, u8); 3],
    strategies: Strategies,
    /// µs since the previous event, and the event.
    acts: Vec<(u32, Act)>,
}

fn round() -> impl Strategy<Value = Round> {
    let calibrated = || (plan(), prop_oneof![4 => Just(0u8), 1 => Just(1u8), 1 => Just(2u8)]);
    (
        [calibrated(), calibrated(), calibrated()],
        strategies(),
        prop::collection::vec((0u32..20_000, act()), 0..8),
    )
        .prop_map(|(plans, strategies, acts)| Round { plans, strategies, acts })
}

fn calibration(kind: u8) -> Calibration {
    match kind {
        0 => Calibration::None,
        1 => Calibration::StartMin,
        _ => Calibration::BoundsMax,
    }
}

/// A callback for each dynamic plan.
fn callback(seed: u32) -> impl FnMut(u32) -> u32 + Send {
    move |step| match seed.rotate_left(step) % 23 {
        0 => 100,
        1 => 0,
        n => 600 + 97 * n,
    }
}

fn clock() -> impl Strategy<Value = Clock> {
    prop_oneof![
        Just(Clock::Deadlines),
        Just(Clock::Tick { period: 200 }),
        Just(Clock::Tick { period: 100 }),
        Just(Clock::Grid { period: 100 })
    ]
}

/// The program of a plan, if it has one.
fn program<'a>(plan: &'a Plan, next: NextDelay<'a>) -> Option<Program<'a>> {
    Some(match plan {
        Plan::Nothing => return None,
        Plan::Steps(count, delay) => Program::Steps { count: *count, delay: *delay },
        Plan::Whirl(forward, delay) => Program::Whirl { forward: *forward, delay: *delay },
        Plan::List(delays, each, forward) => {
            Program::List { delays, each: *each, forward: *forward }
        }
        Plan::Series(legs) => Program::Series(legs),
        Plan::Dynamic(Some(count), _) => Program::Dynamic { count: *count, next },
        Plan::Dynamic(None, _) => Program::DynamicWhirl { forward: true, next },
    })
}

/// The plan with delays so close to one another that pulses meet.
fn close(plan: Plan) -> Plan {
    let near = |delay: u32| if delay < 600 { delay } else { 600 + delay % 5 };
    let leg = |leg| match leg {
        Leg::Steps { count, delay } => Leg::Steps { count, delay: near(delay) },
        Leg::Wait { count, delay } => Leg::Wait { count, delay: near(delay) },
        leg => leg,
    };
    match plan {
        Plan::Steps(count, delay) => Plan::Steps(count, near(delay)),
        Plan::Whirl(forward, delay) => Plan::Whirl(forward, near(delay)),
        Plan::List(delays, each, forward) => {
            Plan::List(delays.into_iter().map(near).collect(), each, forward)
        }
        Plan::Series(legs) => Plan::Series(legs.into_iter().map(leg).collect()),
        plan => plan,
    }
}

/// The reason for the end of a motor's program.
#[derive(Clone, Copy, Debug)]
enum Stop {
    Bound(i64),
    /// At once, or braking.
    Switch(bool),
    /// A delay that is too small, from this step on.
    TooFast(u32),
}

fn stop() -> impl Strategy<Value = Stop> {
    prop_oneof![
        (0i64..50).prop_map(Stop::Bound),
        any::<bool>().prop_map(Stop::Switch),
        (0u32..50).prop_map(Stop::TooFast),
    ]
}

/// Plays the rounds; afterwards the edges and positions of each motor agree.
fn play(motors: [Motor; 3], clock: Clock, rounds: &[Round]) {
    let mut calls: Vec<_> = rounds
        .iter()
        .map(|round| {
            round.plans.each_ref().map(|(plan, _)| match plan {
                Plan::Dynamic(_, seed) => callback(*seed),
                _ => callback(0),
            })
        })
        .collect();
    let mut rig = Rig::new(motors, clock);
    // Positions in steps by the edges, from where positions were last set.
    for (round, calls) in rounds.iter().zip(&mut calls) {
        rig.cycle.set_strategies(round.strategies);
        let before = [0, 1, 2].map(|m| (rig.position(m), edges_of(&rig, m, &motors)));
        for ((motor, (plan, kind)), next) in (0u8..).zip(&round.plans).zip(calls) {
            let Some(program) = program(plan, next) else { continue };
            rig.cycle.prepare(motor, program, calibration(*kind)).unwrap();
        }
        rig.begun = rig.time.now.get();
        let started = rig.cycle.start();
        let mut at = 0;
        for (us, act) in &round.acts {
            at += u64::from(*us);
            rig.until(at);
            match act {
                Act::Pause => _ = rig.cycle.pause(),
                Act::Resume => _ = rig.cycle.resume(),
                Act::Finish => rig.cycle.finish(),
                Act::Close(min, max) => rig.close(*min, *max),
                Act::Look => rig.cycle.look(),
            }
        }
        _ = rig.cycle.resume();
        rig.close(0, 0);
        rig.until(at + 100_000);
        rig.cycle.finish();
        for motor in 0..3u8 {
            let (position, edges) = before[usize::from(motor)];
            let moved = edges_of(&rig, motor, &motors) - edges;
            let settings = motors[usize::from(motor)];
            let (plan, kind) = &round.plans[usize::from(motor)];
            if started.is_err() {
                assert_eq!(moved, 0, "a refused cycle moved");
            }
            let wanted = match (calibration(*kind), plan) {
                (Calibration::StartMin, plan) if moved != 0 || rig.position(motor) != position => {
                    assert!(!matches!(plan, Plan::Nothing));
                    settings.min.unwrap_or(0)
                }
                _ => position + moved * i64::from(settings.distance),
            };
            assert_eq!(rig.position(motor), wanted, "motor {motor}, {clock:?}");
        }
    }
    assert_eq!(rig.cycle.late(), 0);
}

/// Steps by the edges alone, in the motor's own direction.
fn edges_of(rig: &Rig<3>, motor: u8, motors: &[Motor; 3]) -> i64 {
    let settings = motors[usize::from(motor)];
    let (mut forward, mut steps, mut high) = (true, 0, false);
    for &(time, _, what) in rig.log.borrow().iter().filter(|e| e.1 == motor) {
        match what {
            What::Dir(level) => forward = level != settings.inverted,
            What::Rise => {
                assert!(!std::mem::replace(&mut high, true), "a pulse within a pulse at {time}");
                steps += if forward { 1 } else { -1 };
            }
            What::Fall => high = false,
            What::Enable(_) => {}
        }
    }
    assert!(!high, "STEP is left high");
    steps
}

/// Cycles of a tick of the grid.
const GRID: u64 = 100 * 16;

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(300)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn edges_add_up_to_the_position(
        motors in [motor(), motor(), motor()],
        clock in clock(),
        rounds in prop::collection::vec(round(), 1..4),
    ) {
        play(motors, clock, &rounds);
    }

    /// Beside a motor that stops, and beside one that continues: the same edges, whatever the
    /// others do, and whatever ends them.
    #[test]
    fn nobody_moves_anothers_edges(
        clock in clock(),
        plans in [plan().prop_map(close), plan().prop_map(close)],
        delay in 600u32..605,
        stop in stop(),
        acts in prop::collection::vec((0u32..30_000, prop_oneof![Just(Act::Pause), Just(Act::Resume)]), 0..6),
    ) {
        leaves_alone(clock, &plans, delay, stop, &acts)?;
    }
}

/// A pause of 181 ticks and 1 µs: a pulse that is in progress as it begins makes it 181.
#[test]
fn a_pause_of_about_whole_ticks_moves_all_edges_by_one() {
    let plans = [Plan::Whirl(false, 0), Plan::Nothing];
    let acts = [(27_600, Act::Pause), (18_101, Act::Pause)];
    leaves_alone(Clock::Grid { period: 100 }, &plans, 603, Stop::Bound(0), &acts).unwrap();
}

fn leaves_alone(
    clock: Clock,
    plans: &[Plan; 2],
    delay: u32,
    stop: Stop,
    acts: &[(u32, Act)],
) -> Result<(), TestCaseError> {
    let run = |stop: Option<Stop>| {
        let m = Motor::new(1, 600).braking(20_000);
        let bounded = match stop {
            Some(Stop::Bound(bound)) => m.between(-bound, bound),
            _ => m,
        };
        let mut calls = plans.each_ref().map(|plan| match plan {
            Plan::Dynamic(_, seed) => callback(*seed),
            _ => callback(0),
        });
        let small = move |step| match stop {
            Some(Stop::TooFast(at)) if step >= at => 100,
            _ => delay,
        };
        let mut middle = small;
        let mut rig = Rig::new([m, bounded, m], clock);
        rig.cycle.set_strategies(Strategies {
            soft_end: AtSoftEnd::StopMotor,
            hard_end: match stop {
                Some(Stop::Switch(true)) => AtHardEnd::BrakeMotor,
                _ => AtHardEnd::StopMotor,
            },
            // The others' small delays would stop them too, in both cases.
            small_delay: AtSmallDelay::StopMotor,
            ..Strategies::default()
        });
        for ((motor, plan), next) in [0, 2].into_iter().zip(plans).zip(&mut calls) {
            if let Some(program) = program(plan, next) {
                rig.cycle.prepare(motor, program, Calibration::None).unwrap();
            }
        }
        let whirl = Program::DynamicWhirl { forward: true, next: &mut middle };
        rig.cycle.prepare(1, whirl, Calibration::None).unwrap();
        rig.start();
        let mut at = 0;
        for (us, act) in acts {
            at += u64::from(*us);
            rig.until(at);
            _ = if matches!(act, Act::Pause) { rig.cycle.pause() } else { rig.cycle.resume() };
            if let Some(Stop::Switch(_)) = stop {
                rig.close(0, 2);
            }
        }
        _ = rig.cycle.resume();
        rig.until(at + 200_000);
        rig.cycle.finish();
        [rig.edges(0), rig.edges(2)]
    };
    let (whole, stopped) = (run(None), run(Some(stop)));
    for (whole, stopped) in whole.iter().zip(&stopped) {
        prop_assert_eq!(whole.len(), stopped.len());
        for (a, b) in whole.iter().zip(stopped) {
            prop_assert_eq!(a.1, b.1);
            // Except where a pulse lasts a tick: then an edge may wait for the end of another
            // motor's pulse. So does a pause, and its difference remains. On the grid the time of a
            // pause is rounded up to whole ticks, to one more where the pulse made it longer.
            let pauses = acts.iter().filter(|(_, act)| matches!(act, Act::Pause)).count();
            let wide = matches!(clock, Clock::Tick { .. });
            let waits = if wide { 0 } else { 1 + pauses as u64 };
            let slack = waits * PULSE;
            let apart = a.0.abs_diff(b.0);
            let ticks = if matches!(clock, Clock::Grid { .. }) { apart / GRID } else { 0 };
            prop_assert!(ticks <= pauses as u64, "{:?} {:?}", a, b);
            prop_assert!(apart - ticks * GRID <= slack, "{:?} {:?}", a, b);
        }
    }
    Ok(())
}
