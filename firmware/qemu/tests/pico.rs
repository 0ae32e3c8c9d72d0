//! Streams on a Pico, whose PIO makes the steps, in rp2040js: `firmware/rp2040/test/stream.cjs`.
//! Run by `cargo xtask test --only pico`, which passes the path of that script in
//! `STEPWRIGHT_PICO`.

#[path = "../../../crates/stepwright-feeder/tests/common/mod.rs"]
mod feed;
mod streamed;

use std::env;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use feed::instants::{Befalls, Guarded, Random, ask, befall, instant, motion};
use feed::judge::judge;
use feed::pulses::Pulses;
use feed::wire::{Heard, Wire};
use feed::{HZ, Job, Line, MILLIS, Step, Target, Told, position_of, run, s_curve, steps_of};
use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_rp2040::board::{EMERGENCY, FAULT, STREAM, STREAM_BOARD, SWITCHES};
use stepwright_sim::{Description, Edge, Pin};
use stepwright_stream::brake::BrakeLaw;
use streamed::{apart, organic, terms};

/// The time when it has started, in 2⁻⁴ µs.
const AWAKE: u64 = 20 * MILLIS;
/// The pins of the inputs, by their bits: three switches, a driver's fault, the emergency stop.
const INPUTS: [u32; 8] = [SWITCHES[0], SWITCHES[1], SWITCHES[2], 0, 0, 0, FAULT, EMERGENCY];

struct Pico {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    now: u64,
    said: Vec<u8>,
    edges: Vec<Edge>,
    /// The changes of the laser's pin.
    pulses: Vec<(u64, bool)>,
}

impl Pico {
    fn new() -> Pico {
        let script = env::var("STEPWRIGHT_PICO").expect("STEPWRIGHT_PICO: the script");
        let folder = env::var("STEPWRIGHT_FIRMWARE").expect("STEPWRIGHT_FIRMWARE: the programs");
        let mut node = Command::new("node");
        node.arg(script).arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = node.spawn().expect("node");
        let (to, from) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let from = BufReader::new(from);
        // DIR is low until it is set.
        let low = |axis| Edge { time: 0, axis, pin: Pin::Direction, level: false };
        let edges = (0..3).map(low).collect();
        let mut pico =
            Pico { child, to, from, now: 0, said: Vec::new(), edges, pulses: Vec::new() };
        pico.run_until(0);
        pico
    }

    /// `late` and the positions that the board reports.
    fn tells(&mut self, wire: &mut Wire) -> (u32, [i64; 3]) {
        let mut heard = Heard::default();
        let about = ask(self, wire, &mut heard, "?").expect("about");
        let late = about.split("late=").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
        let place =
            |axis| ask(self, wire, &mut heard, &format!("V{axis}")).unwrap().parse().unwrap();
        (late.parse().unwrap(), [1, 2, 3].map(place))
    }
}

impl Drop for Pico {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Target for Pico {
    fn run_until(&mut self, cycle: u64) {
        self.now = self.now.max(AWAKE + cycle);
        writeln!(self.to, "u {}", self.now).unwrap();
        let mut line = String::new();
        self.from.read_line(&mut line).unwrap();
        let mut parts = line.trim_end().split('|');
        let [said, edges, pulses] = [(); 3].map(|()| parts.next().expect("three parts"));
        let bytes =
            (0..said.len() / 2).map(|n| u8::from_str_radix(&said[2 * n..][..2], 16).unwrap());
        self.said.extend(bytes);
        self.edges.extend(edges.split(',').filter(|edge| !edge.is_empty()).map(|edge| {
            let mut words = edge.split(' ');
            let mut word = || words.next().expect("four words");
            let (time, axis, pin) = (word().parse().unwrap(), word().parse().unwrap(), word());
            let pin = if pin == "s" { Pin::Step } else { Pin::Direction };
            Edge { time, axis, pin, level: word() == "1" }
        }));
        self.pulses.extend(pulses.split(',').filter(|change| !change.is_empty()).map(|change| {
            let (time, level) = change.split_once(' ').expect("two words");
            (time.parse().unwrap(), level == "1")
        }));
    }
    fn receive(&mut self, byte: u8) {
        writeln!(self.to, "b {byte:02x}").unwrap();
    }
    fn said(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.said)
    }
    fn edges(&mut self) -> &[Edge] {
        &self.edges
    }
}

