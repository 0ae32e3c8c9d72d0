//! `stepwright serve`, as programs and pages meet it: over HTTP, and over its WebSocket.

use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::common::{self, Running};
use crate::served::{Served, next};
use serde_json::{Value, json};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

#[test]
fn an_axis_travels_where_it_is_told_and_nowhere_else() {
    let served = Served::board();
    let board = served.get("/api/board");
    assert_eq!(
        (&board["name"], &board["axes"][2]["axis"]),
        (&json!("the virtual board"), &json!(3))
    );
    assert!(board["settings"].as_array().unwrap().iter().any(|one| one["name"] == "pulse-us"));
    let done =
        served.order("/api/move", json!({"axis": 1, "by": 300, "top_speed": 2000, "accel": 20000}));
    assert_eq!(done["lines"][0], "PO", "{done}");
    let busy = served.declined("/api/move", json!({"axis": 1, "by": 5}), 409);
    assert!(busy.contains("on its way"), "{busy}");
    assert_eq!(served.rest(1)["position"], 300);
    served.order("/api/move", json!({"axis": 2, "to": -70, "top_speed": 2000}));
    assert_eq!(served.rest(2)["position"], -70);
    served.order("/api/move", json!({"axis": 1, "to": 0, "top_speed": 2000, "jerk": 400_000}));
    assert_eq!(served.rest(1)["position"], 0);
    // What the board refuses says so, and nothing moves.
    for body in [
        json!({"axis": 1, "by": 1_000_000, "top_speed": 900_000, "accel": 50_000_000}),
        json!({"axis": 4, "by": 5}),
        json!({"axis": 1, "by": 5, "steps": 6}),
        json!({"axis": 1, "to": 1_i64 << 40}),
    ] {
        let (status, said) = served.post("/api/move", body);
        assert!((400..500).contains(&status) && said["what"].is_string(), "{status} {said}");
    }
    let state = served.get("/api/state");
    let positions: Vec<_> =
        state["axes"].as_array().unwrap().iter().map(|axis| axis["position"].clone()).collect();
    assert_eq!(positions, [0, -70, 0], "{state}");
}

#[test]
fn everybody_may_stop_and_the_position_stays_known() {
    let mut served = Served::board();
    served.order("/api/move", json!({"axis": 1, "by": 1_000_000, "accel": 20000}));
    served.order("/api/move", json!({"axis": 2, "by": -1_000_000, "accel": 20000}));
    served.wait(1, |axis| axis["position"].as_i64() > Some(50));
    let key = std::mem::take(&mut served.key);
    served.order("/api/stop", json!({"axis": 2}));
    let stopped = served.rest(2);
    assert_eq!((&stopped["state"], &stopped["stop"]["name"]), (&json!("ready"), &json!("stop")));
    assert_eq!(served.axis(1)["moving"], true);
    served.order("/api/stop", json!({}));
    let at = served.rest(1)["position"].as_i64().unwrap();
    assert!((50..900_000).contains(&at), "{at}");
    // It goes on from there, as ordered.
    served.key = key;
    served.order("/api/move", json!({"axis": 1, "by": -50, "top_speed": 2000}));
    assert_eq!(served.rest(1)["position"], at - 50);
}

#[test]
fn a_kill_loses_the_position_until_it_is_called_0() {
    let mut served = Served::board();
    served.order("/api/run", json!({"axis": 1, "speed": 800}));
    served.wait(1, |axis| axis["moving"] == true);
    let key = std::mem::take(&mut served.key);
    served.order("/api/kill", json!({}));
    let killed = served.rest(1);
    assert_eq!((&killed["state"], &killed["position"]), (&json!("uncertain"), &Value::Null));
    served.key = key;
    let why = served.declined("/api/move", json!({"axis": 1, "by": 5}), 409);
    assert!(why.contains("uncertain"), "{why}");
    served.order("/api/zero", json!({"axis": 1}));
    assert_eq!(served.axis(1)["position"], 0);
    served.order("/api/move", json!({"axis": 1, "by": 5, "top_speed": 2000}));
    assert_eq!(served.rest(1)["position"], 5);
    assert_eq!(served.get("/api/state")["errors"][0]["name"], "kill");
    served.order("/api/acknowledge", json!({}));
    assert_eq!(served.get("/api/state")["errors"], json!([]));
}

#[test]
fn a_travel_is_changed_on_its_way() {
    let served = Served::board();
    let why = served.declined("/api/retarget", json!({"axis": 1, "to": 5}), 409);
    assert!(why.contains("at rest"), "{why}");
    served.order("/api/move", json!({"axis": 1, "by": 100, "top_speed": 2000, "accel": 20000}));
    served.rest(1);
    served.order("/api/move", json!({"axis": 1, "by": 1_000_000, "accel": 20000}));
    served.wait(1, |axis| axis["position"].as_i64() > Some(150));
    served.order("/api/retarget", json!({"axis": 1, "to": -30, "top_speed": 2500}));
    assert_eq!(served.rest(1)["position"], -30);
}

