//! Streams on the simulated chip, with its receiver of three bytes: edges compared with the virtual
//! board's, and with the requested times.

use std::collections::VecDeque;
use std::io::{PipeReader, Read, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::common;
use crate::feed::guards;
use crate::feed::instants::{Befalls, Guarded, KINDS, Outcome, Random, befall, instant, motion};
use crate::feed::judge::judge;
use crate::feed::wire::Wire;
use crate::feed::{
    self, Job, Line, MILLIS, Step, Target, Told, position_of, run, s_curve, steps_of, terms,
};
use nix::sys::wait::waitpid;
use nix::unistd::{ForkResult, Pid, fork};
use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_rig::edges::{Needs, check};
use stepwright_rig::{Board, Chip};
use stepwright_sim::{Edge, Queues};

/// A chip with the program, whose time begins when it has started.
pub struct Awake {
    pub chip: Chip,
    begun: u64,
}

impl Awake {
    pub fn new() -> Awake {
        let mut chip = common::program("stream");
        chip.clear_longest_off();
        let begun = chip.now();
        Awake { chip, begun }
    }

    /// `late` and the positions that the chip reports.
    fn tells(&mut self) -> (u32, [i64; 3]) {
        self.chip.send(&[0xFF; 4]);
        self.chip.ask("");
        let about = self.chip.ask("?").expect("about");
        let late = about.split("late=").nth(1).and_then(|rest| rest.split(' ').next());
        let at = [1, 2, 3].map(|axis| self.chip.ask(&format!("V{axis}")).unwrap().parse().unwrap());
        (late.unwrap().parse().unwrap(), at)
    }
}

impl Target for Awake {
    fn run_until(&mut self, cycle: u64) {
        self.chip.run_until(self.begun + cycle);
    }
    fn receive(&mut self, byte: u8) {
        self.chip.send(&[byte]);
    }
    fn said(&mut self) -> Vec<u8> {
        self.chip.take_said()
    }
    fn edges(&mut self) -> &[Edge] {
        self.chip.edges()
    }
}

impl Guarded for Awake {
    fn now(&self) -> u64 {
        self.chip.now()
    }
    fn begun(&self) -> u64 {
        self.begun
    }
    fn close(&mut self, input: u8, closed: bool) {
        match input {
            0..=2 => self.chip.press(input.into(), closed),
            _ => {
                let [emergency, fault] = self.chip.board().stoppers();
                self.chip.pull(if input == 7 { emergency } else { fault }, closed);
            }
        }
    }
}

/// Runs a job on the chip. Returns the result, late steps, and edges.
fn on_chip(job: &[Vec<Step>; 3], terms: FeedTerms, line: Line) -> (Told, u32, Vec<Edge>) {
    let mut chip = Awake::new();
    chip.chip.watch_stack();
    let told = run(&mut chip, Job::new(job.clone()), terms, line);
    println!("{:?}, {} again, {} bytes", told.state, told.again, told.bytes);
    chip.chip.run_to_silence(10_000_000, 500_000_000);
    let (late, positions) = chip.tells();
    let edges = chip.chip.edges().to_vec();
    for axis in 0..3u8 {
        let at = position_of(&steps_of(&edges, axis));
        assert_eq!(positions[usize::from(axis)], at, "axis {axis}: the chip's, and the edges'");
    }
    assert_eq!(chip.chip.lost(), 0, "bytes");
    let (off, at) = chip.chip.longest_off();
    println!(
        "stack to spare: {} bytes; {off} cycles without interrupts before {at:#x}",
        chip.chip.spare()
    );
    assert!(chip.chip.spare() > 0);
    (told, late, edges)
}

/// The largest distance of an edge from the virtual board's, in µs; and the number of edges farther
/// than `bound`.
fn apart(edges: &[Edge], job: &[Vec<Step>; 3], terms: FeedTerms, bound: f64) -> (f64, usize) {
    let mut queues = Queues::default();
    let mut board = feed::board(&mut queues);
    run(&mut board, Job::new(job.clone()), terms, Line::default());
    let apart = feed::apart(edges, board.recorder());
    let beyond = apart.iter().filter(|value| value.abs() > bound).count();
    (apart[apart.len() - 1].max(-apart[0]), beyond)
}

fn organic(seconds: f64) -> [Vec<Step>; 3] {
    let waves = [(400.0, 1.0), (150.0, 3.1), (30.0, 9.7)];
    [0.0, 1.9, 0.4]
        .map(|phase| feed::wander(seconds, &waves[..if phase == 0.4 { 1 } else { 3 }], phase))
}

fn three(speed: f64) -> [Vec<Step>; 3] {
    [0.0, 0.0, 0.0].map(|more| s_curve(60_000, speed * (1.0 + more), 40_000.0, 400_000.0))
}

/// Three equal axes with limited jerk, while `?` is sent back to back.
#[test]
fn three_axes_at_38_000_steps_a_second() {
    let job = three(38_000.0);
    let line = Line { polls: true, ..Line::default() };
    let (told, late, edges) = on_chip(&job, terms([40_000.0; 3]), line);
    let (worst, beyond) = apart(&edges, &job, terms([40_000.0; 3]), 7.0);
    println!("late {late}, {} answers, worst {worst:.2} us, beyond 7 us: {beyond}", told.answers);
    assert_eq!((told.state, told.again), (FeedState::Over, 0));
    assert!(told.answers > 20);
    // One in 100,000, of 180,000.
    assert!(late <= 1, "{late} late");
}

/// The late steps of one axis at this speed, and the largest distance of a step from the virtual
/// board's, in µs.
fn one_axis(speed: f64) -> (u32, f64) {
    let job = [s_curve(330_000, speed, 400_000.0, 4_000_000.0), vec![], vec![]];
    let (told, late, edges) = on_chip(&job, terms([400_000.0; 3]), Line::default());
    let (worst, _) = apart(&edges, &job, terms([400_000.0; 3]), 7.0);
    println!("late {late}, worst {worst:.2} us");
    assert_eq!((told.state, told.again), (FeedState::Over, 0));
    (late, worst)
}

/// At the limit of its interrupt: a step each 80 cycles, of which the interrupt takes 70, and a few
/// more on a Mega.
#[test]
fn one_axis_at_200_000_steps_a_second() {
    let speed = if common::board() == Board::Uno { 200_000.0 } else { 196_000.0 };
    let (late, worst) = one_axis(speed);
    assert!(late == 0 && worst < 5.0);
}

/// One step in 100,000 may be late there, when an interrupt's entry and a byte coincide: depending
/// on the build none, 1 or 2 of these are. The schedule slips by less than two intervals each time.
#[test]
fn a_mega_near_200_000_steps_a_second() {
    for speed in [198_000.0, 199_000.0, 200_000.0] {
        let (late, worst) = one_axis(speed);
        assert!(late <= 3 && worst < 5.0 + 10.0 * f64::from(late));
    }
}

/// A motion that turns all the time.
#[test]
fn a_motion_that_wanders() {
    let job = organic(3.0);
    let line = Line { polls: true, ..Line::default() };
    let (told, late, edges) = on_chip(&job, terms([40_000.0; 3]), line);
    let (worst, beyond) = apart(&edges, &job, terms([40_000.0; 3]), 7.0);
    println!("late {late}, worst {worst:.2} us, beyond 7 us: {beyond} of {}", edges.len() / 2);
    assert_eq!((told.state, told.again, late), (FeedState::Over, 0, 0));
}

/// The Mega's FIFO holds more than a second, with each step within 5 µs.
#[test]
fn a_mega_rides_through_a_second() {
    if common::board() == Board::Uno {
        return;
    }
    let job = organic(5.0);
    let sleeps = vec![(1_500 * MILLIS, 1_000 * MILLIS), (3_300 * MILLIS, 1_000 * MILLIS)];
    let terms = FeedTerms { ahead: 1_400_000, lease: 2_000, ..terms([40_000.0; 3]) };
    let (told, late, edges) = on_chip(&job, terms, Line { sleeps, ..Line::default() });
    let (worst, _) = feed::worst(&edges, &job, 75.0, 0.0);
    println!("late {late}, worst {worst:.2} us");
    assert_eq!((told.state, told.again, late), (FeedState::Over, 0, 0));
    assert!(worst < 5.0 + 15.0, "{worst}");
}

/// After a silence longer than the planned time ahead the board brakes, and the position agrees
/// with the edges.
#[test]
fn a_longer_stall_brakes() {
    let job = organic(7.0);
    let decels = [30_000.0, 20_000.0, 10_000.0];
    let sleeps = vec![(800 * MILLIS, 4_000 * MILLIS)];
    let line = Line { sleeps, ..Line::default() };
    let (told, _, edges) = on_chip(&job, terms(decels), line);
    assert_eq!(told.state, FeedState::Off);
    for axis in 0..3u8 {
        let n = usize::from(axis);
        judge(&steps_of(&edges, axis), &job[n], decels[n]).unwrap();
    }
}

#[test]
fn spoilt_bytes_and_stalls_lose_no_step() {
    let [x, y, _] = organic(3.0);
    let job = [x, y, vec![]];
    for (spoils, sleeps) in [
        (100, vec![]),
        (0, (0..3).map(|n| (500 * MILLIS + n * 700 * MILLIS, 200 * MILLIS)).collect()),
    ] {
        let line = Line { spoils, sleeps, seed: 3, ..Line::default() };
        let (told, late, edges) = on_chip(&job, terms([40_000.0; 3]), line);
        assert_eq!((told.state, late), (FeedState::Over, 0), "{} again", told.again);
        let (worst, _) = feed::worst(&edges, &job, 75.0, 0.0);
        println!("{} again, late {late}, worst {worst:.2} us", told.again);
        assert!(worst < 25.0 + 15.0);
    }
}

/// The instants that are judged at the same time.
const JUDGES: usize = 2;
/// The instants of a run.
const OF_A_RUN: u64 = 20;

/// The result of an instant, from another process.
struct Report(PipeReader, Pid);

impl Report {
    /// Continues in another process, with the chip in its present state. So a run continues for all
    /// of its instants, and is simulated only once.
    fn fork(judge: impl FnOnce() -> String) -> Report {
        let (reader, mut writer) = std::io::pipe().unwrap();
        // SAFETY: the child has the memory of this thread, writes to its pipe and ends; it prints
        // nothing.
        match unsafe { fork() }.unwrap() {
            ForkResult::Parent { child } => Report(reader, child),
            ForkResult::Child => {
                let told = catch_unwind(AssertUnwindSafe(judge));
                let _ = writer.write_all(told.unwrap_or("it panics".into()).as_bytes());
                // SAFETY: nothing else is left to do.
                unsafe { nix::libc::_exit(0) }
            }
        }
    }

    fn wait(mut self) -> String {
        let mut told = String::new();
        self.0.read_to_string(&mut told).unwrap();
        waitpid(self.1, None).unwrap();
        told
    }
}

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |value| value.parse().expect(name))
}

