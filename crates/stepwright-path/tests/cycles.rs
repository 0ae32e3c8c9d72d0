//! Paths in cycles on the virtual board: whatever bounds, switches, pauses, cancellations and changes do, the
//! edges add up to the reported position, and no motor changes the edges of another.

use std::cell::Cell;

use proptest::prelude::*;
use stepwright::Rate;
use stepwright_cycle::{
    AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, Calibration, Clock, Leg, Motor, Program,
    Strategies,
};
use stepwright_path::{Arc, Line, LivePath, Pace, Steps, legs};
use stepwright_sim::{CycleBoard, Edge, Pin, Stand};

const HZ: u32 = 16_000_000;
/// The smallest delay, in µs.
const SMALLEST: u32 = 300;
/// The ticks of a pulse: an edge may wait for the end of another motor's pulse.
const PULSE: u64 = 32;

/// A path of the first two motors. The third motor makes steps of its own.
#[derive(Clone, Copy, Debug)]
enum Way {
    Line([i32; 2]),
    /// The radius in steps, the angle at the beginning, and the sweep.
    Arc(f64, f64, f64),
}

#[derive(Clone, Copy, Debug)]
enum Act {
    Scale(f64),
    Brake,
    GoOn,
    Retarget([i32; 2]),
    GiveUp,
    Pause,
    Resume,
    Finish,
}

fn way() -> impl Strategy<Value = Way> {
    prop_oneof![
        prop::array::uniform2(-300i32..300)
            .prop_filter("it leads somewhere", |way| *way != [0, 0])
            .prop_map(Way::Line),
        (20.0f64..100.0, 0.0f64..6.0, prop_oneof![-7.0f64..-0.5, 0.5f64..7.0])
            .prop_map(|(radius, begin, sweep)| Way::Arc(radius, begin, sweep)),
    ]
}

fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        3 => (0.1f64..2.0).prop_map(Act::Scale),
        2 => Just(Act::Brake),
        3 => Just(Act::GoOn),
        3 => prop::array::uniform2(-300i32..300).prop_map(Act::Retarget),
        1 => Just(Act::GiveUp),
        2 => Just(Act::Pause),
        3 => Just(Act::Resume),
        1 => Just(Act::Finish),
    ]
}

fn motor() -> impl Strategy<Value = (Motor, Stand)> {
    let bound = || prop::option::weighted(0.3, -250i64..250);
    (1u32..9, any::<bool>(), [bound(), bound(), bound(), bound()], 500u32..2_000_000).prop_map(
        |(distance, inverted, [min, max, below, above], decel)| {
            let scaled = |bound: Option<i64>| bound.map(|b| b * i64::from(distance));
            let (min, max) = (scaled(min), scaled(max));
            let motor = Motor { inverted, min, max, decel, ..Motor::new(distance, SMALLEST) };
            (motor, Stand { min: below.map(|n| n - 300), max: above.map(|n| n + 300) })
        },
    )
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

fn pace() -> impl Strategy<Value = Pace> {
    let bend = prop::option::of(0.01f64..0.2);
    (100.0f64..2_500.0, 500.0f64..20_000.0, bend).prop_map(|(speed, accel, bend)| {
        let pace = Pace::new(speed, accel);
        bend.map_or(pace, |bend| pace.with_jerk(accel / bend))
    })
}

/// The steps of the path, one unit each.
fn steps(way: Way, pace: Pace) -> [Steps; 2] {
    let rate = Rate::from_hz(HZ).unwrap();
    let (lead, step) = (rate.micros(SMALLEST), [1.0; 2]);
    match way {
        Way::Line(steps) => Steps::line(&Line { steps, step }, pace, rate, lead).unwrap(),
        Way::Arc(radius, begin, sweep) => {
            let centre = [-radius * begin.cos(), -radius * begin.sin()];
            Steps::arc(&Arc { centre, sweep, step }, pace, rate, lead).unwrap()
        }
    }
}

fn ask(path: &LivePath, act: Act, at: f64) {
    match act {
        Act::Scale(part) => _ = path.scale(at, part),
        Act::Brake => _ = path.pause(at),
        Act::GoOn => _ = path.resume(at),
        Act::Retarget(to) => _ = path.retarget(at, &to),
        Act::GiveUp => _ = path.finish(at),
        Act::Pause | Act::Resume | Act::Finish => {}
    }
}

/// The number of steps by the edges alone, in the motor's own direction.
fn edges_of(edges: &[Edge], axis: u8, motor: &Motor) -> i64 {
    let (mut forward, mut steps, mut high) = (true, 0, false);
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        match edge.pin {
            Pin::Direction => forward = edge.level != motor.inverted,
            Pin::Step if edge.level => {
                assert!(!std::mem::replace(&mut high, true), "a pulse within a pulse: {edge:?}");
                steps += if forward { 1 } else { -1 };
            }
            Pin::Step => high = false,
            Pin::Coil(_) | Pin::Enable | Pin::Min | Pin::Max => {}
        }
    }
    assert!(!high, "STEP is left high");
    steps
}

type Acts = Vec<(u32, Act)>;

