//! Homing by `stepwright serve`: 0 by a limit switch, and all that may come between.

use std::time::{Duration, Instant};

use crate::common;
use crate::served::{Served, next};
use serde_json::{Value, json};
use tungstenite::Message;

/// A virtual machine whose switch of axis 1 stands there, and whose board knows of it.
fn machine(place: i64) -> Served {
    let served = Served::start(&["--virtual", "--switch", &format!("1:{place}")]);
    served.order("/api/set", json!({"name": "switches", "value": 1}));
    served
}

/// A quick homing.
fn quick() -> Value {
    json!({"axis": 1, "speed": 3000, "slow": 500, "accel": 20000, "within": 200_000})
}

/// How the homing of axis 1 ends. Its page is heard of meanwhile.
#[track_caller]
fn ended(served: &Served) -> Value {
    let axis = served.wait(1, |axis| {
        served.order("/api/control/beat", json!({}));
        ["done", "failed"].iter().any(|stage| axis["home"]["stage"] == **stage)
    });
    axis["home"].clone()
}

#[track_caller]
fn is_homed(served: &Served, position: i64) {
    let home = ended(served);
    assert_eq!(home["stage"], "done", "{home}");
    let axis = served.rest(1);
    assert_eq!((&axis["position"], &axis["state"]), (&json!(position), &json!("ready")));
}

#[test]
fn zero_is_where_the_switch_closes() {
    let served = machine(-300);
    let done = served.order("/api/home", quick());
    assert_eq!(done["lines"].as_array().unwrap().last(), Some(&json!("E")), "{done}");
    assert!(served.axis(1)["home"]["words"].is_string());
    let before = served.axis(1)["origin"].as_u64();
    is_homed(&served, 50);
    assert!(served.axis(1)["origin"].as_u64() > before);
    // That its switch has stopped it was meant, and is no error.
    assert_eq!(served.get("/api/state")["errors"], json!([]));
    // From elsewhere it is the same place, and the axis can be moved again.
    served.order("/api/move", json!({"axis": 1, "to": 700, "top_speed": 3000, "accel": 20000}));
    served.rest(1);
    let mut body = quick();
    body["back_off"] = json!(20);
    served.order("/api/home", body);
    is_homed(&served, 20);
    served.order("/api/move", json!({"axis": 1, "by": 5}));
    assert_eq!(served.rest(1)["position"], 25);
    // Onto the switch and not through it; from there, too.
    served.order("/api/run", json!({"axis": 1, "speed": -1000}));
    assert_eq!(served.rest(1)["stop"]["name"], "switch");
    served.order("/api/home", quick());
    is_homed(&served, 50);
    // That one was not meant, and is kept until it is acknowledged.
    assert_eq!(served.get("/api/state")["errors"][0]["name"], "switch");
    served.order("/api/acknowledge", json!({}));
    assert_eq!(served.get("/api/state")["errors"], json!([]));
}

#[test]
fn a_switch_may_end_the_travel_forward() {
    let served = machine(400);
    served.order("/api/set", json!({"name": "switch-forward", "value": 1}));
    served.order("/api/home", quick());
    is_homed(&served, -50);
}

#[test]
fn a_lost_position_is_found_again() {
    let served = machine(-300);
    for name in ["home-first", "safe-start"] {
        served.order("/api/set", json!({"name": name, "value": 1}));
    }
    served.order("/api/run", json!({"axis": 1, "speed": 800}));
    served.order("/api/kill", json!({}));
    served.rest(1);
    let why = served.declined("/api/home", quick(), 409);
    assert!(why.contains("an axis was stopped"), "{why}");
    served.order("/api/acknowledge", json!({}));
    served.order("/api/home", quick());
    is_homed(&served, 50);
}

