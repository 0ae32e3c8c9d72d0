//! `stepwright status`: switches, faults, the reason of the last stop, and what was set.
#![cfg(unix)]

use crate::common::{Running, stepwright};
use serde_json::{Value, json};

/// A virtual board with a switch 100 steps behind its first axis.
struct Board {
    _running: Running,
    port: String,
}

impl Board {
    fn start() -> Board {
        let mut running = Running::start(&["board", "--pty", "--fast", "--switch", "1:-100"]);
        let port = running.wait_out("pty ").replace("pty ", "");
        Board { _running: running, port }
    }

    fn send(&self, lines: &[&str]) {
        stepwright(&[&["send", "--port", &self.port], lines].concat());
    }

    fn text(&self) -> String {
        stepwright(&["status", "--port", &self.port]).stdout
    }

    /// The row with this name.
    #[track_caller]
    fn row(&self, name: &str) -> Option<String> {
        let text = self.text();
        let row = text.lines().find_map(|line| line.strip_prefix(name).map(str::trim_start));
        row.map(str::to_owned)
    }

    fn json(&self) -> Value {
        let ended = stepwright(&["status", "--format", "json", "--port", &self.port]);
        serde_json::from_str(&ended.stdout).unwrap()
    }
}

#[test]
fn the_switches_that_the_board_knows_of() {
    let board = Board::start();
    assert_eq!((board.row("switches"), &board.json()["switches"]), (None, &json!([])));
    board.send(&["$switches=5", "$switch-forward=4", "$switch-high=4"]);
    // Z of this machine is wired to nothing: its pull-up is a closed switch to 5 V.
    let row = "axis 1 backward open (reads high), axis 3 forward closed (reads high)";
    assert_eq!(board.row("switches").as_deref(), Some(row));
    stepwright(&["move", "-400", "--port", &board.port])
        .assert(1, "position -100 stopped by its limit switch");
    let row =
        "axis 1 backward closed (reads low, has stopped it), axis 3 forward closed (reads high)";
    assert_eq!(board.row("switches").as_deref(), Some(row));
    let mut first = json!({
        "axis": 1, "end": "backward", "closed": true, "level_when_closed": "low", "stopped": true
    });
    assert_eq!(board.json()["switches"][0], first);
    let third = json!({
        "axis": 3, "end": "forward", "closed": true, "level_when_closed": "high", "stopped": false
    });
    assert_eq!(board.json()["switches"][1], third);
    // Away from it, and it is open.
    stepwright(&["move", "60", "--port", &board.port]).assert(0, "position -40 ready");
    let row = "axis 1 backward open (reads high), axis 3 forward closed (reads high)";
    assert_eq!(board.row("switches").as_deref(), Some(row));
    first["closed"] = json!(false);
    first["stopped"] = json!(false);
    assert_eq!(board.json()["switches"][0], first);
}

#[test]
fn the_faults_until_they_are_forgotten() {
    let board = Board::start();
    assert_eq!(board.row("faults").as_deref(), Some("none since the last !"));
    board.send(&["$switches=1"]);
    stepwright(&["move", "-400", "--port", &board.port]);
    board.send(&["K"]);
    assert_eq!(board.row("faults").as_deref(), Some("a limit switch, a kill (K) since the last !"));
    assert_eq!(board.json()["board"]["errors"], json!(["switch", "kill"]));
    board.send(&["!"]);
    assert_eq!(board.row("faults").as_deref(), Some("none since the last !"));
    assert_eq!(board.json()["board"]["errors"], json!([]));
}

#[test]
fn the_reason_of_the_last_stop_until_the_axis_moves_again() {
    let board = Board::start();
    board.send(&["$switches=1"]);
    assert_eq!(board.row("axis 1").as_deref(), Some("position 0 ready"));
    stepwright(&["move", "-400", "--port", &board.port]);
    let row = "position -100 ready, stopped by its limit switch";
    assert_eq!(board.row("axis 1").as_deref(), Some(row));
    assert_eq!(board.json()["axes"][0]["stop"], "switch");
    stepwright(&["move", "50", "--port", &board.port]).assert(0, "position -50 ready");
    assert_eq!(board.row("axis 1").as_deref(), Some("position -50 ready"));
    stepwright(&["run", "200", "--detach", "--port", &board.port]);
    stepwright(&["stop", "--port", &board.port]);
    assert!(board.row("axis 1").unwrap().ends_with(" ready, stopped by a soft stop (Z)"));
    assert_eq!(board.json()["axes"][0]["stop"], "stop");
}

#[test]
fn the_settings_that_differ_from_their_defaults() {
    let board = Board::start();
    assert_eq!((board.row("settings"), &board.json()["settings"]), (None, &json!({})));
    board.send(&["$idle-ms=500", "$pulse-us=2", "$switches=3"]);
    assert_eq!(board.row("settings").as_deref(), Some("idle-ms=500 switches=3"));
    assert_eq!(board.json()["settings"], json!({ "idle-ms": 500, "switches": 3 }));
}

#[test]
fn the_extras_of_the_board() {
    let board = Board::start();
    assert_eq!(board.row("extras").as_deref(), Some("jerk, safety, sum"));
    assert_eq!(board.json()["board"]["can"], json!(["jerk", "safety", "sum"]));
}
