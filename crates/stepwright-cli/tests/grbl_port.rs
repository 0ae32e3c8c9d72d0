//! `grbl --port` on `board --pty --program stream`: the motors of a board, under a sender.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use crate::common::{PtyBoard, program};

fn stepwright() -> Command {
    Command::new(program())
}

/// A sender on standard input and output.
struct Sender {
    child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<String>,
}

impl Sender {
    fn new(board: &PtyBoard) -> Sender {
        let mut child = stepwright()
            .args(["grbl", "--stdio", "--port", &board.1])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (tell, lines) = mpsc::channel();
        let out = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                if tell.send(line).is_err() {
                    return;
                }
            }
        });
        let mut sender = Sender { input: child.stdin.take(), child, lines };
        sender.hear("Grbl 1.1h");
        for line in ["$100=80", "$101=80", "$110=6000", "$111=6000", "$120=500", "$121=500"] {
            sender.say(&format!("{line}\n"));
            sender.hear("ok");
        }
        sender
    }

    fn say(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().unwrap();
        input.write_all(bytes).unwrap();
        input.flush().unwrap();
    }

    /// The next line that has this in it.
    fn hear(&mut self, wanted: &str) -> String {
        let end = Instant::now() + Duration::from_secs(30);
        let mut heard = Vec::new();
        loop {
            let line = self.lines.recv_timeout(end.saturating_duration_since(Instant::now()));
            let Ok(line) = line else { panic!("no {wanted} in {heard:?}") };
            if line.contains(wanted) {
                return line;
            }
            heard.push(line);
        }
    }

    /// Asks until the report has this in it.
    fn report(&mut self, wanted: &str) -> String {
        let end = Instant::now() + Duration::from_secs(30);
        loop {
            self.say("?");
            let line = self.hear("<");
            if line.contains(wanted) {
                return line;
            }
            assert!(Instant::now() < end, "{line} is not {wanted}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// What is said at the end, on standard error.
    fn end(mut self) -> String {
        self.input = None;
        let mut text = String::new();
        self.child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
        self.child.wait().unwrap();
        text
    }
}

/// What a board that is fed can't do is refused. Motion is tried in simulated time:
/// `stepwright-feeder/tests/grbl.rs`.
#[test]
fn homing_and_probe_are_refused() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    for (line, answer) in [("$22=1", "error:3"), ("$H", "error:5")] {
        sender.say(&format!("{line}\n"));
        assert_eq!(sender.hear("error"), answer, "{line}");
    }
    sender.say("G38.2 Z-1 F10\n");
    assert_eq!(sender.hear("error"), "error:20");
    let told = sender.end();
    assert!(told.contains("board 0 0 0, late steps 0"), "{told}");
}

/// A board that vanishes is an alarm with its own words.
#[test]
fn a_board_that_vanishes_is_an_alarm() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    sender.say("G1 X100 F1000\n");
    sender.report("<Run|MPos:1");
    drop(board);
    sender.hear("[MSG:Board lost");
    sender.hear("ALARM:3");
    let told = sender.end();
    assert!(told.contains("its position stays known"), "{told}");
}

/// A second Ctrl-C kills while the first one still brakes, and says so only if the board does.
#[test]
fn a_second_signal_kills_and_says_what_is_known() {
    use nix::sys::signal::{Signal, kill};
    let pid = |child: &Child| nix::unistd::Pid::from_raw(child.id() as i32);
    for silent in [false, true] {
        let board = PtyBoard::new(&["--program", "stream"]);
        let mut sender = Sender::new(&board);
        // It brakes for a second.
        sender.say("$120=50\n");
        sender.hear("ok");
        sender.say("G1 X200 F3000\n");
        sender.report("<Run|MPos:2");
        if silent {
            kill(pid(&board.0.child), Signal::SIGSTOP).unwrap();
        }
        for _ in 0..2 {
            kill(pid(&sender.child), Signal::SIGINT).unwrap();
            std::thread::sleep(Duration::from_millis(20));
        }
        let told = sender.end();
        if silent {
            assert!(told.contains("did not confirm K") && told.contains("power"), "{told}");
            kill(pid(&board.0.child), Signal::SIGCONT).unwrap();
        } else {
            assert!(told.contains("killed: the positions of axes that moved are lost"), "{told}");
            // The next session begins where the axes stand.
            let mut sender = Sender::new(&board);
            sender.say("G1 X1 F1000\n");
            sender.report("<Idle|MPos:1.000");
            let told = sender.end();
            assert!(told.contains("did not know where its axes are"), "{told}");
            assert!(told.contains("board 80 0 0"), "{told}");
        }
    }
}

