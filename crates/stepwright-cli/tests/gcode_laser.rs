//! `stepwright gcode FILE --laser`: its power beside the edges, as the text of the job orders it.

use std::io::Write;

use crate::common::{Ended, Running, stepwright};

const ENGRAVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/gcode/engrave.nc");

/// M4 with S changed on the way, a rest, a rapid, and M3.
const JOB: &str = "M4 S500 G1 F3000 X10\nS1000 X20\nG4 P0.3\nG0 X30\nM3 S250 G1 X40\nM5 X45\n";

/// The command with this job on its standard input.
fn piped(job: &str, options: &[&str]) -> Ended {
    let mut running = Running::start(&[&["gcode", "-"], options].concat());
    running.child.stdin.take().unwrap().write_all(job.as_bytes()).unwrap();
    running.end()
}

fn json(ended: &Ended) -> serde_json::Value {
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    serde_json::from_str(&ended.stdout).unwrap()
}

#[test]
fn a_plan_says_how_long_it_is_on() {
    let plan =
        |options: &[&str]| json(&piped(JOB, &[&["--plan", "--format", "json"], options].concat()));
    let (spindle, laser) = (plan(&[]), plan(&["--laser"]));
    assert_eq!(
        (&spindle["laser_on_s"], &laser["laser_on_mm"]),
        (&serde_json::Value::Null, &30.0.into())
    );
    // Two lines from rest to rest, 20 mm at 50 mm/s; a third between two others.
    let on = laser["laser_on_s"].as_f64().unwrap();
    assert!((0.6..0.75).contains(&on), "{laser}");
    // A spindle rests for S1000, M3 and M5.
    let seconds = |plan: &serde_json::Value| plan["seconds"].as_f64().unwrap();
    assert!(seconds(&spindle) > seconds(&laser) + 0.1, "{spindle} {laser}");
    assert_eq!(laser["notes"].as_array().map(Vec::len), spindle["notes"].as_array().map(Vec::len));
    let weak = piped(JOB, &["--plan", "--laser", "--laser-max", "255"]);
    assert!(
        weak.stdout.contains("It burns with up to S1000: from S255 on that is full power."),
        "{weak:#?}"
    );
}

