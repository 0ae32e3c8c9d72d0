//! Changes of a route at known times: an override, a hold and its end, a cancelled jog.

use crate::judge::{Axis, jump_needed};
use stepwright_path::{AxisPace, Route, Unplannable};

const AXIS: AxisPace =
    AxisPace { step: 0.01, speed: 400.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

/// 100 mm at 100 mm/s, in two pieces: 1.1 s.
fn route() -> Route<2> {
    let mut route = Route::new([AXIS; 2]).unwrap();
    route.line_to([30.0, 0.0], 100.0).unwrap();
    route.line_to([100.0, 0.0], 100.0).unwrap();
    route.close();
    route
}

/// The number of steps up to each of these times, and the time of the end.
fn counts(route: &mut Route<2>, times: &[f64]) -> (Vec<usize>, f64) {
    let steps: Vec<f64> = route.by_ref().map(|step| step.time).collect();
    let count = |t: &f64| steps.iter().filter(|step| *step <= t).count();
    (times.iter().map(count).collect(), route.time())
}

#[test]
fn a_line_by_hand() {
    let (counts, end) = counts(&mut route(), &[0.1, 0.55, 1.0, 1.1]);
    assert!((end - 1.1).abs() < 1e-9, "{end}");
    assert_eq!(counts, [500, 5_000, 9_500, 10_000]);
}

#[test]
fn a_hold_brakes_stands_and_goes_on() {
    let mut route = route();
    route.hold(0.55);
    // No more steps until it is resumed: 50 mm, and 5 mm of braking.
    assert_eq!(counts(&mut route, &[0.55, 0.65, 9.0]).0, [5_000, 5_500, 5_500]);
    assert!(route.is_held() && !route.is_over());
    route.resume(3.0);
    // 45 mm from rest to rest.
    let (rest, end) = counts(&mut route, &[3.0, 3.1]);
    assert!((end - 3.55).abs() < 1e-9, "{end}");
    assert_eq!((rest, route.positions(), route.is_over()), (vec![0, 500], [10_000, 0], true));
}

#[test]
fn an_override_takes_hold_at_its_time() {
    let mut route = route();
    route.scale(0.55, 0.5).unwrap();
    // From 100 to 50 mm/s in 0.05 s over 3.75 mm; then 45 mm at 50 mm/s, and 1.25 mm of braking.
    let (counts, end) = counts(&mut route, &[0.55, 0.6]);
    assert!((end - (0.55 + 0.05 + 0.9 + 0.05)).abs() < 1e-9, "{end}");
    assert_eq!(counts, [5_000, 5_375]);
    assert_eq!(route.scale(0.0, f64::NAN), Err(Unplannable::Scale));
}

#[test]
fn an_override_stays_within_the_axes() {
    // 300 mm/s are ordered; the axes can do 400.
    let mut route = Route::new([AXIS; 2]).unwrap();
    route.line_to([1_000.0, 0.0], 300.0).unwrap();
    route.scale(0.0, 2.0).unwrap();
    route.close();
    let (_, end) = counts(&mut route, &[]);
    assert!((end - (1_000.0 / 400.0 + 0.4)).abs() < 1e-9, "{end}");
}

#[test]
fn a_jog_is_cancelled_and_goes_home() {
    let mut route = Route::new([AXIS; 2]).unwrap();
    route.line_to([1e6, 0.0], 100.0).unwrap();
    route.close();
    route.cancel(0.55);
    assert_eq!(counts(&mut route, &[]).0.len(), 0);
    assert!(route.is_over());
    assert!((route.end()[0] - 55.0).abs() < 1e-9 && route.positions() == [5_500, 0]);
    assert!((route.time() - 0.65).abs() < 1e-9);
    route.line_to([0.0, 0.0], 100.0).unwrap();
    route.close();
    counts(&mut route, &[]);
    assert_eq!((route.positions(), route.is_over()), ([0, 0], true));
}

#[test]
fn pieces_that_come_late_are_taken_from_rest() {
    let mut route = route();
    counts(&mut route, &[]);
    route.line_to([100.0, 50.0], 100.0).unwrap();
    route.close();
    assert_eq!(counts(&mut route, &[]).0.len(), 0);
    assert_eq!(route.positions(), [10_000, 5_000]);
    assert!((route.time() - 1.7).abs() < 1e-9);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let wrong = |axis: AxisPace| Route::new([axis]).unwrap_err();
    assert_eq!(wrong(AxisPace { step: 0.0, ..AXIS }), Unplannable::Step);
    assert_eq!(wrong(AxisPace { speed: f64::NAN, ..AXIS }), Unplannable::Speed);
    assert_eq!(wrong(AxisPace { accel: -1.0, ..AXIS }), Unplannable::Accel);
    assert_eq!(wrong(AxisPace { jump: f64::INFINITY, ..AXIS }), Unplannable::Jump);
    assert_eq!(Route::at([AXIS], [1e9]).unwrap_err(), Unplannable::TooLong);
    let mut route = Route::new([AXIS; 3]).unwrap();
    let none = [0.0; 3];
    assert_eq!(route.line_to([f64::NAN, 0.0, 0.0], 1.0), Err(Unplannable::TooLong));
    assert_eq!(route.line_to([1.0, 0.0, 0.0], 0.0), Err(Unplannable::Speed));
    assert_eq!(route.line_to(none, f64::NAN), Err(Unplannable::Speed));
    for (axes, centre, sweep, error) in [
        ([0, 0], [5.0, 0.0], 1.0, Unplannable::Axes),
        ([0, 3], [5.0, 0.0], 1.0, Unplannable::Axes),
        ([0, 1], [0.0, 0.001], 1.0, Unplannable::Radius),
        ([0, 1], [f64::NAN, 0.0], 1.0, Unplannable::Radius),
        ([0, 1], [5.0, 0.0], 0.0, Unplannable::Sweep),
        ([0, 1], [5.0, 0.0], f64::INFINITY, Unplannable::Sweep),
        ([0, 1], [1e9, 0.0], 1.0, Unplannable::TooLong),
    ] {
        assert_eq!(route.arc(axes, centre, sweep, none, 9.0), Err(error), "{axes:?} {sweep}");
    }
    assert!(route.is_over() && route.with_deviation(-1.0).is_err());
}

#[test]
fn a_refusal_says_what_is_allowed() {
    let said = |axis: AxisPace| Route::new([axis]).unwrap_err().to_string();
    let least = |what: String| assert!(what.ends_with("must be 10^-12 to 10^24"), "{what}");
    // Above 0, but too small.
    least(said(AxisPace { speed: 1e-13, ..AXIS }));
    least(said(AxisPace { accel: 1e-13, ..AXIS }));
    least(said(AxisPace { jump: 1e-13, ..AXIS }));
    let mut route = Route::new([AXIS; 3]).unwrap();
    let axes = route.arc([0, 3], [5.0, 0.0], 1.0, [0.0; 3], 9.0).unwrap_err();
    assert!(axes.to_string().contains("an arc two different ones"), "{axes}");
    least(route.with_deviation(1e-13).err().unwrap().to_string());
}

/// Two corners 0.09 mm apart, each with a jump that the time between them allows at a constant speed. X slows
/// down at both. If it braked over both it would slow down too much, so such a hold comes a little later.
#[test]
fn a_hold_over_two_corners_keeps_the_law() {
    let fine = AxisPace { step: 0.000_5, ..AXIS };
    for n in 0..100 {
        let mut route = Route::new([fine; 2]).unwrap();
        let mut at = [0.0f64; 2];
        for (angle, length) in [(25.0f64, 5.0), (45.0, 0.09), (65.0, 5.0)] {
            let (sin, cos) = angle.to_radians().sin_cos();
            at = [at[0] + length * cos, at[1] + length * sin];
            route.line_to(at, 17.5).unwrap();
        }
        route.close();
        let hold = 0.285 + 0.000_1 * f64::from(n);
        route.hold(hold);
        route.resume(1.0);
        let mut axes: [Axis; 2] = Default::default();
        for step in route.by_ref() {
            axes[step.axis].push((step.time, step.forward));
        }
        assert!(route.is_over() && route.time() > 1.0);
        for axis in &axes {
            let (jump, when) = jump_needed(axis, fine.step, fine.accel, route.time());
            assert!(jump <= 5.001, "held at {hold}: a jump of {jump} at {when}");
        }
    }
}

/// A wait that is infinite, NaN or negative is no wait.
#[test]
fn a_wait_is_finite() {
    for (seconds, rest) in [(f64::INFINITY, 0.0), (f64::NAN, 0.0), (-1.0, 0.0), (0.5, 0.5)] {
        let mut route = Route::new([AXIS; 2]).unwrap();
        assert!(route.dwell(seconds) && route.time() == rest, "{seconds}: {}", route.time());
    }
}
