//! `plan` against a closed form of its own, in f64: 2⁵³ is far more than the
//! ticks of these travels. (The core's tests hold it to 160 bits.)

use crate::common;
use proptest::prelude::*;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};
use stepwright_oracle::{IdealSCurve, IdealTrapezoid, JerkLimits};

fn stepwright(line: &str) -> Command {
    let mut command = Command::new(common::program());
    command.args(line.split_whitespace());
    command
}

fn stdout(line: &str) -> String {
    let output = stepwright(line).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// step, delay, time, speed, phase
type Row = (u32, u64, u64, f64, String);

fn rows(csv: &str) -> Vec<Row> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("step,delay,time,speed,phase"));
    let row = |line: &str| {
        let mut cells = line.split(',');
        let mut cell = || cells.next().unwrap();
        let number = |text: &str| text.parse().unwrap();
        (
            cell().parse().unwrap(),
            number(cell()),
            number(cell()),
            cell().parse().unwrap(),
            cell().to_owned(),
        )
    };
    lines.map(row).collect()
}

/// Everything that a list of steps promises.
fn check(csv: &str, steps: u32, hz: u32, speeds: (f64, f64), accels: (f64, f64)) {
    let rows = rows(csv);
    assert_eq!(rows.len(), steps as usize);
    let slopes = (2.0 * accels.0, 2.0 * accels.1);
    let length = f64::from(steps.saturating_sub(1));
    let ideal = IdealTrapezoid::new((speeds.0, speeds.0), speeds.1, slopes, length);
    let mut now = 0;
    let order = ["up", "cruise", "down"];
    let mut place = 0;
    for (i, (step, delay, time, speed, phase)) in rows.iter().enumerate() {
        now += delay;
        assert_eq!((*step as usize, *time), (i + 1, now));
        let want = ideal.time(i as f64) * f64::from(hz);
        assert!((now as f64 - want).abs() <= 1.0 + want * 1e-12, "step {step}: {now}, not {want}");
        match i {
            0 => assert_eq!((*delay, *speed), (0, speeds.0.min(speeds.1))),
            _ => assert_eq!(*speed, f64::from(hz) / *delay as f64),
        }
        let at = order.iter().position(|name| name == phase).unwrap();
        assert!(at >= place, "{phase} at step {step} after {}", order[place]);
        place = at;
    }
}

/// A ramp counted in steps: what the law holds is 2a, to the nearest 10⁻⁶.
fn check_ramp(steps: u32, (start, top): (u32, u32), ramp: u32, hz: u32) {
    let csv = stdout(&format!(
        "plan ramp --steps {steps} --start-speed {start} --top-speed {top} --ramp {ramp} \
         --timer-hz {hz} --format csv"
    ));
    let (start, top) = (f64::from(start), f64::from(top));
    let slope = (top * top - start * start).max(1.0) / f64::from(ramp);
    let accel = (slope * 1e6).round() / 2e6;
    check(&csv, steps, hz, (start, top), (accel, accel));
}

/// So slow that the rounding of 2a is more than a tick, after two minutes.
#[test]
fn a_slow_ramp_is_as_steep_as_it_is_held() {
    check_ramp(271, (1, 2), 17, 1_000_000);
}

