//! The power of a laser on the virtual board, against the times that were asked for.

use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_sim::{Description, Edge, Queues, Recorder, StreamBoard};

use crate::common::{HZ, Job, Line, MILLIS, run, s_curve, steps_of, terms};

/// Edges, and the laser's powers with their times.
#[derive(Default)]
pub struct Watch {
    pub edges: Vec<Edge>,
    pub powers: Vec<(u64, u8)>,
}

impl Recorder for Watch {
    fn edge(&mut self, edge: Edge) {
        self.edges.push(edge);
    }
    fn laser(&mut self, time: u64, power: u8) {
        self.powers.push((time, power));
    }
}

impl AsRef<[Edge]> for Watch {
    fn as_ref(&self) -> &[Edge] {
        &self.edges
    }
}

/// Two seconds of two axes, the second one half as fast.
fn moving() -> [Vec<(f64, bool)>; 3] {
    let x = s_curve(40_000, 20_000.0, 80_000.0, 800_000.0);
    let y = x.iter().step_by(2).copied().collect();
    [x, y, vec![]]
}

/// Changes at these times apart, in s, with powers that differ from one to the next.
fn changes(end: f64, apart: &[f64]) -> Vec<(f64, u8)> {
    let (mut time, mut all) = (0.05, vec![]);
    for n in 0.. {
        if time >= end {
            return all;
        }
        all.push((time, [255, 0, 37, 128, 1][n % 5]));
        time += apart[n % apart.len()];
    }
    all
}

/// The changes on the board with their times on the path, and how late each is, in µs.
fn late(
    board: &mut StreamBoard<'_, Watch>,
    job: &[Vec<(f64, bool)>; 3],
    powers: &[(f64, u8)],
) -> Vec<f64> {
    let watch = board.recorder();
    let first = steps_of(&watch.edges, 0)[0].0 as f64 - job[0][0].0 * HZ;
    let made = &watch.powers;
    let off = usize::from(powers.last().unwrap().1 != 0);
    assert_eq!((made.len(), made.last().unwrap().1), (powers.len() + off, 0));
    let each = made.iter().zip(powers);
    each.map(|(made, wanted)| {
        assert_eq!(made.1, wanted.1);
        (made.0 as f64 - first) / 16.0 - wanted.0 * 1e6
    })
    .collect()
}

fn played(powers: &[(f64, u8)], line: Line, change: impl Fn(&mut FeedTerms)) -> Vec<f64> {
    let axes = moving();
    let mut queues = Queues::default();
    let mut board: StreamBoard<Watch> =
        StreamBoard::new(&mut queues, Description::uno(), Watch::default());
    let mut terms = terms([80_000.0; 3]);
    change(&mut terms);
    let told = run(&mut board, Job::new(axes.clone()).with_laser(powers), terms, line);
    assert_eq!(told.state, FeedState::Over);
    assert_eq!(board.late(), 0);
    late(&mut board, &axes, powers)
}

/// Half a unit of 16 µs, and a visit of the main loop each 50 µs: before the start too.
fn are_on_time(late: &[f64]) {
    let most = late.iter().copied().fold(f64::MIN, f64::max);
    let least = late.iter().copied().fold(f64::MAX, f64::min);
    assert!(least > -8.0 - 50.0 && most < 8.0 + 50.0, "{least} {most}");
}

#[test]
fn each_change_comes_at_its_time() {
    let end = moving()[0].last().unwrap().0;
    for apart in [&[0.001][..], &[0.0007, 0.004, 0.011], &[0.3], &[0.13, 0.0006]] {
        let powers = changes(end - 0.001, apart);
        let late = played(&powers, Line::default(), |_| ());
        are_on_time(&late);
    }
}

#[test]
fn spoilt_bytes_lose_no_change() {
    let powers = changes(2.0, &[0.004, 0.021]);
    let line = Line { spoils: 400, ..Line::default() };
    let late = played(&powers, line, |_| ());
    are_on_time(&late);
}

/// A host that falls silent, `Z` and `K`: the laser goes off before the axes rest.
#[test]
fn off_the_path_it_is_off() {
    let axes = moving();
    for (silent, text) in [(true, ""), (false, "Z"), (false, "K")] {
        let mut queues = Queues::default();
        let mut board: StreamBoard<Watch> =
            StreamBoard::new(&mut queues, Description::uno(), Watch::default());
        let mut job = Job::new(axes.clone()).with_laser(&[(0.01, 200)]);
        let terms = FeedTerms { axes: 0b11, laser: true, ..terms([80_000.0; 3]) };
        let mut feeder = stepwright_feeder::StreamFeeder::new(terms, 0);
        let mut now = 0;
        let mut said = false;
        while now < 4_000 * MILLIS {
            now += MILLIS;
            board.run_until(now);
            let heard = board.take_answers();
            if now >= 800 * MILLIS && silent {
                continue;
            }
            feeder.hear(&heard, now / 16);
            job.feed(&mut feeder);
            if now >= 800 * MILLIS && !said {
                said = true;
                feeder.say(text);
            }
            let bytes = feeder.bytes(now / 16);
            board.receive(&bytes);
        }
        let watch = board.recorder();
        let last = watch.edges.iter().rfind(|edge| edge.is_step()).unwrap().time;
        assert_eq!(watch.powers.len(), 2, "{text}: {:?}", watch.powers);
        let (off, power) = watch.powers[1];
        assert_eq!(power, 0);
        // Braking from 20,000 steps/s takes 250 ms; K takes none.
        let before = if text == "K" { 0 } else { 150 * MILLIS };
        assert!(off > 700 * MILLIS && off + before <= last + MILLIS, "{text}: {off} {last}");
        assert!(!board.is_busy());
    }
}

/// It never burns where nothing moves, though nobody switched it off: before the start, and behind the end.
#[test]
fn at_rest_it_is_off() {
    let powers = [(0.0, 90)];
    let axes = moving();
    let mut queues = Queues::default();
    let mut board: StreamBoard<Watch> =
        StreamBoard::new(&mut queues, Description::uno(), Watch::default());
    for _ in 0..2 {
        let job = Job::new(axes.clone()).with_laser(&powers);
        let told = run(&mut board, job, terms([80_000.0; 3]), Line::default());
        assert_eq!(told.state, FeedState::Over);
        let watch = std::mem::take(board.recorder());
        let steps: Vec<_> = watch.edges.iter().filter(|edge| edge.is_step()).collect();
        let [(on, 90), (off, 0)] = watch.powers[..] else { panic!("{:?}", watch.powers) };
        let (first, last) = (steps[0].time, steps.last().unwrap().time);
        let begin = first - (axes[0][0].0 * HZ) as u64;
        assert!(on + MILLIS > begin && on < begin + MILLIS, "{on} {begin}");
        assert!(off >= last && off <= last + 3 * MILLIS, "{off} {last}");
    }
}
