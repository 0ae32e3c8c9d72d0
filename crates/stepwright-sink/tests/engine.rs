//! Motors over a model player: what they do, held against the engine that steps by itself.

use std::cell::RefCell;

use proptest::prelude::*;
use stepwright::engine::WIRING;
use stepwright::entry::EntryParts;
use stepwright::queue::Queue;
use stepwright::{
    Accel, Axis, AxisLimits, Board, Control, Cost, Rate, Run, Speed, Steppers, Ticks,
};
use stepwright_sim::{Description, Edge, Queues, virtual_steppers_of};
use stepwright_sink::{ModelEdge, ModelPlayer, SinkEngine};

const RATE: Rate = Rate::of::<125_000_000>();
/// 250,000 steps/s.
const LEAST: Ticks = 500;
/// 1 µs.
const BOUND: Ticks = 125;
/// The main loop comes round so often.
const ROUND: Ticks = 12_500;

type Told = RefCell<Vec<ModelEdge>>;

fn board<const N: usize>() -> Board<N> {
    let cost = Cost::independent(LEAST);
    let mut board = Board::<N> { cost, runs: u16::MAX, ..Board::unmeasured(RATE) };
    board.set_drivers(125, 250, 375);
    board
}

fn limits(speed: u32, accel: u32) -> AxisLimits {
    AxisLimits::new(Speed::from_steps(speed).unwrap(), Accel::from_steps(accel).unwrap())
}

/// Net steps of an axis.
fn net(told: &Told, axis: u8) -> i64 {
    let edges = told.borrow();
    let steps = edges.iter().filter(|edge| edge.axis == axis).filter_map(|edge| edge.step);
    steps.map(|forward| if forward { 1 } else { -1 }).sum()
}

/// Motors of `N` axes over a model, for a test.
macro_rules! motors {
    ($motors:ident, $told:ident, $n:literal) => {
        let $told = Told::default();
        let mut queues = [const { Queue::<8>::new() }; $n];
        let mut ends = queues.each_mut().map(|queue| Some(queue.split()));
        let mut entries = Vec::new();
        let feeds = ends.each_mut().map(|ends| {
            let (feed, taken) = ends.take().unwrap();
            entries.push(taken);
            feed
        });
        let entries: [_; $n] = entries.try_into().unwrap_or_else(|_| unreachable!());
        let model = ModelPlayer::<$n, _>::new(|edge| $told.borrow_mut().push(edge));
        let board = board::<$n>();
        let engine = SinkEngine::new(model, entries, board.timing, BOUND);
        #[allow(unused_mut)]
        let mut $motors = Steppers::new(engine, feeds, board);
    };
}

macro_rules! finish {
    ($motors:ident) => {
        while $motors.any_moving() {
            $motors.poll();
            $motors.engine().pass(ROUND);
        }
    };
}

/// Times of the steps of an axis, from the first.
fn steps(told: &Told, axis: u8) -> Vec<i64> {
    let edges = told.borrow();
    let own = edges.iter().filter(|edge| edge.axis == axis && edge.step.is_some());
    let all: Vec<i64> = own.map(|edge| edge.at as i64).collect();
    all.iter().map(|at| at - all[0]).collect()
}

/// The same move on the virtual board, whose engine steps by itself.
fn virtual_steps(target: i32, limits: AxisLimits) -> Vec<i64> {
    let mut queues = Queues::default();
    let description =
        Description { board: board(), ..Description::at(RATE, Cost::independent(500)) };
    let mut motors = virtual_steppers_of::<u32, _>(&mut queues, description, Vec::<Edge>::new());
    motors.set_limits(Axis::X, limits);
    motors.move_to(Axis::X, target.into()).unwrap();
    while motors.any_moving() {
        motors.poll();
        motors.engine().pass(ROUND);
    }
    let steps = motors.engine().recorder().iter().filter(|edge| edge.is_step());
    let all: Vec<i64> = steps.map(|edge| edge.time as i64).collect();
    all.iter().map(|at| at - all[0]).collect()
}