#[test]
fn a_run_needs_one_who_is_heard_of() {
    let served = Served::board();
    let mut live = served.live();
    let begin = Instant::now();
    served.order("/api/run", json!({"axis": 1, "speed": -600}));
    // Longer than the lease, and than the board's own.
    while begin.elapsed() < Duration::from_millis(2500) {
        next(&mut live, "state");
        live.send(Message::text(json!({"beat": served.key}).to_string())).unwrap();
    }
    assert_eq!(served.axis(1)["moving"], true);
    let silent = Instant::now();
    drop(live);
    let axis = served.rest(1);
    assert!(silent.elapsed() < Duration::from_secs(20), "{:?}", silent.elapsed());
    assert_eq!((&axis["state"], &axis["stop"]["name"]), (&json!("ready"), &json!("stop")));
    // A travel that ends needs nobody.
    served.order("/api/move", json!({"axis": 1, "to": 0, "top_speed": 1500}));
    assert_eq!(served.rest(1)["position"], 0);
}

#[test]
fn another_page_that_takes_over_ends_the_run() {
    let mut served = Served::board();
    let (status, said) = served.post("/api/control", json!({}));
    assert_eq!(status, 409, "{said}");
    served.order("/api/run", json!({"axis": 1, "speed": 600}));
    let new = served.taken(true);
    let old = std::mem::replace(&mut served.key, new);
    let axis = served.rest(1);
    assert_eq!(axis["stop"]["name"], "stop", "{axis}");
    let new = std::mem::replace(&mut served.key, old);
    served.declined("/api/move", json!({"axis": 1, "by": 5}), 409);
    served.key = new;
    served.order("/api/control/release", json!({}));
    served.declined("/api/move", json!({"axis": 1, "by": 5}), 409);
    assert_eq!(served.axis(1)["position"], axis["position"]);
}

#[test]
fn settings_have_the_names_they_have_everywhere() {
    let served = Served::board();
    served.order("/api/set", json!({"name": "pulse-us", "value": 7}));
    let board = served.get("/api/board");
    let settings = board["settings"].as_array().unwrap();
    let pulse = settings.iter().find(|one| one["name"] == "pulse-us").unwrap();
    assert_eq!((&pulse["value"], &pulse["max"]), (&json!(7), &json!(20)));
    for wrong in [json!(21), json!(-1), json!(2.5), json!(1e300)] {
        let why = served.declined("/api/set", json!({"name": "pulse-us", "value": wrong}), 422);
        assert!(why.starts_with("pulse-us is "), "{why}");
    }
    served.order("/api/move", json!({"axis": 1, "by": 3000}));
    let why = served.declined("/api/set", json!({"name": "pulse-us", "value": 3}), 409);
    assert!(why.contains("refused $pulse-us=3"), "{why}");
}

/// The page counts in the millimetres or degrees of each axis.
#[test]
fn each_axis_has_its_unit() {
    let text = "[axis.1]\nsteps-per-rev = 3200\nmm-per-rev = 8\n[axis.2]\nmm-per-rev = 8\n";
    let file = common::Scratch::new("units.toml");
    std::fs::write(&file.0, text).unwrap();
    let units = |more: &[&str]| {
        let served = Served::on(&[&["--machine", file.path(), "--virtual"], more].concat());
        let axes = served.get("/api/board")["axes"].clone();
        let one = |axis: &Value| json!([axis["unit"], axis["steps_per_unit"]]);
        axes.as_array().unwrap().iter().map(one).collect::<Vec<_>>()
    };
    assert_eq!(units(&[]), [json!(["mm", 400.0]), json!(["mm", 25.0]), json!(["steps", 1.0])]);
    let typed = units(&["--steps-per-rev", "1600"]);
    assert_eq!(typed, [json!(["mm", 200.0]), json!(["mm", 200.0]), json!(["deg", 1600.0 / 360.0])]);
}

/// The machine file is told as it stands there.
#[test]
fn the_machine_file_is_told() {
    let text = "lease = '2s'\n[axis.2]\nmm-per-rev = 8\naccel = '200mm/s2'\n";
    let file = common::Scratch::new("machine.toml");
    std::fs::write(&file.0, text).unwrap();
    let served = Served::on(&["--machine", file.path(), "--virtual"]);
    let machine = &served.get("/api/board")["machine"];
    assert_eq!(machine["file"], file.path());
    let told = |axis: Value, name: &str, value: &str| {
        let row = json!({"axis": axis, "name": name, "value": value});
        assert!(machine["values"].as_array().unwrap().contains(&row), "{machine}");
    };
    told(Value::Null, "lease", "2s");
    told(json!(2), "mm-per-rev", "8");
    told(json!(2), "accel", "200mm/s2");
    assert_eq!(Served::board().get("/api/board")["machine"], Value::Null);
}

