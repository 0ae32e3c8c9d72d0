//! A virtual board at the end of a serial line, and jobs for it.
#![allow(dead_code)] // the tests of simulated chips share it, and each uses its part

pub mod guards;
pub mod instants;
pub mod judge;
pub mod pulses;
pub mod wire;

use std::collections::VecDeque;

use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_sim::{Description, Edge, Queues, Recorder, StreamBoard};
use stepwright_stream::brake::BrakeLaw;

pub const HZ: f64 = 16e6;
/// Cycles of a millisecond.
pub const MILLIS: u64 = 16_000;

/// A step: seconds after the start, and forward or not.
pub type Step = (f64, bool);

/// The times of `n` steps with a symmetric S-curve: closed form, so that a judge may have it.
pub fn s_curve(n: usize, v: f64, a: f64, j: f64) -> Vec<Step> {
    let (tj, ta) = (a / j, v / a - a / j);
    assert!(ta >= 0.0);
    let up = |t: f64| {
        if t <= tj {
            j * t.powi(3) / 6.0
        } else if t <= tj + ta {
            let d = t - tj;
            j * tj.powi(3) / 6.0 + j * tj * tj * d / 2.0 + a * d * d / 2.0
        } else {
            let e = 2.0 * tj + ta - t;
            v * (2.0 * tj + ta) / 2.0 - (v * e - j * e.powi(3) / 6.0)
        }
    };
    let rise = 2.0 * tj + ta;
    let level = (n as f64 - v * rise) / v;
    assert!(level >= 0.0);
    let total = 2.0 * rise + level;
    let at = |t: f64| {
        if t < rise {
            up(t)
        } else if t < rise + level {
            v * rise / 2.0 + v * (t - rise)
        } else {
            n as f64 - up(total - t)
        }
    };
    let mut low = 0.0;
    (0..n)
        .map(|k| {
            let (mut from, mut to) = (low, total);
            for _ in 0..60 {
                let middle = (from + to) / 2.0;
                if at(middle) < k as f64 + 0.5 { from = middle } else { to = middle }
            }
            low = from;
            (from, true)
        })
        .collect()
}

/// How far each step is from where another board made it, in µs and in order, where the one in the middle is
/// on time; all turn as there.
pub fn apart(made: &[Edge], wanted: &[Edge]) -> Vec<f64> {
    let mut apart = Vec::new();
    for axis in 0..3u8 {
        let (made, wanted) = (steps_of(made, axis), steps_of(wanted, axis));
        assert_eq!(made.len(), wanted.len());
        for (made, wanted) in made.iter().zip(&wanted) {
            assert_eq!(made.1, wanted.1);
            apart.push((made.0 as f64 - wanted.0 as f64) / 16.0);
        }
    }
    apart.sort_by(f64::total_cmp);
    let middle = apart[apart.len() / 2];
    apart.iter().map(|value| value - middle).collect()
}

/// Steps of a motion that wanders: a sum of sines, in steps, sampled where it passes half steps.
pub fn wander(seconds: f64, waves: &[(f64, f64)], phase: f64) -> Vec<Step> {
    let at = |t: f64| -> f64 {
        let ease = (t / 0.5).min((seconds - t) / 0.5).clamp(0.0, 1.0);
        let ease = ease * ease * (3.0 - 2.0 * ease);
        ease * waves
            .iter()
            .map(|(size, hz)| size * (2.0 * std::f64::consts::PI * hz * t + phase).sin())
            .sum::<f64>()
    };
    let (dt, mut steps, mut here) = (20e-6, Vec::new(), 0i64);
    let mut k = 0u64;
    while (k as f64) * dt < seconds {
        let (t, next) = (k as f64 * dt, (k + 1) as f64 * dt);
        let (p, q) = (at(t), at(next));
        // Half a step and a little more: no step is taken back at once.
        while q > here as f64 + 0.75 {
            steps.push((t + dt * ((here as f64 + 0.75 - p) / (q - p)).clamp(0.0, 1.0), true));
            here += 1;
        }
        while q < here as f64 - 0.75 {
            steps.push((t + dt * ((here as f64 - 0.75 - p) / (q - p)).clamp(0.0, 1.0), false));
            here -= 1;
        }
        k += 1;
    }
    steps
}

