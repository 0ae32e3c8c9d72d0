//! How long the queued steps last.

use super::*;
use crate::queue::{Next, Queue, Source};

#[test]
fn what_is_queued_lasts_as_long_as_its_runs() {
    let horizon = Horizon::new(256_000);
    let mut queue = Queue::<8>::new();
    let (mut feed, mut engine) = queue.split();
    let mut motor = Motor::<8>::IDLE;
    assert_eq!(motor.spans(&feed), (0, 0));
    // Round the queue's places many times; a run of k + 1 units each.
    for k in 0..300u32 {
        let unit = k % 20 + 1;
        let span = horizon.span((unit << horizon.unit) - 1);
        motor.push(&mut feed, &Run::steady(2000, 1), span);
        // The previous entry has been played.
        let last = if k == 0 { 0 } else { (k - 1) % 20 + 1 };
        let (present, behind) = motor.spans(&feed);
        assert_eq!(u32::from(present + behind), unit + last, "run {k}");
        assert!(matches!(engine.take(), Next::Entry(_)));
    }
    engine.clear(true);
    assert_eq!(motor.spans(&feed), (0, 0));
}

/// The interrupt may move on to the next entry between two reads: here it does so when it is asked
/// for the rest of the present entry, which is a short wait. After it come a step of 58 units and
/// one of 40, so that nothing should be planned.
#[test]
fn nothing_is_planned_behind_a_long_step_that_begins_meanwhile() {
    let horizon = Horizon::new(256_000);
    let mut queue = Queue::<8>::new();
    let (mut feed, mut engine) = queue.split();
    let mut motor = Motor::<8> { leg: Leg::Open, ..Motor::IDLE };
    for units in [1, 58, 40] {
        motor.push(&mut feed, &Run::steady(2000, 1), units);
    }
    assert!(matches!(engine.take(), Next::Entry(_)));
    let mut goes_on = || {
        assert!(matches!(engine.take(), Next::Entry(_)));
        Playing::Left(100)
    };
    assert_eq!(motor.wants(&mut feed, &horizon, &mut goes_on), u8::MAX);
    assert_eq!(motor.spans(&feed), (58, 40));
}

#[test]
fn what_lasts_for_long_counts_as_long() {
    let horizon = Horizon::new(256_000);
    let mut queue = Queue::<8>::new();
    let (mut feed, mut engine) = queue.split();
    let mut motor = Motor::<8>::IDLE;
    for _ in 0..3 {
        motor.push(&mut feed, &Run::steady(2000, 1), horizon.span(200 << horizon.unit));
    }
    assert_eq!(motor.spans(&feed), (85, 170));
    // The first of them has been played to its end.
    assert!(matches!((engine.take(), engine.take()), (Next::Entry(_), Next::Entry(_))));
    assert_eq!(motor.spans(&feed), (85, 85));
}
