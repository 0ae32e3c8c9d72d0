//! Tests of G-code jobs: their time before they start, by hand and by their steps.

use stepwright::{Board, Rate};
use stepwright_path::{AxisPace, RouteStep, Unplannable, length};
use stepwright_plan::gcode::{GcodeJob, JobError, JobPlan, JobTerms};

const AXIS: AxisPace =
    AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

fn board() -> Board<3> {
    Board::unmeasured(Rate::MHZ)
}

fn plan(job: &str) -> JobPlan {
    JobPlan::of(job.bytes(), [AXIS; 3], &board(), |_, _| ()).unwrap()
}

/// All steps, and the time at which the job is over.
fn steps(job: &str) -> (Vec<RouteStep>, f64) {
    let mut job = GcodeJob::new(job.bytes(), [AXIS; 3]).unwrap();
    let mut steps = Vec::new();
    while let Some(step) = job.step().unwrap() {
        steps.push(step);
    }
    (steps, job.time())
}

fn end(steps: &[RouteStep]) -> [i32; 3] {
    let mut at = [0; 3];
    steps.iter().for_each(|step| at[step.axis] += if step.forward { 1 } else { -1 });
    at
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found}, not {expected}");
}

#[test]
fn times_by_hand() {
    // 100 mm at 100 mm/s, and 0.1 s for both ramps together.
    let line = plan("G1 F6000 X100");
    near(line.time, 1.1);
    near(line.at_feed, 0.9);
    near(line.ramps, 0.2);
    assert_eq!(line.peaks.map(|peak| peak.rate.round()), [8_000.0, 0.0, 0.0]);
    // As fast as the axes can: 200 mm/s each, and 200·√2 along the diagonal.
    near(plan("G0 X100 Y100").time, 0.7);
    near(plan("G0 X100 Y50").time, 0.7);
    // Rapid moves have no F.
    let rapid = plan("G0 X100 Y100\nG4 P1\nG1 F6000 X0");
    near(rapid.at_axes, 0.3);
    near(rapid.at_feed, 0.9);
    // X is at its limit, because the line would be faster.
    let steep = plan("G1 F60000 X100 Y10");
    near(steep.time, 0.7);
    near(steep.at_axes, 0.3);
    // In inverse time, two moves a minute: 30 s, and 0.001 s for the ramps to 1 mm/s.
    near(plan("G93 G1 F2 X30").time, 30.001);
    near(plan("G1 F6000 X100\nG4 P1.5\nX0").time, 1.1 + 1.5 + 1.1);
    near(plan("G4 P2").time, 2.0);
    assert_eq!(plan(""), JobPlan::default());
}

/// Each axis jumps by 5 mm/s at a right angle: the speed falls by 95 mm/s, and rises by as many.
#[test]
fn a_corner_costs_what_it_costs() {
    let found = plan("G1 F6000 X100\nY100\nX200\n");
    near(found.time, 3.1 + 2.0 * 0.09025);
    let [first, second] = found.corners[..] else { panic!("{:?}", found.corners) };
    assert_eq!((first.line, first.place), (1, [100.0, 0.0, 0.0]));
    assert_eq!((second.line, second.place), (2, [100.0, 100.0, 0.0]));
    near(first.speed, 5.0);
    near(first.cost, 0.09025);
    // A path of the same length without a corner is faster by the cost.
    near(found.time - plan("G1 F6000 X300").time, first.cost + second.cost);
}

#[test]
fn the_worst_ten_corners_come_first() {
    let job: String = (1..=40).map(|n| format!("G1 F6000 X{0}\nY{0}\n", n * n)).collect();
    let corners = plan(&job).corners;
    assert_eq!(corners.len(), 10);
    assert!(corners.windows(2).all(|pair| pair[0].cost >= pair[1].cost - 1e-9), "{corners:?}");
    // Equal corners are in the order of the file.
    let same = plan("G1 F6000 X100\nY100\nX200\nY200").corners;
    assert_eq!(same.iter().map(|corner| corner.line).collect::<Vec<_>>(), [1, 2, 3]);
    // The speed between short lines is low, and so is the cost of their corners.
    assert!(corners.iter().all(|corner| corner.line > 8), "{corners:?}");
}

/// A slow stretch of any length is no corner.
#[test]
fn a_slow_feed_is_no_corner() {
    assert_eq!(plan("G1 F6000 X100\nF60 X102\nF6000 X200").corners, []);
}

