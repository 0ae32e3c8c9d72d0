//! Lines of several axes by `stepwright serve`, and requests that wait for the end of an order.

use std::net::TcpStream;
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{self, stepwright};
use crate::served::{Served, answered};
use serde_json::{Value, json};

/// Where every axis is, after all rest.
#[track_caller]
fn places(served: &Served) -> Vec<Value> {
    (1..=3).map(|axis| served.rest(axis)["position"].clone()).collect()
}

#[test]
fn a_line_is_the_one_of_the_command() {
    let served = Served::board();
    let done = served.order("/api/line", json!({"by": [2000, -500], "accel": 2500}));
    let line = ["line", "2000", "-500", "--accel", "2500", "--fast", "--format", "json"];
    let ended = stepwright(&line);
    let command: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(done["lines"], command["lines"]);
    assert_eq!(done["ended"], Value::Null);
    let state = served.get("/api/state");
    let moving: Vec<_> =
        state["axes"].as_array().unwrap().iter().map(|one| &one["moving"]).collect();
    assert_eq!(moving, [true, true, false]);
    assert_eq!(places(&served), [2000, -500, 0]);
    // On the way both are in the same part of their travel, so they end together.
    let quick = json!({"to": [0, null, 3000], "top_speed": 2000, "accel": 3000, "jerk": 20_000});
    served.order("/api/line", quick);
    assert_eq!(places(&served), [0, -500, 3000]);
    // A travel of one axis may be said as a line.
    served.order("/api/line", json!({"by": [0, 500]}));
    assert_eq!(places(&served), [0, 0, 3000]);
}

#[test]
fn what_is_no_line_says_why() {
    let served = Served::board();
    for (body, what) in [
        (json!({}), "neither `by` nor `to`"),
        (json!({"by": [1], "to": [1]}), "both `by` and `to`"),
        (json!({"by": []}), "by has 0 numbers"),
        (json!({"by": [1, 2, 3, 4, 5, 6, 7, 8, 9]}), "by has 9 numbers"),
        (json!({"by": [1, 2, 3, 4]}), "the board has no axis 4"),
        (json!({"by": [1, 2_147_483_648_i64]}), "by is 2147483648"),
        (json!({"by": [0, null, 0]}), "no axis moves"),
        (json!({"to": [0, 0]}), "no axis moves"),
        (json!({"to": [5, 3_000_000_000_i64]}), "from 0 to 3000000000 is too far"),
        (json!({"by": [1, 2], "axis": 1}), "unknown field `axis`"),
        (json!({"by": [1, 2], "accel": 0.5}), "accel is 0.5"),
        // Its share of the ramp would be a fraction of a step/s².
        (json!({"by": [1_000_000, 2], "top_speed": 5, "accel": 1}), ""),
    ] {
        let (status, said) = served.post("/api/line", body.clone());
        if !what.is_empty() {
            assert_eq!(status, 422, "{body}: {said}");
            assert!(said["what"].as_str().unwrap().contains(what), "{body}: {said}");
        }
    }
    served.order("/api/stop", json!({}));
    places(&served);
    // All stand still, or none begins.
    served.order("/api/move", json!({"axis": 2, "by": 100_000}));
    let before = served.axis(1)["position"].clone();
    let why = served.declined("/api/line", json!({"by": [10, 10]}), 409);
    assert_eq!(why, "axis 2 is on its way");
    served.order("/api/kill", json!({}));
    served.rest(2);
    let why = served.declined("/api/line", json!({"by": [10, 10]}), 409);
    assert_eq!(why, "the position of axis 2 is uncertain");
    served.order("/api/line", json!({"by": [10, null, 10]}));
    assert_eq!(served.rest(1)["position"].as_i64(), before.as_i64().map(|at| at + 10));
    let mut other = served;
    other.key.clear();
    other.declined("/api/line", json!({"by": [1]}), 409);
}

#[test]
fn a_stop_ends_a_line_and_keeps_the_positions() {
    let served = Served::board();
    served.order("/api/line", json!({"by": [200_000, 100_000], "top_speed": 2000}));
    served.wait(1, |axis| axis["position"].as_i64() > Some(500));
    served.order("/api/stop", json!({}));
    let at: Vec<_> = places(&served).iter().map(|at| at.as_i64().unwrap()).collect();
    assert!(at[0] > 500 && (at[0] - 2 * at[1]).abs() <= 20, "{at:?}");
}

/// What such a request is answered in the end.
#[track_caller]
fn concluded(stream: TcpStream) -> Value {
    let (status, done) = answered(stream);
    assert_eq!(status, 200, "{done}");
    done["ended"].clone()
}

