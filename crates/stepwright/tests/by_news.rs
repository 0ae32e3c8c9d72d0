//! A planner that is called only at news and at orders.

use stepwright::{Accel, Axis, AxisLimits, Board, ByNews, Speed, Steppers};
use stepwright_sim::{Description, Edge, Queues, SimEngine, virtual_engine, virtual_steppers_of};

type Motors<'q> = Steppers<'q, ByNews<SimEngine<'q, Vec<Edge>, u32>>, 3>;

/// Lets motors plan at the order, and then whenever the engine has news, until they rest or this
/// many ticks have passed. Returns how often there was news.
fn carry_out(motors: &mut Motors, ticks: u32) -> usize {
    let (mut news, end) = (0, motors.engine().inner().now() + u64::from(ticks));
    loop {
        while motors.plan() {}
        if !motors.any_moving() {
            return news;
        }
        let left = end.saturating_sub(motors.engine().inner().now()) as u32;
        if left == 0 || !motors.engine().inner().sleep(left) {
            return news;
        }
        news += 1;
    }
}

fn with<R>(play: impl FnOnce(&mut Motors, Board<3>) -> R) -> R {
    let mut queues = Queues::default();
    let (engine, feeds, board) = virtual_engine(&mut queues, Description::uno(), Vec::new());
    play(&mut Steppers::new(ByNews::new(engine, &board), feeds, board), board)
}

/// Intervals from far below the horizon of 16 ms to far above it, and around it.
#[test]
fn no_step_is_late_whatever_the_speed() {
    for speed in [3_000, 200, 130, 90, 75, 70, 66, 64, 63, 62, 60, 58, 40, 30, 20, 7, 2, 1] {
        with(|motors, _| {
            let limits = AxisLimits::new(Speed::from_steps(speed).unwrap(), Accel::of::<1_000>());
            motors.set_limits(Axis::X, limits);
            motors.move_to(Axis::X, 40).unwrap();
            carry_out(motors, u32::MAX);
            assert_eq!((motors.position(Axis::X), motors.late()), (Some(40), 0), "{speed}");
        });
    }
}

/// The steps that an axis makes after a stop that comes 2 s after the start of a run.
fn steps_after_a_stop(speed: i32) -> i64 {
    with(|motors, _| {
        motors.run(Axis::X, speed).unwrap();
        carry_out(motors, 2 * 16_000_000);
        let before = motors.position(Axis::X).unwrap();
        motors.stop(Axis::X);
        carry_out(motors, u32::MAX);
        assert!(!motors.any_moving());
        motors.position(Axis::X).unwrap() - before
    })
}

/// The same with a planner that is called every millisecond.
fn steps_after_a_stop_with_a_clock(speed: i32) -> i64 {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers_of::<u32, _>(&mut queues, Description::uno(), ());
    motors.run(Axis::X, speed).unwrap();
    let mut before = None;
    for ms in 0.. {
        while motors.plan() {}
        if ms == 2_000 {
            before = motors.position(Axis::X);
            motors.stop(Axis::X);
        }
        if !motors.any_moving() {
            break;
        }
        motors.engine().pass(16_000);
    }
    motors.position(Axis::X).unwrap() - before.unwrap()
}

/// A stop takes effect after the queued steps: one step later than with a clock if the interval is
/// longer than the horizon, and otherwise at most another horizon later.
#[test]
fn a_slow_axis_stops_one_step_later() {
    for speed in [2, 5, 30, 50, 57, 60, 62, 64, 70, 90, 200, 499] {
        let (news, clock) = (steps_after_a_stop(speed), steps_after_a_stop_with_a_clock(speed));
        println!("{speed} steps/s: {news} steps, {clock} with a clock");
        let horizon = i64::from(speed) * 16 / 1_000;
        assert!(news <= clock + 1 + horizon, "{speed}: {news}, {clock}");
    }
}

/// Three axes of different speeds: exact, and with no more news than there can be entries.
#[test]
fn three_axes_arrive() {
    with(|motors, _| {
        for (axis, speed) in Axis::all().zip([3_000, 333, 5]) {
            let limits = AxisLimits::new(Speed::from_steps(speed).unwrap(), Accel::of::<4_000>());
            motors.set_limits(axis, limits);
        }
        for (axis, target) in Axis::all().zip([9_000, -900, 12]) {
            motors.move_to(axis, target).unwrap();
        }
        carry_out(motors, u32::MAX);
        let at = [Axis::X, Axis::Y, Axis::Z].map(|axis| motors.position(axis));
        assert_eq!((at, motors.late()), ([Some(9_000), Some(-900), Some(12)], 0));
        let edges = motors.engine().inner().recorder();
        let steps = [0, 1, 2].map(|n| edges.iter().filter(|e| e.axis == n && e.is_step()).count());
        assert_eq!(steps, [9_000, 900, 12]);
    });
}
