//! A sender's controller on a board that is fed, in simulated time: hold, resume, override, jog, reset,
//! judged by the board's steps.

use std::collections::VecDeque;

use crate::common::*;
use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_grbl::{FedRun, Grbl, VirtualMill};
use stepwright_sim::{Description, Queues, StreamBoard};

use crate::laser::Watch;

/// The machine, and what the command does for it.
struct Mill<'q> {
    grbl: Grbl<VirtualMill>,
    board: StreamBoard<'q, Watch>,
    /// And when it began, in cycles.
    run: Option<(FedRun, u64)>,
    now: f64,
    said: String,
    states: Vec<FeedState>,
    /// Bytes on their way to the board, and how many come in a ms.
    wire: VecDeque<u8>,
    pace: usize,
    /// Bytes on their way back, each with the cycle in which it comes, and their delay in ms.
    back: VecDeque<(u64, u8)>,
    lag: u64,
}

impl<'q> Mill<'q> {
    fn new(queues: &'q mut Queues) -> Mill<'q> {
        let settings =
            b"$100=80\n$101=80\n$102=80\n$110=6000\n$111=6000\n$120=500\n$121=500\n$122=500\nG21\n";
        Mill::with(queues, settings)
    }

    fn with(queues: &'q mut Queues, settings: &[u8]) -> Mill<'q> {
        let grbl = Grbl::new(VirtualMill::default()).fed(true);
        let board = StreamBoard::new(queues, Description::uno(), Watch::default());
        let (said, states) = (String::new(), vec![]);
        let mut mill = Mill {
            grbl,
            board,
            run: None,
            now: 0.0,
            said,
            states,
            wire: VecDeque::new(),
            pace: usize::MAX,
            back: VecDeque::new(),
            lag: 0,
        };
        mill.say(settings);
        mill
    }

    fn say(&mut self, bytes: &[u8]) {
        self.grbl.receive(self.now, bytes);
    }

    /// A millisecond.
    fn turn(&mut self) {
        self.board.run_until(self.board.now() + MILLIS);
        let time = self.board.now();
        let fresh = self.board.take_answers();
        self.back.extend(fresh.into_iter().map(|byte| (time + self.lag * MILLIS, byte)));
        let mut heard = vec![];
        while self.back.front().is_some_and(|(at, _)| *at <= time) {
            heard.extend(self.back.pop_front().map(|(_, byte)| byte));
        }
        match &mut self.run {
            None if self.grbl.has_run() => {
                let terms = FeedTerms {
                    ahead: 500_000,
                    laser: true,
                    ..terms([0, 1, 2].map(|n| {
                        self.grbl.settings().get(120 + n) * self.grbl.settings().get(100 + n)
                    }))
                };
                let run = FedRun::begin(&self.grbl, self.now, StreamFeeder::new(terms, 0));
                self.run = run.map(|run| (run, time));
            }
            None => self.now += 1e-3,
            Some((run, begun)) => {
                let bytes = run.turn(&mut self.grbl, &heard, (time - *begun) / 16);
                self.now = run.now();
                self.wire.extend(bytes);
                if run.state().is_end() {
                    self.states.push(run.state());
                    self.run = None;
                }
            }
        }
        let some = self.wire.len().min(self.pace);
        let bytes: Vec<u8> = self.wire.drain(..some).collect();
        self.board.receive(&bytes);
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
    let edges = mill.board.recorder().edges.len();
    mill.pass(400);
    assert_eq!(
        (mill.report()[..18].to_owned(), mill.board.recorder().edges.len()),
        (held[..18].to_owned(), edges)
    );
    mill.say(b"\x91~");
    mill.pass(70);
    assert!(mill.board.recorder().edges.len() > edges + 20, "it goes on");
    mill.rest();
    assert_eq!(mill.agree(), [0; 3]);
    // A dwell, and a run that begins where the last one has ended facing backward.
    mill.say(b"G1 X5 F1000\nG4 P0.1\nG1 X2.5\nX10\n");
    mill.rest();
    assert_eq!(mill.agree(), [800, 0, 0]);
    assert!(mill.report().starts_with("<Idle|MPos:10.000,0.000,0.000"));
}

/// Until the board has begun, a stop keeps it from beginning; a held run begins when it is resumed.
#[test]
fn a_stop_before_the_run_begins_moves_nothing() {
    let (mut filling, mut most) = (0, 0);
    for (stop, line) in [
        (0x18, "G91G1X40F4000"),
        (b'!', "G91G1X40F4000"),
        (0x84, "G64P0.1G91G1X40F4000"),
        (0x85, "$J=G91X40F4000"),
    ] {
        for millis in (0..130).step_by(7) {
            let mut queues = Queues::default();
            let mut mill = Mill::new(&mut queues);
            mill.say(format!("{line}\n").as_bytes());
            mill.pass(millis);
            let runs = mill.run.as_ref().map(|(run, _)| run.state()) == Some(FeedState::Running);
            filling += u32::from(!runs);
            mill.say(&[stop]);
            mill.pass(500);
            let made = mill.grbl.position()[0];
            let told = format!("{stop:x} after {millis} ms: {made} steps, {}", mill.report());
            assert!(
                runs || made == 0 && steps_of(&mill.board.recorder().edges, 0).is_empty(),
                "{told}"
            );
            most = most.max(made);
            if stop == b'!' || stop == 0x84 {
                assert!(told.contains("<Hold:0|") || told.contains("<Door:0|"), "{told}");
                mill.say(b"\x91~");
                mill.rest();
                assert_eq!(mill.agree(), [3_200, 0, 0], "{told}");
            } else {
                mill.rest();
                assert_eq!(mill.agree(), [made, 0, 0], "{told}");
                mill.say(b"G91G1Y1F3000\n");
                mill.rest();
                assert_eq!(mill.agree(), [made, 80, 0], "{told}");
            }
        }
    }
    assert!(filling >= 40 && (1..250).contains(&most), "{filling} {most}");
}

/// A reset drops lines that were told while the plan was ahead, and those that wait to become an arc.
#[test]
fn a_reset_drops_what_is_planned_ahead() {
    for tolerance in ["G61", "G64P0.02"] {
        for millis in [60, 110, 180, 260, 400] {
            let mut queues = Queues::default();
            let mut mill = Mill::new(&mut queues);
            mill.say(format!("{tolerance}G91G1F3000\n").as_bytes());
            for n in 0..millis / 5 {
                mill.say(format!("X0.5Y0.0{}\n", n % 3).as_bytes());
                mill.pass(5);
            }
            let before = mill.grbl.position()[0];
            mill.say(b"\x18");
            mill.rest();
            let [x, ..] = mill.agree();
            // At 50 mm/s some 45 ms, and 2.5 mm of braking.
            let way = x - before;
            assert!((0..400).contains(&way), "{tolerance}, {millis} ms: {way}");
            assert!(mill.report().starts_with("<Idle|"));
        }
    }
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
            let edges = mill.board.recorder().edges.len();
            assert!((12_600..14_500).contains(&edges), "{edges}");
        }
    }
}

/// By the board's steps and its laser alone: M3 constant along its lines, M4 by the speed, nothing on a rapid
/// and at rest, wherever the job is held, with another speed behind it.
#[test]
fn the_laser_follows_the_steps() {
    for held in [0, 220, 450, 700, 1_100, 1_400] {
        let mut queues = Queues::default();
        let mut mill = Mill::new(&mut queues);
        mill.say(b"$32=1\n$30=1000\n");
        mill.say(b"M3 S500\nG1 X20 F3000\nG0 X40\nM4 S800\nG1 X60\nS400 X40\n");
        // From the opened door on, within some ms, until the resume.
        let (mut soon, mut dark) = (0..0, 0..0);
        if held > 0 {
            mill.pass(held);
            let door = held < 500;
            mill.say(if door { b"\x84" } else { b"!" });
            let asked = mill.board.now();
            mill.pass(60);
            let begin = mill.board.now();
            soon = asked..if door { begin } else { asked };
            mill.pass(440);
            dark = begin..if door { mill.board.now() } else { begin };
            mill.say(b"\x92\x92~");
        }
        mill.rest();
        assert_eq!(mill.agree(), [3_200, 0, 0]);
        let Watch { edges, powers } = std::mem::take(mill.board.recorder());
        let steps = steps_of(&edges, 0);
        let power = |time: u64| {
            let n = powers.partition_point(|change| change.0 <= time);
            n.checked_sub(1).map_or(0, |n| powers[n].1)
        };
        let (mut x, mut seen, mut doors) = (0, [0; 4], 0);
        for (n, pair) in steps.windows(2).enumerate() {
            x += if pair[0].1 { 1 } else { -1 };
            let apart = (pair[1].0 - pair[0].0) as f64 / HZ;
            let here = power((pair[0].0 + pair[1].0) / 2);
            if apart > 0.05 || dark.contains(&pair[0].0) {
                doors += usize::from(apart < 0.05);
                assert_eq!(here, 0, "dark at {x}, held after {held} ms");
                continue;
            }
            let speed = 1.0 / apart / 80.0;
            let back = n > 80 * 58 && !pair[0].1;
            // Not where lines meet, or where the speed changes within a step or two.
            let (part, wanted) = match x {
                _ if soon.contains(&pair[0].0) => continue,
                4..1_596 => (0, 127.5),
                1_604..3_196 if !back => (1, 0.0),
                3_204..4_790 if !back => (2, 255.0 * 0.8 * speed / 50.0),
                3_204..4_790 => (3, 255.0 * 0.4 * speed / 50.0),
                _ => continue,
            };
            seen[part] += 1;
            // The speed jumps by `$140`, 100 mm/min, and changes by 500 mm/s² besides; a record comes half a ms
            // late.
            let near = 255.0 * 0.8 / 50.0 * (100.0 / 60.0 + 500.0 * (apart + 0.6e-3)) + 1.0;
            let near = if part < 2 { 1.0 } else { near };
            assert!(
                (f64::from(here) - wanted).abs() <= near,
                "{here}, not {wanted} at {x}, {speed} mm/s, held after {held} ms"
            );
        }
        assert_eq!(doors > 50, (1..500).contains(&held), "{doors}");
        assert!(seen.iter().all(|seen| *seen > 1_200), "{seen:?}");
        assert_eq!(powers.last().unwrap().1, 0);
    }
}

/// A hold soon behind the beginning of a run, on a line of 115,200 baud whose answers come late: the board's time
/// is known late, and an axis that rests has its next record soon.
#[test]
fn an_early_hold_stays_on_the_path() {
    let lines = ["G1 X2 Y9 Z1.7 F1000\n", "G1 X2.076 Y9.068 Z-1.748 F1265\n", "G1 X10 F1000\n"];
    for (n, line) in lines.into_iter().enumerate() {
        for millis in (20..250).step_by(3) {
            let mut queues = Queues::default();
            let mut mill = Mill::with(&mut queues, b"");
            (mill.pace, mill.lag) = (11, (u64::from(millis) + n as u64) % 9);
            mill.say(line.as_bytes());
            mill.pass(millis);
            mill.say(b"!");
            mill.pass(400);
            let kept = mill.states.iter().all(|state| *state == FeedState::Over);
            assert!(kept, "{line} {millis} ms, {} ms late", mill.lag);
        }
    }
}