/// Every interval of an axis, and DIR before and behind a step, keep their least times.
fn keeps_times(told: &Told, axis: u8) {
    let (mut last, mut dir) = (None::<u64>, None::<u64>);
    for edge in told.borrow().iter().filter(|edge| edge.axis == axis) {
        if edge.step.is_none() {
            if let Some(last) = last {
                assert!(edge.at >= last + 375, "DIR {} behind a step", edge.at - last);
            }
            dir = Some(edge.at);
            continue;
        }
        if let Some(last) = last {
            assert!(edge.at >= last + 250, "steps {} apart", edge.at - last);
        }
        if let Some(dir) = dir {
            assert!(edge.at >= dir + 250, "DIR {} before a step", edge.at - dir);
        }
        last = Some(edge.at);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// A model and the virtual board step alike, to the bound; and the last step to a tick.
    #[test]
    fn a_move_is_that_of_the_virtual_board(
        target in 1i32..8_000, speed in 200u32..250_000, accel in 2_000u32..2_000_000,
        backward: bool,
    ) {
        let limits = limits(speed, accel);
        let target = if backward { -target } else { target };
        motors!(motors, told, 3);
        motors.set_limits(Axis::X, limits);
        motors.move_to(Axis::X, target.into()).unwrap();
        finish!(motors);
        prop_assert_eq!(motors.position(Axis::X), Some(target.into()));
        prop_assert_eq!(net(&told, 0), i64::from(target));
        prop_assert_eq!(motors.late(), 0);
        keeps_times(&told, 0);
        let (own, other) = (steps(&told, 0), virtual_steps(target, limits));
        prop_assert_eq!(own.len(), other.len());
        for (n, (own, other)) in own.iter().zip(&other).enumerate() {
            prop_assert!((own - other).abs() <= i64::from(BOUND) + 1, "step {}: {} {}", n, own, other);
        }
        let off = own.last().unwrap() - other.last().unwrap();
        prop_assert!(off.abs() <= 2, "the last step is {} ticks off", off);
    }

    /// Killed at any moment, the position is that of the pins, to the step; and what comes next
    /// starts from there.
    #[test]
    fn a_kill_leaves_the_exact_count(
        speed in 500u32..250_000, accel in 5_000u32..2_000_000, moment in 0u32..20_000_000,
        backward: bool,
    ) {
        motors!(motors, told, 1);
        motors.set_limits(Axis::X, limits(speed, accel));
        let speed = i32::try_from(speed).unwrap();
        motors.run(Axis::X, if backward { -speed } else { speed }).unwrap();
        for _ in 0..moment / ROUND {
            motors.poll();
            motors.engine().pass(ROUND);
        }
        motors.engine().pass(moment % ROUND);
        let before = motors.engine().report(0).position;
        prop_assert!((before - net(&told, 0)).abs() <= 1);
        let moved = !motors.engine().is_idle(0);
        motors.kill(Axis::X);
        let at = motors.engine().report(0).position;
        prop_assert_eq!(at, net(&told, 0));
        prop_assert!(!motors.is_moving(Axis::X));
        prop_assert_eq!(motors.position(Axis::X), if moved { None } else { Some(at) });
        motors.engine().pass(1_000_000);
        prop_assert_eq!(at, net(&told, 0));
        motors.set_position(Axis::X, at).unwrap();
        motors.move_to(Axis::X, 100).unwrap();
        finish!(motors);
        prop_assert_eq!(net(&told, 0), 100);
        prop_assert_eq!(motors.late(), 0);
        keeps_times(&told, 0);
    }

    /// A stop brakes behind what is planned, and counts; and so does a change of target.
    #[test]
    fn a_soft_stop_is_the_planners(
        speed in 500u32..250_000, accel in 5_000u32..2_000_000, moment in 1u32..4_000, back: bool,
    ) {
        motors!(motors, told, 1);
        motors.set_limits(Axis::X, limits(speed, accel));
        motors.move_to(Axis::X, 1_000_000_000).unwrap();
        for _ in 0..moment {
            motors.poll();
            motors.engine().pass(ROUND);
        }
        let from = net(&told, 0);
        let seen = motors.position(Axis::X).unwrap();
        prop_assert!((seen - from).abs() <= 1, "{} for {}", seen, from);
        if back {
            motors.retarget(Axis::X, 7).unwrap();
        } else {
            motors.stop(Axis::X);
        }
        finish!(motors);
        let to = net(&told, 0);
        prop_assert_eq!(motors.position(Axis::X), Some(to));
        prop_assert_eq!(motors.late(), 0);
        keeps_times(&told, 0);
        if back {
            prop_assert_eq!(to, 7);
        } else {
            // What is planned ahead, a run, and the way to brake.
            let (speed, accel) = (f64::from(speed), f64::from(accel));
            let most = speed * 0.03 + speed * speed / accel / 2.0 + 10.0;
            prop_assert!(((to - from) as f64) < most, "{} steps, not {}", to - from, most);
        }
    }
}

#[test]
fn axes_of_a_line_start_and_end_together() {
    motors!(motors, told, 4);
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        motors.set_limits(axis, limits(250_000, 1_000_000));
    }
    motors.move_line_to([(Axis::X, 30_000), (Axis::Y, -12_000), (Axis::Z, 30_000)]).unwrap();
    finish!(motors);
    assert_eq!([0, 1, 2].map(|axis| net(&told, axis)), [30_000, -12_000, 30_000]);
    let last = |axis| {
        let edges = told.borrow();
        edges.iter().rfind(|edge| edge.axis == axis && edge.step.is_some()).unwrap().at as i64
    };
    assert_eq!(last(0), last(2));
    assert!((last(0) - last(1)).abs() < 3_000, "{} {}", last(0), last(1));
    assert_eq!(motors.late(), 0);
}