/// Steps of all axes in the order of their times, and the end.
pub struct Job {
    pub axes: [Vec<Step>; 3],
    next: [usize; 3],
    /// The powers of a laser from these times on.
    powers: VecDeque<(f64, u8)>,
    pub end: f64,
}

impl Job {
    pub fn new(axes: [Vec<Step>; 3]) -> Job {
        let end = axes.iter().filter_map(|axis| axis.last()).map(|step| step.0).fold(0.0, f64::max);
        Job { axes, next: [0; 3], powers: VecDeque::new(), end }
    }

    pub fn with_laser(mut self, powers: &[(f64, u8)]) -> Job {
        self.powers.extend(powers);
        self
    }

    pub fn feed(&mut self, feeder: &mut StreamFeeder) {
        while feeder.wants() {
            let first = (0..3)
                .filter_map(|n| self.axes[n].get(self.next[n]).map(|step| (n, *step)))
                .min_by(|a, b| a.1.0.total_cmp(&b.1.0));
            let until = first.map_or(self.end, |(_, (time, _))| time);
            while let Some(&(time, power)) = self.powers.front().filter(|power| power.0 <= until) {
                feeder.power(time, power);
                self.powers.pop_front();
            }
            match first {
                Some((axis, (time, forward))) => {
                    self.next[axis] += 1;
                    feeder.step(axis, time, forward);
                }
                None => feeder.end(self.end),
            }
        }
    }
}

/// What befalls the line.
pub struct Line {
    /// From one end to the other, in cycles.
    pub latency: u64,
    /// One byte of this many is spoilt, each way; 0 for none.
    pub spoils: u64,
    /// The host sleeps: when, from the start, and for how long, in cycles.
    pub sleeps: Vec<(u64, u64)>,
    pub seed: u64,
    /// Text lines are said back to back.
    pub polls: bool,
}

impl Default for Line {
    fn default() -> Self {
        Line { latency: MILLIS, spoils: 0, sleeps: vec![], seed: 1, polls: false }
    }
}

impl Line {
    pub fn random(&mut self) -> u64 {
        // xorshift64*
        self.seed ^= self.seed >> 12;
        self.seed ^= self.seed << 25;
        self.seed ^= self.seed >> 27;
        self.seed.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn spoil(&mut self, byte: u8) -> u8 {
        if self.spoils != 0 && self.random() >> 20 & 0xFF_FFFF < (1 << 24) / self.spoils {
            byte ^ 1 << (self.random() >> 40 & 7)
        } else {
            byte
        }
    }
}

/// What came of a run.
pub struct Told {
    pub state: FeedState,
    pub again: u64,
    pub answers: usize,
    /// When all axes began, in cycles.
    pub begun: u64,
    /// Bytes that the host sent.
    pub bytes: usize,
}

/// A board at the end of the line.
pub trait Target {
    /// Lets time pass until this cycle.
    fn run_until(&mut self, cycle: u64);
    /// A byte has arrived.
    fn receive(&mut self, byte: u8);
    /// What the board has said since.
    fn said(&mut self) -> Vec<u8>;
    /// Edges so far.
    fn edges(&mut self) -> &[Edge];
}

impl<R: Recorder + AsRef<[Edge]>> Target for StreamBoard<'_, R> {
    fn run_until(&mut self, cycle: u64) {
        StreamBoard::run_until(self, cycle);
    }
    fn receive(&mut self, byte: u8) {
        StreamBoard::receive(self, &[byte]);
    }
    fn said(&mut self) -> Vec<u8> {
        self.take_answers()
    }
    fn edges(&mut self) -> &[Edge] {
        let recorder: &R = self.recorder();
        recorder.as_ref()
    }
}

/// A virtual board with nothing in its queues.
pub fn board(queues: &mut Queues) -> StreamBoard<'_, Vec<Edge>> {
    StreamBoard::new(queues, Description::uno(), Vec::new())
}

/// Terms with these decelerations, in steps/s².
pub fn terms(decels: [f64; 3]) -> FeedTerms {
    FeedTerms::avr(decels.map(|a| BrakeLaw::of((a * 1e3) as u64, HZ as u32).unwrap()))
}

