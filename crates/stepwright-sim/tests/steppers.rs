//! The motors as a program uses them: random calls, checked by the edges alone, and refusals.

use proptest::prelude::*;
use stepwright::profile::Unfit;
use stepwright::{
    Accel, Axis, AxisLimits, AxisSet, Board, Jerk, MoveError, OutOfRange, Rate, Refusal, Speed,
};
use stepwright_sim::{
    Description, Edge, Pin, Queues, VirtualSteppers, virtual_steppers, virtual_steppers_of,
};

type Motors<'q> = VirtualSteppers<'q, Vec<Edge>>;

const MILLI: u32 = 16_000;
/// Ticks per second.
const HZ: f64 = 16e6;

fn limits(speed: u32, accel: u32) -> AxisLimits {
    AxisLimits::new(Speed::from_steps(speed).unwrap(), Accel::from_steps(accel).unwrap())
}

fn with_motors(test: impl FnOnce(&mut Motors)) {
    let mut queues = Queues::default();
    test(&mut virtual_steppers(&mut queues, Description::uno(), Vec::new()));
}

/// A main loop that calls `poll` only when `poll` has asked for it.
fn pass(motors: &mut Motors, mut ticks: u32) {
    loop {
        let wait = match motors.poll() {
            Some(wait) => wait.min(ticks),
            None => ticks,
        };
        motors.engine().pass(wait);
        ticks -= wait;
        if ticks == 0 {
            break;
        }
    }
}

fn rest(motors: &mut Motors) {
    for _ in 0..100_000 {
        if !motors.any_moving() {
            return;
        }
        pass(motors, MILLI);
    }
    panic!("it moves for 100 s");
}

// ---- Random calls ----

#[derive(Clone, Debug)]
enum Call {
    Limits(usize, u32, u32, u32),
    MoveTo(usize, i64),
    MoveBy(usize, i32),
    Line(Vec<i64>),
    Run(usize, i32),
    Retarget(usize, i64),
    Stop(u8),
    Halt(u8),
    Set(usize, i64),
    Rest,
}

fn call() -> impl Strategy<Value = Call> {
    let axis = 0..3usize;
    let place = prop_oneof![-3_000..3_000i64, Just(0), (1i64 << 40)..(1 << 40) + 500];
    prop_oneof![
        1 => (axis.clone(), 50..9_000u32, 200..90_000u32, 0..300u32)
            .prop_map(|(axis, speed, accel, start)| Call::Limits(axis, speed, accel, start)),
        3 => (axis.clone(), place.clone()).prop_map(|(axis, to)| Call::MoveTo(axis, to)),
        2 => (axis.clone(), -900..900).prop_map(|(axis, by)| Call::MoveBy(axis, by)),
        2 => prop::collection::vec(-2_000..2_000i64, 3).prop_map(Call::Line),
        2 => (axis.clone(), -9_000..9_000).prop_map(|(axis, speed)| Call::Run(axis, speed)),
        3 => (axis.clone(), -3_000..3_000i64).prop_map(|(axis, to)| Call::Retarget(axis, to)),
        1 => (0..8u8).prop_map(Call::Stop),
        1 => (0..8u8).prop_map(Call::Halt),
        1 => (axis, place).prop_map(|(axis, at)| Call::Set(axis, at)),
        2 => Just(Call::Rest),
    ]
}

/// An axis, as a reader of the documentation expects it.
#[derive(Clone, Copy, Debug, Default)]
struct Model {
    /// The steps by the edges.
    counted: i64,
    forward: bool,
    /// The offset that `set_position` has added.
    offset: i64,
    unknown: bool,
    moving: bool,
    /// The end of the present move; `None` for a run and for a stop.
    target: Option<i64>,
    run: Option<bool>,
}

impl Model {
    fn position(&self) -> i64 {
        self.counted + self.offset
    }

    fn goes(&mut self, target: i64) {
        self.moving = target != self.position();
        self.target = Some(target);
        self.run = None;
    }
}

const BUSY: MoveError = MoveError::Refused(Refusal::Busy);
const LONG: MoveError = MoveError::Refused(Refusal::Unfit(Unfit::TooLong));

fn reachable(from: i64, to: i64) -> bool {
    (to - from).abs() < 1 << 31
}

fn expected_move(model: &Model, target: i64) -> Result<(), MoveError> {
    match () {
        () if model.moving => Err(BUSY),
        () if model.unknown => Err(MoveError::PositionUnknown),
        () if !reachable(model.position(), target) => Err(LONG),
        () => Ok(()),
    }
}