#[test]
fn a_main_loop_that_is_away_runs_it_dry_once() {
    motors!(motors, told, 1);
    motors.set_limits(Axis::X, limits(100_000, 1_000_000));
    motors.run(Axis::X, 100_000).unwrap();
    for _ in 0..3_000 {
        motors.poll();
        motors.engine().pass(ROUND);
    }
    // 5 ms are planned ahead.
    motors.engine().pass(625_000);
    motors.poll();
    assert_eq!(motors.late(), 0);
    for _ in 0..100 {
        motors.poll();
        motors.engine().pass(ROUND);
    }
    // A second is not.
    motors.engine().pass(125_000_000);
    for _ in 0..3_000 {
        motors.poll();
        motors.engine().pass(ROUND);
    }
    assert_eq!(motors.late(), 1);
    motors.stop(Axis::X);
    finish!(motors);
    assert_eq!(motors.position(Axis::X), Some(net(&told, 0)));
    assert_eq!(motors.late(), 1);
    motors.clear_late();
    assert_eq!(motors.late(), 0);
    keeps_times(&told, 0);
}

/// A program that queues runs of its own may turn on the way: DIR is held and set up all the same.
#[test]
fn a_turn_between_two_runs_keeps_hold_and_setup() {
    let told = Told::default();
    let mut queue = Queue::<8>::new();
    let (mut feed, entries) = queue.split();
    let model = ModelPlayer::<1, _>::new(|edge| told.borrow_mut().push(edge));
    let mut engine = SinkEngine::new(model, [entries], board::<1>().timing, BOUND);
    feed.set_open(true);
    for run in [Run::steady(1_000, 9), Run::turn(300, false), Run::steady(200, 1)] {
        feed.push(run).unwrap();
    }
    feed.push(Run::steady(1_000, 4)).unwrap();
    feed.set_open(false);
    engine.start(1);
    for _ in 0..200 {
        engine.pass(100);
    }
    assert_eq!((engine.report(0).position, engine.is_idle(0), engine.late()), (4, true, 0));
    assert_eq!(net(&told, 0), 4);
    keeps_times(&told, 0);
    let turned = told.borrow().iter().filter(|edge| edge.step.is_none()).count();
    assert_eq!(turned, 1);
}