/// Runs a job on a board until it is over, or off the path.
pub fn run(board: &mut impl Target, mut job: Job, terms: FeedTerms, mut line: Line) -> Told {
    let axes = (0..3).filter(|axis| !job.axes[*axis].is_empty()).map(|axis| 1 << axis).sum();
    let laser = !job.powers.is_empty();
    let mut feeder = StreamFeeder::new(FeedTerms { axes, laser, ..terms }, 0);
    let (mut to, mut from) = (VecDeque::<(u64, u8)>::new(), VecDeque::<(u64, u8)>::new());
    let (mut free_at, mut text, mut answers, mut bytes) = (0u64, vec![], 0, 0);
    let (mut now, mut begun, mut asked) = (0u64, 0, 0u64);
    let byte = 1389; // cycles of a byte at 115,200 baud
    while now < 200_000 * MILLIS {
        now += MILLIS / 4;
        while let Some((at, byte)) = to.front().copied()
            && at <= now
        {
            to.pop_front();
            board.run_until(at);
            board.receive(byte);
        }
        board.run_until(now);
        if begun == 0 && board.edges().iter().any(Edge::is_step) {
            begun = now;
        }
        for byte in board.said() {
            from.push_back((now + line.latency, line.spoil(byte)));
        }
        if begun != 0
            && line.sleeps.iter().any(|(at, ms)| (begun + at..begun + at + ms).contains(&now))
        {
            continue;
        }
        let came = from.iter().take_while(|(at, _)| *at <= now).count();
        let heard: Vec<u8> = from.drain(..came).map(|(_, byte)| byte).collect();
        text.extend(feeder.hear(&heard, now / 16));
        job.feed(&mut feeder);
        if line.polls {
            let ends = text.iter().filter(|byte| **byte == b'\r').count();
            // One that was spoilt is asked again after 100 ms.
            if ends > 0 || asked == 0 || now > asked + 100 * MILLIS {
                (answers, asked) = (answers + ends, now);
                text.clear();
                feeder.say("?");
            }
        }
        let out = feeder.bytes(now / 16);
        bytes += out.len();
        free_at = free_at.max(now);
        for value in out {
            free_at += byte;
            to.push_back((free_at + line.latency, line.spoil(value)));
        }
        if feeder.state().is_end() {
            break;
        }
    }
    board.run_until(now + 50 * MILLIS);
    let (state, again) = (feeder.state(), feeder.again());
    Told { state, again, answers, begun, bytes }
}

/// The largest distance of an edge from its time in a job, in µs, and edges beyond `bound`; the beginning
/// is the one that makes the distance least.
pub fn worst(edges: &[Edge], job: &[Vec<Step>; 3], stagger: f64, bound: f64) -> (f64, usize) {
    let mut apart = Vec::new();
    for axis in 0..3u8 {
        let (steps, wanted) = (steps_of(edges, axis), &job[usize::from(axis)]);
        assert_eq!(steps.len(), wanted.len(), "axis {axis}");
        for (made, wanted) in steps.iter().zip(wanted) {
            assert_eq!(made.1, wanted.1);
            apart.push((made.0 as f64 - wanted.0 * HZ - stagger * f64::from(axis)) / 16.0);
        }
    }
    apart.sort_by(f64::total_cmp);
    let middle = (apart[0] + apart[apart.len() - 1]) / 2.0;
    let beyond = apart.iter().filter(|value| (*value - middle).abs() > bound).count();
    ((apart[apart.len() - 1] - middle).max(middle - apart[0]), beyond)
}

/// The steps of an axis among edges: cycle and direction, from the pins alone.
pub fn steps_of(edges: &[Edge], axis: u8) -> Vec<(u64, bool)> {
    use stepwright_sim::Pin;
    let (mut forward, mut steps) = (true, Vec::new());
    for edge in edges.iter().filter(|edge| edge.axis == axis) {
        match edge.pin {
            Pin::Direction => forward = edge.level,
            Pin::Step if edge.level => steps.push((edge.time, forward)),
            _ => {}
        }
    }
    steps
}

/// Forward less backward steps.
pub fn position_of(steps: &[(u64, bool)]) -> i64 {
    steps.iter().map(|step| if step.1 { 1 } else { -1 }).sum()
}