#[test]
fn a_change_of_the_spindle_is_at_rest() {
    let found = plan("G1 F6000 X100\nM3 S100\nX200\nM8\nX300");
    near(found.time, 3.3);
    let corners: Vec<_> = found.corners.iter().map(|c| (c.line, c.speed)).collect();
    assert_eq!(corners, [(1, 0.0), (3, 0.0)]);
    // An order of the present state is no change. M1 and T do not stop.
    near(plan("M3 S100\nG1 F6000 X100\nM3 S100\nM1\nT2\nX200").time, 2.1);
}

const BADGE: &str = include_str!("../../../examples/gcode/badge.nc");

/// Uneven arcs, helices, tiny pieces, a stop: the planned time is that of the steps, and the steps go to
/// the end of the path.
#[test]
fn the_plan_is_that_of_the_steps() {
    let uneven = "G1 F3000 X10 Y3\nG2 X20.003 Y3.004 I5\nG3 X20.001 Y3.006 I-7.07 J-7.07 Z2\n\
                  G1 X20.0001\n";
    let stops = "G0 X3\nM3 S100\nG1 F500 X3.3 Y0.1\nG4 P0.01\nG18 G2 X4 Z-1 R1\nM5\n\
                 G0 X-7 Y2 Z-3\n";
    let tiny = |n| format!("G1 F2000 X{}\n", f64::from(n) * 1e-3);
    let tiny: String = (1..=3_000).map(tiny).collect();
    for (job, ends) in [
        (BADGE, [0, 0, 240]),
        (uneven, [1_600, 240, 160]),
        (stops, [-560, 160, -240]),
        (&tiny, [240, 0, 0]),
    ] {
        let (found, (steps, time)) = (plan(job), steps(job));
        assert_eq!(found.time.to_bits(), time.to_bits(), "{} {time}", found.time);
        assert_eq!(end(&steps), ends);
        assert!(steps.windows(2).all(|pair| pair[0].time <= pair[1].time));
        assert!(steps.last().unwrap().time <= time);
    }
}

/// Ends rounded to 3 digits make no corners: a circle of arcs is passed at speed.
#[test]
fn rounded_arcs_are_passed_at_speed() {
    for (word, side) in [("G2", -0.7), ("G3", 0.7)] {
        let place = |n: i32| {
            let angle = f64::from(n) * side;
            [20.0 * angle.cos(), 20.0 * angle.sin()].map(|at| (at * 1e3).round() / 1e3)
        };
        let arc = |n: i32| {
            let ([a, b], [x, y]) = (place(n - 1), place(n));
            format!("{word} F3000 X{x} Y{y} I{:.3} J{:.3}\n", -a, -b)
        };
        let found = plan(&("G0 X20\n".to_owned() + &(1..10).map(arc).collect::<String>()));
        // 9 · 0.7 · 20 mm at 50 mm/s, less the ramps.
        let feed = 126.0 / 50.0;
        assert!((0.93 * feed..feed).contains(&found.at_feed), "{found:?}");
        assert!(found.corners.iter().all(|corner| corner.line < 2), "{:?}", found.corners);
    }
}

/// Arcs go in the ordered direction: a quarter and three quarters of a circle of 10 mm.
#[test]
fn arcs_turn_their_way() {
    for (word, quarters) in [("G3", 1.0), ("G2", 3.0)] {
        let job = format!("{word} F600 X0 Y10 I-10\n");
        let found = plan(&format!("G0 X10\nM3 S1\n{job}"));
        // At 10 mm/s, with 10 ms for both ramps, and 0.2 s for the 10 mm to the start.
        let time = quarters * 10.0 * std::f64::consts::FRAC_PI_2 / 10.0 + 0.01 + 0.2;
        assert!((found.time - time).abs() < 1e-4, "{word}: {} {time}", found.time);
    }
}

