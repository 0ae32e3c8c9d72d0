//! Tests of files on the virtual board behind a line: its refusals, and the final positions of its
//! motors.

use std::cell::Cell;
use std::collections::VecDeque;
use std::fmt::Display;
use std::io;

use stepwright::Rate;
use stepwright_sim::{CycleBoard, CycleLineBoard, Edge, Stand};

use super::*;
use stepwright_host::link::Link;

const UNO: &str = "stepwright-cycle uno hz=16000000 axes=3 legs=22 late=0 can=sum";
const MEGA: &str =
    "stepwright-cycle mega hz=16000000 axes=4 legs=400 late=0 can=sum,brakes,home,tick,paths";

type Host = CycleBoard<'static, Vec<Edge>, 4>;

fn summed(line: &str) -> String {
    format!("{line}*{:02X}", line.bytes().fold(0, stepwright_protocol::crc))
}

/// A board with its identification. Its time passes while the caller waits.
struct Chip {
    about: &'static str,
    board: CycleLineBoard<'static, Vec<Edge>, 4>,
    line: Vec<u8>,
    answers: VecDeque<u8>,
    /// Spoils every n-th byte that it sends; 0: none.
    noise: usize,
    said: usize,
}

impl Chip {
    fn new(about: &'static str, noise: usize) -> Chip {
        let rate = Rate::from_hz(16_000_000).unwrap();
        let stand = Stand { min: Some(-3_000), max: Some(13_600) };
        let board: Host =
            CycleBoard::new([Motor::new(1, 1); 4], [stand; 4], Clock::Deadlines, rate, Vec::new());
        let legs = (0..400).map(|_| Cell::new(Leg::Steps { count: 0, delay: 0 }));
        let legs: &'static [Cell<Leg>] = legs.collect::<Vec<_>>().leak();
        let (line, answers) = (Vec::new(), VecDeque::new());
        Chip { about, board: CycleLineBoard::new(board, legs), line, answers, noise, said: 0 }
    }

    fn say(&mut self, byte: u8) {
        self.said += 1;
        let spoiled = self.noise != 0 && self.said.is_multiple_of(self.noise);
        self.answers.push_back(if spoiled && byte != b'\r' { byte ^ 2 } else { byte });
    }
}

impl Link for Chip {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for byte in bytes {
            self.line.push(*byte);
            if *byte != b'\r' {
                continue;
            }
            let line = std::mem::take(&mut self.line);
            if let [b'?', sum @ ..] = line.as_slice() {
                let about = if sum == b"\r" { self.about.into() } else { summed(self.about) };
                self.answers.extend(about.bytes().chain([b'\r']));
                continue;
            }
            line.iter().for_each(|byte| self.board.receive(*byte));
            self.board.take_answers().into_iter().for_each(|byte| self.say(byte));
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        match (self.answers.pop_front(), buffer) {
            (Some(byte), [first, ..]) => {
                *first = byte;
                Ok(1)
            }
            _ => {
                self.rest(limit);
                Ok(0)
            }
        }
    }

    fn now(&self) -> Duration {
        // Only waiting takes time.
        Duration::from_micros(self.board.now() / 16)
    }

    fn name(&self) -> String {
        "the chip".into()
    }

    fn rest(&mut self, time: Duration) {
        let end = self.board.now() + time.as_micros().max(1) as u64 * 16;
        self.board.run_until(end);
    }
}

struct Nobody;

impl PlayVoice for Nobody {
    fn result(&self, _: &dyn Display) {}

    fn note(&self, _: &dyn Display) {}

    fn asked(&self) -> bool {
        false
    }
}

/// Plays a file. Returns the final positions.
fn play(about: &'static str, noise: usize, file: &str) -> Result<Vec<i64>, PlayError> {
    let text = PlayText::named("file.toml", file);
    let mut plan = stepwright_cyclefile::read(&text)?;
    let mut stages = std::mem::take(&mut plan.stages);
    let board = CycleSession::on(Box::new(Chip::new(about, noise))).expect("it plays cycles");
    let mut session = CyclesOnBoard::new(board, &plan, &text, PlayFormat::Json, &Nobody, 60);
    session.play(&mut stages)?;
    Ok(session.shown.clone().unwrap())
}

/// A file with motors named A, B …, followed by `rest`.
fn file(motors: usize, rest: &str) -> String {
    let names = ["A", "B", "C", "D", "E"];
    let motor = |name| format!("[[motor]]\nname = \"{name}\"\nstep = 1\nsmallest-delay-us = 500\n");
    let motors: String = names[..motors].iter().map(motor).collect();
    format!("{motors}{rest}")
}

