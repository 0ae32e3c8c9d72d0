//! Moves that have ended before their futures are polled, and futures dropped at each poll.

use std::future::Future;
use std::pin::pin;
use std::task::Poll;

use crate::bench::{Moved, with};
use stepwright::Axis;
use stepwright_embassy::Outcome;

/// Plays `deed` when X has come to rest at 100, before the future of that move is polled. Returns
/// the outcome of that future.
fn hears(deed: impl AsyncFnOnce(&Moved<'_>)) -> Outcome {
    with(|bench, motors| {
        let heard = std::cell::Cell::new(None);
        let other = async {
            bench.after(1).await;
            assert_eq!(motors.axis(Axis::X).rest().await, Some(100));
            assert_eq!(heard.get(), None, "the other task comes first");
            deed(motors).await;
        };
        let own = async { heard.set(motors.axis(Axis::X).move_to(100).await.ok()) };
        bench.run(motors, [Box::pin(other) as _, Box::pin(own) as _]);
        heard.get().unwrap()
    })
}

/// Whichever of two tasks is polled first at the end of a move, the axis is free.
#[test]
fn an_axis_is_free_once_it_rests() {
    let heard = hears(async |motors| {
        let back = motors.axis(Axis::X).move_to(40).await;
        assert_eq!(back, Ok(Outcome::Reached { at: 40 }));
    });
    assert_eq!(heard, Outcome::Reached { at: 100 });
}

/// A move that another follows at once wakes its future at its own end, not at that of the other.
#[test]
fn the_end_of_a_move_is_heard_before_that_of_the_next() {
    with(|bench, motors| {
        let own = async {
            let end = motors.axis(Axis::X).move_to(100).await;
            assert_eq!(end, Ok(Outcome::Stopped { at: 0 }));
            assert!(motors.axis(Axis::X).is_moving(), "the next one goes on");
        };
        let next = async {
            // Before the first step, and before the planner has seen the end.
            motors.kill(Axis::X);
            let moved = motors.with(|steppers| steppers.move_to(Axis::X, 2_000));
            assert_eq!(moved, Some(Ok(())));
        };
        bench.run(motors, [Box::pin(own) as _, Box::pin(next) as _]);
    });
}

/// A task that waits for motion sleeps until an axis moves.
#[test]
fn the_next_move_of_an_axis_is_awaited() {
    with(|bench, motors| {
        let seen = std::cell::Cell::new(None);
        let watch = async {
            motors.motion(Axis::X | Axis::Y).await;
            seen.set(Some(bench.time.now()));
            assert!(motors.axis(Axis::Y).is_moving());
            motors.motion(Axis::Y).await; // it moves
        };
        let moves = async {
            _ = motors.axis(Axis::Z).move_to(50).await;
            bench.after(1_000).await;
            assert_eq!(seen.get(), None, "Z is none of them");
            let began = bench.time.now();
            assert!(motors.axis(Axis::Y).move_to(50).await.is_ok());
            assert_eq!(seen.get(), Some(began));
        };
        bench.run(motors, [Box::pin(watch) as _, Box::pin(moves) as _]);
    });
}

/// The outcome is that at the end of the move.
#[test]
fn what_is_changed_after_a_move_does_not_change_its_outcome() {
    let reached = Outcome::Reached { at: 100 };
    assert_eq!(hears(async |motors| motors.axis(Axis::X).set_position(0).unwrap()), reached);
    assert_eq!(hears(async |motors| motors.axis(Axis::X).mark_unknown()), reached);
    assert_eq!(hears(async |motors| motors.fault(Axis::X)), reached);
}

/// Polls a future this many times at most, and drops it. Returns whether it has ended.
async fn polled(times: usize, future: impl Future) -> bool {
    let (mut future, mut left) = (pin!(future), times);
    std::future::poll_fn(move |context| {
        if left == 0 {
            return Poll::Ready(false);
        }
        left -= 1;
        let ended = future.as_mut().poll(context).is_ready();
        if left == 0 {
            // The drop comes at once, not with the next event.
            context.waker().wake_by_ref();
        }
        if ended { Poll::Ready(true) } else { Poll::Pending }
    })
    .await
}

/// Drops a story at each of its polls: the axis brakes, its position is that of the pins, and it
/// moves again.
fn dropped_anywhere(story: impl AsyncFn(&Moved<'_>)) {
    for times in 0..1_000 {
        let mut ended = false;
        with(|bench, motors| {
            let task = async {
                ended = polled(times, story(motors)).await;
                let mut x = motors.axis(Axis::X);
                let at = x.rest().await;
                assert_eq!(at, Some(bench.shafts.borrow().at[0]), "{times} polls");
                assert_eq!(x.move_to(7).await, Ok(Outcome::Reached { at: 7 }), "{times} polls");
            };
            bench.run(motors, [Box::pin(task) as _]);
            assert_eq!((bench.shafts.borrow().at[0], motors.late()), (7, 0));
        });
        if ended {
            assert!(times > 1);
            return;
        }
    }
    panic!("no end");
}

#[test]
fn futures_are_dropped_at_each_poll() {
    dropped_anywhere(async |motors| {
        let mut x = motors.axis(Axis::X);
        _ = x.move_to(300).await;
        _ = x.move_by(-500).await;
        _ = polled(1, x.run(900)).await;
        _ = x.move_to(0).await; // waits for the braking
    });
    dropped_anywhere(async |motors| {
        let mut x = motors.axis(Axis::X);
        _ = polled(1, x.run(-900)).await;
        x.stop().await;
        motors.with(|steppers| steppers.run(Axis::X, 300)).unwrap().unwrap();
        x.stop().await;
    });
}