struct Story<'a, 'q> {
    motors: &'a mut Motors<'q>,
    models: [Model; 3],
    /// The positions at which the present travels began.
    begun: [i64; 3],
}

impl Story<'_, '_> {
    /// Counts the steps since the last look, and compares everything that the motors report.
    fn look(&mut self) {
        for edge in std::mem::take(self.motors.engine().recorder()) {
            let model = &mut self.models[usize::from(edge.axis)];
            match edge.pin {
                Pin::Direction => model.forward = edge.level,
                Pin::Step if edge.level => {
                    assert!(model.moving, "axis {} steps at {}", edge.axis, edge.time);
                    model.counted += if model.forward { 1 } else { -1 };
                }
                _ => {}
            }
        }
        for (axis, model) in Axis::all().zip(&mut self.models) {
            if model.moving && !self.motors.is_moving(axis) {
                model.moving = false;
                assert_eq!(model.run, None, "a run has ended by itself");
                if let Some(target) = model.target {
                    assert_eq!(model.position(), target, "{axis:?} rests elsewhere");
                }
            }
            assert_eq!(model.moving, self.motors.is_moving(axis), "{axis:?}");
            let told = self.motors.position(axis);
            assert_eq!(told, (!model.unknown).then(|| model.position()), "{axis:?}");
            let left = self.motors.distance_to_go(axis);
            match (model.moving, model.run, model.target) {
                (false, ..) => assert_eq!(left, Some(0)),
                (true, Some(_), _) => assert_eq!(left, None),
                (true, None, Some(target)) => assert_eq!(left, Some(target - model.position())),
                // A stop ends where it can; its end is known from now on.
                (true, None, None) => model.target = left.map(|left| model.position() + left),
            }
        }
        assert_eq!(self.motors.late(), 0, "late steps");
    }