/// Who can't brake does not begin.
#[test]
fn an_axis_that_the_board_cannot_brake_does_not_move() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    // 4 steps/s².
    sender.say("$121=0.05\n");
    sender.hear("ok");
    sender.say("G1 X1 F100\n");
    sender.hear("Acceleration below 8");
    sender.hear("ALARM:3");
    let told = sender.end();
    assert!(told.contains("board 0 0 0, late steps 0"), "{told}");
}

#[test]
fn a_move_ends_where_the_board_says_it_is() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    sender.say("G1 X10 Y-5 F2000\n");
    sender.report("<Run");
    sender.report("<Idle|MPos:10.000,-5.000,0.000");
    let told = sender.end();
    assert!(told.contains("board 800 -400 0, late steps 0"), "{told}");
}

/// The time of the session stands while a move waits for the board to come to a stop: a hold of that move
/// keeps the steps that the board keeps.
#[test]
fn a_move_behind_a_stop_that_is_held_ends_where_the_board_says_it_is() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    for stop in ["M3 S100", "M5", "G4 P0.01", "G4 P0.2"] {
        sender.say("G0 X3\n");
        sender.report("<Idle|MPos:3.000");
        sender.say(&format!("G1 X3.5 F3000\n{stop}\nG1 X60\n"));
        // From 10 mm on.
        sender.report("<Run|MPos:1");
        sender.bytes(b"!\x91");
        sender.report("<Hold:0");
        sender.bytes(b"~\x90");
        sender.report("<Idle|MPos:60.000,0.000,0.000");
    }
    let told = sender.end();
    assert!(told.contains("board 4800 0 0, late steps 0"), "{told}");
}

#[test]
fn another_program_is_refused_with_the_remedy() {
    let board = PtyBoard::new(&[]);
    let output = stepwright().args(["grbl", "--stdio", "--port", &board.1]).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("stepwright flash uno --program stream"), "{told}");
}

/// What the board can't play is refused before anything moves, as by `gcode --port`.
#[test]
fn a_step_rate_beyond_the_board_is_refused() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    for line in ["$100=250", "$110=120000", "$120=5000"] {
        sender.say(&format!("{line}\n"));
        sender.hear("ok");
    }
    sender.say("G1 X1000 F200000\n");
    sender.hear("[MSG:X at 500000 steps/s: the board can do 128000, lower $110]");
    sender.hear("ALARM:2");
    let told = sender.end();
    assert!(told.contains("board 0 0 0, late steps 0"), "{told}");
}

/// A board has a run all through a hold, which nobody can end behind the end of the input.
#[test]
fn an_input_that_ends_in_a_hold_ends() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    sender.say("G1 X100 F3000\n");
    sender.report("<Run|MPos:1");
    sender.say("!");
    sender.report("<Hold:0");
    sender.input = None;
    let end = Instant::now() + Duration::from_secs(20);
    while sender.child.try_wait().unwrap().is_none() {
        if Instant::now() > end {
            sender.child.kill().unwrap();
            panic!("it does not end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let told = sender.end();
    assert!(told.contains("error: the input ended in a hold"), "{told}");
}

/// Who reads no answers any more has no way to stop the motors: they brake along the path.
#[test]
fn a_sender_that_reads_no_more_ends_the_motion() {
    let board = PtyBoard::new(&["--program", "stream"]);
    let mut sender = Sender::new(&board);
    sender.say("G1 X200 F3000\n");
    sender.report("<Run|MPos:1");
    // The thread that reads ends with the next line.
    sender.lines = mpsc::channel().1;
    sender.say("?");
    std::thread::sleep(Duration::from_millis(200));
    // The command may have ended by now.
    _ = sender.input.as_mut().unwrap().write_all(b"?");
    let told = sender.end();
    assert!(told.contains("can't write answers to standard output"), "{told}");
    let place = told.split("position ").nth(1).and_then(|told| told.split(' ').next()).unwrap();
    assert!(place.parse::<u32>().is_ok_and(|place| (800..8_000).contains(&place)), "{told}");
    assert!(told.contains(&format!("board {place} 0 0, late steps 0")), "{told}");
}
