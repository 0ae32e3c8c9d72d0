//! A second terminal, while the first one moves a motor.
#![cfg(unix)]

use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use crate::common::{self, Ended, Running, stepwright};
use rustix::process::Signal;

/// A board, its path, and a motor that the first terminal moves.
struct Bench {
    board: Running,
    path: String,
}

impl Bench {
    fn new() -> Bench {
        let mut board = Running::start(&["board", "--pty"]);
        let path = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
        Bench { board, path }
    }

    fn start(&self, args: &[&str]) -> Running {
        Running::start(&[args, &["--port", &self.path]].concat())
    }

    fn order(&self, args: &[&str]) -> Ended {
        self.start(args).end()
    }

    fn end(self) {
        self.board.signal(Signal::INT);
        self.board.end();
    }

    /// Where the first terminal lets others in.
    fn door(&self) -> PathBuf {
        let name = std::fs::canonicalize(&self.path).unwrap();
        let name = name.to_str().unwrap().trim_start_matches('/').replace('/', "-") + ".socket";
        let folder = match std::env::var_os("XDG_RUNTIME_DIR") {
            Some(folder) => PathBuf::from(folder).join("stepwright"),
            None => {
                let uid = rustix::process::getuid().as_raw();
                std::env::temp_dir().join(format!("stepwright-{uid}"))
            }
        };
        folder.join(name)
    }

    /// The first terminal, on its way.
    fn mover(&self) -> Running {
        let mut mover = self.start(&["move", "1000000", "--top-speed", "2000", "--accel", "20000"]);
        mover.wait_err("position ");
        mover
    }
}