#[track_caller]
fn refused(about: &'static str, file: &str, what: &str) {
    let failure = play(about, 0, file).expect_err(what);
    assert!(failure.message.contains(what), "{}", failure.message);
}

const GO: &str = "[[cycle]]\nmove.A = { steps = 10 }\n";

#[test]
fn files_play_and_motors_keep_their_places() {
    let moves = "[[cycle]]\nmove.A = { steps = 100 }\nmove.B = { steps = -50, delay-us = 700 }\n\
                 [[cycle]]\nmove.A = { series = [{ steps = -30 }, { wait = 2, delay-us = 900 }] }\n";
    for about in [UNO, MEGA] {
        assert_eq!(play(about, 0, &file(2, moves)).unwrap(), [70, -50]);
    }
    // A list, a ramp, a time to finish.
    let moves = "[[cycle]]\nmove.A = { delays-us = [900, 800], each = 7, direction = \"backward\" }\n\
                 move.B = { whirl = \"forward\", ramp-us = { from = 2000, to = 600, by = 100 } }\n\
                 finish-s = 0.0205\n";
    let at = play(UNO, 0, &file(2, moves)).unwrap();
    assert_eq!(at[0], -14);
    // 2000, 1900 … 600, and 600 from then on: the 15th step comes after 19.5 ms.
    assert_eq!(at[1], 16);
    let home = "[[cycle]]\nhome = { motor = \"A\", end = \"max\", reach = 20000, back-off = 20 }\n";
    assert_eq!(play(MEGA, 0, &file(1, home)).unwrap(), [0]);
}

#[test]
fn spoiled_answers_are_asked_for_again() {
    let moves = "[[cycle]]\nmove.A = { steps = 1000 }\n[[cycle]]\nmove.A = { steps = -100 }\n";
    for noise in [211, 331, 499] {
        assert_eq!(play(UNO, noise, &file(1, moves)).unwrap(), [900]);
    }
}

#[test]
fn what_a_board_can_not_do_is_refused() {
    refused(UNO, &file(4, GO), "this uno moves 3 motors, and the file has 4");
    refused(MEGA, &file(5, GO), "this mega moves 4 motors, and the file has 5");
    let tick = format!("[clock]\ntick-us = 100\n{}", file(1, GO));
    refused(UNO, &tick, "a uno has no room for the fixed tick");
    assert_eq!(play(MEGA, 0, &tick).unwrap(), [10]);
    let slow = tick.replace("tick-us = 100", "tick-us = 200");
    refused(MEGA, &slow, "smallest delay");
    refused(UNO, &format!("[clock]\ntimer-hz = 8000000\n{}", file(1, GO)), "runs at 16000000 Hz");
    let brakes = format!(
        "[strategies]\nhard-end = \"brake-all\"\n{}",
        file(1, "").replace("name", "decel = 100\nname") + GO
    );
    refused(UNO, &brakes, "no room for braking at a switch");
    assert_eq!(play(MEGA, 0, &brakes).unwrap(), [10]);
    let home = "[[cycle]]\nhome = { motor = \"A\", end = \"min\", reach = 10, back-off = 2 }\n";
    refused(UNO, &file(1, home), "no room for homing");
    refused(MEGA, &file(1, home), "the switch was not found");
    let line = "[[cycle]]\nline = { to = { A = 10 }, speed = 100, accel = 1000 }\n";
    refused(UNO, &file(1, &format!("{GO}{line}")), "a uno has no room for lines and arcs");
    let list = |length| {
        let long = vec!["900"; length].join(",");
        file(1, &format!("[[cycle]]\nmove.A = {{ delays-us = [{long}] }}\n"))
    };
    for (length, more) in [(25, 3), (70_000, 69_978)] {
        let what = format!(
            "has {length} delays and legs of series so far, {more} more than a uno keeps (22)"
        );
        refused(UNO, &list(length), &what);
    }
    assert_eq!(play(MEGA, 0, &list(25)).unwrap(), [25]);
    let each = "[[cycle]]\nmove.A = { delays-us = [900], each = 2147483648 }\n";
    refused(UNO, &file(1, each), "each is at most 2147483647 on a board");
    // The board's own refusals, with the motor's name.
    let small = "[[cycle]]\nmove.A = { steps = 10 }\nmove.B = { steps = 10, delay-us = 400 }\n";
    refused(UNO, &file(2, small), "the first delay of B is below its smallest: at least 500 µs");
    let bound = file(1, "").replace("step =", "max = 5\nstep =") + GO;
    refused(UNO, &bound, "A: soft-end-max");
    let endless = "[[cycle]]\nmove.A = { whirl = \"forward\", delay-us = 20000 }\n";
    refused(UNO, &file(1, endless), "cycle 1 has not ended after 60 s");
}

