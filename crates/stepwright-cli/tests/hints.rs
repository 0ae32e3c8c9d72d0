//! Hints: what the command says where a reader would be lost, one test for each.
#![cfg(unix)]

use std::fs;

use crate::common::{Ended, Running, Scratch, stepwright};
use rustix::process::Signal;
use serde_json::Value;

/// A virtual board that other commands talk to, quicker than in real time.
struct Board {
    running: Running,
    port: String,
}

impl Board {
    fn start(options: &[&str]) -> Board {
        let mut running = Running::start(&[&["board", "--pty", "--fast"], options].concat());
        let port = running.wait_out("pty ").replace("pty ", "");
        Board { running, port }
    }

    fn order(&self, words: &[&str]) -> Ended {
        stepwright(&[words, &["--port", &self.port]].concat())
    }

    #[track_caller]
    fn set(&self, settings: &[&str]) {
        let ended = self.order(&[&["settings", "set"], settings].concat());
        assert_eq!(ended.code(), Some(0), "{ended:?}");
    }

    /// The hint behind a refusal, the same on a terminal and for programs.
    #[track_caller]
    fn refused(&self, words: &[&str]) -> String {
        let json = self.order(&[words, &["--format", "json"]].concat());
        let said = failure(&json);
        assert_eq!((json.code(), said["status"].as_u64()), (Some(1), Some(1)), "{json:?}");
        let text = self.order(words);
        let hint = text.stderr.lines().find_map(|line| line.strip_prefix(" hint: "));
        assert_eq!(hint, said["hint"].as_str(), "{text:?}");
        hint.unwrap_or_default().to_owned()
    }
}

/// The failure of a command with `--format json`: the last line on standard error.
#[track_caller]
fn failure(ended: &Ended) -> Value {
    assert_eq!(ended.stdout, "", "{ended:?}");
    let last = ended.stderr.lines().last().unwrap_or_default();
    serde_json::from_str(last).unwrap_or_else(|_| panic!("{ended:?}"))
}

#[track_caller]
fn holds(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part:?} in {text:?}");
    }
}

#[test]
fn a_speed_beyond_max_speed_names_the_setting() {
    let board = Board::start(&[]);
    board.set(&["max-speed=500"]);
    let hint = board.refused(&["move", "400", "--top-speed", "600"]);
    holds(&hint, &["max-speed=500", "stepwright settings set max-speed=N --port"]);
    // Without it the board's own rate is named, and what makes it slow.
    board.set(&["max-speed=1000000", "pulse-us=20"]);
    let hint = board.refused(&["move", "400", "--top-speed", "300000"]);
    holds(&hint, &["one axis alone makes at most ", "pulse-us=20 makes it slower"]);
}

#[test]
fn a_speed_that_is_too_slow_names_the_option_that_helps() {
    let board = Board::start(&[]);
    let slow = ["move", "2", "--top-speed", "0.004"];
    let hint = board.refused(&[&slow[..], &["--start-speed", "0.001"]].concat());
    holds(&hint, &["--start-speed"]);
    let ended = stepwright(&[&slow[..], &["--start-speed", "1", "--fast"]].concat());
    ended.assert(0, "position 2 ready");
}

#[test]
fn a_ramp_beyond_max_accel_names_the_setting() {
    let board = Board::start(&[]);
    board.set(&["max-accel=5000"]);
    holds(&board.refused(&["move", "400", "--accel", "8000"]), &["max-accel=5000", "--accel"]);
}

#[test]
fn a_target_beyond_a_soft_limit_names_the_settings() {
    let board = Board::start(&[]);
    board.set(&["soft-limits=1", "ahead-x=100"]);
    holds(&board.refused(&["move", "400"]), &["ahead-x=100", "soft-limits=1", "go less far"]);
}

/// Its position is never the same twice.
#[test]
fn an_axis_that_moves_fast_is_not_taken_for_a_silent_board() {
    let board = Board::start(&["--switch", "1:-300"]);
    board.set(&["switches=1"]);
    assert_eq!(board.order(&["run", "2000", "--detach"]).code(), Some(0));
    let home = ["home", "--within", "400"];
    for order in [&["move", "5"][..], &["line", "5", "5"], &["run", "5"], &home] {
        let ended = board.order(order);
        ended.assert_error("axis 1 is on its way");
        holds(&ended.stderr, &["`stepwright watch --axis 1 --port", "`stepwright stop --axis 1 "]);
        assert_eq!(ended.code(), Some(1), "{ended:?}");
    }
    assert_eq!(board.order(&["stop"]).code(), Some(0));
}

