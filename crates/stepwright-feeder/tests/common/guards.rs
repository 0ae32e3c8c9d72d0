//! What stops a streamed run besides silence: inputs, `Z`, `K`; and what goes on all the same. The same
//! for the virtual board and the chips.

use stepwright_feeder::{FeedState, FeedTerms};
use stepwright_stream::credit::Credit;
use stepwright_stream::frame::{FrameBytes, Kind};
use stepwright_stream::record::{Record, RecordAct, RecordBytes, Trail};

use super::instants::{Guarded, ask, ask_credit};
use super::judge::judge;
use super::wire::{Heard, Wire};
use super::{Job, MILLIS, Step, position_of, s_curve, steps_of, terms};

const DECELS: [f64; 3] = [30_000.0, 20_000.0, 2_000.0];

fn paths() -> [Vec<Step>; 3] {
    [8_000.0, 3_000.0, 200.0].map(|v| s_curve((v * 0.9) as usize, v, v * 5.0, v * 100.0))
}

/// A run begins, with these inputs.
fn start(board: &impl Guarded, inputs: u8, high: u8) -> Wire {
    let terms = FeedTerms { inputs, high, lease: 0, ..terms(DECELS) };
    Wire::new(Job::new(paths()), terms, begins(board))
}

/// All axes have braked, and say where they are.
fn braked(board: &mut impl Guarded, wire: &mut Wire, from: &[usize; 3], flags: u8) {
    let mut heard = Heard::default();
    wire.pass(board, wire.now() + 800 * MILLIS);
    heard.listen(board);
    let credit = ask_credit(board, wire, &mut heard).unwrap();
    let all = Credit::OFF | Credit::TRIPPED | Credit::MOVES | Credit::WRONG;
    assert_eq!(credit.flags & all, flags);
    for (axis, path) in (0..3u8).zip(paths()) {
        let steps = steps_of(board.edges(), axis);
        let told = ask(board, wire, &mut heard, &format!("V{}", axis + 1)).unwrap();
        assert_eq!(told, position_of(&steps).to_string(), "axis {axis}");
        let steps = &steps[from[usize::from(axis)]..];
        let verdict = judge(steps, &path, DECELS[usize::from(axis)]).unwrap();
        assert!(verdict.kept < path.len(), "axis {axis} makes its whole path");
    }
}

fn made(board: &mut impl Guarded) -> [usize; 3] {
    [0, 1, 2].map(|axis| steps_of(board.edges(), axis).len())
}

/// An input that is watched brakes all axes, is told, and lets the next run begin.
pub fn an_input_brakes_all_axes(board: &mut impl Guarded) {
    for input in [0, 1, 2, 6, 7] {
        let from = made(board);
        let mut wire = start(board, 1 << input, 0);
        let now = wire.now();
        wire.feed(board, now + 400 * MILLIS);
        // A spark is none: not two looks long.
        board.close(input, true);
        wire.feed(board, now + 400 * MILLIS + MILLIS / 2);
        board.close(input, false);
        wire.feed(board, now + 600 * MILLIS);
        assert_eq!(wire.feeder().state(), FeedState::Running, "a spark of input {input}");
        board.close(input, true);
        wire.feed(board, now + 700 * MILLIS);
        assert_eq!(wire.feeder().state(), FeedState::Tripped, "input {input}");
        braked(board, &mut wire, &from, Credit::OFF | Credit::TRIPPED);
        // Off the switch, which is closed still: a run that watches the others.
        let from = made(board);
        let mut wire = start(board, 0b1100_0111 & !(1 << input), 0);
        let now = wire.now();
        wire.feed(board, now + 2_500 * MILLIS);
        assert_eq!(wire.feeder().state(), FeedState::Over, "beside input {input}");
        let whole = paths().map(|path| path.len());
        assert_eq!([0, 1, 2].map(|axis| made(board)[axis] - from[axis]), whole);
        board.close(input, false);
    }
}