#[test]
fn pins_are_looked_up() {
    let on = |pins: &str, rest: &str| {
        file(1, "").replace("name", &format!("pins = {{ {pins} }}\n{rest}\nname")) + GO
    };
    assert_eq!(play(UNO, 0, &on("step = \"A0\", enable = \"none\"", "")).unwrap(), [10]);
    refused(UNO, &on("step = \"D22\"", ""), "this board has no pin D22");
    assert_eq!(play(MEGA, 0, &on("step = \"D22\"", "")).unwrap(), [10]);
    refused(UNO, &on("dir = \"X1\"", ""), "\"X1\" is no pin: D0 to D53, A0 to A15, or none");
    // A shield has one switch for each motor.
    let switches = "switch-min = -5\nswitch-max = 100";
    refused(UNO, &on("step = \"D2\"", switches), "a board has to know its pin: max");
    assert_eq!(play(UNO, 0, &on("max = \"D12\"", switches)).unwrap(), [10]);
    // A fourth motor has no pins of a shield.
    let four = file(4, GO);
    refused(MEGA, &four, "a board has to know its pin: step");
}

/// Paths end at the nearest step, and begin at the motors' positions.
#[test]
fn paths_play_from_where_the_motors_stand() {
    let line =
        |to: &str| format!("[[cycle]]\nline = {{ to = {{ {to} }}, speed = 900, accel = 3000 }}\n");
    let arc = "[[cycle]]\narc = { motors = [\"A\", \"B\"], centre = [0, 0], degrees = 90, \
               speed = 900, accel = 3000 }\n";
    let all = format!("{GO}{}{}{arc}", line("A = 300"), line("B = 0"));
    assert_eq!(play(MEGA, 0, &file(2, &all)).unwrap(), [0, 300]);
    assert_eq!(play(MEGA, 97, &file(2, &all)).unwrap(), [0, 300]);
    // Changes during the path are part of the runs.
    let changed = "[[cycle]]\nline = { to = { A = 500, B = 100 }, speed = 900, accel = 3000 }\n\
                   pause-s = 0.2\nresume-s = 0.9\nfeed = [{ at-s = 0.1, percent = 50 }]\n\
                   retarget = [{ at-s = 1.1, to = { A = -40, B = 20 } }]\n";
    assert_eq!(play(MEGA, 0, &file(2, changed)).unwrap(), [-40, 20]);
    // A path without length.
    assert_eq!(play(MEGA, 0, &file(2, &line("A = 0"))).unwrap(), [0, 0]);
}

#[test]
fn a_path_that_a_board_can_not_keep_is_refused() {
    let arc = |radius: u32, speed: u32| {
        let centre = format!("[{radius}, 0]");
        let path = format!(
            "[[cycle]]\narc = {{ motors = [\"A\", \"B\"], centre = {centre}, degrees = 3600, \
             speed = {speed}, accel = 3000 }}\n"
        );
        file(2, &path)
    };
    let failure = play(MEGA, 0, &arc(300, 900)).expect_err("ten times round");
    let message = failure.message;
    assert!(message.contains("the path of cycle 1 is "), "{message}");
    assert!(message.contains(" runs, and a mega keeps 400"), "{message}");
    // More runs than the places of a line can number: too long, not endless.
    let far = arc(20_000, 900).replace("3600", "40000");
    let failure = play(MEGA, 0, &far).expect_err("a hundred times round");
    let message = failure.message;
    assert!(message.contains(" runs, and a mega keeps 400"), "{message}");
    let quick = arc(20, 900).replace("smallest-delay-us = 500", "smallest-delay-us = 5000");
    refused(MEGA, &quick, "too fast for A, whose smallest delay is 5000 µs");
}

/// A board keeps a path of several pieces as one. The example fits a Mega.
#[test]
fn a_path_of_several_pieces_plays_on_a_board() {
    let joined = include_str!("../../../../stepwright-cli/src/serve/paths/joined.toml");
    assert_eq!(play(MEGA, 0, joined).unwrap(), [10_000_000, 0]);
    let corner = "[[cycle]]\nfinish-s = 0.5\n[cycle.path]\nspeed = 1000\naccel = 4000\n\
                  pieces = [{ to = { A = 300 } }, { to = { B = 900 } }]\n";
    let at = play(MEGA, 0, &file(2, corner)).unwrap();
    assert!(at[0] == 300 && (1..900).contains(&at[1]), "{at:?}");
    refused(UNO, joined, "a uno has no room for lines and arcs");
}
