//! `stepwright gcode FILE --plan`.

mod common;

use std::io::Write;

use common::{Running, stepwright};

const BADGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/gcode/badge.nc");

/// The command with a job on its standard input.
fn piped(job: &str, format: &str) -> common::Ended {
    let mut running = Running::start(&["gcode", "-", "--plan", "--format", format]);
    running.child.stdin.take().unwrap().write_all(job.as_bytes()).unwrap();
    running.end()
}

#[test]
fn a_job_is_surveyed() {
    let ended = stepwright(&["gcode", BADGE, "--plan"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let lines: Vec<_> = ended.stdout.lines().map(words).collect();
    for line in [
        "lines 22",
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