#[test]
fn what_can_not_be_homed_says_why() {
    let served = Served::board();
    let (status, said) = served.post("/api/home", quick());
    assert_eq!(status, 409, "{said}");
    assert!(said["what"].as_str().unwrap().contains("knows of no limit switch of axis 1"));
    assert!(said["do"].as_str().unwrap().contains("the setting `switches` says so: 1"), "{said}");
    served.declined("/api/home", json!({"axis": 4, "within": 9}), 422);
    served.declined("/api/home", json!({"axis": 1, "slow": 0}), 422);
    served.declined("/api/home", json!({"axis": 1, "slowly": 5}), 422);
    // None stands there: the axis brakes, and keeps its position.
    served.order("/api/set", json!({"name": "switches", "value": 2}));
    let body = json!({"axis": 2, "speed": 2000, "accel": 20000, "within": 200});
    served.order("/api/home", body);
    let axis = served.wait(2, |axis| axis["home"]["stage"] == "failed");
    let words = axis["home"]["words"].as_str().unwrap();
    assert!(words.contains("no switch of axis 2 within 200 steps"), "{axis}");
    assert_eq!(served.rest(2)["position"], -200);
    assert_eq!(served.axis(1)["position"], 0);
}

/// Nobody but the user knows how far an axis can travel.
#[test]
fn how_far_a_switch_may_be_is_asked_for_or_stands_in_the_machine_file() {
    let served = machine(-300);
    assert_eq!(served.get("/api/board")["axes"][0]["home_within"], Value::Null);
    let mut without = quick();
    without.as_object_mut().unwrap().remove("within");
    let (status, said) = served.post("/api/home", without.clone());
    assert_eq!((status, &said["allowed"]), (422, &json!("1 to 2147483647 steps")), "{said}");
    assert!(said["what"].as_str().unwrap().contains("how far the switch of axis 1"), "{said}");
    assert!(said["do"].as_str().unwrap().contains("home-within = \"300mm\""), "{said}");
    assert_eq!(served.axis(1)["position"], 0);
    let file = common::Scratch::new("machine.toml");
    let text = "[axis.1]\nmm-per-rev = 8\nhome-within = '40mm'\n[axis.2]\nhome-within = 70\n";
    std::fs::write(&file.0, text).unwrap();
    let on = ["--machine", file.path(), "--virtual", "--switch", "1:-300"];
    let served = Served::on(&on);
    let axes = &served.get("/api/board")["axes"];
    let within: Vec<_> = (0..3).map(|n| &axes[n]["home_within"]).collect();
    assert_eq!(within, [&json!(1000), &json!(70), &Value::Null]);
    served.order("/api/set", json!({"name": "switches", "value": 3}));
    served.order("/api/home", without.clone());
    is_homed(&served, 50);
    // What is asked counts more than the file.
    served.order("/api/home", json!({"axis": 2, "speed": 2000, "accel": 20000, "within": 20}));
    let axis = served.wait(2, |axis| axis["home"]["stage"] == "failed");
    assert!(axis["home"]["words"].as_str().unwrap().contains("within 20 steps"), "{axis}");
    served.rest(2);
    served.order("/api/home", json!({"axis": 2, "speed": 2000, "accel": 20000}));
    let axis = served.wait(2, |axis| axis["home"]["stage"] == "failed");
    assert!(axis["home"]["words"].as_str().unwrap().contains("within 70 steps"), "{axis}");
    // What was typed of the motors counts more, too.
    let typed = Served::on(&[&on[..], &["--mm-per-rev", "4", "--steps-per-rev", "400"]].concat());
    assert_eq!(typed.get("/api/board")["axes"][0]["home_within"], 4000);
    let text = "[axis.1]\nhome-within = '40mm'\n";
    std::fs::write(&file.0, text).unwrap();
    let ended = common::stepwright(&["serve", "--machine", file.path(), "--virtual"]);
    ended.assert_error("home-within of axis 1");
}

#[test]
fn an_axis_that_is_homed_takes_nothing_else() {
    let served = machine(-100_000);
    served.order("/api/home", quick());
    for (path, body) in [
        ("/api/home", quick()),
        ("/api/move", json!({"axis": 1, "by": 5})),
        ("/api/run", json!({"axis": 1, "speed": 5})),
        ("/api/retarget", json!({"axis": 1, "top_speed": 5})),
        ("/api/zero", json!({"axis": 1})),
    ] {
        let why = served.declined(path, body, 409);
        assert_eq!(why, "axis 1 is being homed", "{path}");
    }
    // Another one does.
    served.order("/api/move", json!({"axis": 2, "by": 5}));
    assert_eq!(served.rest(2)["position"], 5);
    served.order("/api/stop", json!({}));
    served.rest(1);
}