/// What the answer says that has waited.
#[track_caller]
fn ended(served: &Served, path: &str, body: Value) -> Value {
    let done = served.order(&format!("{path}?wait=true"), body);
    assert!(!done["lines"].as_array().unwrap().is_empty(), "{done}");
    done["ended"].clone()
}

#[test]
fn an_answer_that_waits_says_how_the_order_ended() {
    let served = Served::start(&["--virtual", "--switch", "1:-300"]);
    let quick = |more: Value| {
        let mut body = json!({"top_speed": 3000, "accel": 20000});
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        body
    };
    let reached = ended(&served, "/api/move", quick(json!({"axis": 2, "by": 600})));
    assert_eq!(reached["outcome"], "reached", "{reached}");
    let axis = json!({"axis": 2, "position": 600, "target": 600, "stop": null});
    assert_eq!(reached["axes"], json!([axis]));
    // What is asked next is asked of an axis that rests.
    assert_eq!(served.axis(2)["state"], "ready");
    let line = ended(&served, "/api/line", quick(json!({"to": [300, 0]})));
    assert_eq!((&line["outcome"], line["axes"].as_array().unwrap().len()), (&json!("reached"), 2));
    // No steps are no reason to wait for ever.
    let none = ended(&served, "/api/move", quick(json!({"axis": 3, "by": 0})));
    assert_eq!(none["outcome"], "reached");
    // The switch is in the way.
    served.order("/api/set", json!({"name": "switches", "value": 1}));
    let stopped = ended(&served, "/api/move", quick(json!({"axis": 1, "by": -5000})));
    assert_eq!(stopped["outcome"], "stopped", "{stopped}");
    assert_eq!(stopped["words"], "axis 1 was stopped by its limit switch");
    assert_eq!(stopped["axes"][0]["stop"]["name"], "switch");
    assert_eq!(stopped["axes"][0]["target"], -4700);
    served.order("/api/acknowledge", json!({}));
    let home = json!({"axis": 1, "speed": 3000, "slow": 500, "accel": 20000, "within": 9000});
    let homed = ended(&served, "/api/home", home);
    assert_eq!(homed["outcome"], "reached", "{homed}");
    assert_eq!(homed["axes"][0]["position"], 50);
    // None stands there.
    served.order("/api/set", json!({"name": "switches", "value": 3}));
    let home = json!({"axis": 2, "speed": 3000, "accel": 20000, "within": 200});
    let not = ended(&served, "/api/home", home);
    assert_eq!(not["outcome"], "stopped", "{not}");
    assert!(not["words"].as_str().unwrap().contains("no switch of axis 2"), "{not}");
    assert!(not["do"].is_string() && not["axes"][0]["position"].is_i64(), "{not}");
}

#[test]
fn who_waits_holds_up_no_stop_and_hears_of_it() {
    let served = Served::board();
    for (path, outcome, words, position) in [
        ("/api/stop", "stopped", "axis 1 was stopped by a soft stop (Z)", true),
        ("/api/kill", "uncertain", "the position of axis 1 is uncertain", false),
    ] {
        let waits = served.waiting("/api/line", &json!({"by": [1_000_000, 500_000]}));
        served.wait(1, |axis| axis["speed"].as_f64() > Some(100.0));
        let begin = Instant::now();
        served.order(path, json!({}));
        let said = concluded(waits);
        assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());
        assert_eq!(said["outcome"], outcome, "{said}");
        assert!(said["words"].as_str().unwrap().contains(words), "{said}");
        assert_eq!(said["axes"][0]["position"].is_i64(), position, "{said}");
        served.rest(1);
    }
}

/// A change of the target is where the travel ends; another order is another one.
#[test]
fn who_waits_hears_of_the_order_and_no_other() {
    let served = Served::board();
    let waits = served.waiting("/api/move", &json!({"axis": 1, "by": 100_000}));
    served.wait(1, |axis| axis["position"].as_i64() > Some(20));
    served.order("/api/retarget", json!({"axis": 1, "to": 900}));
    let said = concluded(waits);
    assert_eq!(said["outcome"], "reached", "{said}");
    assert_eq!(said["axes"][0]["target"], 900);
    // One of two axes has another order before the line has ended.
    let line = json!({"by": [-900, 9000, 0], "top_speed": 2000, "accel": 20000});
    let waits = served.waiting("/api/line", &line);
    served.wait(2, |axis| axis["moving"] == true);
    served.order("/api/stop", json!({"axis": 1}));
    let at = served.rest(1)["position"].clone();
    served.order("/api/move", json!({"axis": 1, "by": 300_000}));
    let said = concluded(waits);
    assert_eq!(said["outcome"], "stopped", "{said}");
    assert_eq!(said["axes"][0]["position"], at, "{said}");
    assert_eq!(said["axes"][1]["position"], 9000, "{said}");
    assert_eq!(served.axis(1)["moving"], true);
    served.order("/api/stop", json!({}));
}

