//! `stepwright home`: 0 by a limit switch, on a virtual machine.
#![cfg(unix)]

use crate::common::{self, Ended, Running, stepwright};

/// A machine on a pseudo-terminal.
struct Machine {
    _board: Running,
    port: String,
}

impl Machine {
    fn start(options: &[&str]) -> Machine {
        let mut board = Running::start(&[&["board", "--pty", "--fast"], options].concat());
        let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
        Machine { _board: board, port }
    }

    fn order(&self, words: &[&str]) -> Ended {
        stepwright(&[words, &["--port", &self.port]].concat())
    }

    #[track_caller]
    fn ready(&self, words: &[&str], last: &str) {
        let ended = self.order(words);
        assert_eq!((ended.code(), ended.stdout.lines().last()), (Some(0), Some(last)), "{ended:?}");
    }

    #[track_caller]
    fn fails(&self, words: &[&str], why: &str) {
        let ended = self.order(words);
        assert!(ended.code() != Some(0) && ended.stderr.contains(why), "{ended:?}");
    }

    /// The board sends `line`'s answer.
    fn send(&self, line: &str) {
        assert_eq!(self.order(&["send", line]).code(), Some(0));
    }
}

/// 0 is where the switch closes, from wherever the axis begins, and each time again.
#[test]
fn zero_is_where_the_switch_closes() {
    let machine = Machine::start(&["--switch", "1:-300", "--switch", "2:40"]);
    machine.fails(&["home", "--within", "9000"], "knows of no limit switch of axis 1");
    machine.send("$switches=3");
    machine.send("$switch-forward=2");
    machine.ready(&["home", "--within", "9000"], "position 50 ready");
    // The shaft is 250 behind its place at power-up; from beyond the switch it is the same.
    machine.ready(&["move", "--to", "800"], "position 800 ready");
    machine.ready(
        &["home", "--within", "9000", "--speed", "3000", "--accel", "20000"],
        "position 50 ready",
    );
    machine.ready(
        &["home", "--within", "9000", "--back-off", "90deg", "--slow", "30"],
        "position 50 ready",
    );
    machine.ready(
        &["home", "--within", "9000", "--axis", "2", "--back-off", "7"],
        "position -7 ready",
    );
    // What stands at the switch gets away from it.
    machine.fails(&["run", "-200", "--for", "30s"], "stopped by its limit switch");
    machine.ready(&["home", "--within", "9000", "--back-off", "20"], "position 20 ready");
}

