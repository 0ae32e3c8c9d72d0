//! Moves that are awaited, changed, dropped and joined, checked at the pins.

use crate::bench::{AXES, Handle, with};
use embassy_futures::join::join;
use embassy_futures::select::{Either, select};
use stepwright::{Accel, Axis, AxisLimits, AxisSet, MoveError, Refusal, Speed};
use stepwright_embassy::{AsyncAxis, Outcome};

#[test]
fn a_move_is_awaited() {
    with(|bench, motors| {
        bench.run(
            motors,
            [Box::pin(async {
                let mut x = motors.axis(Axis::X);
                assert_eq!(x.move_to(8_000).await, Ok(Outcome::Reached { at: 8_000 }));
                assert_eq!(x.move_by(-500).await, Ok(Outcome::Reached { at: 7_500 }));
                // Already there.
                assert_eq!(x.move_to(7_500).await, Ok(Outcome::Reached { at: 7_500 }));
                let far = x.move_to(1 << 40).await;
                assert!(matches!(far, Err(MoveError::Refused(Refusal::Unfit(_)))), "{far:?}");
            }) as _],
        );
        assert_eq!((bench.shafts.borrow().at, motors.late()), ([7_500, 0, 0], 0));
    });
}

#[test]
fn axes_are_joined() {
    with(|bench, motors| {
        bench.run(
            motors,
            [Box::pin(async {
                let (mut x, mut y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
                let both = join(x.move_to(800), y.move_to(-300)).await;
                let reached = |at| Ok(Outcome::Reached { at });
                assert_eq!(both, (reached(800), reached(-300)));
            }) as _],
        );
        assert_eq!(bench.shafts.borrow().at, [800, -300, 0]);
    });
}

/// The loser brakes with its own deceleration, and its position stays known.
#[test]
fn the_loser_of_a_select_brakes() {
    with(|bench, motors| {
        bench.run(
            motors,
            [Box::pin(async {
                let (mut x, mut y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
                let first = select(x.move_to(100_000), y.move_to(100)).await;
                assert!(
                    matches!(first, Either::Second(Ok(Outcome::Reached { at: 100 }))),
                    "{first:?}"
                );
                assert!(x.is_moving());
                let at = x.rest().await;
                assert_eq!(at, x.position());
                assert!(at.is_some_and(|at| (101..2_000).contains(&at)), "{at:?}");
            }) as _],
        );
        let shafts = bench.shafts.borrow();
        assert_eq!(motors.axis(Axis::X).position(), Some(shafts.at[0]));
        let steps = &shafts.steps[0];
        let last = steps[steps.len() - 1] - steps[steps.len() - 2];
        // At 20,000 steps/s² the last interval is (√2 − 1)·√(2/a), 4.1 ms; at speed it is 0.5 ms.
        assert!(last > 3_000, "{last} µs: it did not brake");
    });
}

/// A move after a dropped one begins when the axis rests; an awaited move is not taken over.
#[test]
fn a_move_waits_for_the_braking_of_a_dropped_one_alone() {
    with(|bench, motors| {
        let other = async {
            bench.after(5).await;
            let busy = motors.axis(Axis::X).move_to(3).await;
            assert_eq!(busy, Err(MoveError::Refused(Refusal::Busy)));
        };
        let own = async {
            let mut x = motors.axis(Axis::X);
            select(x.move_to(9_000), bench.after(300)).await;
            assert!(x.is_moving());
            assert_eq!(x.move_to(0).await, Ok(Outcome::Reached { at: 0 }));
        };
        bench.run(motors, [Box::pin(own) as _, Box::pin(other) as _]);
        assert_eq!((bench.shafts.borrow().at[0], motors.late()), (0, 0));
    });
}

/// Also while the motors are borrowed by `with`.
#[test]
fn a_future_that_is_dropped_within_with_brakes() {
    with(|bench, motors| {
        let drop_it = async {
            let mut x = motors.axis(Axis::X);
            let mut run = Box::pin(x.run(1_000));
            assert!(matches!(select(&mut run, bench.after(200)).await, Either::Second(())));
            let outer = motors.with(|_| drop(run));
            assert_eq!(outer, Some(()));
            let at = x.rest().await;
            assert!(at.is_some_and(|at| (150..300).contains(&at)), "{at:?}");
            assert_eq!(x.move_to(0).await, Ok(Outcome::Reached { at: 0 }));
        };
        bench.run(motors, [Box::pin(drop_it) as _]);
    });
}

/// A future that is not polled moves nothing.
#[test]
fn a_future_that_was_never_polled_moves_nothing() {
    with(|bench, motors| {
        drop(motors.axis(Axis::X).move_to(100));
        bench.run(motors, []);
        assert_eq!(bench.shafts.borrow().at, [0; AXES]);
    });
}

#[test]
fn an_awaited_move_has_another_target_and_another_top_speed() {
    with(|bench, motors| {
        let move_it = async {
            let mut x = motors.axis(Axis::X);
            assert_eq!(x.move_to(4_000).await, Ok(Outcome::Reached { at: 1_000 }));
        };
        let change_it = async {
            let x = motors.axis(Axis::X);
            bench.after(400).await;
            x.set_top_speed(Speed::of::<1_000>()).unwrap();
            bench.after(200).await;
            x.retarget(1_000).unwrap();
            assert!(x.set_top_speed(Speed::of::<2_001>()).is_err());
        };
        bench.run(motors, [Box::pin(move_it) as _, Box::pin(change_it) as _]);
        let shafts = bench.shafts.borrow();
        assert_eq!(shafts.at[0], 1_000);
        let at = |ms: u64| shafts.steps[0].iter().filter(|time| **time < ms * 1_000).count();
        // 2,000 steps/s after 100 ms; from 450 ms on 1,000.
        assert!((198..=202).contains(&(at(390) - at(290))), "{}", at(390) - at(290));
        assert!((99..=101).contains(&(at(600) - at(500))), "{}", at(600) - at(500));
    });
}

#[test]
fn a_run_is_stopped_by_another_handle() {
    with(|bench, motors| {
        let turn = async {
            let outcome = motors.axis(Axis::Y).run(-1_500).await;
            let at = motors.axis(Axis::Y).position().unwrap();
            assert_eq!(outcome, Ok(Outcome::Stopped { at }));
        };
        let stop = async {
            bench.after(700).await;
            let mut y = motors.axis(Axis::Y);
            let at = y.stop().await;
            assert!(at.is_some_and(|at| (-1_150..-900).contains(&at)), "{at:?}");
            // Stopping an axis at rest changes nothing.
            assert_eq!(y.stop().await, at);
        };
        bench.run(motors, [Box::pin(turn) as _, Box::pin(stop) as _]);
        assert_eq!(Some(bench.shafts.borrow().at[1]), motors.axis(Axis::Y).position());
    });
}

/// A fault brakes along the ramp, a kill stops at once; both make the position unknown until it is
/// set.
#[test]
fn a_fault_and_a_kill_leave_the_position_unknown() {
    with(|bench, motors| {
        let moves = async {
            let (mut x, mut y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
            let both = join(x.move_to(9_000), y.move_to(9_000)).await;
            assert_eq!(both, (Ok(Outcome::Uncertain), Ok(Outcome::Uncertain)));
            assert_eq!(x.move_to(0).await, Err(MoveError::PositionUnknown));
            assert_eq!(x.move_by(-10).await, Ok(Outcome::Uncertain));
            x.set_position(7).unwrap();
            assert_eq!(x.move_to(0).await, Ok(Outcome::Reached { at: 0 }));
        };
        let fault = async {
            bench.after(300).await;
            motors.fault(Axis::X);
            motors.kill(Axis::Y);
            let made = bench.shafts.borrow().steps.each_ref().map(Vec::len);
            bench.after(1).await;
            let after = bench.shafts.borrow().steps.each_ref().map(Vec::len);
            assert!(after[0] > made[0] && after[1] == made[1], "{made:?}, {after:?}");
        };
        bench.run(motors, [Box::pin(moves) as _, Box::pin(fault) as _]);
        let shafts = bench.shafts.borrow();
        let first = &shafts.steps[0][..600];
        assert!(first.windows(2).all(|two| two[1] - two[0] >= 490), "no jolt");
    });
}

/// A move ordered by `with` has no future that could be dropped and brake it.
#[test]
fn what_was_ordered_without_a_future_goes_on() {
    with(|bench, motors| {
        let line = async {
            let line =
                motors.with(|steppers| steppers.move_line_to([(Axis::X, 300), (Axis::Z, -900)]));
            assert_eq!(line, Some(Ok(())));
            assert_eq!(motors.with(|_| motors.with(|_| ())), Some(None));
            assert_eq!(
                join(motors.axis(Axis::X).rest(), motors.axis(Axis::Z).rest()).await,
                (Some(300), Some(-900))
            );
        };
        bench.run(motors, [Box::pin(line) as _]);
        assert_eq!(bench.shafts.borrow().at, [300, 0, -900]);
    });
}

/// Four tasks wait for one axis, and the executor sleeps meanwhile.
#[test]
fn many_wait_for_one_axis() {
    with(|bench, motors| {
        let seen = std::cell::Cell::new(0);
        let seen = &seen;
        let wait = || async move {
            bench.after(50).await;
            assert_eq!(motors.axis(Axis::X).rest().await, Some(500));
            seen.set(seen.get() + 1);
        };
        let waiters = (0..3).map(|_| Box::pin(wait()) as _);
        let mover = Box::pin(async { _ = motors.axis(Axis::X).move_to(500).await }) as _;
        bench.run(motors, waiters.chain([mover]));
        assert_eq!(seen.get(), 3);
    });
}

/// News ends the executor's sleep at most twice more than a move has entries; at rest it does not
/// wake.
#[test]
fn it_wakes_no_more_than_twice_beside_the_entries() {
    for (speed, accel, target) in
        [(2_000, 20_000, 8_000), (9_000, 100_000, 30_000), (300, 500, -700), (5, 1_000, 20)]
    {
        with(|bench, motors| {
            let limits = AxisLimits::new(
                Speed::from_steps(speed).unwrap(),
                Accel::from_steps(accel).unwrap(),
            );
            motors.axis(Axis::X).set_limits(limits);
            bench.run(
                motors,
                [Box::pin(async {
                    assert!(motors.axis(Axis::X).move_to(target).await.is_ok());
                    // Nothing moves for an hour.
                    let (wakings, entries) = (bench.wakings.get(), bench.entries.get());
                    println!("{target} steps: {wakings} wakings, {entries} entries");
                    // The order wakes the planner once more.
                    assert!(entries > 2 && wakings < entries + 2, "{wakings}, {entries}");
                    bench.after(3_600_000).await;
                    assert_eq!(bench.wakings.get(), wakings);
                }) as _],
            );
            assert_eq!((bench.shafts.borrow().at[0], motors.late()), (target, 0));
        });
    }
}

/// The same for three axes at once, and for one move after another: at most one waking per entry,
/// and two per move.
#[test]
fn several_axes_wake_no_more_than_their_entries_and_two_a_move() {
    with(|bench, motors| {
        let orders = [(800, 3_000, 1_600), (1_200, 4_000, 2_400), (500, 2_000, -700)];
        let moves = std::cell::Cell::new(0);
        let moves = &moves;
        let walk = |axis, (speed, accel, target): (u32, u32, i64)| async move {
            let limits = AxisLimits::new(
                Speed::from_steps(speed).unwrap(),
                Accel::from_steps(accel).unwrap(),
            );
            motors.axis(axis).set_limits(limits);
            for to in [target, target / 3, -target, 0] {
                let end = motors.axis(axis).move_to(to).await;
                assert_eq!(end, Ok(Outcome::Reached { at: to }));
                moves.set(moves.get() + 1);
            }
        };
        let tasks = Axis::all().zip(orders).map(|(axis, order)| Box::pin(walk(axis, order)) as _);
        bench.run(motors, tasks);
        let (wakings, entries) = (bench.wakings.get(), bench.entries.get());
        println!("{} moves: {wakings} wakings, {entries} entries", moves.get());
        assert_eq!((moves.get(), motors.late()), (12, 0));
        assert!(entries > 100 && wakings <= entries + 2 * moves.get(), "{wakings}, {entries}");
    });
}

/// Stopping all axes stops each.
#[test]
fn all_are_stopped() {
    with(|bench, motors| {
        let turn = |axis| async move { _ = motors.axis(axis).run(1_000).await };
        let stop = async {
            bench.after(200).await;
            motors.stop();
        };
        let turns = Axis::all().map(|axis| Box::pin(turn(axis)) as _);
        bench.run(motors, turns.chain([Box::pin(stop) as _]));
        let at = bench.shafts.borrow().at;
        assert!(at.iter().all(|at| (150..300).contains(at)), "{at:?}");
        assert_eq!(motors.with(|steppers| steppers.any_moving()), Some(false));
        motors.kill(AxisSet::ALL);
        assert_eq!(motors.axis(Axis::X).position(), Some(at[0]), "at rest a kill loses nothing");
    });
}

/// Time at rest counts if the program says so: the next move of a slow axis begins at once.
#[test]
fn a_slow_axis_waits_before_a_move_unless_its_rest_is_counted() {
    for counted in [false, true] {
        with(|bench, motors| {
            let limits = AxisLimits::new(Speed::of::<20>(), Accel::of::<10>());
            motors.axis(Axis::X).set_limits(limits);
            let moves = async {
                let mut x = motors.axis(Axis::X);
                assert!(x.move_to(20).await.is_ok());
                motors.with(|steppers| steppers.count_rest(0)); // it is seen at rest
                bench.after(2_000).await;
                if counted {
                    motors.with(|steppers| steppers.count_rest(2_000_000));
                }
                let ordered = bench.time.now();
                assert!(x.move_to(0).await.is_ok());
                let first = bench.shafts.borrow().steps[0][20] - ordered;
                // √(2/a) is 447 ms.
                assert!(if counted { first < 1_000 } else { first > 400_000 }, "{first} µs");
            };
            bench.run(motors, [Box::pin(moves) as _]);
        });
    }
}

/// The excerpt of docs/first-move.md.
async fn home(
    x: &mut AsyncAxis<'_, '_, Handle<'_>, AXES>,
    closed: impl Future<Output = ()>,
    open: impl Future<Output = ()>,
) -> Result<(), MoveError> {
    if let Either::First(end) = select(x.run(-1_000), closed).await {
        return end.map(drop); // refused, or stopped by another task
    } // else the run is dropped, and brakes
    x.rest().await;
    if let Either::First(end) = select(x.run(100), open).await {
        return end.map(drop);
    }
    x.rest().await;
    x.set_position(0)?;
    Ok(())
}

/// An axis that can't run now is not homed where it stands.
#[test]
fn an_axis_is_homed_by_a_switch() {
    with(|bench, motors| {
        let homed = async {
            let mut x = motors.axis(Axis::X);
            assert_eq!(home(&mut x, bench.after(700), bench.after(900)).await, Ok(()));
            assert_eq!(x.position(), Some(0));
            let made = bench.shafts.borrow().at[0];
            assert!((-800..-500).contains(&made), "{made}");
            x.set_limits(AxisLimits::new(Speed::of::<500>(), Accel::of::<9_000>()));
            let refused = home(&mut x, bench.after(1), bench.after(1)).await;
            assert!(matches!(refused, Err(MoveError::AboveLimit { .. })), "{refused:?}");
        };
        bench.run(motors, [Box::pin(homed) as _]);
    });
}
