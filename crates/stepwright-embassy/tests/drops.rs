//! Futures dropped late or from unexpected places, and moves by `with` after them.

use std::cell::RefCell;
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Wake, Waker};

use crate::bench::{leaked, with};
use embassy_futures::select::{Either, select};
use stepwright::{Axis, MoveError, Refusal};
use stepwright_embassy::Outcome;

/// After an axis has come to rest, it no longer counts as braking, whoever moves it next.
#[test]
fn an_axis_that_with_runs_is_busy_though_a_future_was_dropped_before() {
    with(|bench, motors| {
        let story = async {
            let mut x = motors.axis(Axis::X);
            assert!(matches!(select(x.run(1_000), bench.after(200)).await, Either::Second(())));
            x.rest().await;
            assert_eq!(motors.with(|steppers| steppers.run(Axis::X, 500)), Some(Ok(())));
            let moved = select(x.move_to(3), bench.after(2_000)).await;
            let busy = Err(MoveError::Refused(Refusal::Busy));
            assert!(matches!(&moved, Either::First(end) if *end == busy), "{moved:?}");
            motors.stop();
        };
        bench.run(motors, [Box::pin(story) as _]);
    });
}

/// A move by `with` belongs to no future, even if the future of an ended move has not seen its end
/// yet.
#[test]
fn a_move_of_with_is_not_braked_by_the_drop_of_a_future_whose_move_has_ended() {
    with(|bench, motors| {
        let story = async {
            let x = motors.axis(Axis::X);
            let mut owner = motors.axis(Axis::X);
            let mut ended = Box::pin(owner.move_to(100));
            assert!(matches!(select(&mut ended, bench.after(1)).await, Either::Second(())));
            assert_eq!(x.rest().await, Some(100));
            assert_eq!(motors.with(|steppers| steppers.move_to(Axis::X, 2_000)), Some(Ok(())));
            bench.after(100).await;
            drop(ended);
            assert_eq!(x.rest().await, Some(2_000));
        };
        bench.run(motors, [Box::pin(story) as _]);
    });
}

/// That future still gets the outcome of its own move.
#[test]
fn a_future_hears_of_its_own_move_behind_which_with_has_begun_another() {
    with(|bench, motors| {
        let story = async {
            let x = motors.axis(Axis::X);
            let mut owner = motors.axis(Axis::X);
            let mut ended = Box::pin(owner.move_to(100));
            assert!(matches!(select(&mut ended, bench.after(1)).await, Either::Second(())));
            assert_eq!(x.rest().await, Some(100));
            assert_eq!(motors.with(|steppers| steppers.move_to(Axis::X, 2_000)), Some(Ok(())));
            assert_eq!(ended.await, Ok(Outcome::Reached { at: 100 }));
            assert!(x.is_moving());
            assert_eq!(x.rest().await, Some(2_000));
        };
        bench.run(motors, [Box::pin(story) as _]);
    });
}

thread_local! {
    /// A task that only its waker owns.
    static TASK: RefCell<Option<Pin<Box<dyn Future<Output = ()>>>>> = const { RefCell::new(None) };
}

/// Drops its task when woken.
struct Ends;

impl Wake for Ends {
    fn wake(self: Arc<Self>) {
        drop(TASK.take());
    }
}

/// The planner wakes a task, which ends through that: its axis brakes.
#[test]
fn a_future_that_its_waker_drops_brakes() {
    let (bench, motors) = leaked();
    let story = async {
        let (mut x, y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
        assert_eq!(motors.with(|steppers| steppers.move_to(Axis::Y, 200)), Some(Ok(())));
        let mut task: Pin<Box<dyn Future<Output = ()>>> = Box::pin(async move {
            select(x.run(1_000), y.rest()).await;
        });
        let waker = Waker::from(Arc::new(Ends));
        assert!(task.as_mut().poll(&mut Context::from_waker(&waker)).is_pending());
        TASK.set(Some(task));
        bench.after(1_500).await;
        assert!(TASK.take().is_none(), "Y has come to rest");
        let (x, at) = (motors.axis(Axis::X), bench.shafts.borrow().at);
        assert!(!x.is_moving(), "X goes on: {at:?}");
        assert!((50..400).contains(&at[0]) && x.position() == Some(at[0]), "{at:?}");
    };
    bench.run(motors, [Box::pin(story) as _]);
}