    fn make(&mut self, call: &Call) {
        let nth = |index: usize| Axis::<3>::new(index).unwrap();
        let at = |story: &Self, index: usize| story.models[index].position();
        match *call {
            Call::Limits(index, speed, accel, start) => {
                let start = Speed::from_steps(start).unwrap();
                self.motors.set_limits(nth(index), limits(speed, accel).start_speed(start));
            }
            Call::MoveTo(index, target) => {
                let wanted = expected_move(&self.models[index], target);
                assert_eq!(self.motors.move_to(nth(index), target), wanted, "{call:?}");
                if wanted.is_ok() {
                    self.begun[index] = at(self, index);
                    self.models[index].goes(target);
                }
            }
            Call::MoveBy(index, by) => {
                let wanted = if self.models[index].moving { Err(BUSY) } else { Ok(()) };
                assert_eq!(self.motors.move_by(nth(index), by), wanted, "{call:?}");
                if wanted.is_ok() {
                    self.begun[index] = at(self, index);
                    let target = self.begun[index] + i64::from(by);
                    self.models[index].goes(target);
                }
            }
            Call::Line(ref ends) => {
                let ends = Axis::all().zip(ends.iter().copied());
                let mut each = ends.clone().zip(&self.models);
                let wanted = each.try_for_each(|((_, end), model)| expected_move(model, end));
                assert_eq!(self.motors.move_line_to(ends.clone()), wanted, "{call:?}");
                if wanted.is_ok() {
                    for (axis, end) in ends {
                        self.begun[axis.index()] = at(self, axis.index());
                        self.models[axis.index()].goes(end);
                    }
                }
            }
            Call::Run(index, speed) => {
                let result = self.motors.run(nth(index), speed);
                let top = self.motors.limits(nth(index)).max_speed;
                let model = &mut self.models[index];
                if speed == 0 {
                    assert_eq!(result, Ok(()));
                    (model.run, model.target) = (None, model.target.filter(|_| !model.moving));
                } else if speed.unsigned_abs() > top.steps() {
                    assert_eq!(result, Err(MoveError::AboveLimit { max: top }));
                } else if model.run == Some(speed > 0) && model.moving {
                    // Below the start speed with which the run began it can't go on.
                    let below = MoveError::Refused(Refusal::Unfit(Unfit::BelowStart));
                    let gentle = MoveError::Refused(Refusal::Unfit(Unfit::TooGentle));
                    assert!([Ok(()), Err(below), Err(gentle)].contains(&result), "{result:?}");
                } else if model.moving {
                    assert_eq!(result, Err(BUSY));
                } else {
                    assert_eq!(result, Ok(()));
                    self.begun[index] = model.position();
                    (model.moving, model.target, model.run) = (true, None, Some(speed > 0));
                }
            }
            Call::Retarget(index, target) => {
                let result = self.motors.retarget(nth(index), target);
                let begun = self.begun[index];
                let model = &mut self.models[index];
                if !model.moving {
                    assert_eq!(result, Err(MoveError::Refused(Refusal::Resting)));
                } else if model.unknown {
                    assert_eq!(result, Err(MoveError::PositionUnknown));
                } else if !reachable(begun, target) {
                    assert_eq!(result, Err(LONG));
                } else {
                    assert_eq!(result, Ok(()));
                    (model.target, model.run) = (Some(target), None);
                }
            }
            Call::Stop(bits) => {
                let set = AxisSet::from_bits(bits);
                self.motors.stop(set);
                for axis in set.iter() {
                    let model = &mut self.models[axis.index()];
                    (model.target, model.run) = (None, None);
                }
            }
            Call::Halt(bits) => {
                let set = AxisSet::from_bits(bits);
                let stepped: Vec<_> = set.iter().map(|axis| at(self, axis.index())).collect();
                self.motors.kill(set);
                for (axis, before) in set.iter().zip(stepped) {
                    assert!(!self.motors.is_moving(axis), "{axis:?} moves after a kill");
                    let unknown = self.motors.position(axis).is_none();
                    let model = &mut self.models[axis.index()];
                    // An order that had not reached the engine has moved nothing.
                    let may_rest =
                        !model.unknown && model.moving && before == self.begun[axis.index()];
                    assert!(unknown == (model.moving || model.unknown) || may_rest);
                    model.unknown = unknown;
                    (model.moving, model.target, model.run) = (false, None, None);
                }
            }
            Call::Set(index, position) => {
                let wanted = if self.models[index].moving { Err(BUSY) } else { Ok(()) };
                assert_eq!(self.motors.set_position(nth(index), position), wanted);
                if wanted.is_ok() {
                    let model = &mut self.models[index];
                    model.offset = position - model.counted;
                    model.unknown = false;
                }
            }
            Call::Rest => {
                // An axis of a line may be slow, and may get a far target.
                for _ in 0..5_000 {
                    if self.motors.any_moving() {
                        pass(self.motors, MILLI);
                    }
                }
                self.look();
                self.make(&Call::Stop(AxisSet::<3>::ALL.bits()));
                rest(self.motors);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// For all calls, and any time of motion in between: the position of a motor agrees with its edges, a move
    /// ends on its target, and no step is late, though `poll` is called no more often than it asks.
    #[test]
    fn motors_are_where_they_say(calls in prop::collection::vec((call(), 0..400_000u32), 1..25)) {
        with_motors(|motors| {
            let mut story = Story { motors, models: [Model::default(); 3], begun: [0; 3] };
            story.look();
            for (call, ticks) in &calls {
                story.make(call);
                story.look();
                pass(story.motors, *ticks);
                story.look();
            }
            story.make(&Call::Rest);
            story.look();
        });
    }

    /// On a line each axis keeps its own limits of speed and acceleration, and all axes begin and end together.
    /// (Three ramps of up to some 41,000 steps/s² are admitted.)
    #[test]
    fn a_line_keeps_the_limits_of_each(
        ends in prop::array::uniform3(-4_000..4_000i64),
        speeds in prop::array::uniform3(200..8_000u32),
        accels in prop::array::uniform3(1_000..40_000u32),
    ) {
        with_motors(|motors| {
            for (axis, (speed, accel)) in Axis::all().zip(speeds.into_iter().zip(accels)) {
                motors.set_limits(axis, limits(speed, accel));
            }
            motors.move_line_to(Axis::all().zip(ends)).unwrap();
            rest(motors);
            let edges = std::mem::take(motors.engine().recorder());
            let mut spans = Vec::new();
            for (axis, end) in Axis::all().zip(ends) {
                let steps = edges.iter().filter(|edge| usize::from(edge.axis) == axis.index());
                let times: Vec<u64> = steps.filter(|edge| edge.is_step()).map(|edge| edge.time).collect();
                assert_eq!(motors.position(axis), Some(end));
                assert_eq!(times.len() as u64, end.unsigned_abs());
                let top = f64::from(speeds[axis.index()]);
                for pair in times.windows(2) {
                    // A run is kept to 1 µs, an edge to a tick.
                    let least = HZ / top - 40.0;
                    assert!((pair[1] - pair[0]) as f64 >= least, "{axis:?} at {}", pair[0]);
                }
                // From rest n steps take at least √(2n/a), and so do the last n steps.
                for n in [10, 100, 1_000].into_iter().filter(|n| 2 * n < times.len()) {
                    let least = (2.0 * n as f64 / f64::from(accels[axis.index()])).sqrt() * HZ;
                    let (up, down) = (times[n] - times[0], times[times.len() - 1] - times[times.len() - 1 - n]);
                    assert!(up.min(down) as f64 >= least - 100.0, "{axis:?}: {up} and {down}, {least}");
                }
                if times.len() > 20 {
                    spans.push((times[0], times[times.len() - 1]));
                }
            }
            for pair in spans.windows(2) {
                assert!(pair[0].0.abs_diff(pair[1].0) < 200, "{spans:?}");
                let length = (pair[0].1 - pair[0].0) as f64;
                // The slowest axis has 20 steps: speeds are rounded to 0.001 steps/s.
                assert!(pair[0].1.abs_diff(pair[1].1) as f64 <= 0.002 * length + 200.0, "{spans:?}");
            }
        });
    }
}

// ---- What is said ----

#[test]
fn a_position_has_64_bits() {
    with_motors(|motors| {
        motors.set_position(Axis::X, i64::MAX - 5).unwrap();
        assert_eq!(motors.move_by(Axis::X, 6), Err(LONG));
        motors.move_by(Axis::X, 5).unwrap();
        rest(motors);
        assert_eq!(motors.position(Axis::X), Some(i64::MAX));
        motors.move_to(Axis::X, i64::MAX - 300).unwrap();
        rest(motors);
        assert_eq!(motors.position(Axis::X), Some(i64::MAX - 300));
        motors.set_position(Axis::X, i64::MIN).unwrap();
        assert_eq!(motors.move_by(Axis::X, -1), Err(LONG));
        assert_eq!(motors.move_to(Axis::X, i64::MAX), Err(LONG));
        motors.move_to(Axis::X, i64::MIN + 7).unwrap();
        rest(motors);
        assert_eq!(motors.position(Axis::X), Some(i64::MIN + 7));
    });
}

#[test]
fn what_can_not_be_done_is_refused_with_what_can() {
    with_motors(|motors| {
        let say = |result: Result<(), MoveError>| result.unwrap_err().to_string();
        assert_eq!(
            say(motors.run(Axis::X, 501)),
            "above the limit of this axis: at most 500 steps/s; raise max_speed"
        );
        assert_eq!(say(motors.run(Axis::X, i32::MIN)), "speed out of range: 0 to 1000000 steps/s");
        motors.set_limits(Axis::X, limits(200_000, 1_000_000));
        assert_eq!(
            say(motors.run(Axis::X, -200_000)),
            "too fast for this board: at most 128000 steps/s for this axis now"
        );
        assert_eq!(
            say(motors.move_to(Axis::X, 1 << 31)),
            "too many steps: at most 2147483647 in a travel"
        );
        assert_eq!(say(motors.move_by(Axis::X, i32::MIN)), say(motors.move_to(Axis::X, 1 << 31)));
        assert_eq!(
            say(motors.retarget(Axis::X, 5)),
            "the axis is at rest: there is no travel to change; move it"
        );
        assert_eq!(
            say(motors.move_line_to([(Axis::X, 5), (Axis::Y, 2), (Axis::X, 7)])),
            "an axis is named twice: name each axis of a line once"
        );
        motors.set_limits(Axis::X, limits(1_000, 10_000));
        assert!(!motors.any_moving());
        motors.run(Axis::X, 800).unwrap();
        assert_eq!(
            say(motors.set_position(Axis::X, 0)),
            "the axis is still moving: wait, stop it first, or retarget it"
        );
        assert_eq!(motors.run(Axis::X, -800), Err(BUSY));
        assert_eq!(motors.move_line_to([(Axis::Y, 5), (Axis::X, 5)]), Err(BUSY));
        pass(motors, 100 * MILLI);
        motors.kill(Axis::X);
        assert_eq!(
            say(motors.move_to(Axis::X, 0)),
            "the position is not known: set it with set_position, or move by a distance"
        );
        motors.move_by(Axis::X, 40).unwrap();
        assert_eq!(motors.retarget(Axis::X, 0), Err(MoveError::PositionUnknown));
        rest(motors);
        let out = |result: Result<_, OutOfRange>| result.map(|_| ()).unwrap_err();
        let range = MoveError::from(out(Speed::from_steps(1_000_001)));
        assert_eq!(range.to_string(), "speed out of range: 0 to 1000000 steps/s");
    });
}

/// Every axis has the default limits of the documentation.
#[test]
fn limits_are_the_defaults_until_they_are_set() {
    with_motors(|motors| {
        for axis in Axis::all() {
            assert_eq!(motors.limits(axis), limits(500, 1_000));
        }
        let set = limits(900, 8_000)
            .deceleration(Accel::from_steps(4_000).unwrap())
            .jerk(Jerk::from_steps(100_000).unwrap());
        motors.set_limits(Axis::Y, set);
        assert_eq!((motors.limits(Axis::Y), motors.limits(Axis::Z)), (set, AxisLimits::DEFAULT));
        // Up in 0.5 s over 125 steps, at 500 steps/s until 875, and down.
        motors.move_to(Axis::X, 1_000).unwrap();
        rest(motors);
        let edges = motors.engine().recorder();
        let times: Vec<u64> = edges.iter().filter(|e| e.is_step()).map(|e| e.time).collect();
        let seconds = |from: usize, to: usize| (times[to] - times[from]) as f64 / HZ;
        assert!((seconds(0, 125) - 0.5).abs() < 0.001, "{}", seconds(0, 125));
        assert!((seconds(300, 700) - 0.8).abs() < 0.000_1, "{}", seconds(300, 700));
    });
}

/// A run has its requested speed, also if that changes while it runs, and brakes when it is told to stop.
#[test]
fn a_run_has_the_speed_it_was_told() {
    with_motors(|motors| {
        motors.set_limits(Axis::Z, limits(4_000, 40_000));
        let speed = |motors: &mut Motors| {
            let before = motors.position(Axis::Z).unwrap();
            pass(motors, 500 * MILLI);
            2 * (motors.position(Axis::Z).unwrap() - before)
        };
        motors.run(Axis::Z, -2_000).unwrap();
        pass(motors, 200 * MILLI);
        assert!((-2_002..=-1_998).contains(&speed(motors)));
        motors.run(Axis::Z, -3_000).unwrap();
        pass(motors, 200 * MILLI);
        assert!((-3_002..=-2_998).contains(&speed(motors)));
        assert_eq!(motors.distance_to_go(Axis::Z), None);
        motors.stop(AxisSet::ALL);
        // v²/2d, and the steps that were planned ahead.
        let left = motors.distance_to_go(Axis::Z).unwrap();
        assert!((-240..=-112).contains(&left), "{left}");
        let end = motors.position(Axis::Z).unwrap() + left;
        rest(motors);
        assert_eq!(motors.position(Axis::Z), Some(end));
    });
}

/// Speed and acceleration change on the way, once the planned steps have been made: checked by the intervals of
/// the edges. The move still ends on its target.
#[test]
fn a_move_takes_another_speed_and_acceleration_on_the_way() {
    with_motors(|motors| {
        let (v, a) = (|v| Speed::from_steps(v).unwrap(), |a| Accel::from_steps(a).unwrap());
        motors.set_limits(Axis::X, limits(4_000, 20_000));
        assert_eq!(motors.set_top_speed(Axis::X, v(1)), Err(MoveError::Refused(Refusal::Resting)));
        motors.move_to(Axis::X, 9_000).unwrap();
        pass(motors, 300 * MILLI);
        // Down to 1,000 steps/s at 20,000 steps/s²: 150 ms, and 24 ms of planned steps.
        motors.set_top_speed(Axis::X, v(1_000)).unwrap();
        pass(motors, 400 * MILLI);
        // Up again, with a tenth of the acceleration: 1.5 s. Then down to rest with a quarter of it.
        motors.set_acceleration(Axis::X, a(2_000)).unwrap();
        motors.set_deceleration(Axis::X, a(5_000)).unwrap();
        motors.set_top_speed(Axis::X, v(4_000)).unwrap();
        rest(motors);
        assert_eq!((motors.position(Axis::X), motors.late()), (Some(9_000), 0));
        let edges = motors.engine().recorder();
        let times: Vec<f64> =
            edges.iter().filter(|e| e.is_step()).map(|e| e.time as f64 / HZ).collect();
        assert_eq!(times.len(), 9_000);
        // The mean speed of 20 steps, at their middle.
        let speeds: Vec<(f64, f64)> =
            times.windows(21).map(|w| ((w[0] + w[20]) / 2.0, 20.0 / (w[20] - w[0]))).collect();
        let at = |time: f64| speeds.iter().find(|(middle, _)| *middle >= time).unwrap().1;
        let near = |time: f64, speed: f64| {
            assert!((at(time) - speed).abs() < speed / 500.0, "{} at {time} s", at(time));
        };
        near(0.29, 4_000.0);
        near(0.52, 1_000.0);
        near(0.69, 1_000.0);
        // After at most 24 ms it speeds up by 2,000 steps/s².
        let gain = (at(1.7) - at(0.9)) / 0.8;
        assert!((gain - 2_000.0).abs() < 20.0, "{gain} steps/s²");
        // It slows down by 5,000 steps/s² at the end: v² over the last 400 steps.
        let square = |n: usize| (20.0 / (times[n] - times[n - 20])).powi(2);
        let loss = (square(8_600) - square(8_900)) / 2.0 / 300.0;
        assert!((loss - 5_000.0).abs() < 50.0, "{loss} steps/s²");
        // Above a limit nothing changes.
        motors.run(Axis::X, 1_000).unwrap();
        assert_eq!(
            motors.set_top_speed(Axis::X, v(4_001)),
            Err(MoveError::AboveLimit { max: v(4_000) })
        );
        let steep = |limit| Err(MoveError::TooSteep { limit, max: a(20_000) });
        assert_eq!(motors.set_acceleration(Axis::X, a(20_001)), steep("acceleration"));
        assert_eq!(motors.set_deceleration(Axis::X, a(20_001)), steep("deceleration"));
        let said = motors.set_acceleration(Axis::X, a(20_001)).unwrap_err().to_string();
        assert_eq!(
            said,
            "above the acceleration of this axis: at most 20000 steps/s²; raise its limit"
        );
    });
}

/// A main loop that sleeps for the time that `poll` returns makes no step late, also on fast timers, where a
/// run of slow steps needs more entries than a queue has room for.
#[test]
fn who_sleeps_for_as_long_as_poll_says_is_never_late() {
    for hz in [16_000_000, 42_000_000, 84_000_000, 200_000_000] {
        for speed in [300, 1_291, 2_000, 8_000] {
            let rate = Rate::from_hz(hz).unwrap();
            let plain = Description { assembly: false, ..Description::uno() };
            let description = Description { board: Board::unmeasured(rate), grid: [1; 3], ..plain };
            let mut queues = Queues::default();
            let mut motors = virtual_steppers_of::<u32, _>(&mut queues, description, ());
            motors.set_limits(Axis::X, limits(speed, 1_000));
            motors.move_by(Axis::X, 6_000).unwrap();
            while motors.is_moving(Axis::X) {
                let wait = motors.poll().unwrap_or(hz / 1_000);
                motors.engine().pass(wait);
            }
            assert_eq!(motors.late(), 0, "{speed} steps/s at {hz} Hz");
        }
    }
}

/// An axis that makes a single step of a line keeps its own limits, also if it gets another target on the way.
#[test]
fn the_single_step_of_a_line_keeps_the_limits_of_its_axis() {
    for start in [0, 20] {
        with_motors(|motors| {
            let own = limits(40, 30).start_speed(Speed::from_steps(start).unwrap());
            motors.set_limits(Axis::X, own);
            motors.set_limits(Axis::Y, limits(4_000, 20_000));
            motors.move_line_to([(Axis::X, 1), (Axis::Y, 2_000)]).unwrap();
            motors.retarget(Axis::X, 60).unwrap();
            rest(motors);
            assert_eq!(motors.position(Axis::X), Some(60));
            let edges = motors.engine().recorder();
            let steps = edges.iter().filter(|edge| edge.is_step() && edge.axis == 0);
            let times: Vec<f64> = steps.map(|edge| edge.time as f64 / HZ).collect();
            let speeds: Vec<f64> = times.windows(2).map(|pair| 1.0 / (pair[1] - pair[0])).collect();
            let fastest = speeds.iter().copied().fold(0.0, f64::max);
            assert!((39.9..40.01).contains(&fastest), "{fastest} steps/s");
            let gain = |three: &[f64]| {
                let [first, second] = [three[1] - three[0], three[2] - three[1]];
                (1.0 / second - 1.0 / first) / ((first + second) / 2.0)
            };
            // The first steps are on a ramp from rest, whose mean acceleration is less.
            let steepest = times.windows(3).map(gain).fold(0.0, f64::max);
            assert!(steepest < 30.1, "{steepest} steps/s²");
        });
    }
}