/// An arc of nearly a full circle whose ends are 4 µm nearer or farther. The radius changes evenly from one
/// to the other, where one arc through both ends would be half a millimetre off.
#[test]
fn an_uneven_arc_stays_on_its_way() {
    let step = 0.000_5;
    let fine = AxisPace { step, ..AXIS };
    for (x, y) in [(20.004, -0.1), (19.996, -0.2), (20.004, 0.3)] {
        let job = format!("G0 X20\nG4 P10\nG3 F3000 X{x} Y{y} I-20\n");
        let mut job = GcodeJob::new(job.bytes(), [fine; 3]).unwrap();
        let mut at = [0i32, 0];
        let (mut turned, mut last) = (0.0, 0.0f64);
        let whole = f64::atan2(y, x).rem_euclid(std::f64::consts::TAU);
        let change = x.hypot(y) - 20.0;
        while let Some(step) = job.step().unwrap() {
            at[step.axis] += if step.forward { 1 } else { -1 };
            if step.time < 5.0 {
                continue;
            }
            let angle = f64::from(at[1]).atan2(f64::from(at[0]));
            turned += (angle - last + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
            last = angle;
            let off = f64::from(at[0]).hypot(f64::from(at[1])) * fine.step - 20.0;
            // Each axis is within 3/4 of a step, and an arc of a quarter bows by less than 0.4 µm.
            let most = fine.step * 0.75 * 1.415 + 0.000_4;
            assert!((off - change * turned / whole).abs() < most, "{off} at {at:?}, {turned}");
        }
        assert_eq!(at, [x, y].map(|at| (at / step).round() as i32));
    }
}

/// A circle whose end is on the spoke of its start, a micrometre farther or nearer, is a whole circle, as
/// in grbl and LinuxCNC, for any direction of the spoke. An earlier version made a line of a micrometre.
#[test]
fn a_circle_that_ends_beside_its_start_is_whole() {
    for word in ["G2", "G3"] {
        for (a, b) in [(1, 0), (0, -1), (3, 4), (-1, 3), (7, -11), (-2, -5)] {
            for um in [1, -1] {
                let [x, y] =
                    [a, b].map(|part| format!("{:.3}", f64::from(part * (10_000 + um)) * 1e-3));
                let [x0, y0] = [a * 10, b * 10];
                let job = format!("G0 X{x0} Y{y0}\n{word} F6000 X{x} Y{y} I{} J{}\n", -x0, -y0);
                let round = f64::from(a).hypot(f64::from(b)) * 10.0 * std::f64::consts::TAU;
                let (found, (steps, time)) = (plan(&job), steps(&job));
                near_by(found.survey.arcs.distance, round);
                assert!(found.time > round / 100.0 && found.time.to_bits() == time.to_bits());
                // The path is opposite once, and ends at its end.
                let (mut at, mut far) = ([0i32; 3], 0.0f64);
                for step in &steps {
                    at[step.axis] += if step.forward { 1 } else { -1 };
                    let off = f64::from(at[0] - x0 * 80).hypot(f64::from(at[1] - y0 * 80));
                    far = far.max(if step.time > time - round / 100.0 { off } else { 0.0 });
                }
                near_by(far * 0.0125, round / std::f64::consts::PI);
                let end = [x, y].map(|at| (at.parse::<f64>().unwrap() / 0.0125).round() as i32);
                assert_eq!(at[..2], end, "{job}");
            }
        }
    }
}

/// An arc no larger than a step takes its time, and an arc smaller than a step of another axis is made. An
/// earlier version made neither.
#[test]
fn an_arc_within_a_step_is_made() {
    // A minute for a circle of 10 µm, and a minute for three quarters.
    near_by(plan("G93 G1 X1 F60\nG2 X1 I-0.01 F1\nG4 P1").time, 62.0);
    near_by(plan("G93 G1 X1 F60\nG2 X0.99 Y-0.01 I-0.01 F1\nG4 P1").time, 62.0);
    for coarse in 0..3 {
        let mut axes = [AXIS; 3];
        axes[coarse].step = 1.0;
        let text = "G2 X0 Y0 I-0.9 F600\n";
        let time = JobPlan::of(text.bytes(), axes, &board(), |_, _| ()).unwrap().time;
        assert!((time / (1.8 * std::f64::consts::PI / 10.0) - 1.0).abs() < 0.1, "{coarse} {time}");
        let mut job = GcodeJob::new(text.bytes(), axes).unwrap();
        let (mut at, mut most, mut least) = ([0i32; 3], [0; 3], [0; 3]);
        while let Some(step) = job.step().unwrap() {
            at[step.axis] += if step.forward { 1 } else { -1 };
            for axis in 0..3 {
                most[axis] = most[axis].max(at[axis]);
                least[axis] = least[axis].min(at[axis]);
            }
        }
        assert_eq!(at, [0; 3]);
        let whole = ([0, 72, 0], [-144, -72, 0]);
        let expected = match coarse {
            0 => ([0, 72, 0], [-2, -72, 0]),
            1 => ([0, 1, 0], [-144, -1, 0]),
            _ => whole,
        };
        assert_eq!((most, least), expected, "axis {coarse} is coarse");
    }
}

/// An arc that leads outwards by more than around is no error, as far as grbl accepts it.
#[test]
fn an_arc_that_leads_outwards_is_taken() {
    for job in [
        "G0 X10\nG3 X10.004 Y0.000004 I-10 F600",
        "G0 X0.4504\nG2 X0.45 Y-0.000004 I-0.45 Z-9 F6000",
        "G0 X10\nG2 X10.004 Y0.000004 I-10 F600",
    ] {
        let (found, (_, time)) = (plan(job), steps(job));
        assert_eq!(found.time.to_bits(), time.to_bits(), "{job}");
    }
    // A minute for the arc, for any length.
    near_by(plan("G0 X10\nG93 G3 X10.004 Y0.001 I-10 F1\nG4 P1").time, 61.12);
}

#[test]
fn an_error_ends_it_with_its_line() {
    let of = |job: &str| JobPlan::of(job.bytes(), [AXIS; 3], &board(), |_, _| ()).unwrap_err();
    let said = "line 2, column 7: error 4: F is negative: write 0 or more";
    assert_eq!(of("G0 X1\nG1 X5 F-1").to_string(), said);
    // Beyond 2³¹ steps.
    let axis = AxisPace { step: 1e-6, ..AXIS };
    let far = JobPlan::of(*b"G0 X1\nX9999", [axis; 3], &board(), |_, _| ()).unwrap_err();
    assert!(matches!(far, JobError::Move(2, _)), "{far:?}");
    // The steps before the error are made.
    let mut job = GcodeJob::new(*b"G1 F600 X1\nG1 Q\nX9", [AXIS; 3]).unwrap();
    let mut steps = 0;
    let error = loop {
        match job.step() {
            Ok(step) => steps += i32::from(step.is_some()),
            Err(error) => break error,
        }
    };
    assert!(matches!(error, JobError::Code(error) if error.line == 2));
    assert_eq!(steps, 80);
}

#[test]
fn what_a_board_cannot_do_is_said() {
    // 10,000 steps/s of all axes together: 125 mm/s of one, 62.5 mm/s each of two.
    assert_eq!(plan("G1 F7400 X100").refused, None);
    let found = plan("G1 F6000 X100\nG1 F9000 X200\nF600 X0").refused.unwrap();
    assert_eq!((found.line, found.axis), (2, 0));
    near(found.wanted, 12_000.0);
    near(found.most, 10_000.0);
    // The board is told the highest rate of each axis. X and Y need not be as fast at the same time.
    let apart = plan("G1 F6000 X100\nF5800 Y100").refused.unwrap();
    assert_eq!((apart.line, apart.axis), (1, 0));
    assert!(plan("G1 F5200 X70 Y70").refused.is_none());
    assert!(plan("G1 F5400 X70 Y70").refused.is_some());
}

/// A full circle of 20 mm in chords of 0.1 mm, from places of two digits.
fn rounded_circle() -> String {
    let chord = |n: u32| {
        let (y, x) = (std::f64::consts::TAU * f64::from(n) / 1_257.0).sin_cos();
        format!("X{:.2} Y{:.2}\n", 20.0 * x - 20.0, 20.0 * y)
    };
    (1..=1_257).map(chord).collect()
}

/// G64 P: where it allows that, chords are an arc, up to G61. The planned time is that of the steps.
#[test]
fn chords_within_a_tolerance_are_passed_as_their_arc() {
    let chords = rounded_circle();
    let [exact, within] = ["", "G64 P0.01\n"].map(|mode| format!("{mode}G1 F6000\n{chords}"));
    let arc = plan("G1 F6000\nG3 X0 Y0 I-20").time;
    assert!(plan(&exact).time > 2.0 * arc, "{}", plan(&exact).time);
    near_by(plan(&within).time, arc);
    let both = format!("{within}G4 P1\nG61\n{chords}");
    near_by(plan(&both).time, plan(&within).time + 1.0 + plan(&exact).time);
    for job in [&within, &both] {
        let (steps, time) = steps(job);
        near(plan(job).time, time);
        assert_eq!(end(&steps), [0; 3]);
    }
    // 0.01 mm, the rounding of the text, and the steps.
    let mut at = [0i32; 3];
    for step in steps(&within).0 {
        at[step.axis] += if step.forward { 1 } else { -1 };
        let radius = (f64::from(at[0]) + 1_600.0).hypot(f64::from(at[1])) * 0.0125;
        assert!((radius - 20.0).abs() < 0.01 + 0.0071 + 0.0089, "{at:?}");
    }
}

/// A given tolerance applies until the text orders another one.
#[test]
fn a_tolerance_that_is_asked_for_holds_until_the_job_orders_another() {
    let chords = rounded_circle();
    let terms = JobTerms { tolerance: length(0.01).unwrap(), ..JobTerms::default() };
    let asked = |text: &str| {
        let board = board();
        let plan = JobPlan::on(text.bytes(), [AXIS; 3], &terms, &board, |_, _| ()).unwrap();
        let mut job = GcodeJob::on(text.bytes(), [AXIS; 3], &terms).unwrap();
        while job.step().unwrap().is_some() {}
        near(job.time(), plan.time);
        assert_eq!(plan.terms, terms);
        plan
    };
    let plain = format!("G1 F6000\n{chords}");
    near(asked(&plain).time, plan(&format!("G64 P0.01 G1 F6000\n{chords}")).time);
    for exact in ["G61", "G64"] {
        near(asked(&format!("{exact} {plain}")).time, plan(&plain).time);
    }
    let coarse = format!("G64 P0.05 {plain}");
    near(asked(&coarse).time, plan(&coarse).time);
    // The end of a program keeps the tolerance.
    let twice = format!("{plain}M2\n{plain}");
    near_by(asked(&twice).time, 2.0 * asked(&plain).time);
    let terms = JobTerms { tolerance: length(-0.01).unwrap(), ..JobTerms::default() };
    let job = GcodeJob::on(plain.bytes(), [AXIS; 3], &terms).unwrap().step();
    assert_eq!(job.unwrap_err(), JobError::Move(1, Unplannable::Tolerance));
}

fn near_by(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 0.002, "{found}, not {expected}");
}