#[test]
fn who_hangs_up_leaves_the_motion_as_it_is_without_waiting() {
    let served = Served::start(&["--virtual", "--switch", "1:-100000"]);
    served.order("/api/set", json!({"name": "switches", "value": 1}));
    let stream = served.waiting("/api/move", &json!({"axis": 2, "by": 3000}));
    served.wait(2, |axis| axis["position"].as_i64() > Some(20));
    drop(stream);
    assert_eq!(served.rest(2)["position"], 3000);
    // A homing goes on as long as its request waits, and no longer.
    let home = json!({"axis": 1, "speed": 800, "within": 90_000});
    let stream = served.waiting("/api/home", &home);
    served.wait(1, |axis| axis["moving"] == true);
    thread::sleep(Duration::from_millis(2500));
    assert_eq!(served.axis(1)["home"]["stage"], "seek");
    // Nor does anybody take control from who waits.
    let (status, said) = served.post("/api/control", json!({}));
    assert_eq!(status, 409, "{said}");
    drop(stream);
    let axis = served.rest(1);
    assert_eq!((&axis["home"]["stage"], &axis["state"]), (&json!("failed"), &json!("ready")));
}

#[test]
fn only_what_has_an_end_is_waited_for() {
    let served = Served::board();
    let body = json!({"axis": 1, "by": 5});
    for (path, allowed) in
        [("wait=1", "true, false"), ("wait=", "true, false"), ("wat=true", "wait=true")]
    {
        let (status, said) = served.post(&format!("/api/move?{path}"), body.clone());
        assert_eq!((status, &said["allowed"]), (422, &json!(allowed)), "{path}: {said}");
    }
    assert_eq!(served.order("/api/move?wait=false", body)["ended"], Value::Null);
    assert_eq!(served.rest(1)["position"], 5);
}

/// Nothing is started, and so nothing is waited for.
#[test]
fn what_is_declined_is_answered_at_once() {
    let served = Served::board();
    served.declined("/api/move?wait=true", json!({"axis": 4, "by": 5}), 422);
    served.declined("/api/home?wait=true", json!({"axis": 1, "within": 50}), 409);
    served.order("/api/move", json!({"axis": 1, "by": 100_000}));
    served.declined("/api/move?wait=true", json!({"axis": 1, "by": 5}), 409);
}

/// Who moved it is told where it came to by the positions of then.
#[test]
fn an_axis_that_is_zeroed_as_it_comes_to_rest_has_reached_its_target() {
    let served = Served::board();
    for _ in 0..10 {
        let moves = served.waiting("/api/move", &json!({"axis": 1, "by": 40, "top_speed": 2000}));
        served.wait(1, |axis| axis["position"].as_i64() > Some(0));
        while served.post("/api/zero", json!({"axis": 1})).0 != 200 {}
        let ended = concluded(moves);
        assert_eq!(ended["outcome"], "reached", "{ended}");
    }
}

#[cfg(unix)]
#[test]
fn who_waits_hears_that_the_board_is_lost_or_the_server_ends() {
    let name = common::Scratch::new("port");
    let mut board = common::Running::start(&["board", "--pty"]);
    let path = board.wait_out("pty ").trim_start_matches("pty ").to_owned();
    std::os::unix::fs::symlink(path, &name.0).unwrap();
    let served = Served::start(&["--port", name.path()]);
    let waits = served.waiting("/api/line", &json!({"by": [100_000, 5000]}));
    served.wait(1, |axis| axis["position"].as_i64() > Some(20));
    drop(board);
    let (status, said) = answered(waits);
    assert_eq!((status, &said["do"]), (503, &json!("a motor may be moving: look at it")), "{said}");
    let served = Served::board();
    let waits = served.waiting("/api/move", &json!({"axis": 1, "by": 100_000}));
    served.wait(1, |axis| axis["position"].as_i64() > Some(20));
    served.command.signal(rustix::process::Signal::INT);
    let mut answer = String::new();
    // It brakes first; the answer may be cut off by the end.
    let _ = std::io::Read::read_to_string(&mut &waits, &mut answer);
    assert!(answer.is_empty() || answer.contains("\"stopped\""), "{answer}");
}