/// Plays the path, and returns all edges and the reported positions. Changes of the path are ordered for this
/// many seconds later; 0 means as soon as possible. From memory (`stored`) the path stays as it was at the
/// start.
fn play(
    motors: [(Motor, Stand); 3],
    strategies: Strategies,
    (way, pace, count): (Way, Pace, i32),
    acts: &Acts,
    later: f64,
    stored: bool,
) -> (Vec<Edge>, [i64; 3]) {
    let rate = Rate::from_hz(HZ).unwrap();
    let [mut x, mut y] = steps(way, pace);
    let path = x.law();
    // Later changes must stay within what the motors can follow.
    path.within(&[1e6 / f64::from(SMALLEST); 2]).unwrap();
    let (settings, stands) = (motors.map(|m| m.0), motors.map(|m| m.1));
    let mut board: CycleBoard<Vec<Edge>, 3> =
        CycleBoard::new(settings, stands, Clock::Deadlines, rate, Vec::new());
    let cycle = board.cycle();
    cycle.set_strategies(strategies);
    let cells = |legs: Vec<Leg>| legs.into_iter().map(Cell::new).collect::<Vec<_>>();
    let kept = if stored {
        [&mut x, &mut y].map(|axis| cells(legs(axis, 32, rate.micros(SMALLEST))))
    } else {
        [Vec::new(), Vec::new()]
    };
    let [first, second] = if stored {
        [Program::Stored(&kept[0]), Program::Stored(&kept[1])]
    } else {
        [Program::Paced(&mut x), Program::Paced(&mut y)]
    };
    cycle.prepare(0, first, Calibration::None).unwrap();
    cycle.prepare(1, second, Calibration::None).unwrap();
    let steps = Program::Steps { count, delay: 1_100 };
    cycle.prepare(2, steps, Calibration::None).unwrap();
    cycle.start().unwrap();
    let when = |at: u64| if later > 0.0 { at as f64 / f64::from(HZ) + later } else { 0.0 };
    let mut at = 0;
    for (us, act) in acts {
        at += u64::from(*us) * u64::from(HZ) / 1_000_000;
        board.run_until(at);
        let cycle = board.cycle();
        match act {
            Act::Pause => _ = cycle.pause(),
            Act::Resume => _ = cycle.resume(),
            Act::Finish => cycle.finish(),
            act => ask(&path, *act, when(at)),
        }
    }
    _ = board.cycle().resume();
    path.resume(when(at));
    // Longer than 8 s at a tenth of the lowest speed.
    board.run_until(at + 120 * u64::from(HZ));
    assert!(!board.cycle().is_running(), "it has not ended");
    assert_eq!(board.cycle().late(), 0);
    let positions = [0, 1, 2].map(|motor| board.cycle().position(motor).unwrap());
    (board.with_recorder(std::mem::take), positions)
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(150)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn edges_add_up_to_the_position(
        motors in [motor(), motor(), motor()],
        strategies in strategies(),
        path in (way(), pace(), -200i32..200),
        acts in prop::collection::vec((0u32..200_000, act()), 0..10),
        stored in any::<bool>(),
    ) {
        let (edges, positions) = play(motors, strategies, path, &acts, 0.0, stored);
        for axis in 0..3u8 {
            let (motor, position) = (&motors[usize::from(axis)].0, positions[usize::from(axis)]);
            let moved = edges_of(&edges, axis, motor) * i64::from(motor.distance);
            prop_assert_eq!(position, moved, "motor {}", axis);
        }
    }

    /// If a motor of the path is stopped by its bound, or stopped or braked by its switch, the other motors
    /// have the same edges as beside one that continues.
    #[test]
    fn nobody_moves_anothers_edges(
        path in (way(), pace(), -200i32..200),
        bound in 0i64..60,
        switch in prop::option::of(any::<bool>()),
        acts in prop::collection::vec((0u32..200_000, act()), 0..6),
        stored in any::<bool>(),
    ) {
        let free = (Motor::new(1, SMALLEST), Stand::default());
        let (motor, stand) = free;
        let free = (motor.braking(5_000), stand);
        let (motor, _) = free;
        let stopped = match switch {
            None => (motor.between(-bound, bound), stand),
            Some(_) => (motor, Stand { min: Some(-bound - 1), max: Some(bound + 1) }),
        };
        let strategies = Strategies {
            hard_end: match switch {
                Some(true) => AtHardEnd::BrakeMotor,
                _ => AtHardEnd::StopMotor,
            },
            soft_end: AtSoftEnd::StopMotor,
            small_delay: AtSmallDelay::Fix,
            timing: AtTiming::Cancel,
        };
        // Later than the steps that are handed out ahead. Otherwise a change would take effect sooner with one
        // motor less to wait for.
        let run = |first| play([first, free, free], strategies, path, &acts, 0.01, stored).0;
        let (whole, ended) = (run(free), run(stopped));
        for axis in [1, 2] {
            let of = |edges: &[Edge]| -> Vec<Edge> {
                edges.iter().filter(|e| e.axis == axis && e.pin != Pin::Enable).copied().collect()
            };
            let (whole, ended) = (of(&whole), of(&ended));
            prop_assert_eq!(whole.len(), ended.len());
            for (a, b) in whole.iter().zip(&ended) {
                prop_assert_eq!((a.pin, a.level), (b.pin, b.level));
                prop_assert!(a.time.abs_diff(b.time) <= PULSE, "{a:?} {b:?}");
            }
        }
    }
}