/// A run whose time is over brakes; a switch that comes before the end of its ramp is told of.
#[test]
fn a_run_that_a_switch_halts_as_it_brakes_is_not_ready() {
    let mut board = Running::start(&["board", "--pty", "--switch", "1:-300"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let machine = Machine { _board: board, port };
    machine.send("$switches=1");
    let ended =
        machine.order(&["run", "-400", "--for", "300ms", "--accel", "2000", "--decel", "100"]);
    let last = ended.stdout.lines().last();
    assert_eq!(last, Some("position -300 stopped by its limit switch"), "{ended:?}");
    assert!(ended.code() == Some(1) && ended.stderr.contains("stopped by its limit switch"));
}

/// No switch is found where there is none; nothing is called 0 then, and nothing goes further than
/// was said, however gently it brakes.
#[test]
fn a_switch_that_is_not_there() {
    let machine = Machine::start(&[]);
    machine.send("$switches=1");
    machine.fails(&["home", "--within", "300"], "no switch of axis 1 within 300 steps");
    machine.ready(&["position"], "position -300 ready");
    let gentle = ["home", "--within", "500", "--accel", "2000", "--decel", "100"];
    machine.fails(&gentle, "no switch of axis 1 within 500 steps");
    machine.ready(&["position"], "position -800 ready");
    machine.fails(&["home", "--within", "9000", "--back-off", "0"], "a distance of 1 step or more");
}

/// An axis goes as far as it was told to, also one whose ramps are all of its way.
#[test]
fn a_switch_just_within_is_found() {
    for way in [
        "home --within 1100 --accel 100 --speed 500",
        "home --within 1001 --accel 100 --speed 500",
        "home --within 1050 --accel 200 --speed 1000 --start-speed 0",
        "home --within 1050 --accel 200 --speed 1000 --decel 2000",
        "home --within 1050 --accel 200 --speed 1000 --jerk 300",
        "home --within 1050 --accel 2000 --speed 1000 --jerk 3000",
    ] {
        let words: Vec<_> = way.split(' ').chain(["--fast"]).collect();
        stepwright(&words).assert(0, "position 50 ready");
    }
    stepwright(&["home", "--within", "999", "--fast"])
        .assert_error("no switch of axis 1 within 999 steps");
}

/// A board that refuses travels by a distance takes a run, which is braked in time.
#[test]
fn homing_a_lost_axis_and_one_with_soft_limits() {
    // The time of the brake is that of the computer.
    let mut board = Running::start(&["board", "--pty", "--switch", "1:-400"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let machine = Machine { _board: board, port };
    for line in ["$switches=1", "$home-first=1", "$behind-x=0", "$ahead-x=400"] {
        machine.send(line);
    }
    let steep = ["--accel", "2000", "--decel", "1000", "--speed", "1000"];
    let curved = ["--accel", "2000", "--jerk", "20000", "--speed", "600"];
    for ramps in [steep, curved] {
        let home = ["home", "--slow", "500", "--back-off", "20", "--within"];
        let within = |steps| [&home[..], &[steps], &ramps].concat();
        machine.order(&["run", "50", "--detach"]);
        machine.send("K");
        assert!(machine.order(&["position"]).stdout.contains("uncertain"));
        machine.ready(&within("450"), "position 20 ready");
        machine.send("$soft-limits=1");
        machine.ready(&["move", "--to", "400", "--accel", "2000"], "position 400 ready");
        machine.fails(&within("100"), "no switch of axis 1 within 100 steps");
        let at = machine.order(&["position"]).stdout;
        let steps = at.split(' ').nth(1).and_then(|at| at.parse().ok());
        assert!(steps.is_some_and(|at: i32| (20..=303).contains(&at)), "{at}");
        machine.ready(&["move", "--to", "400", "--accel", "2000"], "position 400 ready");
        machine.ready(&within("410"), "position 20 ready");
        machine.send("$soft-limits=0");
    }
}

/// Stops by the switch are acknowledged with `safe-start`; errors from before are not.
#[test]
fn homing_with_safe_start_and_home_first() {
    let machine = Machine::start(&["--switch", "1:-300"]);
    for line in ["$switches=1", "$safe-start=1", "$home-first=1", "K"] {
        machine.send(line);
    }
    machine.fails(&["home", "--within", "9000"], "an axis was stopped");
    machine.send("!");
    machine.ready(&["home", "--within", "9000"], "position 50 ready");
    machine.ready(&["move", "--to", "5"], "position 5 ready");
}

/// A switch that stays closed is not left by the back-off.
#[test]
fn a_switch_that_stays_closed() {
    let machine = Machine::start(&["--switch", "1:1000000"]);
    // Its level is the wrong one: open reads as closed.
    machine.send("$switches=1");
    machine.send("$switch-high=1");
    machine.fails(&["home", "--within", "9000"], "is closed still, 50 steps away");
}

/// A switch that is not there, or not connected, is not looked for until something breaks.
#[test]
fn a_real_axis_is_not_homed_without_a_bound() {
    let machine = Machine::start(&["--switch", "1:-300"]);
    machine.send("$switches=1");
    let ended = machine.order(&["home"]);
    assert_eq!((ended.code(), ended.stdout.as_str()), (Some(2), ""), "{ended:?}");
    ended.assert_error("home needs --within");
    assert!(ended.stderr.contains("home-within"), "{ended:?}");
    machine.ready(&["position"], "position 0 ready");
    let file = common::Scratch::new("within.toml");
    std::fs::write(&file.0, "[axis.1]\nhome-within = \"9turns\"\n").unwrap();
    machine.ready(&["home", "--machine", file.path()], "position 50 ready");
    // The virtual machine's switch is where it always is.
    stepwright(&["home", "--fast"]).assert(0, "position 50 ready");
}