/// Rows of a run: µs, axis, event, value, position, power.
fn rows(ended: &Ended) -> Vec<Vec<String>> {
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let mut lines = ended.stdout.lines();
    assert_eq!(lines.next(), Some("time_us,axis,event,value,position,power"));
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// From one edge of X to the next M4 burns S/F of a step, however fast that is, and nothing at rest.
#[test]
fn the_rows_burn_what_the_job_orders() {
    let dir = tempfile::tempdir().unwrap();
    let [vcd, mcap] = ["edges.vcd", "edges.mcap"].map(|name| dir.path().join(name));
    let [vcd, mcap] = [&vcd, &mcap].map(|path| path.to_str().unwrap());
    for jerk in ["0", "20000mm/s3"] {
        let recorded = ["--vcd", vcd, "--mcap", mcap, "--jerk", jerk];
        let options = [&["--laser", "--fast", "--format", "csv"], &recorded[..]].concat();
        let rows = rows(&piped(JOB, &options));
        let (mut now, mut power, mut burnt, mut dark, mut x) = (0.0, 0.0, 0.0, 0.0, 0);
        let mut known = 0;
        for row in &rows {
            let time: f64 = row[0].parse().unwrap();
            assert!(time >= now, "{row:?}");
            burnt += (time - now) / 1e6 * power;
            dark += if power == 0.0 { (time - now) / 1e6 } else { 0.0 };
            now = time;
            if row[1] == "laser" {
                power = row[3].parse().unwrap();
                assert_eq!((&*row[2], &*row[4], &row[5]), ("power", "", &row[3]));
            }
            assert_eq!(row[5].parse::<f64>().unwrap(), power, "{row:?}");
            if (&*row[1], &*row[2], &*row[3]) != ("X", "step", "1") {
                continue;
            }
            x += 1;
            // Steps between half a step behind each end of a line: 80 a mm.
            let step = 0.0125 / 50.0;
            let expected = match x {
                2..=800 => 0.5 * step,
                802..=1_600 => step,
                1_602..=2_400 | 3_202.. => 0.0,
                _ => -1.0,
            };
            if expected >= 0.0 {
                // A power has 4 digits, and a time 3.
                let slack = if expected > 0.0 { 1e-6 + 0.0041 * time_of(&rows, x) } else { 0.0 };
                assert!((burnt - expected).abs() <= slack, "step {x}: {burnt}, not {expected}");
                known += 1;
            }
            if x == 1_601 {
                assert!(dark >= 0.3, "{dark}");
            }
            if (2_402..=3_200).contains(&x) {
                assert_eq!(power, 0.25, "step {x}");
            }
            (burnt, dark) = (0.0, 0.0);
        }
        assert_eq!((x, power, known), (3_600, 0.0, 799 + 799 + 799 + 399));
        // The dump has the same changes.
        let dump = std::fs::read_to_string(vcd).unwrap();
        assert!(dump.contains("$var real 64 ! laser $end"), "{dump}");
        let told = dump.lines().filter_map(|line| line.strip_prefix('r')?.strip_suffix(" !"));
        let told: Vec<_> =
            told.skip(1).map(|power| format!("{:.4}", power.parse::<f64>().unwrap())).collect();
        let said: Vec<_> =
            rows.iter().filter(|row| row[1] == "laser").map(|row| row[3].clone()).collect();
        assert!(said.len() > 50 && told == said, "{} {}", told.len(), said.len());
        let times: Vec<u64> =
            dump.lines().filter_map(|line| line.strip_prefix('#')?.parse().ok()).collect();
        assert!(times.is_sorted());
        let bytes = std::fs::read(mcap).unwrap();
        assert!(bytes.windows(6).any(|part| part == b"/laser"));
    }
}

/// The path may end a part of a tick behind the board's last event: its laser ends with it all the same.
#[test]
fn a_job_that_ends_burning_ends_dark() {
    let dir = tempfile::tempdir().unwrap();
    let vcd = dir.path().join("edges.vcd");
    for tenth in 1..10 {
        for mode in ["M3", "M4"] {
            let job = format!("{mode} S500 G1 X3.{tenth} Y1.0{tenth} F1000\n");
            let recorded = ["--vcd", vcd.to_str().unwrap()];
            let options = [&["--laser", "--fast", "--format", "csv"], &recorded[..]].concat();
            let rows = rows(&piped(&job, &options));
            let last = rows.iter().rfind(|row| row[1] == "laser").unwrap();
            assert_eq!(last[3], "0.0000", "{job}");
            assert_eq!(last[0], rows.last().unwrap()[0], "{job}");
            let dump = std::fs::read_to_string(&vcd).unwrap();
            assert_eq!(dump.lines().rfind(|line| line.starts_with('r')), Some("r0 !"), "{job}");
        }
    }
}

/// Seconds from the step before to this one of X.
fn time_of(rows: &[Vec<String>], step: usize) -> f64 {
    let steps = rows.iter().filter(|row| row[1] == "X" && row[2] == "step" && row[3] == "1");
    let times: Vec<f64> = steps.skip(step - 2).take(2).map(|row| row[0].parse().unwrap()).collect();
    (times[1] - times[0]) / 1e6
}

/// Without it a run is what it was.
#[test]
fn a_spindle_has_no_power() {
    let ended = piped(JOB, &["--fast", "--format", "csv"]);
    assert!(ended.stdout.starts_with("time_us,axis,event,value,position\n"), "{ended:#?}");
    assert!(!ended.stdout.contains("laser"));
}

#[test]
fn the_drawing_shows_where_it_burns() {
    let dir = tempfile::tempdir().unwrap();
    let svg = dir.path().join("way.svg");
    let svg = svg.to_str().unwrap();
    let drawn = |options: &[&str]| {
        let ended = stepwright(&[&["gcode", ENGRAVE, "--fast", "--xy", svg], options].concat());
        ended.assert(0, "position 0 0 0 ready");
        std::fs::read_to_string(svg).unwrap()
    };
    let (laser, spindle) = (drawn(&["--laser"]), drawn(&[]));
    assert!(laser.contains("100 %") && !laser.contains("mm/s"), "{laser}");
    assert!(spindle.contains("mm/s") && !spindle.contains("#b8bcc2"), "{spindle}");
    // To the first line, between nine of them, to the ring, to the outline, and home.
    assert_eq!(laser.matches("#b8bcc2").count(), 12, "{laser}");
}

#[test]
fn options_of_a_laser_are_checked() {
    for (options, said) in [
        (&["--laser-max", "255"][..], "--laser"),
        (&["--laser", "--laser-max", "0"], "no S of full power: 0.001 to 1000000"),
        (&["--laser", "--laser-max", "nan"], "no S of full power"),
    ] {
        let ended = stepwright(&[&["gcode", ENGRAVE, "--plan"], options].concat());
        assert_eq!(ended.code(), Some(2), "{ended:#?}");
        assert!(ended.stderr.contains(said), "{ended:#?}");
    }
}