fn cases() -> u32 {
    std::env::var("STEPWRIGHT_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(60)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn trapezoids(
        steps in 0u32..2_000,
        start in 0u32..500,
        top in 1u32..9_000,
        accel in 50u32..90_000,
        decel in 50u32..90_000,
        hz in 1_000_000u32..20_000_000,
    ) {
        let csv = stdout(&format!(
            "plan trapezoid --steps {steps} --start-speed {start} --top-speed {top} --accel {accel} \
             --decel {decel} --timer-hz {hz} --format csv"
        ));
        check(&csv, steps, hz, (start.into(), top.into()), (accel.into(), decel.into()));
    }

    #[test]
    fn ramps(
        steps in 0u32..2_000,
        start in 0u32..500,
        top in 1u32..9_000,
        ramp in 1u32..999,
        hz in 1_000_000u32..20_000_000,
    ) {
        check_ramp(steps, (start, top), ramp, hz);
    }

    /// Every pulse within a tick of the command's own ideal, which is held to a
    /// third one by its duration and its phases.
    #[test]
    fn s_curves(
        steps in 0u32..2_000,
        start in 0u32..500,
        top in 1u32..9_000,
        accel in 50u32..90_000,
        decel in 50u32..90_000,
        jerk in 100u64..10_000_000,
        hz in 1_000_000u32..20_000_000,
    ) {
        let line = format!(
            "plan s-curve --steps {steps} --start-speed {start} --top-speed {top} --accel {accel} \
             --decel {decel} --jerk {jerk} --timer-hz {hz}"
        );
        let value: serde_json::Value =
            serde_json::from_str(&stdout(&format!("{line} --format json"))).unwrap();
        prop_assert!(value["largest_error_ticks"].as_f64().unwrap() <= 1.0);

        let limits = JerkLimits {
            start: f64::from(start),
            top: top.into(),
            accel: accel.into(),
            decel: decel.into(),
            jerk: jerk as f64,
        };
        let ideal = IdealSCurve::new(limits, f64::from(steps.max(1) - 1));
        let (ticks, peak) = (ideal.total() * f64::from(hz), ideal.peak());
        let got = value["duration_ticks"].as_f64().unwrap();
        prop_assert!((got - ticks).abs() <= 1.0 + ticks * 1e-12, "{got}, not {ticks}");
        if steps > 1 {
            let shown = value["peak_speed"].as_f64().unwrap();
            prop_assert!((shown - peak).abs() <= peak * 1e-9, "{shown}, not {peak}");
        }

        let phases = value["phases"].as_array().unwrap();
        let sum: u64 = phases.iter().map(|phase| phase["steps"].as_u64().unwrap()).sum();
        prop_assert_eq!(sum, u64::from(steps));
        let order = ["jerk-up", "up", "jerk-down", "cruise", "jerk-up", "down", "jerk-down"];
        let mut place = 0;
        for phase in phases {
            let name = phase["phase"].as_str().unwrap();
            place += order[place..].iter().position(|known| *known == name).expect(name) + 1;
        }
        let rows = rows(&stdout(&format!("{line} --format csv")));
        prop_assert_eq!(rows.len(), steps as usize);
        prop_assert_eq!(rows.last().map_or(0, |row| row.2), got as u64);
    }

    /// Runs add up to the same steps and, within their bound, the same times.
    #[test]
    fn runs(
        steps in 2u32..3_000,
        ramp in 1u32..999,
        micros in 1u32..200,
        hz in 1_000_000u32..20_000_000,
    ) {
        let line = format!(
            "plan ramp --steps {steps} --start-speed 80 --top-speed 4000 --ramp {ramp} \
             --timer-hz {hz} --format csv"
        );
        let steps = rows(&stdout(&line));
        let list = stdout(&format!("{line} --runs --max-error-us {micros}"));
        let mut now = 0.0;
        let mut step = 1;
        for run in list.lines().skip(1) {
            let cells: Vec<f64> = run.split(',').map(|cell| cell.parse().unwrap()).collect();
            let (interval, add, count) = (cells[2], cells[3], cells[4]);
            prop_assert_eq!(cells[1], f64::from(step + 1));
            for i in 0..count as u32 {
                now += interval + add * f64::from(i);
                step += 1;
                let off = (now - 0.5 - steps[step as usize - 1].2 as f64).abs();
                let allowed = f64::from(micros) * f64::from(hz) / 1e6 + 1.0;
                prop_assert!(off <= allowed, "step {step} is off by {off}");
            }
            prop_assert!((cells[5] - now).abs() < 1e-3);
        }
        prop_assert_eq!(step as usize, steps.len());
    }
}

