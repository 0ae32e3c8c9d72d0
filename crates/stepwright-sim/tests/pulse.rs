//! Pulses of every width that can be set, at the highest rates that are admitted.

use stepwright::Rate;
use stepwright_sim::{Description, Edge, Pin, Queues, VirtualBoard};

type Board<'q> = VirtualBoard<'q, u16, Vec<Edge>>;

/// The answer of a board to a line.
fn ask(board: &mut Board, line: &str) -> String {
    line.bytes().chain(*b"\r").for_each(|byte| board.receive(byte));
    String::from_utf8(board.take_answers()).unwrap().trim_end().to_owned()
}

/// A board with pulses of this width.
fn with_pulse(queues: &mut Queues, description: Description, micros: u32) -> Board<'_> {
    let mut board = Board::new(queues, description, Vec::new());
    assert_eq!(ask(&mut board, "$max-speed=200000"), "Y");
    assert_eq!(ask(&mut board, &format!("$pulse-us={micros}")), "Y");
    board
}

/// Orders 2,000 steps and more of each axis. Returns whether the order is admitted.
fn order(board: &mut Board, speeds: &[u32]) -> bool {
    assert_eq!(ask(board, "PO"), "Y");
    for (n, &speed) in speeds.iter().enumerate() {
        let order = [format!("A{}", n + 1), format!("s0 t{speed} a40000 d40000 G+{}", long(speed))];
        for line in order.iter().flat_map(|lines| lines.split(' ')) {
            assert_eq!(ask(board, line), "Y", "{line}");
        }
    }
    ask(board, "E") == "Y"
}

fn long(speed: u32) -> u64 {
    u64::from(speed).pow(2) / 40_000 + 2_000
}

/// The speeds of this many axes, whose steps meet in every phase.
fn alike(axes: u32) -> impl Fn(u32) -> Vec<u32> {
    move |top| (0..axes).map(|n| top - top * 3 * n / 1_000).collect()
}

/// The highest rates that are admitted.
fn highest(description: Description, micros: u32, speeds: &impl Fn(u32) -> Vec<u32>) -> Vec<u32> {
    let (mut low, mut high) = (500, 200_000);
    while high - low > 1 {
        let middle = (low + high) / 2;
        let mut queues = Queues::default();
        let mut board = with_pulse(&mut queues, description, micros);
        if order(&mut board, &speeds(middle)) { low = middle } else { high = middle }
    }
    speeds(low)
}

/// Checks that no step is late, and that pulses and pauses are at least as wide as set.
fn keeps(description: Description, micros: u32, speeds: impl Fn(u32) -> Vec<u32>) {
    let speeds = highest(description, micros, &speeds);
    let mut queues = Queues::default();
    let mut board = with_pulse(&mut queues, description, micros);
    assert!(order(&mut board, &speeds));
    board.run_to_rest();
    assert_eq!(board.late(), 0, "{micros} µs, {speeds:?} steps/s");
    let width = u64::from(description.board.rate.micros(micros));
    for (axis, &speed) in (0u8..).zip(&speeds) {
        assert_eq!(board.position(axis), Some(long(speed) as i64));
        let edges = board.recorder().iter();
        let times: Vec<u64> = edges
            .filter(|edge| edge.axis == axis && edge.pin == Pin::Step)
            .map(|edge| edge.time)
            .collect();
        assert!(times.windows(2).all(|two| two[1] - two[0] >= width), "{micros} µs, axis {axis}");
    }
}

const WIDTHS: [u32; 6] = [1, 2, 3, 5, 10, 20];

#[test]
fn an_uno_keeps_what_it_admits() {
    for micros in WIDTHS {
        (1..=3).for_each(|axes| keeps(Description::uno(), micros, alike(axes)));
    }
}

#[test]
fn a_board_that_has_nothing_to_do_but_hold_its_pulses_keeps_what_it_admits() {
    let rate = Rate::from_hz(2_000_000).unwrap();
    for micros in WIDTHS {
        (1..=3).for_each(|axes| keeps(Description::quick(rate, [10, 12, 14]), micros, alike(axes)));
    }
}

/// A step that waits for the pulse of another axis has to catch up before the next such wait.
#[test]
fn a_fast_axis_beside_slow_ones_catches_up() {
    let quick = Description::quick(Rate::from_hz(16_000_000).unwrap(), [70, 93, 118]);
    for description in [quick, Description::uno()] {
        for micros in WIDTHS {
            for slow in [&[500][..], &[1000], &[500, 510], &[1000, 503]] {
                keeps(description, micros, |top| [&[top], slow].concat());
            }
        }
    }
}

/// The speed `max` of `?` is the highest of one axis, for every pulse width.
#[test]
fn the_highest_speed_is_the_pulses() {
    for micros in WIDTHS {
        let mut queues = Queues::default();
        let mut board = with_pulse(&mut queues, Description::uno(), micros);
        let health = ask(&mut board, "?");
        let max = health.split(" max=").nth(1).unwrap().split(' ').next().unwrap();
        let max: u32 = max.parse().unwrap();
        assert!(!order(&mut board, &[max + 1]), "{health}");
        assert!(order(&mut board, &[max]), "{health}");
    }
}
