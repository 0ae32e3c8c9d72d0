//! A program of one's own by `stepwright-host`, and the command beside it, on one board.
#![cfg(unix)]

use std::thread;
use std::time::Duration;

use crate::common::{Ended, Running, stepwright};
use rustix::process::Signal;
use stepwright::{Accel, Speed};
use stepwright_host::motion::Action;
use stepwright_host::{Board, Error, MotionLimits, Outcome};
use stepwright_protocol::{Refusal, Selection, Stop};

/// A virtual board that stays, and its path.
struct Bench(Running, String);

impl Bench {
    fn new() -> Bench {
        let mut board = Running::start(&["board", "--pty"]);
        let path = board.wait_out("").strip_prefix("pty ").unwrap().to_owned();
        Bench(board, path)
    }

    fn end(self) {
        self.0.signal(Signal::INT);
        self.0.end();
    }
}

fn limits(top: u32, accel: u32) -> MotionLimits {
    MotionLimits::new(Speed::from_steps(top).unwrap(), Accel::from_steps(accel).unwrap())
}

/// What the command says while `travel` is on its way in this program.
fn meanwhile(args: &'static [&'static str], steps: i64) -> (Ended, Result<Outcome, Error>) {
    let bench = Bench::new();
    let path = bench.1.clone();
    let mut board = Board::open(&path).unwrap();
    let mut x = board.axis(1).unwrap();
    x.travel(steps, &limits(1_000, 10_000)).unwrap();
    let command = thread::spawn(move || stepwright(&[args, &["--port", &path]].concat()));
    let outcome = x.wait(|_| Action::GoOn);
    // Who asks last is heard too.
    while !command.is_finished() {
        board.session().pause(Duration::from_millis(20)).unwrap();
    }
    drop(board);
    bench.end();
    (command.join().unwrap(), outcome)
}

#[test]
fn the_command_asks_changes_and_stops_what_a_program_moves() {
    let (ended, outcome) = meanwhile(&["position"], 3_000);
    assert!(ended.last_line().ends_with(" busy"), "{}", ended.last_line());
    assert_eq!(outcome.unwrap(), Outcome::Reached { at: 3_000 });
    let (ended, outcome) = meanwhile(&["retarget", "--to", "4000"], 3_000);
    assert_eq!(ended.code(), Some(0));
    assert_eq!(outcome.unwrap(), Outcome::Reached { at: 4_000 });
    let (ended, outcome) = meanwhile(&["stop"], 30_000);
    assert_eq!(ended.code(), Some(0));
    let outcome = outcome.unwrap();
    assert!(
        matches!(outcome, Outcome::Stopped { at: 1..30_000, reason: Some(Stop::Soft) }),
        "{outcome}"
    );
    // Orders are the holder's.
    let (ended, outcome) = meanwhile(&["move", "5"], 3_000);
    ended.assert_error("is in use");
    assert_eq!(outcome.unwrap(), Outcome::Reached { at: 3_000 });
}

#[test]
fn a_program_joins_what_the_command_moves() {
    let bench = Bench::new();
    let Err(Error::Open(_)) = Board::join(&bench.1) else { panic!("nobody holds it") };
    let port = ["--port", &bench.1];
    let slow = ["move", "100000", "--top-speed", "2000", "--accel", "20000"];
    let mut mover = Running::start(&[&slow, &port[..]].concat());
    mover.wait_err("position ");
    let Err(Error::Open(_)) = Board::open(&bench.1) else { panic!("it is held") };
    let mut board = Board::join(&bench.1).unwrap();
    let mut x = board.axis(1).unwrap();
    assert!(x.position().unwrap().is_some_and(|at| at > 0));
    x.set_top_speed(Speed::from_steps(3_000).unwrap()).unwrap();
    assert!(matches!(x.travel(5, &limits(1_000, 10_000)), Err(Error::Moving)));
    let refused = board.axis(2).unwrap().travel(5, &limits(1_000, 10_000)).unwrap_err();
    let Error::Refused { reason: Some(Refusal::Line), .. } = refused else { panic!("{refused}") };
    // The holder leaves when its motor rests, and with it the way to the board.
    board.session().stop(Selection::FIRST).unwrap();
    let mover = mover.end();
    assert_eq!(mover.code(), Some(1));
    assert!(mover.last_line().ends_with(" stopped by a soft stop (Z)"), "{}", mover.last_line());
    bench.end();
}
