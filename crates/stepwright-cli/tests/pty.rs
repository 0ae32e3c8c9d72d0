//! Conversations with `stepwright board --pty`, by our own command and by
//! other programs.
#![cfg(unix)]

use std::time::{Duration, Instant};

use crate::common::{self, Ended, LIMIT, Running, stepwright};
use rustix::process::Signal;
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use serial2::SerialPort;

/// A board on a pseudo-terminal.
struct Board {
    running: Running,
    path: String,
}

impl Board {
    fn start(options: &[&str]) -> Board {
        let mut running = Running::start(&[&["board", "--pty"], options].concat());
        let first = running.wait_out("");
        let path = first.strip_prefix("pty ").expect("the first line").to_owned();
        Board { running, path }
    }

    /// Our command on its port.
    #[track_caller]
    fn order(&self, order: &[&str]) -> Ended {
        stepwright(&[order, &["--port", &self.path]].concat())
    }

    fn open(&self) -> Client {
        let mut port = SerialPort::open(&self.path, 115_200).expect("the path opens");
        port.set_read_timeout(LIMIT).unwrap();
        Client { port }
    }

    /// Ctrl-C.
    fn end(self) -> Ended {
        self.running.signal(Signal::INT);
        self.running.end()
    }
}

/// Another program on its port.
struct Client {
    port: SerialPort,
}

impl Client {
    #[track_caller]
    fn say(&self, line: &str) -> String {
        self.port.write_all(line.as_bytes()).unwrap();
        self.port.write_all(b"\r").unwrap();
        self.hear()
    }

    #[track_caller]
    fn hear(&self) -> String {
        let mut answer = String::new();
        loop {
            let mut byte = [0];
            self.port.read_exact(&mut byte).expect("an answer");
            match byte[0] {
                b'\r' => return answer,
                byte => answer.push(char::from(byte)),
            }
        }
    }