/// Waits of a stream are told piece by piece, shortly before they begin: the player has run dry long before
/// the next step is known. An axis that begins with them is started for its first step, later than others.
#[test]
fn waits_that_are_told_piece_by_piece_keep_their_time() {
    let entry = |pins, events, ticks: u32| {
        let (groups, growth, interval) = (1, 0, ticks << 16);
        (EntryParts { pins, then: pins, events, groups, interval, growth }.entry(), events * ticks)
    };
    let (wait, steps) = (|ticks| entry(0, 1, ticks), |n, ticks| entry(WIRING.step, n, ticks));
    let lists = [
        [vec![wait(10_000), steps(4, 1_000)], vec![wait(20_000); 5], vec![steps(3, 1_000)]]
            .concat(),
        [vec![wait(10_000); 6], vec![steps(3, 700), wait(30_000), steps(1, 700)]].concat(),
    ];
    let told = Told::default();
    let mut queues = [const { Queue::<8>::new() }; 2];
    let [x, y] = queues.each_mut().map(Queue::split);
    let model = ModelPlayer::<2, _>::new(|edge| told.borrow_mut().push(edge));
    let mut engine = SinkEngine::new(model, [x.1, y.1], board::<2>().timing, BOUND);
    let mut feeds = [x.0, y.0];
    let (mut next, mut at) = ([0; 2], [0; 2]);
    // DIR has been held for long.
    engine.pass(1_000);
    for now in (0..200_000).step_by(500) {
        for (n, feed) in feeds.iter_mut().enumerate() {
            if now == 0 {
                feed.set_open(true);
            }
            while let Some((entry, lasts)) = lists[n].get(next[n]).filter(|_| at[n] < now + 4_000) {
                assert!(feed.put(*entry));
                (next[n], at[n]) = (next[n] + 1, at[n] + lasts);
            }
            if next[n] == lists[n].len() {
                feed.set_open(false);
            }
        }
        if now == 0 {
            engine.start(0b11);
        }
        engine.refill();
        engine.pass(500);
    }
    let wanted = [
        vec![10_000, 11_000, 12_000, 13_000, 114_000, 115_000, 116_000],
        vec![60_000, 60_700, 61_400, 92_100],
    ];
    for (axis, wanted) in (0..2).zip(wanted) {
        let edges = told.borrow();
        let made = edges.iter().filter(|edge| edge.axis == axis && edge.step.is_some());
        let off = made.zip(&wanted).map(|(edge, wanted)| edge.at as i64 - 1_000 - wanted);
        assert!(off.clone().count() == wanted.len(), "axis {axis}");
        assert!(
            off.clone().all(|off| off.abs() <= 2),
            "axis {axis}: {:?}",
            off.collect::<Vec<_>>()
        );
        assert_eq!(net(&told, axis), wanted.len() as i64);
        assert!(engine.is_idle(axis));
    }
    assert_eq!(engine.late(), 0);
}

#[test]
fn an_axis_that_there_is_not_rests() {
    motors!(motors, _told, 1);
    let engine = motors.engine();
    assert!(engine.is_idle(3) && engine.report(3).position == 0);
    engine.start(0xF0);
    engine.kill(0xF0);
    engine.set_position(7, 3);
    engine.pass(1_000);
    assert!(engine.is_idle(0));
}

/// DIR changes no sooner than the hold time behind the last step before a kill.
#[test]
fn a_turn_behind_a_kill_waits_for_hold() {
    motors!(motors, told, 1);
    motors.set_limits(Axis::X, limits(100_000, 2_000_000));
    motors.run(Axis::X, 100_000).unwrap();
    for _ in 0..200 {
        motors.poll();
        motors.engine().pass(ROUND);
    }
    let made = net(&told, 0);
    while net(&told, 0) == made {
        motors.engine().pass(1);
    }
    motors.kill(Axis::X);
    motors.set_position(Axis::X, 0).unwrap();
    motors.move_to(Axis::X, -10).unwrap();
    while motors.any_moving() {
        motors.poll();
        motors.engine().pass(10);
    }
    assert_eq!(net(&told, 0), made + 1 - 10);
    keeps_times(&told, 0);
}
