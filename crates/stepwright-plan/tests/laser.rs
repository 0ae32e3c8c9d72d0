//! Tests of a laser's power, judged by the steps and the text of the job alone.
//!
//! The judge knows the place of each step of an axis along the path: half a step after a whole position. M4
//! burns the same amount per mm at any speed, so between two steps the power adds up to S/F times the way
//! between them. M3 adds up to S times the time. The judge does not use the planner's speeds.

use crate::common::{AXES, Job, Tool, run};
use proptest::prelude::*;
use stepwright::{Board, Rate};
use stepwright_path::AxisPace;
use stepwright_plan::gcode::{GcodeJob, JobPlan, JobTerms, PowerChange};

const AXIS: AxisPace = AXES[0];

fn plan(job: &str, laser: Option<f64>) -> JobPlan {
    let board: Board<3> = Board::unmeasured(Rate::MHZ);
    let terms = JobTerms { laser, ..JobTerms::default() };
    JobPlan::on(job.bytes(), [AXIS; 3], &terms, &board, |_, _| ()).unwrap()
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found}, not {expected}");
}

/// The power changes of a whole job.
fn signal(job: &str) -> Vec<PowerChange> {
    let mut job = GcodeJob::new(job.bytes(), [AXIS; 3]).unwrap().with_laser(1_000.0);
    while job.step().unwrap().is_some() {}
    std::iter::from_fn(|| job.power(1e6)).collect()
}

#[test]
fn times_by_hand() {
    // 10 mm at 100 mm/s and two ramps of 0.1 s, for the first line only.
    let laser = plan("M3 S100\nG1 F6000 X10\nG4 P1\nG0 X0", Some(1_000.0)).laser.unwrap();
    near(laser.time, 0.2);
    near(laser.way, 10.0);
    assert_eq!((laser.highest, laser.most), (100.0, 1_000.0));
    // Never on at rest: a dwell, and the rests before and after it.
    let laser = plan("M4 S50 G1 F6000 X10\nG4 P3\nX20\nM5\nX30", Some(1_000.0)).laser.unwrap();
    near(laser.time, 0.2 + 0.1 + 0.05);
    near(laser.way, 20.0);
    // S0 and a probe do not burn.
    let dark = plan("M3 S0 G1 F600 X10\nS9 G38.3 X20\nG0 X30", Some(1_000.0)).laser.unwrap();
    assert_eq!((dark.time, dark.way, dark.highest), (0.0, 0.0, 0.0));
    assert_eq!(plan("M3 S9 G1 F600 X9", None).laser, None);
}

/// A change of the laser makes no corner and costs no time. A spindle rests for a change.
#[test]
fn no_change_of_the_laser_stops_the_path() {
    const WORDS: [&str; 6] = ["M3 S100", "S200", "M4", "M5", "M3", "S0"];
    let job = |words: bool| -> String {
        let line = |n: usize| {
            let word = if words { WORDS[n % 6] } else { "" };
            format!("{word}\nG1 F6000 X{}\n", 10 * (n + 1))
        };
        (0..12).map(line).collect()
    };
    let (bare, with) = (plan(&job(false), None), plan(&job(true), Some(1_000.0)));
    assert_eq!((with.time.to_bits(), &with.corners), (bare.time.to_bits(), &bare.corners));
    let spindle = plan(&job(true), None);
    assert!(spindle.time > bare.time + 0.5, "{} {}", spindle.time, bare.time);
    // Coolant, dwells and pauses still rest.
    let rests = "G1 F6000 X100\nM8\nX200\nG4 P1\nX300\nM0\nX400";
    near(plan(rests, Some(1.0)).time, plan(rests, None).time);
}

