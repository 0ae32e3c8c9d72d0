//! Streamed runs on the simulated chip, with its receiver of three bytes: edges against the virtual
//! board's, and against the times that were asked for.

#[path = "../../../crates/stepwright-feeder/tests/common/mod.rs"]
mod feed;

mod common;

use feed::{HZ, Job, Line, MILLIS, Step, Target, Told, position_of, run, s_curve, steps_of, terms};
use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_rig::Chip;
use stepwright_sim::{Edge, Queues};

/// A chip with the program in it, whose time begins when it has woken.
struct Awake {
    chip: Chip,
    begun: u64,
}

impl Awake {
    fn new() -> Awake {
        let mut chip = common::program("stream");
        chip.watch_stack();
        chip.clear_longest_off();
        let begun = chip.now();
        Awake { chip, begun }
    }

    /// `late` and the positions, as the chip tells.
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

/// On the chip: what came of it, late steps, edges.
fn on_chip(job: &[Vec<Step>; 3], terms: FeedTerms, line: Line) -> (Told, u32, Vec<Edge>) {
    let mut chip = Awake::new();
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

/// The largest distance of an edge from the virtual board's, in µs; and edges farther than `bound`.
fn apart(edges: &[Edge], job: &[Vec<Step>; 3], terms: FeedTerms, bound: f64) -> (f64, usize) {
    let mut queues = Queues::default();
    let mut board = feed::board(&mut queues);
    run(&mut board, Job::new(job.clone()), terms, Line::default());
    let mut apart = Vec::new();
    for axis in 0..3u8 {
        let (made, wanted) = (steps_of(edges, axis), steps_of(board.recorder(), axis));
        assert_eq!(made.len(), wanted.len());
        for (made, wanted) in made.iter().zip(&wanted) {
            assert_eq!(made.1, wanted.1);
            apart.push((made.0 as f64 - wanted.0 as f64) / 16.0);
        }
    }
    apart.sort_by(f64::total_cmp);
    let middle = apart[apart.len() / 2];
    let beyond = apart.iter().filter(|value| (*value - middle).abs() > bound).count();
    ((apart[apart.len() - 1] - middle).max(middle - apart[0]), beyond)
}

fn organic(seconds: f64) -> [Vec<Step>; 3] {
    let waves = [(400.0, 1.0), (150.0, 3.1), (30.0, 9.7)];
    [0.0, 1.9, 0.4]
        .map(|phase| feed::wander(seconds, &waves[..if phase == 0.4 { 1 } else { 3 }], phase))
}

fn three(speed: f64) -> [Vec<Step>; 3] {
    [0.0, 0.0, 0.0].map(|more| s_curve(60_000, speed * (1.0 + more), 40_000.0, 400_000.0))
}

/// Three equal axes with limited jerk, while `?` is asked back to back.
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

/// One axis as fast as its interrupt goes.
#[test]
fn one_axis_at_200_000_steps_a_second() {
    let job = [s_curve(330_000, 200_000.0, 400_000.0, 4_000_000.0), vec![], vec![]];
    let (told, late, edges) = on_chip(&job, terms([400_000.0; 3]), Line::default());
    let (worst, _) = apart(&edges, &job, terms([400_000.0; 3]), 7.0);
    println!("late {late}, worst {worst:.2} us");
    assert_eq!((told.state, told.again, late), (FeedState::Over, 0, 0));
    assert!(worst < 5.0);
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

/// At random instants: the position is that of the edges, and no axis is stopped harder than ordered.
#[test]
fn silence_brakes_every_axis() {
    let slow = s_curve(150, 60.0, 300.0, 3_000.0);
    let jobs = [
        (organic(2.0), [8_000.0, 30_000.0, 5_000.0]),
        (three(30_000.0), [40_000.0, 30_000.0, 20_000.0]),
        ([slow.clone(), vec![], slow], [300.0, 300.0, 400.0]),
    ];
    let moments = std::env::var("STEPWRIGHT_MOMENTS").map_or(2, |count| count.parse().unwrap());
    for (n, (job, decels)) in (0u64..).zip(&jobs) {
        for k in 0..moments {
            let dead = (331 + 777 * (k + n)) % 1_500 * MILLIS;
            let line = Line { dead, ..Line::default() };
            let (told, _, edges) = on_chip(job, terms(*decels), line);
            let last = edges.iter().map(|edge| edge.time).max().unwrap();
            assert!(last > told.begun + dead, "it stops before the silence");
            for axis in 0..3u8 {
                let (steps, wanted) = (steps_of(&edges, axis), &job[usize::from(axis)]);
                let off = steps.iter().zip(wanted).position(|(made, wanted)| {
                    let since = (wanted.0 - job[usize::from(axis)][0].0) * HZ;
                    ((made.0 - steps[0].0) as f64 - since).abs() > 800.0
                });
                let Some(off) = off.filter(|off| *off > 0) else { continue };
                let steepest = feed::steepest(&steps, steps[off - 1].0);
                let decel = decels[usize::from(axis)];
                assert!(steepest < decel * 1.05, "axis {axis}: {steepest} of {decel}");
            }
        }
    }
}