/// A contact that opens, as those of an emergency stop do.
pub fn an_input_that_opens_brakes_all_axes(board: &mut impl Guarded) {
    board.close(7, true);
    let from = made(board);
    let mut wire = start(board, 1 << 7, 1 << 7);
    let now = wire.now();
    wire.feed(board, now + 500 * MILLIS);
    assert_eq!(wire.feeder().state(), FeedState::Running);
    board.close(7, false);
    wire.feed(board, now + 600 * MILLIS);
    assert_eq!(wire.feeder().state(), FeedState::Tripped);
    braked(board, &mut wire, &from, Credit::OFF | Credit::TRIPPED);
}

/// `F` and `V` tell, `I` is refused, `Z` brakes.
pub fn z_brakes_and_f_tells(board: &mut impl Guarded) {
    let mut heard = Heard::default();
    let mut wire = start(board, 0, 0);
    let now = wire.now();
    wire.feed(board, now + 500 * MILLIS);
    assert_eq!(ask(board, &mut wire, &mut heard, "F").unwrap(), "B");
    assert_eq!(ask(board, &mut wire, &mut heard, "I1").unwrap(), "E busy");
    assert_eq!(ask(board, &mut wire, &mut heard, "Z").unwrap(), "Y");
    assert_eq!(ask(board, &mut wire, &mut heard, "F").unwrap(), "B");
    braked(board, &mut wire, &[0; 3], Credit::OFF);
    assert_eq!(ask(board, &mut wire, &mut heard, "F").unwrap(), "R");
}

/// `K` stops at once; the positions of those that moved are unknown until `I`, and the next run begins.
pub fn k_stops_at_once(board: &mut impl Guarded) {
    let mut heard = Heard::default();
    let mut wire = start(board, 0, 0);
    let now = wire.now();
    wire.feed(board, now + 500 * MILLIS);
    // In the middle of a frame, so that one is open.
    wire.cut(0);
    wire.send(&[Kind::Data as u8, 40, 1, 2, 3]);
    wire.pass(board, now + 503 * MILLIS);
    assert_eq!(ask(board, &mut wire, &mut heard, "K").unwrap(), "Y");
    let stopped = made(board);
    wire.pass(board, wire.now() + 500 * MILLIS);
    assert_eq!(made(board), stopped, "it moves behind K");
    assert_eq!(ask(board, &mut wire, &mut heard, "F").unwrap(), "R");
    for axis in 1..=3 {
        assert_eq!(ask(board, &mut wire, &mut heard, &format!("V{axis}")).unwrap(), "E uncertain");
        assert_eq!(ask(board, &mut wire, &mut heard, &format!("I{axis}")).unwrap(), "Y");
        assert_eq!(ask(board, &mut wire, &mut heard, &format!("V{axis}")).unwrap(), "0");
    }
    let mut wire = start(board, 0, 0);
    let now = wire.now();
    wire.feed(board, now + 2_500 * MILLIS);
    assert_eq!(wire.feeder().state(), FeedState::Over);
    for (axis, path) in (1..).zip(paths()) {
        let told = ask(board, &mut wire, &mut heard, &format!("V{axis}")).unwrap();
        assert_eq!(told, path.len().to_string());
    }
}

/// Frames by hand, from a number on.
fn frames(wire: &mut Wire, from: u8, frames: &[(Kind, &[u8])]) {
    for (n, (kind, payload)) in (from..).zip(frames) {
        wire.send(FrameBytes::new(*kind, n, payload).as_bytes());
    }
}

/// A gate, and this many steps of axis 0 at 1,000 steps/s, to rest.
fn data(steps: u16) -> Vec<u8> {
    let (mut bytes, mut trail) = (vec![0], Trail::NONE);
    for act in [RecordAct::Steps(steps - 1), RecordAct::Step { halvings: 0, goes_on: false }] {
        let record = Record { act, interval: 16_000 << 8, growth: 0 };
        bytes.extend(RecordBytes::new(0, &record, &trail).unwrap().as_bytes());
        trail.pass(&record);
    }
    bytes
}

const SETUP: (Kind, &[u8]) = (Kind::Setup, &[0; 18]);
const START: (Kind, &[u8]) = (Kind::Start, &[1, 0, 0, 0]);
const END: (Kind, &[u8]) = (Kind::End, &[]);

