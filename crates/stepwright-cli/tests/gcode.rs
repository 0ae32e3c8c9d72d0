//! `stepwright gcode FILE`, planned and run.

use std::io::Write;

use crate::common::{self, Running, stepwright};

const BADGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/gcode/badge.nc");

/// The command with a job on its standard input, planned.
fn piped(job: &str, format: &str) -> common::Ended {
    with_input(job, &["--plan", "--format", format])
}

fn with_input(job: &str, options: &[&str]) -> common::Ended {
    let mut running = Running::start(&[&["gcode", "-"], options].concat());
    running.child.stdin.take().unwrap().write_all(job.as_bytes()).unwrap();
    running.end()
}

#[test]
fn a_job_is_planned() {
    let ended = stepwright(&["gcode", BADGE, "--plan"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let lines: Vec<_> = ended.stdout.lines().map(words).collect();
    for line in [
        "lines 22",
        "the board can do it",
        "rapid moves 6",
        // 40 + 20 + 40 + 20 mm around, 4 + 3.5 mm down.
        "lines at a feed rate 6",
        "their length 127.500 mm",
        // Four quarters of 5 mm and a circle of 7 mm: 24 π.
        "arcs 5",
        "their length 75.398 mm",
        "slowest feed rate 120 mm/min",
        "X 0.000 50.000 0.000 50.000",
        "Y 0.000 30.000 0.000 30.000",
        "Z -1.000 3.000 -1.000 3.000",
    ] {
        assert!(lines.iter().any(|found| found == line), "no {line:?} in {}", ended.stdout);
    }
}

#[test]
fn programs_read_json_from_standard_input() {
    let ended = piped("G20 G0 X1\nG1 F10 Y-2", "json");
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let found: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((&found["rapid_mm"], &found["feed_mm"]), (&25.4.into(), &50.8.into()));
    assert_eq!(found["rows"][1]["cut_from"], -50.8);
    // Without a corner, and without a move, there are lists all the same.
    let empty = |found: serde_json::Value| found["corners"]["rows"] == serde_json::json!([]);
    assert!(empty(json(&piped("G1 F600 X10", "json"))) && empty(json(&piped("", "json"))));
    assert!(!piped("G1 F600 X10", "table").stdout.contains("Corners"));
}

/// A place on a circle is a sine, and where that should be 0 it is 3e-16.
#[test]
fn places_of_corners_have_no_noise() {
    let ended = piped("G0 X5\nG1 F6000\nG3 X-5 I-5\nX5 I5\nG1 Y5\nG2 X0 Y0 J-5\nG1 X-3 Y7", "json");
    let found = json(&ended);
    let rows = found["corners"]["rows"].as_array().unwrap();
    assert!(rows.len() > 1, "{found}");
    for place in rows.iter().flat_map(|row| ["x", "y", "z"].map(|axis| &row[axis])) {
        let text = place.to_string();
        assert!(["-3.0", "0.0", "5.0", "7.0"].contains(&text.as_str()), "{text}");
    }
}

#[test]
fn a_byte_order_mark_before_a_job_is_passed_over() {
    assert_eq!(piped("\u{feff}G0 X1\n", "json").stdout, piped("G0 X1\n", "json").stdout);
    let ended = piped("G0 X1\n\u{feff}G0 X2\n", "table");
    assert_eq!(ended.code(), Some(1));
    ended.assert_error(
        "-: line 2, column 1: error 1: a byte order mark (U+FEFF) stands here: it is ",
    );
}

#[test]
fn an_error_has_its_number_and_its_place() {
    let ended = piped("G0 X1\nG1 X5 F-1\n", "table");
    assert_eq!(ended.code(), Some(1));
    ended.assert_error("-: line 2, column 7: error 4: F is negative: write 0 or more");
    let ended = piped("G0 X1\nG1 X5 F-1\n", "json");
    let said: serde_json::Value = serde_json::from_str(ended.stderr.trim()).unwrap();
    assert_eq!(
        (&said["line"], &said["column"], &said["status"]),
        (&2.into(), &7.into(), &1.into())
    );
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let ended = stepwright(&["gcode", "/nowhere/job.nc", "--plan"]);
    assert_eq!(ended.code(), Some(1));
    ended.assert_error("can't read /nowhere/job.nc");
    let ended = stepwright(&["gcode", "/", "--plan"]);
    assert_eq!(ended.code(), Some(1));
    ended.assert_error("can't read /: ");
}

#[test]
fn a_line_that_never_ends_is_refused() {
    for args in [&["--plan"][..], &["--fast"]] {
        let ended = stepwright(&[&["gcode", "/dev/zero"], args].concat());
        assert_eq!(ended.code(), Some(1));
        ended.assert_error(
            "/dev/zero: line 1, column 65535: error 11: the line is too long: at most 65535 ",
        );
    }
}

/// Standard error without the words about plots and recordings.
fn json(ended: &common::Ended) -> serde_json::Value {
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    serde_json::from_str(&ended.stdout).unwrap()
}

/// A step may take longer than a timer counts: 268 s at 16 MHz.
#[test]
fn a_feed_may_be_as_slow_as_it_likes() {
    let said = |options: &[&str]| {
        json(&with_input(
            "G1 X0.05 F0.002\nG4 P400\nX0\n",
            &[&["--format", "json"], options].concat(),
        ))
    };
    let (plan, run) = (said(&["--plan"]), said(&["--fast"]));
    assert!((plan["seconds"].as_f64().unwrap() - 3_400.0).abs() < 1e-3, "{plan}");
    assert_eq!((&run["state"], &run["position"][0]), (&"ready".into(), &0.into()));
    assert!((run["seconds"].as_f64().unwrap() - 3_400.0).abs() < 1e-3, "{run}");
}

/// `--tolerance` is `G64 P` for the whole job, planned and run.
#[test]
fn a_tolerance_is_that_of_the_text() {
    let chords = |n: u32| {
        let (sin, cos) = (f64::from(n) * 0.005).sin_cos();
        format!("X{:.2} Y{:.2}\n", 20.0 * sin, 20.0 - 20.0 * cos)
    };
    let plain = format!("G1 F6000\n{}", (1..400).map(chords).collect::<String>());
    let said = |text: &str, options: &[&str]| {
        json(&with_input(text, &[&["--format", "json"], options].concat()))
    };
    let modal = said(&format!("G64 P0.01\n{plain}"), &["--plan"]);
    let exact = said(&plain, &["--plan"]);
    let asked = said(&plain, &["--plan", "--tolerance", "0.01mm"]);
    assert_eq!(asked["seconds"], modal["seconds"]);
    assert!(asked["seconds"].as_f64().unwrap() < 0.5 * exact["seconds"].as_f64().unwrap());
    assert_eq!((&asked["tolerance_mm"], &exact["tolerance_mm"]), (&0.01.into(), &().into()));
    let run = said(&plain, &["--fast", "--tolerance", ".01"]);
    assert_eq!(run["planned_seconds"], asked["seconds"]);
    for wrong in ["-1", "1001", "0.01in", "nan", ""] {
        let ended = stepwright(&["gcode", BADGE, "--plan", &format!("--tolerance={wrong}")]);
        assert_eq!(ended.code(), Some(2), "{ended:#?}");
        assert!(ended.stderr.contains("is no tolerance: 0 to 1000 mm"), "{ended:#?}");
    }
}

/// The time before the start is that of the run on the virtual board, to the tick; and the edges
/// say the same.
#[test]
fn the_plan_has_the_time_of_the_run() {
    let uneven = "G0 X3 Y1\nG1 F1800 X20.0003 Y7\nG2 X26.003 Y7.004 I3\nG4 P0.25\nM3 S9\n\
                  G3 X20.003 Y7.003 I-3 Z2.5\nG0 X0 Y0\nG93 G1 F30 X-5 Z0\n";
    let tiny = |n: u32| format!("G1 F3000 X{:.3}\n", f64::from(n) * 0.007);
    let tiny: String = (1..=2_000).map(tiny).collect();
    let (badge, quick) = (std::fs::read_to_string(BADGE).unwrap(), ["--start-speed", "12mm/s"]);
    for (job, options) in [
        (&*badge, &[][..]),
        (&badge, &quick),
        (&badge, &["--accel", "400mm/s2,700mm/s2,90mm/s2", "--steps-per-rev", "1600,3200,400"]),
        (uneven, &[]),
        (&badge, &["--jerk", "20000mm/s3"]),
        (uneven, &["--jerk", "8000mm/s3,0,30000mm/s3"]),
        (&tiny, &["--top-speed", "60mm/s"]),
    ] {
        let run = |last: &[&str]| {
            let all = [&["gcode", "-"], options, last].concat();
            let mut running = Running::start(&all);
            running.child.stdin.take().unwrap().write_all(job.as_bytes()).unwrap();
            running.end()
        };
        let planned = json(&run(&["--plan", "--format", "json"]));
        let found = json(&run(&["--fast", "--format", "json"]));
        let hz = found["ticks_per_second"].as_f64().unwrap();
        let ticks = (planned["seconds"].as_f64().unwrap() * hz).round();
        assert_eq!(found["ticks"].as_f64(), Some(ticks), "{options:?} {found}");
        assert_eq!(found["planned_seconds"], planned["seconds"]);
        assert_eq!((&found["state"], &found["late"]), (&"ready".into(), &0.into()));
        // The edges: the drivers are switched off at the end, later by the lead.
        let lead = found["lead_ticks"].as_f64().unwrap() / hz * 1e6;
        let edges = run(&["--fast", "--format", "csv"]);
        let last = edges.last_line().split(',').next().unwrap().parse::<f64>().unwrap();
        assert!((last - lead - ticks / hz * 1e6).abs() < 0.001, "{last} {ticks}");
        let mut at = [0i64; 3];
        for line in edges.stdout.lines().filter(|line| line.contains(",step,1,")) {
            let cells: Vec<_> = line.split(',').collect();
            at["XYZ".find(cells[1]).unwrap()] = cells[4].parse().unwrap();
        }
        assert_eq!(serde_json::to_value(at).unwrap(), found["position"]);
    }
}

/// A run ends exactly where the job does.
#[test]
fn a_run_ends_at_the_end() {
    let ended = stepwright(&["gcode", BADGE, "--fast"]);
    ended.assert(0, "position 0 0 240 ready");
    let planned = ended.stdout.lines().find(|line| line.starts_with("  time")).unwrap();
    let took = ended.stdout.lines().find(|line| line.starts_with("  took")).unwrap();
    assert_eq!(planned.split_whitespace().nth(1), took.split_whitespace().nth(1));
    let mut running = Running::start(&["gcode", "-", "--fast"]);
    let job = b"G1 F3000 X1.2345 Y-3.2\nG2 X11.2345 I5\nG0 Z-0.0063\n";
    running.child.stdin.take().unwrap().write_all(job).unwrap();
    // 98.76, 898.76, −256 and −0.504 steps.
    running.end().assert(0, "position 899 -256 -1 ready");
}

#[test]
fn nothing_moves_before_an_error() {
    let mut running = Running::start(&["gcode", "-", "--fast", "--format", "csv"]);
    running.child.stdin.take().unwrap().write_all(b"G0 X1\nG1 X5 F-1\n").unwrap();
    let ended = running.end();
    assert_eq!((ended.code(), &*ended.stdout), (Some(1), ""));
    ended.assert_error("line 2, column 7: error 4: F is negative");
}

#[test]
fn a_job_that_is_too_fast_is_refused() {
    let too_fast = ["--top-speed", "500mm/s", "--steps-per-rev", "12800"];
    let ended = stepwright(&[&["gcode", BADGE, "--fast"], &too_fast[..]].concat());
    assert_eq!((ended.code(), &*ended.stdout), (Some(1), ""), "{ended:#?}");
    ended.assert_error("An Uno would refuse it: in line ");
    let planned = stepwright(&[&["gcode", BADGE, "--plan"], &too_fast[..]].concat());
    assert_eq!(planned.code(), Some(0));
    assert!(planned.stdout.contains("An Uno would refuse it: in line "), "{}", planned.stdout);
}

/// What an axis can do: typed for all, for each, or in the machine file; what is wrong is said.
#[test]
fn axes_are_typed_or_in_the_machine_file() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("stepwright.toml");
    let machine = "[axis.1]\nsteps-per-rev = 1600\nmm-per-rev = 10\ntop-speed = '30mm/s'\n\
                   accel = '300mm/s2'\nstart-speed = '2mm/s'\n[axis.2]\nmm-per-rev = 8\n";
    std::fs::write(&file, machine).unwrap();
    let file = file.to_str().unwrap();
    let plan = |job: &str, options: &[&str]| {
        let mut running =
            Running::start(&[&["gcode", "-", "--plan", "--format", "json"], options].concat());
        running.child.stdin.take().unwrap().write_all(job.as_bytes()).unwrap();
        let found = json(&running.end());
        [&found["seconds"], &found["peak_x"], &found["peak_y"]].map(|v| v.as_f64().unwrap())
    };
    let near = |found: [f64; 3], expected: [f64; 3]| {
        let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs() / b).fold(0.0, f64::max);
        assert!(off < 1e-6, "{found:?}, not {expected:?}");
    };
    let job = "G0 X30\nG4 P1\nG0 Y80\n";
    near(plan(job, &["--machine", file]), [1.1 + 1.0 + 0.6, 4_800.0, 80_000.0]);
    near(
        plan(job, &["--machine", "none"]),
        [2.0 * 0.03f64.sqrt() + 1.0 + 0.6, 13_856.406, 16_000.0],
    );
    let typed = ["--machine", file, "--top-speed", "20mm/s,40mm/s,1mm/s", "--accel", "100mm/s2"];
    near(plan(job, &typed), [1.7 + 1.0 + 2.4, 3_200.0, 16_000.0]);
    // A jerk of X, of which a plan uses 0.99: 300 mm/s² come in A/J, by which each ramp is longer
    // than 0.1 s. Y then has its acceleration in 1 ms.
    let bent = format!("{machine}[axis.3]\njerk = '1mm/s3'\n")
        .replace("'2mm/s'", "'2mm/s'\njerk = '6000mm/s3'");
    std::fs::write(file, bent).unwrap();
    let (x, y) = (300.0 / 5_940.0, 0.001 / 0.99);
    near(plan(job, &["--machine", file]), [1.1 + x + 1.0 + 0.6 + y, 4_800.0, 80_000.0]);
    near(plan(job, &["--machine", file, "--jerk", "0"]), [1.1 + 1.0 + 0.6, 4_800.0, 80_000.0]);
    let two = stepwright(&["gcode", BADGE, "--plan", "--accel", "1mm/s2,2mm/s2"]);
    assert_eq!(two.code(), Some(2));
    two.assert_error("--accel has 2 values: one for all axes, or three");
}