#[test]
fn a_closed_switch_is_named_and_after_it_what_safe_start_asks_for() {
    let board = Board::start(&["--switch", "1:-100"]);
    board.set(&["switches=1", "safe-start=1"]);
    let ended = board.order(&["move", "-400"]);
    ended.assert(1, "position -100 stopped by its limit switch");
    let hint = board.refused(&["move", "-4"]);
    holds(&hint, &["safe-start=1", "stepwright send --port", "'!'"]);
    assert_eq!(board.order(&["send", "!"]).code(), Some(0));
    let hint = board.refused(&["move", "-4"]);
    holds(&hint, &["a limit switch is closed", "switches=1", "stepwright status --port"]);
    board.order(&["move", "150"]).assert(0, "position 50 ready");
}

#[test]
fn homing_first_names_the_setting_and_the_command() {
    let board = Board::start(&[]);
    board.set(&["home-first=1", "switches=1"]);
    // Its position is known since it was switched on; a kill loses it.
    assert_eq!(board.order(&["send", "PO", "S5", "T10", "R9", "G+9000", "E", "K"]).code(), Some(0));
    let ended = board.order(&["move", "10"]);
    holds(&ended.stderr, &["uncertain", "stepwright zero --axis 1 --port"]);
    let ended = board.order(&["send", "PO", "S5", "T10", "R9", "G+9", "E"]);
    holds(&ended.stderr, &["the reason for the last: the position is not known"]);
}

#[test]
fn a_jerk_that_the_board_would_ignore_names_the_setting() {
    let board = Board::start(&[]);
    board.set(&["law=0"]);
    let hint = board.refused(&["move", "400", "--jerk", "40000"]);
    holds(&hint, &["stepwright settings set law=1 --port", "leave --jerk out"]);
}

#[test]
fn a_change_of_a_motor_at_rest_names_the_commands_that_move() {
    let board = Board::start(&[]);
    holds(&board.refused(&["retarget", "100"]), &["stepwright move", "stepwright run"]);
}

/// One rule: 2 is what makes no sense whatever the board, 1 is what a board, a file or a
/// calculation refuses.
#[test]
fn exit_statuses_follow_the_rule() {
    let help = stepwright(&["--help"]).stdout;
    holds(&help, &["Exit status:\n", "\n  2    invalid command line, whatever the board"]);
    for (code, words) in [
        (0, &["move", "4", "--fast"][..]),
        (0, &["calc", "timer", "10rpm"]),
        (2, &["move"]),
        (2, &["move", "far"]),
        (2, &["move", "4", "--top-speed", "1e9"]),
        (2, &["move", "4", "--top-speed", "-4"]),
        (2, &["move", "4", "--accel", "1e12"]),
        (2, &["move", "4", "--jerk", "1e18"]),
        (2, &["move", "4mm"]),
        (2, &["move", "1e12"]),
        (2, &["move", "4", "--axis", "9"]),
        (2, &["run", "0", "--for", "1s", "--fast"]),
        (2, &["move", "4", "--plot", "x.pdf"]),
        (2, &["plan", "trapezoid", "--steps", "9", "--accel", "1e9", "--top-speed", "9"]),
        (2, &["timed"]),
        (2, &["settings", "set", "--port", "x", "pulse-us=21"]),
        (1, &["move", "4", "--axis", "4", "--fast"]),
        (1, &["move", "4", "--port", "/dev/none"]),
        (1, &["move", "999999", "--top-speed", "500000", "--fast"]),
        (1, &["calc", "timer", "1e9"]),
        (1, &["cycle", "/dev/none"]),
        (1, &["move", "4", "--fast", "--plot", "/dev/none/x.svg"]),
    ] {
        let ended = stepwright(words);
        assert_eq!(ended.code(), Some(code), "{words:?}: {ended:?}");
        // For programs the same, with the same words.
        let json = stepwright(&[words, &["--format", "json"]].concat());
        let has_json = !["plan", "settings"].contains(&words[0]);
        if code != 0 && has_json {
            let said = failure(&json);
            assert_eq!((json.code(), said["status"].as_i64()), (Some(code), Some(code.into())));
            let message = ended.stderr.lines().find_map(|line| line.strip_prefix("error: "));
            // Those of the options' parser are more than a line on a terminal.
            let first = message.unwrap_or_default();
            assert!(said["error"].as_str().unwrap().starts_with(first), "{words:?}: {said}");
        }
    }
}

