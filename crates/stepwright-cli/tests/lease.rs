//! `--lease`: a board that hears no more from the command brakes by itself.
#![cfg(unix)]

mod common;

use std::thread;
use std::time::{Duration, Instant};

use common::{LIMIT, Running, stepwright};

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
    for order in [&["run", "300", "--lease", "400ms"][..], &["move", "100000", "--lease", "400ms"]]
    {
        let mut command = Running::start(&[order, &["--port", &port]].concat());
        command.wait_out("  lines");
        thread::sleep(Duration::from_millis(1200));
        assert!(command.child.try_wait().unwrap().is_none(), "it stays while the motor runs");
        command.child.kill().unwrap();
        command.child.wait().unwrap();
        let begin = Instant::now();
        let status = loop {
            // No question before the lease has run out: each would hold it.
            thread::sleep(Duration::from_millis(1500));
            let status = stepwright(&["status", "--port", &port]);
            if !status.stdout.contains("busy") {
                break status;
            }
            assert!(begin.elapsed() < LIMIT, "{status:?}");
        };
        assert!(status.stdout.contains("the silence of the host"), "{status:?}");
        assert!(!status.stdout.contains("uncertain"), "{status:?}");
    }
}

/// And it was given back: a master that knows no lease may be silent afterwards.
#[test]
fn a_lease_is_given_back() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
    stepwright(&["move", "40", "--lease", "500ms", "--port", &port]).assert(0, "position 40 ready");
    let ended = stepwright(&["run", "300", "--port", &port]);
    assert!(ended.last_line().ends_with(" busy"), "{ended:?}");
    thread::sleep(Duration::from_millis(1500));
    let status = stepwright(&["status", "--port", &port]);
    assert!(status.stdout.contains("busy"), "{status:?}");
}