/// Austin, Eq 8: c0 of 4π rad/s² at 1 MHz and 1.8°, and 200 delays that
/// sum to a second.
#[test]
fn the_exact_ramp_of_austin() {
    let csv = stdout(
        "plan trapezoid --steps 1000 --accel 12.566370614359172rad/s2 --top-speed 120rpm \
         --format csv",
    );
    let rows = rows(&csv);
    assert_eq!(rows[1].1, 70_711);
    assert_eq!((rows[200].2, rows[200].1), (1_000_000, 2_503));
    // 599 steps of 2500 ticks between the ramps.
    assert_eq!(rows[999].2, 3_497_500);
}

/// A reader that has seen enough ends even the longest list, without a word.
#[test]
fn a_closed_pipe_is_no_error() {
    let mut child =
        stepwright("plan trapezoid --steps 2147483647 --accel 400 --top-speed 400 --format csv")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert_eq!(lines.next().unwrap().unwrap(), "step,delay,time,speed,phase");
    assert_eq!(lines.next().unwrap().unwrap(), "1,0,0,0,up");
    drop(lines);
    let mut complaint = String::new();
    child.stderr.take().unwrap().read_to_string(&mut complaint).unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(complaint, "");
}

#[test]
fn json_is_json() {
    for extra in ["", "--runs", "--steps 0"] {
        let steps = if extra.contains("steps") { "" } else { "--steps 500" };
        let json = stdout(&format!(
            "plan trapezoid {steps} {extra} --accel 4000 --top-speed 120rpm --format json"
        ));
        let value: serde_json::Value = serde_json::from_str(&json).expect(&json);
        assert_eq!(value["law"], "trapezoid");
        assert_eq!(value["values"][1]["given"], "120rpm");
        assert_eq!(value["values"][1]["held"], 400.0);
        let list = if extra == "--runs" { "runs" } else { "rows" };
        assert!(value[list].is_array());
        assert!(value["largest_error_ticks"].as_f64().unwrap() <= 1.0);
    }
}

#[test]
fn shells_get_their_completions() {
    for shell in ["bash", "zsh", "fish"] {
        assert!(stdout(&format!("completions {shell}")).contains("trapezoid"), "{shell}");
    }
}

/// Austin's laws: the core's delays against the command's own formulas, in
/// f64, for any order.
mod austin {
    use super::*;

    fn law() -> impl Strategy<Value = String> {
        let c0 = prop_oneof![Just("exact"), Just("0.676"), Just("c1")];
        let law = prop_oneof![
            Just("austin".to_owned()),
            (0u32..=90).prop_map(|knee| format!("linear-factor --knee 0.{knee:02}")),
            (2u8..=9).prop_map(|p| format!("power --power {p}")),
            (0u8..=16).prop_map(|breaks| format!("piecewise --breaks {breaks}")),
        ];
        prop_oneof![
            8 => (law, c0).prop_map(|(law, c0)| format!("{law} --c0 {c0}")),
            1 => Just("austin --divisor 2n".to_owned()),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(cases()))]

        #[test]
        fn laws(
            law in law(),
            steps in 0u32..3_000,
            top in 1u32..9_000,
            accel in 50u32..90_000,
            decel in 50u32..90_000,
            hz in 1_000_000u32..20_000_000,
        ) {
            let json = stdout(&format!(
                "plan {law} --steps {steps} --top-speed {top} --accel {accel} --decel {decel} \
                 --timer-hz {hz} --format json"
            ));
            let value: serde_json::Value = serde_json::from_str(&json).unwrap();
            let number = |name: &str| value[name].as_f64().unwrap();
            prop_assert!(number("largest_error_ticks") <= 1.0, "{json}");
            prop_assert!(number("peak_speed") <= f64::from(top) * (1.0 + 1e-12));
            let phases = value["phases"].as_array().unwrap();
            let pulses = phases.iter().map(|phase| phase["steps"].as_u64().unwrap()).sum::<u64>();
            prop_assert_eq!(pulses, u64::from(steps));
            prop_assert_eq!(value["rows"].as_array().unwrap().len(), steps as usize);
        }