impl Guarded for Pico {
    fn now(&self) -> u64 {
        self.now
    }
    fn begun(&self) -> u64 {
        AWAKE
    }
    fn close(&mut self, input: u8, closed: bool) {
        // With a pull-up, a closed input is low.
        writeln!(self.to, "i {} {}", INPUTS[usize::from(input)], u8::from(!closed)).unwrap();
    }
}

/// Runs a job on the board. Returns the result and the edges; late steps and the positions are
/// checked against them.
fn on_pico(job: &[Vec<Step>; 3], terms: FeedTerms, line: Line) -> (Told, Vec<Edge>) {
    let mut pico = Pico::new();
    let told = run(&mut pico, Job::new(job.clone()), terms, line);
    println!("{:?}, {} again, {} bytes", told.state, told.again, told.bytes);
    let mut wire = Wire::new(Job::new([vec![], vec![], vec![]]), terms, pico.now - AWAKE);
    let now = wire.now();
    wire.pass(&mut pico, now + 100 * MILLIS);
    let (late, positions) = pico.tells(&mut wire);
    assert_eq!(late, 0);
    let edges = pico.edges().to_vec();
    for axis in 0..3u8 {
        let at = position_of(&steps_of(&edges, axis));
        assert_eq!(positions[usize::from(axis)], at, "axis {axis}: the board's, and the pins'");
    }
    (told, edges)
}

/// A run that the board keeps up with: its edges are at most `most` µs from the virtual board's.
fn keeps_up(what: &str, job: &[Vec<Step>; 3], decel: f64, most: f64) {
    let terms = terms(STREAM, [decel; 3]);
    let (told, edges) = on_pico(job, terms, Line { polls: true, ..Line::default() });
    assert_eq!((told.state, told.again), (FeedState::Over, 0));
    let description =
        Description { board: STREAM_BOARD, ..Description::at(STREAM.rate, STREAM_BOARD.cost) };
    let axes = (0..3).filter(|axis| !job[*axis].is_empty()).map(|axis| 1 << axis).sum();
    let worst = apart(description, &edges, job, FeedTerms { axes, ..terms });
    println!("{what}: {} answers, worst {worst:.2} us", told.answers);
    assert!(worst < most, "{worst}");
}

#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn three_axes_at_50_000_steps_a_second() {
    let path = s_curve(25_000, 50_000.0, 300_000.0, 6_000_000.0);
    keeps_up("three axes", &[path.clone(), path.clone(), path], 300_000.0, 6.0);
}

#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn one_axis_at_200_000_steps_a_second() {
    let path = s_curve(100_000, 200_000.0, 1_000_000.0, 20_000_000.0);
    keeps_up("one axis", &[path, vec![], vec![]], 1_000_000.0, 6.0);
}

/// Axes that turn and rest in the middle of a run.
#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn a_motion_that_wanders() {
    keeps_up("it wanders", &organic(1.5, 1.0), 40_000.0, 12.0);
}

/// One axis after another, each from rest to rest, while the others wait.
#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn axes_that_take_turns() {
    let path = s_curve(800, 4_000.0, 50_000.0, 1_000_000.0);
    let span = path.last().unwrap().0 + 0.05;
    let part =
        |n: u32, forward| path.iter().map(move |step| (step.0 + f64::from(n) * span, forward));
    let job = [
        part(0, true).chain(part(3, false)).collect(),
        part(1, false).chain(part(4, true)).collect(),
        part(2, true).collect(),
    ];
    keeps_up("in turns", &job, 50_000.0, 6.0);
}

#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn spoilt_bytes_lose_no_step() {
    let [x, y, _] = organic(1.0, 1.0);
    let job = [x, y, vec![]];
    let line = Line { spoils: 100, seed: 3, ..Line::default() };
    let (told, edges) = on_pico(&job, terms(STREAM, [40_000.0; 3]), line);
    assert_eq!(told.state, FeedState::Over);
    assert!(told.again > 5, "nothing was spoilt");
    for axis in 0..3u8 {
        assert_eq!(steps_of(&edges, axis).len(), job[usize::from(axis)].len());
    }
}