/// A host falls silent at random instants of runs of all speeds. 1,000 and more of them by `cargo
/// xtask silence`.
#[test]
fn silence_at_any_instant_brakes_every_axis() {
    let instants = number("STEPWRIGHT_INSTANTS", 16);
    silent(instants, OF_A_RUN.min(instants / KINDS).max(1), number("STEPWRIGHT_SEED", 1));
}

/// One axis that brakes at 193,000 steps/s: the end of a group and a byte coincided, the step was
/// later than its interval, and 160 steps after it came 102 cycles apart, which is 19 % slower.
#[test]
fn a_late_step_at_the_top_slows_no_axis_down() {
    silent(OF_A_RUN, OF_A_RUN, 30_017);
}

/// This many instants, `each` of them in one run.
fn silent(instants: u64, each: u64, seed: u64) {
    let (mut told, mut made, mut n) = (Vec::new(), 0, 0);
    while made < instants {
        let mut random = Random::new(seed + n);
        let mut motion = motion(seed + n, &mut random);
        motion.lease = [0, 200, 1_000][random.below(3) as usize];
        let mut times: Vec<u64> = (0..each).map(|_| instant(&motion, &mut random)).collect();
        times.sort_unstable();
        let mut chip = Awake::new();
        let mut wire = Wire::new(Job::new(motion.path.clone()), motion.terms(), 0);
        let mut reports = VecDeque::new();
        for at in times.into_iter().take((instants - made) as usize) {
            wire.feed(&mut chip, at);
            let mut random = Random::new(random.any());
            let befalls = Befalls::any(&mut random);
            reports.push_back(Report::fork(|| {
                let came = befall(&mut chip, &mut wire, &motion, befalls, &mut random);
                let came = came.and_then(|outcome| {
                    check(chip.chip.edges(), Needs::DEFAULT)?;
                    Ok(outcome)
                });
                match came {
                    Ok(Outcome { off, axes, .. }) => {
                        let most = axes.iter().map(|axis| axis.steepest).fold(0.0, f64::max);
                        format!("ok {} {most}", u8::from(off))
                    }
                    Err(why) => format!(
                        "seed {}, {}, at {} ms, {befalls:?}, lease {}: {why}",
                        seed + n,
                        motion.name,
                        at / MILLIS,
                        motion.lease
                    ),
                }
            }));
            made += 1;
            if reports.len() >= JUDGES {
                told.extend(reports.pop_front().map(Report::wait));
            }
        }
        told.extend(reports.into_iter().map(Report::wait));
        n += 1;
    }
    let (mut off, mut most, mut wrong) = (0, 0.0f64, vec![]);
    for told in told {
        match told.strip_prefix("ok ").and_then(|told| told.split_once(' ')) {
            Some((left, part)) => {
                off += u64::from(left == "1");
                most = most.max(part.parse().unwrap());
            }
            None => wrong.push(told),
        }
    }
    println!(
        "{made} instants of {n} runs, {off} off the path, at most {most:.3} of a deceleration"
    );
    assert!(wrong.is_empty(), "{} of {made}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(off > made / 2, "{off} of {made}");
}

#[test]
fn an_input_brakes_all_axes() {
    guards::an_input_brakes_all_axes(&mut Awake::new());
    guards::an_input_that_opens_brakes_all_axes(&mut Awake::new());
}

#[test]
fn z_brakes_and_k_stops() {
    guards::z_brakes_and_f_tells(&mut Awake::new());
    guards::k_stops_at_once(&mut Awake::new());
    guards::what_was_not_started_is_forgotten(&mut Awake::new());
    guards::a_count_of_nothing_moves_nothing(&mut Awake::new());
}

#[test]
fn a_lease_counts_until_the_end() {
    guards::a_lease_counts_until_the_end(&mut Awake::new());
}
