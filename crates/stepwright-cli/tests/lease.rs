//! `--lease`: a board that hears no more from the command brakes by itself.
#![cfg(unix)]

use std::thread;
use std::time::{Duration, Instant};

use crate::common::{Ended, Running, stepwright};
use crate::served::Served;

#[test]
fn a_lease_is_asked_for_with_the_order_and_held_to_its_end() {
    let ended = stepwright(&["move", "4000", "--lease", "500ms", "--fast"]);
    ended.assert(0, "position 4000 ready");
    assert!(ended.stdout.contains("  lines       L500 PO S5 T100 R200 G+4000 E\n"), "{ended:?}");
    let ended = stepwright(&["run", "200", "--lease", "0.2", "--for", "3s", "--fast"]);
    assert!(ended.last_line().ends_with(" ready"), "{ended:?}");
    for wrong in ["100ms", "61s", "soon"] {
        let ended = stepwright(&["move", "1", "--lease", wrong, "--fast"]);
        assert_eq!((ended.code(), ended.stdout.as_str()), (Some(2), ""), "{ended:?}");
    }
}

/// The command dies at once, and cannot even say goodbye.
#[test]
fn a_killed_command_leaves_no_motor_running() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    for order in
        [&["run", "300", "--lease", "1500ms"][..], &["move", "100000", "--lease", "1500ms"]]
    {
        let mut command = Running::start(&[order, &["--port", &port]].concat());
        command.wait_out("  lines");
        thread::sleep(Duration::from_millis(1200));
        assert!(command.child.try_wait().unwrap().is_none(), "it stays while the motor runs");
        command.child.kill().unwrap();
        command.child.wait().unwrap();
        let status = asked_until_it_rests(&port);
        assert!(status.stdout.contains("the silence of the host"), "{status:?}");
        assert!(!status.stdout.contains("uncertain"), "{status:?}");
    }
}

/// Asks at once, and again and again: a lease is its holder's, and nobody else's line holds it.
#[track_caller]
fn asked_until_it_rests(port: &str) -> Ended {
    let begin = Instant::now();
    loop {
        let status = stepwright(&["status", "--port", port]);
        assert_eq!(status.code(), Some(0), "{status:?}");
        if !status.stdout.contains("busy") {
            return status;
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "questions hold it: {status:?}");
    }
}

/// The same by a lease that is longer than any question, whatever comes next: a watch, another
/// order, a server.
#[test]
fn nobody_holds_the_lease_of_a_dead_holder() {
    // All at once: each waits for its lease.
    let orders: [&[&str]; 3] = [&["watch"], &["send", "?"], &["move", "5"]];
    thread::scope(|scope| {
        for order in orders {
            scope.spawn(move || waits_before(order));
        }
    });
}

fn waits_before(order: &[&str]) {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let mut holder = Running::start(&["run", "300", "--lease", "5s", "--port", &port]);
    holder.wait_err("position ");
    holder.child.kill().unwrap();
    holder.child.wait().unwrap();
    let ended = stepwright(&[order, &["--port", &port]].concat());
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(ended.stderr.contains("a lease of 5000 ms"), "{ended:?}");
    // Who comes after that need not wait, while the motor brakes at most.
    let status = stepwright(&["status", "--port", &port]);
    assert!(!status.stderr.contains("lease"), "{status:?}");
    asked_until_it_rests(&port);
}

/// A stop waits for no lease.
#[test]
fn a_stop_comes_before_the_lease_of_a_dead_holder() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let mut holder = Running::start(&["run", "300", "--lease", "60s", "--port", &port]);
    holder.wait_err("position ");
    holder.child.kill().unwrap();
    holder.child.wait().unwrap();
    let begin = Instant::now();
    let ended = stepwright(&["stop", "--port", &port]);
    assert!(ended.last_line().ends_with(" ready"), "{ended:?}");
    // It has given the lease back, so nobody after it need wait, and no motor is braked by it.
    let ended = stepwright(&["move", "5", "--port", &port]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(begin.elapsed() < Duration::from_secs(30), "{ended:?}");
}

/// A note of a lease that has run out long ago holds nobody up.
#[test]
fn an_old_lease_is_not_waited_for() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let mut holder = Running::start(&["run", "300", "--lease", "2s", "--port", &port]);
    holder.wait_err("position ");
    // It holds its lease for longer than that.
    thread::sleep(Duration::from_secs(3));
    holder.child.kill().unwrap();
    holder.child.wait().unwrap();
    thread::sleep(Duration::from_secs(3));
    let status = stepwright(&["status", "--port", &port]);
    assert!(status.stdout.contains("the silence of the host"), "{status:?}");
    assert_eq!(status.stderr, "", "{status:?}");
}

/// What a page runs has a lease of the server's.
#[test]
fn a_killed_server_leaves_no_motor_running() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    let mut served = Served::start(&["--port", &port]);
    served.order("/api/run", serde_json::json!({"axis": 1, "speed": 300}));
    served.command.child.kill().unwrap();
    served.command.child.wait().unwrap();
    let status = asked_until_it_rests(&port);
    // On a slow machine the server has missed its page before, and braked by itself.
    assert!(!status.stdout.contains("uncertain"), "{status:?}");
}

/// And it was given back: a master that knows no lease may be silent afterwards.
#[test]
fn a_lease_is_given_back() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    stepwright(&["move", "40", "--lease", "500ms", "--port", &port]).assert(0, "position 40 ready");
    let ended = stepwright(&["run", "300", "--detach", "--port", &port]);
    assert!(ended.last_line().ends_with(" busy"), "{ended:?}");
    thread::sleep(Duration::from_millis(1500));
    let status = stepwright(&["status", "--port", &port]);
    assert!(status.stdout.contains("busy"), "{status:?}");
}