#[test]
fn the_conversation_is_told_with_its_meaning() {
    let served = Served::board();
    let mut live = served.live();
    next(&mut live, "state");
    served.order("/api/move", json!({"axis": 1, "by": 300, "top_speed": 2000}));
    let mut lines = Vec::new();
    while lines.last().is_none_or(|line: &Value| !line["line"].as_str().unwrap().starts_with('E')) {
        lines.push(next(&mut live, "line"));
    }
    // No question among them, and each with its answer.
    let go = lines.iter().find(|line| line["line"].as_str().unwrap().starts_with("G+300")).unwrap();
    assert!(go["means"].as_str().unwrap().starts_with("travel by this many steps"), "{go}");
    assert_eq!(go["answer_means"], "accepted");
    assert!(lines.iter().all(|line| line["question"] == false), "{lines:?}");
    let plan = next(&mut live, "plan");
    assert_eq!(
        (&plan["axis"], plan["position"].as_array().unwrap().last()),
        (&json!(1), Some(&json!(300.0)))
    );
    live.send(Message::text(r#"{"questions":true}"#)).unwrap();
    let asked = next(&mut live, "line");
    assert_eq!(asked["question"], true);
    // Who says nonsense is hung up on.
    live.send(Message::text("{\"move\":4000}")).unwrap();
    while live.read().is_ok() {}
}

#[test]
fn a_page_of_another_site_can_not_join() {
    let served = Served::board();
    for (name, value) in [("Origin", "http://evil.example"), ("Host", "evil.example")] {
        let mut request =
            format!("ws://{}/api/live", served.address).into_client_request().unwrap();
        request.headers_mut().insert(name, value.parse().unwrap());
        let stream = TcpStream::connect(&served.address).unwrap();
        let error = tungstenite::client(request, stream).err().map(|error| error.to_string());
        assert!(error.as_ref().is_some_and(|error| error.contains("403")), "{error:?}");
    }
    // Half a request, and then nothing: others are served meanwhile.
    let mut half = TcpStream::connect(&served.address).unwrap();
    half.write_all(b"POST /api/move HTTP/1.1\r\nHost: 127").unwrap();
    assert_eq!(served.axis(1)["position"], 0);
}

#[cfg(unix)]
mod unix {
    use super::*;
    use crate::common::{Scratch, stepwright};
    use rustix::process::Signal;

    #[test]
    fn ctrl_c_brakes_before_it_ends() {
        let served = Served::board();
        served.order("/api/run", json!({"axis": 1, "speed": 800, "accel": 4000}));
        served.command.signal(Signal::INT);
        let ended = served.command.end();
        assert_eq!(ended.code(), Some(0), "{ended:#?}");
        assert!(ended.stderr.contains("braking"), "{ended:#?}");
    }

    #[test]
    fn beyond_this_machine_a_token_is_asked_for() {
        let args = ["serve", "--machine", "none", "--virtual", "--bind", "0.0.0.0:0"];
        let mut command = Running::start(&args);
        let page = command.wait_out("page http://0.0.0.0:");
        let (address, token) = page.split_once("/#token=").unwrap();
        let port = address.rsplit(':').next().unwrap();
        let address = format!("127.0.0.1:{port}");
        let served = Served { command, address, key: String::new() };
        let (status, said) = served.ask("GET", "/api/state", "");
        assert_eq!(status, 401, "{said}");
        let (status, said) = served.ask("GET", &format!("/api/state?token={token}"), "");
        assert_eq!((status, &said["connected"]), (200, &json!(true)));
        // No other machine can ask for 0.0.0.0.
        served.command.signal(Signal::INT);
        let ended = served.command.end();
        assert!(ended.stderr.contains("in the place of 0.0.0.0"), "{ended:#?}");
    }

    /// A board on a pseudo-terminal, which a name leads to.
    fn plug(name: &Scratch) -> Running {
        let mut board = Running::start(&["board", "--pty"]);
        let path = board.wait_out("pty ").trim_start_matches("pty ").to_owned();
        let _ = std::fs::remove_file(&name.0);
        std::os::unix::fs::symlink(path, &name.0).unwrap();
        board
    }

    #[test]
    fn a_board_that_vanishes_is_met_again_and_starts_nothing() {
        let name = Scratch::new("port");
        let mut board = plug(&name);
        let served = Served::start(&["--port", name.path()]);
        served.order("/api/move", json!({"axis": 1, "by": 100, "top_speed": 2000}));
        assert_eq!(served.rest(1)["position"], 100);
        // Twice: the second time it has been met again.
        for _ in 0..2 {
            served.order("/api/move", json!({"axis": 1, "by": 1_000_000}));
            drop(board);
            let lost = served.wait(1, |axis| axis["state"] == "lost");
            assert_eq!((&lost["position"], &lost["moving"]), (&Value::Null, &json!(false)));
            assert!(served.get("/api/state")["trouble"]["do"].is_string());
            for (path, body) in [
                ("/api/move", json!({"axis": 1, "by": 500})),
                ("/api/run", json!({"axis": 1, "speed": 500})),
                ("/api/stop", json!({})),
            ] {
                served.declined(path, body, 503);
            }
            board = plug(&name);
            let back = served.wait(1, |axis| axis["state"] == "ready");
            assert_eq!((&back["position"], &back["moving"]), (&json!(0), &json!(false)));
            served.order("/api/move", json!({"axis": 1, "by": 70, "top_speed": 2000}));
            assert_eq!(served.rest(1)["position"], 70);
        }
        drop(board);
    }

    /// As in a reset, or with an adapter that has power of its own: the port stays there.
    #[test]
    fn a_board_that_was_silent_is_met_again_at_the_same_port() {
        let name = Scratch::new("silent");
        let board = plug(&name);
        let served = Served::start(&["--port", name.path()]);
        served.order("/api/run", json!({"axis": 1, "speed": 500}));
        served.wait(1, |axis| axis["position"].as_i64() > Some(50));
        board.signal(Signal::STOP);
        served.wait(1, |axis| axis["state"] == "lost");
        board.signal(Signal::CONT);
        // What ran is braked: nobody has held it meanwhile.
        let back = served.wait(1, |axis| axis["state"] == "ready" && axis["moving"] == false);
        served.order("/api/move", json!({"axis": 1, "by": 70, "top_speed": 2000}));
        let at = served.rest(1)["position"].as_i64().unwrap();
        assert_eq!(at, back["position"].as_i64().unwrap() + 70);
        // Guests find it, too.
        let asked = stepwright(&["position", "--port", name.path()]);
        assert_eq!(
            (asked.code(), asked.last_line()),
            (Some(0), format!("position {at} ready").as_str())
        );
        drop(board);
    }

    #[test]
    fn a_second_terminal_stops_what_a_page_has_started() {
        let name = Scratch::new("stopped");
        let board = plug(&name);
        let served = Served::start(&["--port", name.path()]);
        let begin = || {
            served.order("/api/move", json!({"axis": 1, "by": 1_000_000, "accel": 20000}));
            let from = served.get("/api/state")["axes"][0]["position"].as_i64();
            served.wait(1, |axis| axis["position"].as_i64() > from.map(|at| at + 50));
        };
        begin();
        let stopped = stepwright(&["stop", "--port", name.path()]);
        assert_eq!(stopped.code(), Some(0), "{stopped:?}");
        let at = served.rest(1)["position"].as_i64().unwrap();
        let first = format!("axis 1 position {at} ready\n");
        assert!(stopped.stdout.starts_with(&first), "{stopped:?}");
        // What comes afterwards is not stopped any more.
        served.order("/api/move", json!({"axis": 1, "by": 20, "top_speed": 2000}));
        assert_eq!(served.rest(1)["position"], at + 20);
        begin();
        let killed = stepwright(&["kill", "--port", name.path()]);
        assert!(killed.stdout.starts_with("axis 1 position uncertain\n"), "{killed:?}");
        drop(board);
    }

    /// The plan of another axis still holds.
    #[test]
    fn a_change_from_elsewhere_ends_the_plan_of_its_axis() {
        let name = Scratch::new("changed");
        let board = plug(&name);
        let served = Served::start(&["--port", name.path()]);
        let mut live = served.live();
        for axis in [1, 2] {
            served.order("/api/move", json!({"axis": axis, "by": 10_000}));
        }
        let changed = stepwright(&["retarget", "5000", "--axis", "2", "--port", name.path()]);
        assert_eq!(changed.code(), Some(0), "{changed:?}");
        assert_eq!(next(&mut live, "unplanned")["axis"], 2);
        drop(board);
    }

    #[test]
    fn without_a_board_there_is_no_page() {
        let args = ["serve", "--machine", "none", "--bind", "127.0.0.1:0", "--port", "/nowhere"];
        let ended = Running::start(&args).end();
        assert_eq!((ended.code(), ended.stdout.as_str()), (Some(1), ""), "{ended:#?}");
        ended.assert_error("there is no port /nowhere");
    }
}