#[test]
fn it_looks_retargets_and_watches() {
    let bench = Bench::new();
    let mover = bench.mover();
    let mut watcher = bench.start(&["watch"]);
    watcher.wait_err("position ");
    let status = bench.order(&["status"]);
    assert!(status.stdout.contains("axis 1      position ") && status.stdout.contains(" busy"));
    // Another axis' state is asked for while the first watches its own.
    bench.order(&["position", "--axis", "2"]).assert(0, "position 0 ready");
    bench.order(&["retarget", "5", "--axis", "2"]).assert_error("axis 2 is at rest");
    assert!(bench.order(&["position"]).last_line().ends_with(" busy"));
    // A speed that is no whole number of steps/s has a line of its own.
    let ended = bench.order(&["retarget", "--top-speed", "2500.5"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let ended = bench.order(&["retarget", "-100"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let moved = mover.end();
    moved.assert(0, "position -100 ready");
    for words in ["top speed 2500.5 steps/s", "target -100"] {
        assert!(moved.stderr.contains(&format!("another terminal: {words}")), "{moved:#?}");
    }
    // Whom it had asked through is gone: it goes on by itself.
    watcher.end().assert(0, "position -100 ready");
    bench.end();
}

#[test]
fn it_gives_no_orders_while_the_first_has_the_port() {
    let bench = Bench::new();
    let mover = bench.mover();
    for order in [&["zero", "--axis", "2"][..], &["move", "5", "--axis", "2"], &["send", "F"]] {
        bench.order(order).assert_error("in use");
    }
    // Nor does who finds the door without our command.
    let mut door = UnixStream::connect(bench.door()).unwrap();
    door.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    door.write_all(b"A2\rPO\rS5\rT100\rR9\rG+4\rE\rI1\r$pulse-us=9\r\r\xff\x00\rF\r").unwrap();
    let mut answers = Vec::new();
    while answers.iter().filter(|byte| **byte == b'\r').count() < 12 {
        let mut byte = [0];
        door.read_exact(&mut byte).unwrap();
        answers.push(byte[0]);
    }
    assert_eq!(String::from_utf8(answers).unwrap(), "Y\rE\rE\rE\rE\rE\rE\rE\rE\rE\rE\rR\r");
    // A line without end is no line: the door closes.
    door.write_all(&[b'F'; 1000]).ok();
    let mut rest = Vec::new();
    assert!(door.read_to_end(&mut rest).is_err() || rest.is_empty());
    bench.order(&["position", "--axis", "2"]).assert(0, "position 0 ready");
    bench.order(&["retarget", "10", "--axis", "1"]);
    mover.end().assert(0, "position 10 ready");
    bench.end();
}

#[test]
fn a_first_terminal_that_was_killed_is_in_nobodys_way() {
    let bench = Bench::new();
    let mover = bench.mover();
    mover.signal(Signal::KILL);
    mover.end();
    // Its socket is still there, and the motor goes on.
    assert!(bench.order(&["position"]).last_line().ends_with(" busy"));
    assert_eq!(bench.order(&["retarget", "70"]).code(), Some(0));
    bench.order(&["watch"]).assert(0, "position 70 ready");
    bench.order(&["move", "5"]).assert(0, "position 75 ready");
    bench.end();
}

/// It lets another in and is gone: its socket closes after its conversations.
#[test]
fn a_first_terminal_that_is_about_to_end_is_in_nobodys_way() {
    let bench = Bench::new();
    bench.order(&["move", "5"]).assert(0, "position 5 ready");
    let door = UnixListener::bind(bench.door()).unwrap();
    let ending = thread::spawn(move || (0..2).for_each(|_| drop(door.accept().unwrap())));
    bench.order(&["position"]).assert(0, "position 5 ready");
    ending.join().unwrap();
    bench.order(&["move", "5"]).assert(0, "position 10 ready");
    bench.end();
}

#[test]
fn a_first_terminal_that_is_suspended_is_named() {
    let bench = Bench::new();
    bench.order(&["move", "5"]).assert(0, "position 5 ready");
    let door = UnixListener::bind(bench.door()).unwrap();
    // Whoever comes is let in, and never answered.
    let ended = bench.order(&["position"]);
    assert_eq!(ended.code(), Some(1), "{ended:#?}");
    ended.assert_error("no answer from the stepwright that holds");
    drop(door);
    std::fs::remove_file(bench.door()).unwrap();
    bench.order(&["move", "5"]).assert(0, "position 10 ready");
    bench.end();
}

#[test]
fn a_detached_move_is_watched_later() {
    let bench = Bench::new();
    let ended = bench.order(&["move", "2000", "--detach"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    assert!(ended.last_line().ends_with(" busy"), "{ended:#?}");
    bench.order(&["watch", "--format", "json"]).assert(
        0,
        &format!(
            r#"{{"axis":1,"board":"{}","position":2000,"state":"ready","stop":null}}"#,
            bench.path
        ),
    );
    stepwright(&["move", "5", "--detach"]).assert(2, "");
    bench.end();
}

#[test]
fn several_terminals_look_at_once() {
    let bench = Bench::new();
    let mover = bench.mover();
    let looks: Vec<_> =
        (1..=3).map(|axis| bench.start(&["position", "--axis", &axis.to_string()])).collect();
    for (axis, look) in looks.into_iter().enumerate() {
        let ended = look.end();
        assert_eq!(ended.code(), Some(0), "{ended:#?}");
        assert_eq!(ended.last_line() == "position 0 ready", axis > 0, "{ended:#?}");
    }
    mover.signal(Signal::INT);
    assert_eq!(mover.end().code(), Some(130));
    bench.end();
}

/// A position counts from zero, wherever the travel began, and both terminals say it in words.
#[test]
fn a_travel_is_sent_to_a_position() {
    let bench = Bench::new();
    bench.order(&["move", "100", "--top-speed", "2000"]).assert(0, "position 100 ready");
    let mover = bench.start(&["move", "1000000", "--accel", "20000", "--format", "json"]);
    let begin = std::time::Instant::now();
    while !bench.order(&["position"]).last_line().ends_with(" busy") {
        assert!(begin.elapsed() < common::LIMIT, "it never moves");
    }
    let ended = bench.order(&["retarget", "--to", "-30", "--accel", "30000"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let said = ": acceleration 30000 steps/s², target -30\n";
    assert!(ended.stdout.contains(said), "{ended:#?}");
    let json = bench.order(&["retarget", "--to", "-50", "--format", "json"]);
    assert!(json.stdout.contains(r#""lines":["@-150"]"#), "{json:#?}");
    let moved = mover.end();
    assert_eq!(moved.code(), Some(0), "{moved:#?}");
    for part in [r#""position":-50,"#, r#""target":-50"#, r#""state":"ready""#] {
        assert!(moved.stdout.contains(part), "{part}: {moved:#?}");
    }
    assert!(moved.stderr.contains("another terminal: target -50"), "{moved:#?}");
    // Nobody knows where a travel began that nobody holds.
    assert_eq!(bench.order(&["move", "100000", "--detach"]).code(), Some(0));
    let ended = bench.order(&["retarget", "--to", "7"]);
    ended.assert_error("where the travel began is not known");
    assert!(ended.stderr.contains("retarget DISTANCE"), "{ended:#?}");
    assert_eq!(bench.order(&["kill"]).code(), Some(0));
    bench.end();
}

/// An axis of a line has a new target: the line says so, and ends there.
#[test]
fn an_axis_of_a_line_is_sent_to_a_position() {
    let bench = Bench::new();
    bench.order(&["move", "100", "--top-speed", "2000"]).assert(0, "position 100 ready");
    let mut line = bench.start(&["line", "1000000", "4000", "--top-speed", "2000"]);
    line.wait_err("position ");
    let ended = bench.order(&["retarget", "--to", "30", "--accel", "20000"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let ended = bench.order(&["retarget", "-7", "--axis", "2", "--top-speed", "1000"]);
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let ended = line.end();
    ended.assert(0, "position 30 -7 ready");
    for words in ["axis 1: target 30", "axis 2: target -7", "axis 2: top speed 1000 steps/s"] {
        assert!(ended.stderr.contains(&format!("another terminal, {words}")), "{ended:#?}");
    }
    bench.end();
}

/// What another terminal changes of an axis is no change of the next.
#[test]
fn a_run_that_is_given_an_end_is_there() {
    let bench = Bench::new();
    let mut runner = bench.start(&["run", "2000", "--accel", "20000"]);
    runner.wait_err("position ");
    assert_eq!(bench.order(&["retarget", "--to", "90"]).code(), Some(0));
    let ended = runner.end();
    ended.assert(0, "position 90 ready");
    bench.end();
}

/// However many guests ask without a pause, the first terminal comes to its own lines between
/// theirs: it hears Ctrl-C, and holds its lease only by what it says itself.
#[test]
fn a_crowd_of_guests_does_not_hold_up_the_first_terminal() {
    let bench = Bench::new();
    let mover = bench.mover();
    let door = bench.door();
    let crowd: Vec<_> = (0..40)
        .map(|_| {
            let mut guest = UnixStream::connect(&door).unwrap();
            std::thread::spawn(move || {
                let mut byte = [0];
                // Until the first terminal closes the door.
                while guest.write_all(b"F\r").is_ok() && guest.read_exact(&mut byte).is_ok() {
                    while byte[0] != b'\r' && guest.read_exact(&mut byte).is_ok() {}
                }
            })
        })
        .collect();
    std::thread::sleep(Duration::from_millis(300));
    mover.signal(Signal::INT);
    let ended = mover.end();
    assert_eq!(ended.code(), Some(130), "{ended:?}");
    assert!(ended.last_line().ends_with(" stopped"), "{ended:?}");
    crowd.into_iter().for_each(|guest| guest.join().unwrap());
    bench.end();
}

/// A stop of one axis is none of another, whoever has the port.
#[test]
fn the_stop_of_an_axis_leaves_the_others_on_their_way() {
    let bench = Bench::new();
    let mut mover = bench.mover();
    bench.order(&["stop", "--axis", "3"]).assert(0, "position 0 ready");
    mover.wait_err("position ");
    assert!(bench.order(&["position"]).last_line().ends_with(" busy"));
    mover.signal(Signal::KILL);
    mover.end();
    // Nobody has it, and two axes run.
    let moved = bench.order(&["run", "300", "--axis", "2", "--detach"]);
    assert_eq!(moved.code(), Some(0), "{moved:#?}");
    let stopped = bench.order(&["stop", "--axis", "1"]);
    assert_eq!(stopped.code(), Some(0), "{stopped:#?}");
    assert!(bench.order(&["position", "--axis", "2"]).last_line().ends_with(" busy"));
    bench.order(&["position"]).assert(0, stopped.last_line());
    let stopped = bench.order(&["stop"]);
    assert_eq!(stopped.code(), Some(0), "{stopped:#?}");
    bench.order(&["stop", "--axis", "4"]).assert_error("the board has no axis 4");
    bench.end();
}