        /// Eq 18, wherever and however often, also where the way up is over.
        #[test]
        fn ramps_that_change(
            changes in prop::collection::btree_map(1u32..2_500, 50u32..90_000, 1..6),
            steps in 0u32..3_000,
            top in 1u32..9_000,
            accel in 50u32..90_000,
            decel in 50u32..90_000,
        ) {
            let changes: String =
                changes.iter().map(|(after, to)| format!(" --change {after}:{to}")).collect();
            let json = stdout(&format!(
                "plan austin --steps {steps} --top-speed {top} --accel {accel} --decel {decel} \
                 --format json{changes}"
            ));
            let value: serde_json::Value = serde_json::from_str(&json).unwrap();
            let number = |name: &str| value[name].as_f64().unwrap();
            // The core's divisor is rounded to 2⁻¹⁶ behind each change (`general.rs`).
            let rounded = changes.matches("--change").count() as f64 * 2.2e-6;
            let most = 1.0 + rounded * number("duration_ticks");
            prop_assert!(number("largest_error_ticks") <= most, "{json}");
            prop_assert!(number("peak_speed") <= f64::from(top) * (1.0 + 1e-12));
            prop_assert_eq!(value["rows"].as_array().unwrap().len(), steps as usize);
        }

        #[test]
        fn runs(law in law(), steps in 2u32..2_000, micros in 1u32..50) {
            let line = format!("plan {law} --steps {steps} --top-speed 3000 --accel 9000");
            let json = stdout(&format!("{line} --format json --runs --max-error-us {micros}"));
            let value: serde_json::Value = serde_json::from_str(&json).unwrap();
            let off = value["runs_error_ticks"].as_f64().unwrap();
            prop_assert!(off <= f64::from(micros) + 1.0, "{off}");
            let runs = value["runs"].as_array().unwrap();
            let count = runs.iter().map(|run| run["count"].as_u64().unwrap()).sum::<u64>();
            prop_assert_eq!(count, u64::from(steps) - 1);
        }
    }

    /// Twice the acceleration from 200 steps/s on: the speeds of that ramp follow v² = v₀² + 2as,
    /// and both boards make these delays.
    #[test]
    fn a_ramp_that_changes() {
        let order = "--accel 200 --top-speed 900 --change 101:400";
        let plan = rows(&stdout(&format!("plan austin --steps 1200 {order} --format csv")));
        assert_eq!((plan[100].1, plan[101].1), (5_013, 4_963));
        for n in (110..420).step_by(50) {
            // Eq 18 holds in the middle of the delay before, 99.5 steps from rest.
            let (v, far) = (plan[n].3, n as f64 - 100.0);
            let ideal = (2.0 * 200.0 * 99.5 + 2.0 * 400.0 * far).sqrt();
            assert!((v / ideal - 1.0).abs() < 1e-3, "{n}: {v} instead of {ideal}");
        }
        let file = std::env::temp_dir().join(format!("stepwright-{}.vcd", std::process::id()));
        let vcd = file.to_str().unwrap();
        stdout(&format!("move 1200 --law austin {order} --virtual --fast --vcd {vcd}"));
        let dump = std::fs::read_to_string(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        let (mut at, mut edges) = (0u64, Vec::new());
        for line in dump.lines() {
            match line.strip_prefix('#') {
                Some(time) => at = time.parse().unwrap(),
                None if line == "1a" => edges.push(at),
                None => {}
            }
        }
        // 100 ps a unit, 1 µs a tick of the plan.
        let moved: Vec<u64> = edges.iter().map(|at| (at - edges[0]) / 10_000).collect();
        assert_eq!(moved, plan.iter().map(|row| row.2).collect::<Vec<_>>());
    }

    #[test]
    fn the_published_form() {
        let csv = stdout("plan austin-fixed --steps 10 --c0 50000 --c-min 2500 --format csv");
        let delays: Vec<_> = rows(&csv).iter().map(|row| row.1).collect();
        let published = [0, 50_000, 30_000, 23_333, 19_744, 17_421, 17_421, 19_744, 23_333, 30_000];
        assert_eq!(delays, published);
    }

    /// Laws beside themselves: what must come out.
    #[test]
    fn comparisons() {
        let line = "plan compare trapezoid austin linear-factor power piecewise --steps 2000 \
                    --accel 2000 --top-speed 1000 --c0 c1 --format json";
        let value: serde_json::Value = serde_json::from_str(&stdout(line)).unwrap();
        let cell = |row: usize, name: &str| value["rows"][row][name].as_f64().unwrap();
        // The reference against itself: √(2/a) … 1000 steps/s, 0.5 s up and down.
        assert_eq!((cell(0, "largest_error_percent"), cell(0, "time_lost_s")), (0.0, 0.0));
        assert!((cell(0, "duration_s") - (1.0 + 1_499.0 / 1_000.0)).abs() < 2e-6);
        assert!((cell(0, "peak_acceleration") - 2_000.0).abs() < 0.01);
        // c1 makes an almost perfect ramp: Table 1, and 0.4056 for 0.4142.
        assert!((cell(1, "largest_error_percent") + 2.08).abs() < 0.5);
        assert!(cell(1, "rms_error_percent") < 0.1);
        // A linear factor takes time, and spares jerk.
        assert!(cell(2, "time_lost_s") > 0.05);
        assert!(cell(2, "peak_jerk") < 0.1 * cell(0, "peak_jerk"));
        for row in 1..5 {
            // From c₀ to 0.4056 of it is a little more than a.
            assert!(cell(row, "peak_acceleration") <= 2_090.0);
            assert!(cell(row, "peak_speed") <= 1_000.0);
        }
    }
}

