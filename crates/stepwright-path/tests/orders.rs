//! Changes of a route that are ordered while it is made, for the present time of the route.

use crate::jobs::AXIS;
use stepwright_path::{AxisPace, Route};

/// No limit of the jerk, and a limit.
const JERKS: [f64; 2] = [f64::INFINITY, 10_000.0];

fn route(jerk: f64) -> Route<2> {
    Route::new([AxisPace { jerk, ..AXIS }; 2]).unwrap()
}

/// A line along the first axis, closed.
fn line(jerk: f64, to: f64) -> Route<2> {
    let mut route = route(jerk);
    route.line_to([to, 0.0], 50.0).unwrap();
    route.close();
    route
}

/// Curves and corners, closed. A change here often has to be tried again.
fn curves(jerk: f64) -> Route<2> {
    let mut route = route(jerk);
    for n in 1..=200 {
        let x = 0.2 * f64::from(n);
        route.line_to([x, 4.0 * (x / 3.0).sin()], 80.0).unwrap();
    }
    for n in 0..8 {
        let [x, y] = route.end();
        let sweep = if n % 2 == 0 { 3.1 } else { -3.1 };
        route.arc([0, 1], [x + 3.0, y], sweep, [0.0; 2], 60.0).unwrap();
        let [x, y] = route.end();
        route.line_to([x + 4.0, y + 1.0], 100.0).unwrap();
        route.line_to([x + 4.3, y - 0.2 * f64::from(n)], 100.0).unwrap();
    }
    route.close();
    route
}

/// Takes the steps up to a time. Returns the time of the last step.
fn up_to(route: &mut Route<2>, time: f64) -> f64 {
    route.by_ref().find(|step| step.time > time).expect("a step").time
}

fn drain(route: &mut Route<2>) -> usize {
    route.by_ref().count()
}

/// The end of a hold does not overtake a hold that has to be tried again. The route would rest for ever.
#[test]
fn a_resume_does_not_overtake_a_hold() {
    let made = curves(10_000.0);
    for n in 0..120 {
        for at_once in [false, true] {
            let mut route = made.clone();
            let mut now = up_to(&mut route, 0.02 + 0.033 * f64::from(n));
            route.hold(if at_once { 0.0 } else { now });
            for step in route.by_ref().take(3) {
                now = step.time;
            }
            route.resume(if at_once { 0.0 } else { now });
            drain(&mut route);
            assert!(route.is_over(), "held at {now}, at once {at_once}: {}", route.is_held());
        }
    }
}

/// Of two overrides the later one stays in force.
#[test]
fn an_override_does_not_overtake_another() {
    let made = curves(10_000.0);
    for n in 0..40 {
        let mut route = made.clone();
        let mut now = up_to(&mut route, 0.1 + 0.05 * f64::from(n));
        route.scale(now, 1.5).unwrap();
        for step in route.by_ref().take(3) {
            now = step.time;
        }
        route.scale(now, 0.9).unwrap();
        let mut feed = 0.0;
        while let Some(stretch) = route.pass_over() {
            feed = stretch.feed;
        }
        assert!((feed - 90.0).abs() < 1e-9, "{now}: ordered {feed}");
    }
}

/// A hold after an override that has to be tried again stops as soon as without the override.
#[test]
fn a_hold_does_not_wait_for_an_override() {
    let made = curves(10_000.0);
    for n in 0..40 {
        let mut route = made.clone();
        let now = up_to(&mut route, 0.1 + 0.05 * f64::from(n));
        let mut alone = route.clone();
        alone.hold(now);
        drain(&mut alone);
        route.scale(now, 0.9).unwrap();
        route.hold(now);
        drain(&mut route);
        assert!(alone.is_held() && route.is_held());
        let late = route.time() - alone.time();
        assert!(late < 0.02, "ordered at {now}: {late} s later");
        // Both are in force then.
        route.resume(0.0);
        let mut feed = 0.0;
        while let Some(stretch) = route.pass_over() {
            feed = stretch.feed;
        }
        assert!(route.is_over() && (feed - 90.0).abs() < 1e-9, "{now}: ordered {feed}");
    }
}

/// A cancellation of a route that is over does not affect the next move.
#[test]
fn a_cancel_of_a_route_that_is_over_is_nothing() {
    for jerk in JERKS {
        // Cancelled at once; before its end, but too late to brake; after its end, during a rest.
        for (early, late) in [(None, 0.0), (Some(1e-7), 0.0), (None, 0.2)] {
            let mut route = line(jerk, 10.0);
            let end = end_of(&route);
            if let Some(early) = early {
                route.cancel(end - early);
            }
            assert_eq!(drain(&mut route), 800, "{jerk} {early:?}");
            if early.is_none() {
                route.cancel(route.time() + late);
            }
            assert!(route.dwell(2.0 * late));
            route.line_to([20.0, 0.0], 50.0).unwrap();
            route.close();
            assert_eq!((drain(&mut route), route.positions()), (800, [1_600, 0]), "{jerk} {late}");
        }
        // A cancellation for later applies to the move at that time.
        let mut route = line(jerk, 10.0);
        drain(&mut route);
        route.cancel(route.time() + 0.1);
        route.line_to([20.0, 0.0], 50.0).unwrap();
        route.close();
        assert!(drain(&mut route) < 800);
        // A hold applies to the next move.
        let mut route = line(jerk, 10.0);
        drain(&mut route);
        route.hold(route.time());
        route.line_to([20.0, 0.0], 50.0).unwrap();
        route.close();
        assert!(drain(&mut route) == 0 && route.is_held());
    }
}

/// The time of the end.
fn end_of(route: &Route<2>) -> f64 {
    let mut route = route.clone();
    while route.pass_over().is_some() {}
    route.time()
}

/// A change that is ordered for a time after the end of a hold waits during the hold.
#[test]
fn what_is_to_come_waits_while_it_stands() {
    for jerk in JERKS {
        let mut route = line(jerk, 1_000.0);
        route.hold(1.0);
        route.scale(5.0, 0.1).unwrap();
        drain(&mut route);
        route.resume(2.0);
        for (time, speed) in [(3.0, 50.0), (6.0, 5.0)] {
            let at = up_to(&mut route, time);
            let moves = AXIS.step / (route.next().unwrap().time - at);
            assert!((moves - speed).abs() < 1e-6, "{jerk}: {moves} mm/s at {time} s");
        }

        let mut route = line(jerk, 1_000.0);
        route.hold(1.0);
        route.hold(10.0);
        drain(&mut route);
        route.resume(2.0);
        drain(&mut route);
        assert!(route.is_held() && route.time() > 10.0, "{jerk}: {}", route.time());
    }
}

/// A change at an infinite time never comes.
#[test]
fn times_stay_finite() {
    for jerk in JERKS {
        let mut route = line(jerk, 10.0);
        route.hold(0.1);
        drain(&mut route);
        route.resume(f64::INFINITY);
        route.cancel(f64::INFINITY);
        assert_eq!(drain(&mut route), 0);
        assert!(route.is_held() && route.time().is_finite());
        route.resume(f64::NEG_INFINITY);
        drain(&mut route);
        assert!(route.is_over() && route.time().is_finite(), "{jerk}");
    }
}