/// Lines that wait are made before a dwell.
#[test]
fn lines_that_wait_come_before_a_dwell() {
    let (steps, time) = steps("G64 P0.01\nG1 F6000 X10\nX20\nG4 P5\nX30\n");
    let before = steps.iter().filter(|step| step.time < 5.0).count();
    assert_eq!((before, steps.len()), (1_600, 2_400));
    near(time, plan("G1 F6000 X20\nG4 P5\nX30").time);
}

/// A corner after chords that became one line has the line number of the last chord.
#[test]
fn a_corner_behind_a_fitted_line_has_its_line() {
    let chords: String = (1..=100).map(|n| format!("X{n}\n")).collect();
    let found = plan(&format!("G64 P0.01\nG1 F6000\n{chords}Y100\n"));
    let [corner] = found.corners[..] else { panic!("{:?}", found.corners) };
    assert_eq!((corner.line, corner.place), (102, [100.0, 0.0, 0.0]));
}

/// Lines that wait are held and dropped, as lines on the route are.
#[test]
fn lines_that_wait_are_held_and_dropped() {
    let text = format!("G64 P0.01\nG1 F6000\n{}", rounded_circle());
    let job = || GcodeJob::new(text.clone().into_bytes(), [AXIS; 3]).unwrap();
    let mut held = job();
    held.hold_at(0.0);
    assert_eq!((held.step().unwrap(), held.is_held()), (None, true));
    held.resume_at(2.0);
    let rest = std::iter::from_fn(|| held.step().unwrap()).collect::<Vec<_>>();
    assert!(rest[0].time > 2.0 && end(&rest) == [0; 3]);
    let mut dropped = job();
    while dropped.step().unwrap().is_some_and(|step| step.time < 0.5) {}
    dropped.cancel();
    let last = std::iter::from_fn(|| dropped.step().unwrap()).last().unwrap();
    assert!(last.time < 0.65 && dropped.step().unwrap().is_none(), "{}", last.time);
}

/// A job brakes along its way from any place.
#[test]
fn a_job_is_cancelled() {
    let long = "G1 F6000 X100\nG3 X100 Y40 J20\nG1 X0 Y0\n".repeat(5);
    let mut job = GcodeJob::new(long.bytes(), [AXIS; 3]).unwrap();
    let mut time = 0.0;
    while time < 1.5 {
        time = job.step().unwrap().unwrap().time;
    }
    job.cancel();
    let mut last = time;
    while let Some(step) = job.step().unwrap() {
        last = step.time;
    }
    assert!(last < time + 0.15 && last > time + 0.05, "{time} {last}");
    assert_eq!(job.step().unwrap(), None);
}