#[test]
fn a_belt_takes_a_speed_in_millimetres() {
    let ended = stepwright(&["calc", "belt", "--teeth", "20", "--speed", "60mm/s"]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    holds(&ended.stdout, &["1.5 rev/s", "60 mm/s"]);
    let screw = ["calc", "screw", "--pitch", "2mm", "--starts", "4", "--speed", "4mm/s"];
    holds(&stepwright(&screw).stdout, &["0.5 rev/s", "4 mm/s"]);
}

#[test]
fn a_number_may_have_an_exponent() {
    stepwright(&["move", "1e3", "--top-speed", "2e4", "--fast"]).assert(0, "position 1000 ready");
    let plan = ["plan", "trapezoid", "--steps", "1e9", "--accel", "1e3", "--top-speed", "1e6"];
    holds(&stepwright(&plan).stdout, &["trapezoid: 1000000000 steps"]);
}

#[test]
fn timed_without_a_speed_names_the_options_that_give_one() {
    let ended = stepwright(&["timed"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("no speed: give --speed, --top or --case");
    holds(&ended.stderr, &[" hint: `stepwright timed --speed 250 --steps 1000`"]);
}

#[test]
fn a_port_in_use_says_who_gets_through() {
    let board = Board::start(&[]);
    board.order(&["run", "200", "--detach"]);
    let mut holder = Running::start(&["watch", "--port", &board.port]);
    holder.wait_err("position ");
    let ended = board.order(&["move", "10"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("is in use");
    holds(&ended.stderr, &["`stepwright stop` and `stepwright kill` get through"]);
    assert_eq!(board.order(&["stop"]).code(), Some(0));
}

#[test]
fn the_version_says_the_commands_name() {
    let ended = stepwright(&["--version"]);
    assert_eq!(ended.stdout, format!("stepwright {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_current_of_a_thousand_amperes_is_questioned() {
    let ended = stepwright(&["calc", "vref", "1700"]);
    holds(&ended.stdout, &["1700 A is more than the 2.5 A of a DRV8825: is it in mA?", "1700mA"]);
    assert!(!stepwright(&["calc", "vref", "1700mA"]).stdout.contains("is it in mA"));
}

/// The shaded phases of a plan of two steps fill its panels, no more and no less.
#[test]
fn a_plan_of_two_steps_keeps_its_bands() {
    let svg = Scratch::new("two.svg");
    let plan = ["plan", "trapezoid", "--steps", "2", "--accel", "1e3", "--top-speed", "1e3"];
    let ended = stepwright(&[&plan[..], &["--plot", svg.path()]].concat());
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    let svg = fs::read_to_string(&svg.0).unwrap();
    let number = |line: &str, name: &str| -> f64 {
        let (_, rest) = line.split_once(&format!("{name}=\"")).unwrap();
        rest.split('"').next().unwrap().parse().unwrap()
    };
    // The tint of a way down; the gaps behind its name are 20 pixels high.
    let bands: Vec<_> = (svg.lines())
        .filter(|line| line.contains("#fdf2e9") && !line.contains("height=\"20.0\""))
        .map(|line| (number(line, " x"), number(line, " width")))
        .collect();
    assert_eq!(bands.len(), 4, "{svg}");
    // Speed and acceleration over time, and both over steps.
    assert_eq!((bands[0], bands[1]), (bands[2], bands[3]), "{bands:?}");
    assert!(bands[0].0 + bands[0].1 < bands[1].0 && bands[1].0 + bands[1].1 <= 1200.0, "{bands:?}");
    assert_eq!(svg.matches("fill-opacity=\"0.1\"").count(), 4, "a curve in each");
}

#[test]
fn a_board_that_ctrl_c_ends_at_rest_keeps_its_position() {
    let board = Board::start(&[]);
    board.order(&["move", "400"]).assert(0, "position 400 ready");
    board.running.signal(Signal::INT);
    let ended = board.running.end();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(ended.stderr.ends_with("\nposition 400 ready\n"), "{ended:?}");
}

/// Plans that take minutes say how far they are.
#[test]
fn long_plans_say_how_far_they_are() {
    let limits = ["--accel", "2000", "--top-speed", "1e5"];
    let published = ["--c0", "50000", "--c-min", "2500"];
    for (law, options) in
        [("power", limits.as_slice()), ("piecewise", &limits), ("austin-fixed", &published)]
    {
        let words = [&["plan", law, "--steps", "2147483647"], options].concat();
        let mut plan = Running::start(&words);
        let told = plan.wait_err("");
        holds(&told, &[" % of 2147483647 steps"]);
        // Dropped, and ended with it.
    }
}

/// `plan ramp` has the ranges of S, T, R and G.
#[test]
fn a_plan_of_a_ramp_takes_what_the_line_takes() {
    let plan = |steps: &str, start: &str, top: &str, ramp: &str| {
        stepwright(&[
            "plan",
            "ramp",
            "--steps",
            steps,
            "--start-speed",
            start,
            "--top-speed",
            top,
            "--ramp",
            ramp,
        ])
    };
    for (steps, start, top, ramp) in [
        ("4000", "50", "1000", "200"),
        ("-4000", "50", "1000", "200"),
        ("+4000", "0", "1000", "999"),
        ("-2147483648", "50", "1000", "1"),
        ("2147483647", "50", "1000", "999"),
        ("0", "50", "1000", "200"),
        ("400", "50", "50", "200"),
        ("400", "70", "50", "200"),
        ("400", "0.004", "0.5", "5"),
    ] {
        let ended = plan(steps, start, top, ramp);
        assert_eq!(ended.code(), Some(0), "{steps} {start} {top} {ramp}: {ended:?}");
    }
    assert_eq!(plan("-4000", "50", "1000", "200").stdout, plan("4000", "50", "1000", "200").stdout);
    assert_eq!(plan("2147483648", "50", "1000", "200").code(), Some(2));
    assert_eq!(plan("-2147483649", "50", "1000", "200").code(), Some(2));
}

/// `--vcd` is explained where it is found, and its unit is the longest that is exact.
#[test]
fn a_dump_says_how_it_is_imported_and_has_the_longest_exact_unit() {
    let help = stepwright(&["move", "--help"]).stdout;
    holds(&help, &["PulseView imports it", "sigrok-cli -i edges.vcd", "stepper_motor"]);
    let dump = Scratch::new("unit.vcd");
    let unit = |words: &[&str]| {
        let ended = stepwright(&[words, &["--vcd", dump.path()]].concat());
        assert_eq!(ended.code(), Some(0), "{ended:?}");
        let text = fs::read_to_string(&dump.0).unwrap();
        text.lines().find(|line| line.starts_with("$timescale")).unwrap().to_owned()
    };
    assert_eq!(unit(&["move", "4", "--fast"]), "$timescale 100 ps $end");
    let timed = ["timed", "--speed", "200", "--steps", "9", "--drive", "shield"];
    assert_eq!(unit(&timed), "$timescale 100 ps $end");
    let slow = [&timed[..], &["--oscillator", "1000000"]].concat();
    assert_eq!(unit(&slow), "$timescale 1 us $end");
}

#[test]
fn a_negative_speed_is_told_to_have_no_sign() {
    for option in ["--top-speed", "--start-speed", "--accel", "--decel", "--jerk"] {
        for value in ["-4", "-4rpm"] {
            let ended = stepwright(&["move", "4", "--fast", option, value]);
            assert_eq!(ended.code(), Some(2), "{ended:?}");
            ended.assert_error("give it without a sign");
            holds(&ended.stderr, &[option]);
        }
    }
}

#[test]
fn a_line_of_too_many_numbers_says_how_many_there_may_be() {
    let ended = stepwright(&["line", "1", "2", "3", "4", "--fast"]);
    ended.assert_error("the board has no axis 4");
    holds(&ended.stderr, &["a line has a number for each axis: 3 at most here"]);
}

#[test]
fn one_motor_twice_is_no_way_of_two() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/cycles/triangle.toml");
    let ended = stepwright(&["cycle", example, "--xy", "x.svg", "--xy-motors", "X,X"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("two motors, not one twice");
}
