//! A sender's controller on a board that is fed, in simulated time: hold, resume, override, jog, reset,
//! judged by the board's steps.

use crate::common::*;
use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_grbl::{FedRun, Grbl, VirtualMill};
use stepwright_sim::{Queues, StreamBoard};

/// The machine, and what the command does for it.
struct Mill<'q> {
    grbl: Grbl<VirtualMill>,
    board: StreamBoard<'q, Vec<stepwright_sim::Edge>>,
    /// And when it began, in cycles.
    run: Option<(FedRun, u64)>,
    now: f64,
    said: String,
    states: Vec<FeedState>,
}

impl<'q> Mill<'q> {
    fn new(queues: &'q mut Queues) -> Mill<'q> {
        let grbl = Grbl::new(VirtualMill::default()).fed();
        let board = board(queues);
        let (said, states) = (String::new(), vec![]);
        let mut mill = Mill { grbl, board, run: None, now: 0.0, said, states };
        mill.say(
            b"$100=80\n$101=80\n$102=80\n$110=6000\n$111=6000\n$120=500\n$121=500\n$122=500\nG21\n",
        );
        mill
    }

    fn say(&mut self, bytes: &[u8]) {
        self.grbl.receive(self.now, bytes);
    }

    /// A millisecond.
    fn turn(&mut self) {
        self.board.run_until(self.board.now() + MILLIS);
        let heard = self.board.take_answers();
        let time = self.board.now();
        match &mut self.run {
            None if self.grbl.has_run() => {
                let terms = FeedTerms { ahead: 500_000, ..terms([40_000.0; 3]) };
                let run = FedRun::begin(&self.grbl, self.now, StreamFeeder::new(terms, 0));
                self.run = run.map(|run| (run, time));
            }
            None => self.now += 1e-3,
            Some((run, begun)) => {
                let bytes = run.turn(&mut self.grbl, &heard, (time - *begun) / 16);
                self.now = run.now();
                self.board.receive(&bytes);
                if run.state().is_end() {
                    self.states.push(run.state());
                    self.run = None;
                }
            }
        }
        self.grbl.advance(self.now);
        self.said += &String::from_utf8(self.grbl.take_answers()).unwrap();
    }

    fn pass(&mut self, millis: u32) {
        (0..millis).for_each(|_| self.turn());
    }

    /// Until nothing moves, and the board rests.
    fn rest(&mut self) {
        let (mut quiet, mut turns) = (0, 0);
        while quiet < 50 {
            self.turn();
            turns += 1;
            assert!(turns < 60_000, "it does not come to rest: {}", self.report());
            let moves = self.run.is_some() || self.grbl.has_run();
            quiet = if moves { 0 } else { quiet + 1 };
        }
    }

    fn report(&mut self) -> String {
        self.said.clear();
        self.say(b"?");
        self.turn();
        self.said[self.said.find('<').unwrap()..].lines().next().unwrap().to_owned()
    }

    /// The board is where the session is.
    fn agree(&mut self) -> [i64; 3] {
        let at = [0, 1, 2].map(|axis| self.board.position(axis).unwrap());
        assert_eq!(at, self.grbl.position());
        assert!(self.states.iter().all(|state| *state == FeedState::Over), "{:?}", self.states);
        assert_eq!(self.board.late(), 0);
        at
    }
}

#[test]
fn a_job_with_a_hold_and_an_override_ends_exactly() {
    let mut queues = Queues::default();
    let mut mill = Mill::new(&mut queues);
    mill.say(b"G1 X40 F3000\nG2 X40 Y40 J20\nG1 X0 Y0\n");
    mill.pass(500);
    assert!(mill.report().starts_with("<Run|MPos:1"), "{}", mill.said);
    mill.say(b"!");
    // 50 ms to the brake, which takes 0.1 s.
    mill.pass(150);
    let held = mill.report();
    assert!(held.starts_with("<Hold:0|"), "{held}");
    let edges = mill.board.recorder().len();
    mill.pass(400);
    assert_eq!(
        (mill.report()[..18].to_owned(), mill.board.recorder().len()),
        (held[..18].to_owned(), edges)
    );
    mill.say(b"\x91~");
    mill.pass(70);
    assert!(mill.board.recorder().len() > edges + 20, "it goes on");
    mill.rest();
    assert_eq!(mill.agree(), [0; 3]);
    // A dwell, and a run that begins where the last one has ended facing backward.
    mill.say(b"G1 X5 F1000\nG4 P0.1\nG1 X2.5\nX10\n");
    mill.rest();
    assert_eq!(mill.agree(), [800, 0, 0]);
    assert!(mill.report().starts_with("<Idle|MPos:10.000,0.000,0.000"));
}

#[test]
fn a_jog_and_a_reset_brake_along_the_path() {
    let mut queues = Queues::default();
    let mut mill = Mill::new(&mut queues);
    mill.say(b"$J=G91 X100 Y50 F3000\n");
    mill.pass(700);
    mill.say(b"\x85");
    mill.rest();
    let [x, y, _] = mill.agree();
    assert!(x > 1_000 && x < 7_000 && (x - 2 * y).abs() <= 2, "{x} {y}");
    mill.say(b"G91 G1 X-50 Y-25 F3000\n");
    mill.pass(600);
    mill.say(b"\x18");
    mill.rest();
    assert!(mill.said.contains("Grbl 1.1h"), "{}", mill.said);
    let [x, y, _] = mill.agree();
    assert!((x - 2 * y).abs() <= 3, "{x} {y}");
    assert!(mill.report().starts_with("<Idle|"));
}

/// A move right behind a stop waits until the board has come to the end of the run before.
#[test]
fn a_run_that_waits_for_the_one_before_loses_no_step() {
    let mut queues = Queues::default();
    let mut mill = Mill::new(&mut queues);
    let stops = ["M3 S100", "M5", "G4 P0.01", "G4 P0.1", "M8"];
    for (n, stop) in stops.iter().enumerate() {
        mill.say(format!("G1 X5 F3000\n{stop}\nG1 X0.2 Y3\n").as_bytes());
        mill.rest();
        assert_eq!(mill.agree(), [16, 240, 0], "{stop}");
        // A hold and an override of the second run, soon after its beginning.
        for millis in [40, 120, 250] {
            mill.say(format!("G1 X{}\n{stop}\nG4 P0.01\nG1 X60\n", n + 1).as_bytes());
            let over = mill.states.len();
            let mut turns = 0;
            while mill.states.len() == over || mill.run.is_none() {
                mill.turn();
                turns += 1;
                assert!(turns < 5_000, "{stop}, {millis} ms: {}", mill.report());
            }
            mill.pass(millis);
            mill.say(b"!\x91");
            mill.pass(400);
            mill.say(b"~\x90");
            mill.rest();
            assert_eq!(mill.agree(), [4_800, 240, 0], "{stop}, {millis} ms");
            mill.say(b"G0 X0.2\n");
            mill.rest();
        }
    }
}

/// Lines that wait for others to become an arc are made like those that do not, also behind a cut, and with a
/// sender that says a few at a time.
#[test]
fn chords_within_a_tolerance_end_exactly() {
    let chord = |n: u32| {
        let (y, x) = (std::f64::consts::TAU * f64::from(n) / 628.0).sin_cos();
        format!("X{:.2}Y{:.2}\n", 10.0 * x - 10.0, 10.0 * y)
    };
    let chords: Vec<String> = (1..=628).map(chord).collect();
    for (few, pause) in [(628, 0), (40, 70), (7, 13), (1, 3)] {
        for held in [150, 430, 800] {
            let mut queues = Queues::default();
            let mut mill = Mill::new(&mut queues);
            mill.say(b"G64P0.02G1F3000\n");
            let mut millis = 0;
            for lines in chords.chunks(few) {
                lines.iter().for_each(|line| mill.say(line.as_bytes()));
                mill.pass(pause);
                millis += pause;
                if (held..held + pause).contains(&millis) {
                    mill.say(b"!\x91");
                    mill.pass(400);
                    mill.say(b"~\x90");
                }
            }
            if pause == 0 {
                mill.pass(held);
                mill.say(b"!\x91");
                mill.pass(400);
                mill.say(b"~\x90");
            }
            mill.rest();
            assert_eq!(mill.agree(), [0; 3], "{few} lines each {pause} ms, held at {held} ms");
            // Four times 800 steps of each axis, up and down.
            let edges = mill.board.recorder().len();
            assert!((12_600..14_500).contains(&edges), "{edges}");
        }
    }
}