/// What ends a homing on its way ends all of it: nothing begins again by itself.
#[test]
fn a_stop_and_a_kill_end_a_homing() {
    let mut served = machine(-100_000);
    for (path, state) in [("/api/stop", "ready"), ("/api/kill", "uncertain")] {
        served.order("/api/home", quick());
        served.wait(1, |axis| axis["speed"].as_f64().unwrap() < -500.0);
        // Everybody may.
        let key = std::mem::take(&mut served.key);
        served.order(path, json!({}));
        let axis = served.rest(1);
        assert_eq!((&axis["state"], &axis["home"]["stage"]), (&json!(state), &json!("failed")));
        assert!(axis["home"]["words"].as_str().unwrap().contains("stopped"), "{axis}");
        std::thread::sleep(Duration::from_millis(400));
        let later = served.axis(1);
        assert_eq!((&later["moving"], &later["position"]), (&json!(false), &axis["position"]));
        served.key = key;
    }
}

/// Also between two legs, of which the slow one would be long.
#[test]
fn a_page_that_is_gone_homes_nothing() {
    let served = machine(-300);
    let mut live = served.live();
    let mut body = quick();
    (body["slow"], body["back_off"]) = (json!(20), json!(400));
    served.order("/api/home", body);
    let begin = Instant::now();
    loop {
        let state = next(&mut live, "state");
        live.send(Message::text(json!({"beat": served.key}).to_string())).unwrap();
        if state["axes"][0]["home"]["stage"] == "approach" {
            break;
        }
        assert!(begin.elapsed() < common::LIMIT, "{state}");
    }
    drop(live);
    let silent = Instant::now();
    let axis = served.rest(1);
    assert!(silent.elapsed() < Duration::from_secs(10), "{:?}", silent.elapsed());
    assert_eq!((&axis["home"]["stage"], &axis["state"]), (&json!("failed"), &json!("ready")));
    let at = axis["position"].as_i64().unwrap();
    assert!((300..=400).contains(&at), "{axis}");
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(served.axis(1)["position"], at);
    assert!(axis["home"]["words"].as_str().unwrap().contains("gone"), "{axis}");
}

#[test]
fn who_takes_over_ends_the_homing_of_the_one_before() {
    let mut served = machine(-100_000);
    served.order("/api/home", quick());
    served.key = served.taken(true);
    let axis = served.rest(1);
    assert_eq!((&axis["home"]["stage"], &axis["state"]), (&json!("failed"), &json!("ready")));
}

#[cfg(unix)]
mod unix {
    use super::*;
    use crate::common::{Running, Scratch};

    /// A board on a pseudo-terminal, which a name leads to.
    fn plug(name: &Scratch) -> Running {
        let mut board = Running::start(&["board", "--pty", "--switch", "1:-100000"]);
        let path = board.wait_out("pty ").trim_start_matches("pty ").to_owned();
        let _ = std::fs::remove_file(&name.0);
        std::os::unix::fs::symlink(path, &name.0).unwrap();
        board
    }

    #[test]
    fn a_board_that_vanishes_is_not_homed_when_it_is_back() {
        let name = Scratch::new("port");
        let board = plug(&name);
        let served = Served::start(&["--port", name.path()]);
        let known = json!({"name": "switches", "value": 1});
        served.order("/api/set", known.clone());
        served.order("/api/home", quick());
        served.wait(1, |axis| axis["position"].as_i64() < Some(-100));
        drop(board);
        served.wait(1, |axis| axis["state"] == "lost");
        served.declined("/api/home", quick(), 503);
        let board = plug(&name);
        served.wait(1, |axis| axis["state"] == "ready");
        std::thread::sleep(Duration::from_millis(400));
        let back = served.axis(1);
        assert_eq!((&back["position"], &back["home"]), (&json!(0), &Value::Null), "{back}");
        // It has forgotten its switch, for its EEPROM was another one.
        served.order("/api/set", known);
        served.order("/api/home", quick());
        served.order("/api/stop", json!({"axis": 1}));
        assert_eq!(served.rest(1)["home"]["stage"], "failed");
        drop(board);
    }
}