/// A host that was ended while it filled the queues: the next one begins with nothing of it. What was
/// filled is not started behind a `Z`.
pub fn what_was_not_started_is_forgotten(board: &mut impl Guarded) {
    let mut heard = Heard::default();
    let mut wire = start(board, 0, 0);
    let [from, ..] = made(board);
    frames(&mut wire, 0, &[SETUP, (Kind::Data, &data(50))]);
    wire.pass(board, wire.now() + 50 * MILLIS);
    frames(&mut wire, 2, &[SETUP, (Kind::Data, &data(7)), START, END]);
    wire.pass(board, wire.now() + 500 * MILLIS);
    assert_eq!(made(board)[0] - from, 7);
    frames(&mut wire, 6, &[SETUP, (Kind::Data, &data(50))]);
    assert_eq!(ask(board, &mut wire, &mut heard, "Z").unwrap(), "Y");
    frames(&mut wire, 8, &[START, END]);
    wire.pass(board, wire.now() + 500 * MILLIS);
    assert_eq!(made(board)[0] - from, 7, "it starts behind Z");
    assert_eq!(ask(board, &mut wire, &mut heard, "F").unwrap(), "R");
    frames(&mut wire, 8, &[SETUP, (Kind::Data, &data(9)), START, END]);
    wire.pass(board, wire.now() + 500 * MILLIS);
    assert_eq!(made(board)[0] - from, 16);
}

/// Records of no step, and of less than two groups, are none.
pub fn a_count_of_nothing_moves_nothing(board: &mut impl Guarded) {
    let mut heard = Heard::default();
    let mut wire = start(board, 0, 0);
    let [from, ..] = made(board);
    // The wait is 1,000 ticks: 22 bits with a prefix.
    let steps: &[u8] = &[0, 0x00, 0, 0, 0, 0x80, 0x3E, 0x80];
    for (n, record) in
        (0..).zip([steps, &[0, 0x10, 0, 0x80, 0x3E, 0x80, 0], &[0, 0x10, 1, 0x80, 0x3E, 0x80, 0]])
    {
        frames(&mut wire, 4 * n, &[SETUP, (Kind::Data, record), START, END]);
        wire.pass(board, wire.now() + 500 * MILLIS);
        let credit = ask_credit(board, &mut wire, &mut heard).unwrap();
        assert_eq!(credit.flags & Credit::WRONG, Credit::WRONG, "{record:?}");
        assert_eq!(made(board)[0] - from, 0, "{record:?}");
    }
}

/// The lease: a host that is silent for longer brakes it, with all in the FIFO; not behind the end.
pub fn a_lease_counts_until_the_end(board: &mut impl Guarded) {
    for (lease, feeds, off) in [(200, 500, true), (0, 500, true), (160, 3_000, false)] {
        let from = made(board);
        let path = if off { paths() } else { [150.0; 3].map(|v| s_curve(60, v, 800.0, 8_000.0)) };
        let ended = terms([30_000.0, 20_000.0, 2_000.0]);
        let mut wire =
            Wire::new(Job::new(path.clone()), FeedTerms { lease, ..ended }, begins(board));
        let now = wire.now();
        // A short job is there with its end some 0.3 s before that.
        let mut looks = 0;
        while looks < feeds && (off || !wire.has_ended()) {
            looks += 1;
            wire.feed(board, now + looks * MILLIS);
        }
        let silent = wire.now() + board.begun();
        wire.pass(board, wire.now() + 1_500 * MILLIS);
        let mut heard = Heard::default();
        heard.listen(board);
        let credit = ask_credit(board, &mut wire, &mut heard).unwrap();
        assert_eq!(credit.is(Credit::OFF), off, "lease {lease}");
        for axis in 0..3u8 {
            let (n, steps) = (usize::from(axis), steps_of(board.edges(), axis));
            let steps = &steps[from[n]..];
            let verdict = judge(steps, &path[n], DECELS[n]).unwrap();
            if off {
                let left = (steps[verdict.kept - 1].0 - silent) / MILLIS;
                let bounds = if lease == 200 { 200..285 } else { 250..700 };
                assert!(bounds.contains(&left), "axis {axis} leaves {left} ms later");
            } else {
                assert_eq!((verdict.kept, verdict.braked), (path[n].len(), 0));
            }
        }
    }
}

/// The present, in the wire's time.
fn begins(board: &impl Guarded) -> u64 {
    board.now() - board.begun()
}