    /// Asks until the answer is this.
    #[track_caller]
    fn say_until(&self, line: &str, right: impl Fn(&str) -> bool) -> String {
        let begin = Instant::now();
        loop {
            let answer = self.say(line);
            if right(&answer) {
                return answer;
            }
            assert!(begin.elapsed() < LIMIT, "{line}: still {answer}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Distances and positions in other units, from where the axis stands.
#[test]
fn targets_in_ones_own_unit() {
    let board = Board::start(&[]);
    let motor = ["--steps-per-rev", "400", "--mm-per-rev", "8"];
    let order = |way: &[&str]| board.order(&[way, &motor].concat());
    for (way, last) in [
        (&["move", "100"][..], "position 100 ready"),
        (&["move", "--to", "90deg"], "position 100 ready"),
        (&["move", "-0.5mm"], "position 75 ready"),
        (&["move", "--to", "-.5mm"], "position -25 ready"),
        (&["line", "--to", "0", "-90deg", "1mm"], "position 0 -100 50 ready"),
        (&["line", "1mm", "-1mm"], "position 50 -150 ready"),
    ] {
        let ended = order(way);
        assert_eq!(
            (ended.status.code(), ended.stdout.lines().last()),
            (Some(0), Some(last)),
            "{ended:?}"
        );
    }
    let far = order(&["move", "--to", "-2147483600"]);
    assert_eq!(far.status.code(), Some(2));
    assert!(far.stderr.contains("from 50 are -2147483650 steps, too far"), "{far:?}");
}

#[test]
fn a_newcomer_tries_every_line() {
    let board = Board::start(&[]);
    let client = board.open();
    let all = |lines: &[&str]| -> String {
        lines.iter().map(|line| client.say(line)).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(all(&["F", "V1", "E", "G+1", "I1"]), "R 0 E E Y");
    assert_eq!(all(&["PO", "S20", "T100", "R50", "G+500", "E", "F"]), "Y Y Y Y Y Y B");
    let way: i64 = client.say_until("V1", |at| at != "0").parse().unwrap();
    assert!(way > 0 && way < 500, "{way}");
    client.say_until("F", |status| status == "R");
    assert_eq!(client.say("V1"), "500");
    // Soft stop of an endless run.
    assert_eq!(client.say("g-"), "Y");
    client.say_until("V1", |at| at.parse::<i64>().unwrap() < 480);
    assert_eq!(all(&["T50", "I1", "Z"]), "E E Y");
    client.say_until("F", |status| status == "R");
    let rest = client.say("V1");
    assert_eq!(
        (client.say("V1"), client.say("Z"), client.say("V1")),
        (rest.clone(), "Y".into(), rest)
    );
    // Hard stop.
    assert_eq!(client.say("g+"), "Y");
    assert_eq!(all(&["K", "F", "V1", "I1", "V1"]), "Y R E Y 0");
    let info = client.say("?");
    assert!(info.starts_with("stepwright 0.1 axes=3 max=128000 late=0 refused=5"), "{info}");
    drop(client);
    let ended = board.end();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(ended.stderr.ends_with("position 0 ready\n"), "{ended:?}");
}

#[test]
fn our_own_orders() {
    let board = Board::start(&["--fast"]);
    board.order(&["position"]).assert(0, "position 0 ready");
    board.order(&["move", "4000"]).assert(0, "position 4000 ready");
    board.order(&["move", "-1000", "--axis", "2"]).assert(0, "position -1000 ready");
    board.order(&["position", "--axis", "2"]).assert(0, "position -1000 ready");
    let status = board.order(&["status"]);
    for row in [
        "axis 1      position 4000 ready\n",
        "axis 2      position -1000 ready\n",
        "refused     0 lines\n",
    ] {
        assert!(status.stdout.contains(row), "{status:?}");
    }
    board.order(&["zero"]).assert(0, "position 0 ready");
    board.order(&["move", "1"]).assert(0, "position 1 ready");
    let ended = board.order(&["send", "F", "V1", "V2", "PO", "nonsense"]);
    assert_eq!((ended.stdout.as_str(), ended.code()), ("R\n1\n-1000\nY\nE\n", Some(1)));
    ended.assert_error("refused: nonsense");
    assert!(ended.stderr.contains("not a line of this protocol"), "{ended:?}");
    let ended = board.order(&["send", "T1000"]);
    assert_eq!((ended.stdout.as_str(), ended.code()), ("E\n", Some(1)));
    let form = "`T<1…999>`: top speed, in tens of steps/s; when: axis ready";
    assert!(ended.stderr.contains(form), "{ended:?}");
    let ended = board.order(&["status", "--format", "json"]);
    let status: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(status["board"]["last"], "range");
    assert_eq!(status["axes"][1]["position"], -1000);
    let ended = board.order(&["move", "9", "--top-speed", "999999", "--ramp", "1"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("refused E: faster than the board can step");
    let stopped = board.order(&["stop"]);
    let axes = "axis 1 position 1 ready\naxis 2 position -1000 ready\naxis 3 position 0 ready\n";
    assert_eq!((stopped.code(), stopped.stdout.as_str()), (Some(0), axes), "{stopped:?}");
    board.order(&["stop", "--axis", "1"]).assert(0, "position 1 ready");
    board.order(&["kill"]).assert(0, "axis 3 position 0 ready");
}

#[test]
fn a_run_stays_with_its_motor() {
    let board = Board::start(&[]);
    let mut running = Running::start(&["run", "500", "--port", &board.path]);
    running.wait_err("running; Ctrl-C brakes");
    running.wait_err("position ");
    running.signal(Signal::TERM);
    let ended = running.end();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(ended.last_line().ends_with(" ready"), "{ended:?}");
    board.order(&["position"]).assert(0, ended.last_line());
}

#[test]
fn a_run_goes_on_without_us_until_it_is_stopped() {
    let board = Board::start(&[]);
    let ended = board.order(&["run", "-500", "--detach"]);
    assert!(ended.last_line().ends_with(" busy"), "{ended:?}");
    assert_eq!(ended.code(), Some(0));
    assert!(ended.stderr.contains(&format!("stepwright stop --port {}", board.path)), "{ended:?}");
    let ended = board.order(&["position"]);
    assert!(ended.last_line().starts_with("position -"), "{ended:?}");
    assert!(ended.last_line().ends_with(" busy"), "{ended:?}");
    let ended = board.order(&["zero"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("still travelling");
    let ended = board.order(&["move", "5"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("still travelling");
    let stopped = board.order(&["stop", "--axis", "1"]);
    assert!(stopped.last_line().ends_with(" ready"), "{stopped:?}");
    assert_eq!(stopped.code(), Some(0));
    board.order(&["position"]).assert(0, stopped.last_line());
    // And killed: the position is lost until it is set.
    assert_eq!(board.order(&["run", "500", "--detach"]).code(), Some(0));
    let killed = board.order(&["kill"]);
    killed.assert(0, "axis 3 position 0 ready");
    assert!(killed.stdout.starts_with("axis 1 position uncertain\n"), "{killed:?}");
    let ended = board.order(&["position"]);
    ended.assert(1, "position uncertain");
    ended.assert_error("uncertain");
    let ended = board.order(&["move", "5"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("uncertain");
    assert!(ended.stderr.contains("stepwright zero --axis 1"), "{ended:?}");
    board.order(&["zero"]).assert(0, "position 0 ready");
    board.order(&["move", "5"]).assert(0, "position 5 ready");
}

#[test]
fn programs_come_and_go() {
    let board = Board::start(&[]);
    for n in 0..40 {
        let client = board.open();
        if n % 3 == 0 {
            // One that leaves in the middle, with answers unread.
            client.port.write_all(b"V1\rV1\rV1\r?\rPO\rG+").unwrap();
        } else {
            // The first answer may belong to what stood in the slave.
            client.say_until("F", |status| status == "R");
        }
    }
    board.order(&["move", "20"]).assert(0, "position 20 ready");
}

/// A program that leaves the line with an echo must not have the board talk to
/// itself.
#[test]
fn a_line_that_is_left_cooked_is_made_raw() {
    let board = Board::start(&[]);
    let client = board.open();
    assert_eq!(client.say("F"), "R");
    let mut settings = tcgetattr(&client.port).unwrap();
    settings.local_modes |= rustix::termios::LocalModes::ECHO;
    settings.output_modes |= rustix::termios::OutputModes::OPOST;
    tcsetattr(&client.port, OptionalActions::Now, &settings).unwrap();
    drop(client);
    let begin = Instant::now();
    loop {
        let plain = std::fs::OpenOptions::new().read(true).open(&board.path).unwrap();
        let settings = tcgetattr(&plain).unwrap();
        if !settings.local_modes.contains(rustix::termios::LocalModes::ECHO) {
            break;
        }
        assert!(begin.elapsed() < LIMIT);
        drop(plain);
        std::thread::sleep(Duration::from_millis(30));
    }
    board.order(&["move", "20"]).assert(0, "position 20 ready");
}

#[test]
fn garbage_and_floods_are_survived() {
    let board = Board::start(&["--fast"]);
    let client = board.open();
    let noise: Vec<u8> = (0..50_000u32).map(|n| (n.wrapping_mul(n) >> 7) as u8).collect();
    let mut port = client.port.try_clone().unwrap();
    port.set_write_timeout(LIMIT).unwrap();
    let writer = std::thread::spawn(move || {
        port.write_all(&noise).unwrap();
        // Many questions, and nobody listens to the answers.
        port.write_all(&b"V1\r".repeat(100_000)).unwrap();
    });
    writer.join().unwrap();
    drop(client);
    // A master that gets in step first.
    board.order(&["move", "20"]).assert(0, "position 20 ready");
}

#[test]
fn a_board_that_vanishes_is_noticed_at_once() {
    for order in [&["move", "100000"][..], &["run", "1000", "--for", "1h"]] {
        let mut board = Board::start(&[]);
        let mut running = Running::start(&[order, &["--port", &board.path]].concat());
        running.wait_err("position");
        // As if it was unplugged.
        board.running.child.kill().unwrap();
        let gone = Instant::now();
        let ended = running.end();
        assert!(gone.elapsed() < Duration::from_secs(10), "{:?}", gone.elapsed());
        ended.assert(1, "position uncertain");
        ended.assert_error("lost the board on its way");
        assert!(ended.stderr.contains("may still be moving"), "{ended:?}");
    }
}

#[test]
fn a_port_that_is_no_board_is_told() {
    for (path, why) in [
        ("/dev/null", "can't open /dev/null as a serial port"),
        ("/nowhere", "there is no port /nowhere"),
    ] {
        let ended = stepwright(&["move", "5", "--port", path]);
        assert_eq!(ended.code(), Some(1), "{ended:?}");
        ended.assert_error(why);
        assert!(ended.stderr.contains("stepwright ports"), "{ended:?}");
    }
    // A line at whose other end nobody speaks.
    let (_silent, path) = common::pty();
    let ended = stepwright(&["status", "--port", &path]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("no answer from");
}

#[test]
fn two_masters_at_once_are_kept_apart_but_a_stop_gets_through() {
    let board = Board::start(&[]);
    let mut moving = Running::start(&["move", "1000000", "--port", &board.path]);
    moving.wait_err("position");
    let ended = board.order(&["move", "5"]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error("is in use");
    let killed = board.order(&["kill"]);
    assert_eq!(killed.code(), Some(0), "{killed:?}");
    let ended = moving.end();
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    board.order(&["position"]).assert(1, "position uncertain");
    board.order(&["zero"]).assert(0, "position 0 ready");

    let mut moving = Running::start(&["move", "-1000000", "--axis", "2", "--port", &board.path]);
    moving.wait_err("position");
    let stopped = board.order(&["stop", "--axis", "2"]);
    assert_eq!(stopped.code(), Some(0), "{stopped:?}");
    let ended = moving.end();
    let rest = stopped.last_line().strip_suffix(" ready").expect("it rests");
    ended.assert(1, &format!("{rest} stopped by a soft stop (Z)"));
    ended.assert_error("steps before -1000000, by a soft stop (Z)");
    let status = board.order(&["status"]).stdout;
    assert!(status.contains(&format!("{rest} ready, stopped by a soft stop (Z)\n")), "{status}");
    assert!(status.contains("position 0 ready, stopped by a kill (K)\n"), "{status}");
}

#[test]
fn ctrl_c_over_the_port_brakes_and_kills() {
    let board = Board::start(&[]);
    let moving = |order: &[&str]| {
        let mut running = Running::start(&[order, &["--port", &board.path]].concat());
        running.wait_err("position");
        running
    };
    let running = moving(&["move", "1000000"]);
    running.signal(Signal::INT);
    let ended = running.end();
    assert_eq!(ended.code(), Some(130), "{ended:?}");
    let rest = ended.last_line().strip_suffix(" stopped").expect("it says where").to_owned();
    board.order(&["position"]).assert(0, &format!("{rest} ready"));
    let brake = ["--top-speed", "2000", "--accel", "20000", "--decel", "200"];
    let mut running = moving(&[&["move", "1000000"], &brake[..]].concat());
    running.signal(Signal::INT);
    running.wait_err("braking");
    running.signal(Signal::INT);
    running.end().assert(130, "position uncertain");
    board.order(&["position"]).assert(1, "position uncertain");
}

#[test]
fn recordings_end_with_the_board() {
    let file = common::Scratch::new("pty.vcd");
    let board = Board::start(&["--fast", "--vcd", file.path()]);
    board.order(&["move", "40"]).assert(0, "position 40 ready");
    assert_eq!(board.end().code(), Some(0));
    let dump = std::fs::read_to_string(&file.0).unwrap();
    assert_eq!(dump.lines().filter(|line| *line == "1a").count(), 40);
    assert!(dump.lines().last().unwrap().starts_with('#'));
}

/// A board that is ended cuts the motion of its motors short. Where those are that rest is known.
#[test]
fn a_board_that_is_ended_while_a_motor_moves_is_not_done() {
    let board = Board::start(&[]);
    board.order(&["move", "3", "--axis", "2"]).assert(0, "position 3 ready");
    assert_eq!(board.order(&["move", "100000", "--detach"]).code(), Some(0));
    let ended = board.end();
    assert_eq!(ended.code(), Some(130), "{ended:?}");
    ended.assert_error("the board was ended while a motor moved");
    assert!(ended.stderr.contains("axis 2 position 3 ready\nposition uncertain\n"), "{ended:?}");
}