#[test]
fn powers_by_hand() {
    let power = |found: &[PowerChange], time: f64| {
        found.iter().rev().find(|change| change.time <= time).map_or(0.0, |change| change.power)
    };
    // M3: on from its start to its end, without a ramp. Above S1000 it is full power.
    let found = signal("M3 S250\nG1 F6000 X10\nG0 X20\nG1 S5000 X30");
    let powers: Vec<_> = found.iter().map(|change| change.power).collect();
    assert_eq!(powers, [0.25, 0.0, 1.0, 0.0]);
    assert_eq!(found[0].time, 0.0);
    // M4: half of the speed gives half of the power. The ramp to 100 mm/s takes 0.1 s.
    let found = signal("M4 S1000 G1 F6000 X100\nG4 P1\nX50");
    for (time, expected) in [(0.0, 0.0), (0.05, 0.5), (0.1, 1.0), (0.6, 1.0), (1.05, 0.5)] {
        let found = power(&found, time);
        assert!((found - expected).abs() <= 1.0 / 255.0, "{time}: {found}, not {expected}");
    }
    // A constant power is exact, and off is exactly 0.
    assert_eq!((power(&found, 0.5), power(&found, 1.5), power(&found, 9.0)), (1.0, 0.0, 0.0));
    let off: Vec<_> = found.iter().filter(|change| change.power == 0.0).collect();
    assert_eq!(off.len(), 2);
    near(off[0].time, 1.1);
    // In inverse time: 30 mm in half a minute.
    assert_eq!(power(&signal("M4 S500 G93 G1 F2 X30"), 15.0), 0.5);
    // An axis slower than F makes the laser weaker too: 200 of 400 mm/s.
    assert_eq!(power(&signal("M4 S800 G1 F24000 X100"), 0.4), 0.4);
}

/// Chords that become one line or one arc burn like it, and S changes at its own line.
#[test]
fn chords_within_a_tolerance_burn_as_one() {
    let chords =
        |from: i32, to: i32| (from + 1..=to).map(|n| format!("X{n}\n")).collect::<String>();
    for mode in ["M3", "M4"] {
        let lines = signal(&format!("{mode} S500 G1 F6000 X50\nS250 X100\nM5 X110\n"));
        let (first, second) = (chords(0, 50), chords(50, 100));
        let many =
            signal(&format!("G64 P0.01\n{mode} S500 G1 F6000\n{first}S250\n{second}M5 X110\n"));
        assert_eq!(many.len(), lines.len());
        for (a, b) in many.iter().zip(&lines) {
            assert!(
                (a.time - b.time).abs() < 1e-9 && (a.power - b.power).abs() < 1e-9,
                "{a:?} {b:?}"
            );
        }
    }
}

/// The laser of a braked job is off as soon as the job stands.
#[test]
fn a_braked_job_is_dark() {
    let job = "M3 S1000 G1 F6000 X500";
    let mut job = GcodeJob::new(job.bytes(), [AXIS; 3]).unwrap().with_laser(1_000.0);
    while job.step().unwrap().is_some_and(|step| step.time < 1.0) {}
    assert_eq!(job.power(0.9).map(|change| change.power), Some(1.0));
    job.cancel();
    while job.step().unwrap().is_some() {}
    let found: Vec<_> = std::iter::from_fn(|| job.power(100.0)).collect();
    assert_eq!(found, [PowerChange { time: job.time(), power: 0.0 }]);
}

/// A fixed job of each kind, before random ones.
#[test]
fn mixed_jobs_burn_what_they_order() {
    let line = |x, y, tool| Job::Line { x, y, tool };
    let (constant, dynamic) = (Tool::M3 { s: 400, f: 3_000 }, Tool::M4 { s: 700, f: 4_800 });
    let job = [
        line(800, 0, constant),
        line(1_600, 400, Tool::M3 { s: 900, f: 3_000 }),
        line(1_600, 1_600, Tool::Rapid),
        line(800, 1_600, dynamic),
        line(0, 1_600, Tool::M4 { s: 350, f: 4_800 }),
        Job::Dwell(300),
        line(0, 0, Tool::M4 { s: 1_000, f: 1_200 }),
        Job::Half { radius: 400, clockwise: true, tool: dynamic },
        Job::Half { radius: 240, clockwise: false, tool: constant },
        line(0, 0, Tool::M5 { f: 3_000 }),
    ];
    for jerk in [f64::INFINITY, 20_000.0] {
        for holds in [&[][..], &[700, 1_500, 3_001, 6_000]] {
            let found = run(&job, AXES.map(|axis| AxisPace { jerk, ..axis }), holds, 3);
            found.judge();
            assert!(found.steps.len() > 9_000, "{}", found.steps.len());
        }
    }
}

