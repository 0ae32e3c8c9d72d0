//! Ctrl-C: once brakes, twice kills. (Other signals: `signals.rs`.)
#![cfg(unix)]

use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

use crate::common::{self, Running};
use rustix::process::Signal;

/// Braking from this speed takes ten seconds: time to press again.
const SLOW_BRAKE: [&str; 6] = ["--top-speed", "2000", "--accel", "20000", "--decel", "200"];

fn moving(order: &[&str]) -> Running {
    let mut running = Running::start(order);
    // A line a second, once it moves.
    running.wait_err("position");
    running
}

fn position(line: &str, state: &str) -> i64 {
    let position = line.strip_prefix("position ").and_then(|line| line.strip_suffix(state));
    position.and_then(|text| text.trim().parse().ok()).unwrap_or_else(|| panic!("{line}"))
}

#[test]
fn once_brakes_a_move_and_the_position_is_known() {
    let running = moving(&["move", "1000000"]);
    running.signal(Signal::INT);
    let ended = running.end();
    let at = position(ended.last_line(), "stopped");
    assert!(at > 200 && at < 1_000_000, "{ended:?}");
    assert_eq!(ended.code(), Some(130), "{ended:?}");
    assert!(ended.stderr.contains("braking; Ctrl-C again kills"), "{ended:?}");
    ended.assert_error(&format!("braked at {at}, {} steps before 1000000", 1_000_000 - at));
}

#[test]
fn twice_kills_a_move_and_the_position_is_lost() {
    let mut running = moving(&[&["move", "1000000"], &SLOW_BRAKE[..]].concat());
    running.signal(Signal::INT);
    running.wait_err("braking");
    running.signal(Signal::INT);
    let ended = running.end();
    ended.assert(130, "position uncertain");
    ended.assert_error("killed");
}

#[test]
fn once_brakes_a_line_and_twice_kills_it() {
    let running = moving(&["line", "1000000", "-500000"]);
    running.signal(Signal::INT);
    let ended = running.end();
    let places = ended.last_line().strip_prefix("position ").unwrap().strip_suffix(" stopped");
    let places: Vec<i64> = places.unwrap().split(' ').map(|at| at.parse().unwrap()).collect();
    // Near the line: each brakes from the end of what is planned for it, up to 16 ms on.
    assert!(places[0] > 200 && (places[0] + 2 * places[1]).abs() <= 40, "{ended:?}");
    assert_eq!(ended.code(), Some(130), "{ended:?}");

    let mut running = moving(&[&["line", "1000000", "-500000"], &SLOW_BRAKE[..]].concat());
    running.signal(Signal::INT);
    running.wait_err("braking");
    running.signal(Signal::INT);
    running.end().assert(130, "position uncertain");
}

#[test]
fn once_ends_a_run_as_it_should() {
    let running = moving(&["run", "1000"]);
    running.signal(Signal::INT);
    let ended = running.end();
    assert!(position(ended.last_line(), "ready") > 200, "{ended:?}");
    assert_eq!(ended.code(), Some(0), "{ended:?}");
}

#[test]
fn twice_kills_a_run() {
    let mut running = moving(&["run", "-2000", "--accel", "20000", "--decel", "200"]);
    running.signal(Signal::INT);
    running.wait_err("braking");
    running.signal(Signal::INT);
    running.end().assert(130, "position uncertain");
}

#[test]
fn a_fast_endless_run_can_be_stopped() {
    let running = moving(&["run", "1000", "--for", "9999h", "--fast"]);
    running.signal(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code(), Some(130), "{ended:?}");
    assert!(position(ended.last_line(), "ready") > 0, "{ended:?}");
}

#[test]
fn the_board_ends_at_once() {
    let mut running = Running::start(&["board", "--stdio"]);
    let mut stdin = running.child.stdin.take().unwrap();
    stdin.write_all(b"PO\rG-40\rE\rF\r").unwrap();
    running.wait_out("B");
    running.signal(Signal::INT);
    // It does not wait for the end of its input.
    let ended = running.end();
    // The motor was on its way.
    assert_eq!(ended.code(), Some(130), "{ended:?}");
    let said = "position uncertain\nerror: the board was ended while a motor moved\n";
    assert!(ended.stderr.starts_with(said), "{ended:?}");
    drop(stdin);
}

#[test]
fn a_reader_that_has_seen_enough_stops_no_motor() {
    let mut child = Command::new(common::program())
        .args(["move", "1500"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    // `stepwright move 1500 | head -1`: the rest is said to nobody.
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with("axis 1"), "{line}");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