/// Its deceleration comes near to a speed of its own, below the first of the other ramp.
#[test]
fn a_power_term_that_gets_no_faster_comes_to_an_end() {
    for power in [4, 6] {
        let line = format!(
            "plan power --steps 16 --timer-hz 1000000 --accel 27359 --top-speed 87 --decel 2435 \
             --c0 exact --power {power}"
        );
        assert!(stdout(&line).contains("power term"), "{power}");
    }
}

/// The first delay of the summary is that of the list, also where no ramp is left; and a lowered
/// acceleration is said.
#[test]
fn the_first_delay_is_the_first_one() {
    for law in ["austin", "austin --divisor 2n", "austin --c0 c1", "power", "piecewise"] {
        for (limits, first, note) in [
            ("--steps 5 --accel 2000 --top-speed 20", 50_000.0, false),
            ("--steps 500 --accel 2000 --top-speed 2000", 0.0, false),
            // Eq 18 with J = m − ½: 9 times the deceleration.
            ("--steps 5 --accel 2000 --decel 10 --top-speed 2000", 0.0, true),
        ] {
            let line = format!("plan {law} {limits} --format");
            let json: serde_json::Value =
                serde_json::from_str(&stdout(&format!("{line} json"))).unwrap();
            let values = json["values"].as_array().unwrap();
            let said = values.iter().find(|value| value["name"] == "first delay").unwrap();
            let held = said["held"].as_f64().unwrap();
            let delay = rows(&stdout(&format!("{line} csv")))[1].1 as f64;
            assert!((held - delay).abs() <= 1.0, "{line}: {held}, not {delay}");
            assert!(first == 0.0 || held == first, "{line}: {held}");
            let told = json["note"].as_str().unwrap_or_default();
            assert_eq!(told.contains("the acceleration is lowered to 90 steps/s²"), note, "{json}");
        }
    }
}