/// A host that sleeps for longer than the planned time ahead.
#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn a_long_stall_brakes() {
    let job = organic(2.0, 1.0);
    let decels = [30_000.0, 20_000.0, 10_000.0];
    let sleeps = vec![(500 * MILLIS, 2_000 * MILLIS)];
    let (told, edges) = on_pico(&job, terms(STREAM, decels), Line { sleeps, ..Line::default() });
    assert_eq!(told.state, FeedState::Off);
    for (n, axis) in (0..3u8).enumerate() {
        judge(&steps_of(&edges, axis), &job[n], decels[n]).unwrap();
    }
}

/// While three axes move. The laser is off at power-up, and after a host's silence.
#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn its_laser_has_the_power_at_its_time() {
    let x = s_curve(20_000, 20_000.0, 60_000.0, 600_000.0);
    let axes: [Vec<Step>; 3] = [x.clone(), x.iter().step_by(2).copied().collect(), x];
    let powers = [(0.2, 255), (0.4, 0), (0.5, 26), (0.7, 128), (0.9, 230), (1.1, 0)];
    let terms = terms(STREAM, [60_000.0; 3]);
    let mut pico = Pico::new();
    assert_eq!(pico.pulses, []);
    let job = Job::new(axes.clone()).with_laser(&powers);
    let told = run(&mut pico, job, terms, Line::default());
    assert_eq!(told.state, FeedState::Over);
    let begin = steps_of(pico.edges(), 0)[0].0 as f64 - axes[0][0].0 * HZ;
    let pulses = Pulses { changes: pico.pulses.clone(), period: 2_056 }; // 63 · 255 / 125 MHz
    pulses.check(begin, &powers, |power| f64::from(power) / 255.0);

    let (mut pico, begun) = (Pico::new(), 500 * MILLIS);
    let line = Line { sleeps: vec![(begun, 2_000 * MILLIS)], ..Line::default() };
    let told = run(&mut pico, Job::new(axes).with_laser(&[(0.1, 255)]), terms, line);
    assert_eq!(told.state, FeedState::Off);
    let [(on, true), (off, false)] = pico.pulses[..] else { panic!("{:?}", pico.pulses) };
    let last = steps_of(pico.edges(), 0).last().unwrap().0;
    // Braking from 20,000 steps/s takes 333 ms.
    assert!(on < begun + AWAKE && off + 100 * MILLIS < last, "{on} {off} {last}");
}

fn number(name: &str, otherwise: u64) -> u64 {
    env::var(name).map_or(otherwise, |value| value.parse().expect(name))
}

/// A host falls silent at random instants of runs of all speeds.
#[test]
#[ignore = "by `cargo xtask test --only pico`"]
fn silence_at_any_instant_brakes_every_axis() {
    let (instants, seed) = (number("STEPWRIGHT_INSTANTS", 4), number("STEPWRIGHT_SEED", 1));
    let (mut off, mut most, mut wrong) = (0, 0.0f64, vec![]);
    for n in seed..seed + instants {
        let mut random = Random::new(n);
        // Not slow ones, whose decelerations the brake may not support at this timer's rate.
        let mut motion = motion([0, 1, 2, 6, 5][n as usize % 5], &mut random);
        motion.lease = [0, 200, 1_000][random.below(3) as usize];
        let hz = STREAM.rate.hz();
        let brakes = motion.decels.map(|decel| BrakeLaw::of((decel * 1e3) as u64, hz).unwrap());
        let terms = FeedTerms { hz, brakes, stagger: 0, ..motion.terms() };
        let at = instant(&motion, &mut random);
        // Each input in turn.
        let befalls = match n as usize % 3 {
            0 => Befalls::Input([0, 1, 2, 6, 7][n as usize / 3 % 5]),
            _ => Befalls::any(&mut random),
        };
        let mut pico = Pico::new();
        let mut wire = Wire::new(Job::new(motion.path.clone()), terms, 0);
        wire.feed(&mut pico, at);
        match befall(&mut pico, &mut wire, &motion, befalls, &mut random) {
            Ok(told) => {
                off += u64::from(told.off);
                most = told.axes.iter().map(|axis| axis.steepest).fold(most, f64::max);
            }
            Err(why) => wrong.push(format!(
                "seed {n}, {}, {befalls:?} at {} ms, lease {}: {why}",
                motion.name,
                at / MILLIS,
                motion.lease
            )),
        }
    }
    println!("{instants} instants, {off} off the path, at most {most:.3} of a deceleration");
    assert!(wrong.is_empty(), "{} of {instants}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(off > 0);
}
