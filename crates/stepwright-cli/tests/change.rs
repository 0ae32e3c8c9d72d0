//! A change of mind on the way: `retarget`, the lines of a script, and keys.
#![cfg(unix)]

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{self, LIMIT, Running, pty, stepwright, stepwright_with};
use rustix::process::Signal;
use rustix::termios::tcgetattr;

/// The lines of a script that is heard at 11520 bytes a second.
fn script(lines: &[(&str, f64)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (line, seconds) in lines {
        bytes.extend(line.bytes().chain([b'\r']));
        bytes.resize(bytes.len() + (seconds * 11_520.0) as usize, b'\n');
    }
    bytes
}

const BEGIN: [(&str, f64); 7] = [
    ("PO", 0.0),
    ("s0", 0.0),
    ("t2000", 0.0),
    ("a4000", 0.0),
    ("d4000", 0.0),
    ("G+4000", 0.0),
    ("E", 1.2),
];

#[test]
fn a_script_sends_a_motor_back_on_its_way() {
    let lines = [&BEGIN[..], &[("@-600", 0.3), ("V1", 0.0), ("t500", 0.0), ("F", 0.0)]].concat();
    let ended = stepwright_with(&["board", "--stdio", "--fast"], &script(&lines));
    let answers: Vec<&str> = ended.stdout.split('\r').collect();
    // It brakes from 2000 steps/s meanwhile.
    let there: i64 = answers[8].parse().unwrap();
    assert!((2_000..2_500).contains(&there), "{ended:?}");
    assert_eq!((answers[7], answers[9], answers[10]), ("Y", "Y", "B"), "{ended:?}");
    assert!(ended.stderr.contains("position -600 ready"), "{ended:?}");
    assert_eq!(ended.code(), Some(0));
}

#[test]
fn a_run_is_given_a_speed_a_target_and_a_reason_why_not() {
    let mut board = Running::start(&["board", "--pty"]);
    let path = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let order = |order: &[&str]| stepwright(&[order, &["--port", &path]].concat());
    order(&["retarget", "5"]).assert_error("axis 1 is at rest, there is no travel to change");
    assert_eq!(order(&["run", "500", "--detach"]).code(), Some(0));
    let ended = order(&["retarget", "--top-speed", "900", "--accel", "3000"]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(
        ended.stdout.contains(": acceleration 3000 steps/s², top speed 900 steps/s\n"),
        "{ended:?}"
    );
    order(&["retarget", "99", "--top-speed", "20"]).assert_error("refused t20: slower than");
    let ended = order(&["retarget", "-100", "--format", "json"]);
    assert!(ended.stdout.contains(r#""lines":["@-100"]"#), "{ended:?}");
    let begin = Instant::now();
    while order(&["position"]).last_line() != "position -100 ready" {
        assert!(begin.elapsed() < LIMIT, "it never comes back");
        thread::sleep(Duration::from_millis(50));
    }
    board.signal(Signal::INT);
    board.end();
}

/// What comes from a terminal until it holds this.
#[track_caller]
fn wait_for(terminal: &mut File, seen: &mut String, part: &str) {
    let begin = Instant::now();
    while !seen.contains(part) {
        let mut bytes = [0; 512];
        let count = terminal.read(&mut bytes).unwrap_or(0);
        seen.push_str(&String::from_utf8_lossy(&bytes[..count]));
        assert!(begin.elapsed() < LIMIT && count > 0, "no {part:?} in {seen}");
    }
}

#[test]
fn keys_change_the_speed_and_stop_and_the_terminal_is_given_back() {
    let (mut terminal, path) = pty();
    let side = || Stdio::from(File::options().read(true).write(true).open(&path).unwrap());
    let kept = File::open(&path).unwrap();
    let before = tcgetattr(&kept).unwrap().local_modes;
    let mut child = Command::new(common::program())
        .args(["move", "-1000000"])
        .stdin(side())
        .stderr(side())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut seen = String::new();
    wait_for(&mut terminal, &mut seen, "keys: + faster, - slower, s stop");
    assert_ne!(tcgetattr(&kept).unwrap().local_modes, before);
    for (key, said) in [("+", "top speed 1100"), ("-", "top speed 990"), ("s", "braking")] {
        terminal.write_all(key.as_bytes()).unwrap();
        wait_for(&mut terminal, &mut seen, said);
    }
    wait_for(&mut terminal, &mut seen, "error: braked at -");
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130), "{seen}");
    assert_eq!(tcgetattr(&kept).unwrap().local_modes, before);
    let mut out = String::new();
    child.stdout.unwrap().read_to_string(&mut out).unwrap();
    assert!(out.trim_end().ends_with("stopped"), "{out}");
}

/// 0.004 steps/s, as a telescope turns: on the virtual board, and over a port.
#[test]
fn speeds_in_thousandths_of_a_step_per_second() {
    let vcd = common::Scratch::new("slow.vcd");
    let ended = common::stepwright(&[
        "move",
        "3",
        "--top-speed",
        "0.004",
        "--fast",
        "--vcd",
        vcd.path(),
        "--format",
        "json",
    ]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(ended.stdout.contains(r#""lines":["PO","S5","m4","R1","G+3","E"]"#), "{ended:?}");
    // In 100 ps: rising edges 250 s apart, to the microsecond.
    let text = std::fs::read_to_string(vcd.path()).unwrap();
    let (mut now, mut rises, mut step) = (0i64, Vec::new(), "");
    for line in text.lines() {
        match line.strip_prefix('#') {
            Some(time) => now = time.parse().unwrap(),
            None if line.contains(" step1 ") => step = line.split_whitespace().nth(3).unwrap(),
            None if !step.is_empty() && line == format!("1{step}") => rises.push(now),
            None => {}
        }
    }
    assert_eq!(rises.len(), 3, "{text}");
    for pair in rises.windows(2) {
        assert!((pair[1] - pair[0] - 2_500_000_000_000).abs() < 10_000, "{rises:?}");
    }
    // A plan of what is refused would be none.
    for (order, says) in [
        (
            &["move", "3", "--top-speed", "0.003"][..],
            "5 min 33 s between two steps at 0.003 steps/s",
        ),
        (&["run", "0.001", "--for", "1s"], "16 min 40 s between two steps at 0.001 steps/s"),
        (
            &["move", "9", "--start-speed", "0", "--top-speed", "0.005"],
            "16 min 40 s for the first step and the last from rest, and one at 0.005 steps/s",
        ),
        // The slower of two axes.
        (
            &["line", "4", "-2", "--start-speed", "2", "--accel", "9", "--top-speed", "0.006"],
            "8 min 20 s between two steps at 0.002 steps/s",
        ),
    ] {
        let ended = common::stepwright(&[order, &["--fast"]].concat());
        assert_eq!((ended.code(), ended.stdout.as_str()), (Some(1), ""), "{ended:?}");
        ended.assert_error(&format!("slower than the board can wait: {says}"));
    }

    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let order = |order: &[&str]| common::stepwright(&[order, &["--port", &port]].concat());
    let ended = order(&["move", "3", "--top-speed", "7.5"]);
    assert!(ended.stdout.contains("m7500"), "{ended:?}");
    ended.assert(0, "position 3 ready");
    let ended = order(&["run", "-0.25", "--start-speed", "0", "--accel", "1", "--detach"]);
    assert!(ended.stdout.contains("m250"), "{ended:?}");
    let ended = order(&["retarget", "--top-speed", "0.125"]);
    assert!(ended.stdout.contains(": top speed 0.125 steps/s"), "{ended:?}");
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    board.signal(Signal::INT);
    board.end();
}