#[test]
fn the_way_is_drawn_with_its_speed() {
    let dir = tempfile::tempdir().unwrap();
    let [svg, vcd] = ["way.svg", "edges.vcd"].map(|name| dir.path().join(name));
    let [svg, vcd] = [&svg, &vcd].map(|path| path.to_str().unwrap());
    let ended = stepwright(&["gcode", BADGE, "--fast", "--xy", svg, "--vcd", vcd]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let drawn = std::fs::read_to_string(svg).unwrap();
    assert!(drawn.contains("X, mm") && drawn.contains("mm/s"), "{drawn}");
    let edges = std::fs::read_to_string(vcd).unwrap();
    assert!(edges.contains("$enddefinitions"), "{edges}");
    let plan = stepwright(&["gcode", BADGE, "--plan", "--xy", svg]);
    assert_eq!(plan.code(), Some(2));
}

/// Ctrl-C brakes along the path, wherever it is.
#[cfg(unix)]
#[test]
fn ctrl_c_brakes() {
    let mut running = Running::start(&["gcode", "-", "--format", "json"]);
    running.child.stdin.take().unwrap().write_all(b"G1 F6000 X900 Y300\n").unwrap();
    // The first word is after a second, of about ten.
    running.wait_err("1");
    running.signal(rustix::process::Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code(), Some(130), "{ended:#?}");
    assert!(ended.stderr.contains("braked before the end of the job"), "{ended:#?}");
    let found: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let [x, y] = [0, 1].map(|n| found["position"][n].as_i64().unwrap());
    assert!(x > 400 && x < 72_000 && (x - 3 * y).abs() <= 3, "{found}");
    assert_eq!(found["state"], "stopped");
}

/// A path that turns right behind the middle between two positions: the motor is not told to step
/// and to step back faster than the job ever is.
#[test]
fn a_turn_between_two_positions_is_no_fault() {
    for x in ["1.00627", "1.0065", "1.008", "1.0124"] {
        let mut running = Running::start(&["gcode", "-", "--fast"]);
        let job = format!("G1 F60 X{x}\nX0\nX{x}\nX0.5\n");
        running.child.stdin.take().unwrap().write_all(job.as_bytes()).unwrap();
        running.end().assert(0, "position 40 0 0 ready");
    }
}

#[test]
fn a_job_that_does_not_move_is_done() {
    for (job, took) in [("", "0.000000"), ("M3 S1\nG4 P0.5\nM5\n", "0.500000")] {
        let mut running = Running::start(&["gcode", "-", "--fast"]);
        running.child.stdin.take().unwrap().write_all(job.as_bytes()).unwrap();
        let ended = running.end();
        ended.assert(0, "position 0 0 0 ready");
        assert!(ended.stdout.contains(&format!("took        {took} s")), "{ended:#?}");
    }
}