fn tool() -> impl Strategy<Value = Tool> {
    let speed = prop_oneof![300u32..9_000, 20_000u32..40_000];
    prop_oneof![
        2 => (0u32..1_500, speed.clone()).prop_map(|(s, f)| Tool::M3 { s, f }),
        4 => (0u32..1_000, speed.clone()).prop_map(|(s, f)| Tool::M4 { s, f }),
        1 => speed.prop_map(|f| Tool::M5 { f }),
        1 => Just(Tool::Rapid),
    ]
}

fn part() -> impl Strategy<Value = Job> {
    prop_oneof![
        8 => (-400i32..400, -400i32..400, tool()).prop_map(|(x, y, tool)| Job::Line { x, y, tool }),
        2 => (4i32..300, any::<bool>(), tool())
            .prop_map(|(radius, clockwise, tool)| Job::Half { radius, clockwise, tool }),
        1 => (1u32..400).prop_map(Job::Dwell),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..Default::default() })]

    /// Random programs, a third of them with limited jerk, half of them with holds.
    #[test]
    fn random_jobs_burn_what_they_order(
        job in prop::collection::vec(part(), 1..24),
        jerk in prop_oneof![2 => Just(f64::INFINITY), 1 => 5_000f64..80_000.0],
        holds in prop_oneof![Just(Vec::new()), prop::collection::vec(1usize..2_000, 1..5)],
        stride in 1usize..200,
    ) {
        run(&job, AXES.map(|axis| AxisPace { jerk, ..axis }), &holds, stride).judge();
    }

    /// For any bytes the power is from 0 to 1, times never fall, and the power ends at 0.
    #[test]
    fn no_text_is_too_strange(
        words in prop::collection::vec(prop_oneof![
            Just("M3 "), Just("M4 "), Just("M5 "), Just("S1e3"), Just("S9999999 "), Just("S0.00000000001 "),
            Just("G1 "), Just("G0 "), Just("F900 "), Just("F0.001 "), Just("F9999999 "), Just("X3 "), Just("X0 "),
            Just("Y1 "), Just("G93 "), Just("G94 "), Just("G2 I2 "), Just("G3 J-1 "), Just("\n"), Just("\n"),
            Just("G4 P.2\n"), Just("M2\n"), Just("G38.3 X1 F9\n"), Just("G28\n"), Just("%\n"), Just("S-1\n"),
        ], 0..60),
        most in prop_oneof![Just(1_000.0), Just(1e-9), Just(1e9)],
    ) {
        let text = words.concat();
        // A job may take hours: 30 s of it are enough.
        let mut job = GcodeJob::new(text.bytes(), [AXIS; 3]).unwrap().with_laser(most);
        let mut last = PowerChange { time: 0.0, power: 0.0 };
        let mut see = |change: PowerChange| {
            assert!((0.0..=1.0).contains(&change.power) && change.time >= last.time, "{change:?}");
            last = change;
        };
        let (mut steps, mut now) = (0, 0.0);
        while let Ok(Some(step)) = job.step() {
            (steps, now) = (steps + 1, step.time);
            while let Some(change) = job.power(now) {
                see(change);
            }
            if steps > 3_000 {
                job.cancel();
            }
        }
        while let Some(change) = job.power(now.max(job.time()) + 1.0) {
            see(change);
        }
        prop_assert_eq!(last.power, 0.0);
    }
}

/// The judge detects a laser that is off by a hundredth, late, or on at rest.
#[test]
fn the_judge_is_no_yes_man() {
    let line = |x, tool| Job::Line { x, y: 0, tool };
    let dynamic = Tool::M4 { s: 800, f: 3_000 };
    let job = [line(800, dynamic), Job::Dwell(200), line(0, dynamic), line(400, Tool::Rapid)];
    let good = run(&job, AXES, &[], 1);
    good.judge();
    let worse = |change: fn(&mut PowerChange)| {
        let mut bad = good.clone();
        bad.power.iter_mut().for_each(change);
        std::panic::catch_unwind(move || bad.judge()).is_err()
    };
    assert!(worse(|change| change.power *= 0.98));
    assert!(worse(|change| change.time += 0.004));
    assert!(worse(|change| change.power = change.power.max(0.003)));
    assert!(worse(|change| change.power = if change.power > 0.7 { 1.0 } else { change.power }));
}
