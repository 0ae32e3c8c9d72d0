//! Orders that a board refuses, kills and forgets, on 16 and 32 bits.

use crate::edges::{check_timing, steps_of};
use stepwright::profile::Ramp;
use stepwright::{Accel, Axis, Order, Rate, Refusal, Speed, Travel};
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

fn order(top: u32, travel: Travel) -> Order {
    Order {
        start: Speed::ZERO,
        top: Speed::from_steps(top).unwrap(),
        up: Ramp::Accel(Accel::from_steps(40_000).unwrap()),
        down: Ramp::Accel(Accel::from_steps(40_000).unwrap()),
        jerk: None,
        travel,
    }
}

const FAR: Travel = Travel::By(2_000_000);

fn board(queues: &mut Queues) -> VirtualBoard<'_, u16, Vec<Edge>> {
    VirtualBoard::new(queues, Description::uno(), Vec::new())
}

/// Starts an axis for each of these top speeds; 0 leaves the axis out.
fn start(board: &mut VirtualBoard<'_, u16, Vec<Edge>>, tops: &[u32]) -> Result<(), Refusal> {
    let orders = Axis::all().zip(tops).filter(|(_, top)| **top > 0);
    let orders = orders.map(|(axis, top)| (axis, order(*top, FAR)));
    board.motors().start(orders)
}

/// The foreground of a fast board plans as fast: its queue lasts for only a few steps.
#[test]
fn the_steepest_ramp_is_on_time() {
    let rate = Rate::from_hz(16_000_000).unwrap();
    for phase in 0..16 {
        let mut queues = Queues::default();
        let description = Description::quick(rate, [76, 117, 125]);
        let mut board: VirtualBoard<u16, Vec<Edge>> =
            VirtualBoard::new(&mut queues, description, Vec::new());
        for line in ["PO", "t200000", "R7", "G-1279", "E"] {
            line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
            board.run_until(board.now() + 50 * phase);
        }
        board.run_to_rest();
        assert_eq!((board.position(0), board.late()), (Some(-1279), 0), "{phase}");
    }
}

#[test]
fn what_the_board_cannot_step_is_refused_and_nothing_moves() {
    for (tops, fits) in [
        (&[128_000][..], true),
        (&[128_001], false),
        (&[43_478, 43_478], true),
        (&[43_479, 43_478], false),
        (&[21_248, 21_248, 21_248], true),
        (&[21_249, 21_249, 21_249], false),
        (&[28_571, 18_428, 16_746], true),
        (&[28_571, 18_428, 16_747], false),
        // Two other axes that step at the same moment would make its steps late.
        (&[28_572, 1_000, 1_000], false),
        (&[57_142, 1_000], true),
        (&[57_143, 1_000], false),
    ] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let started = start(&mut board, tops);
        assert_eq!(started.is_ok(), fits, "{tops:?}: {started:?}");
        if !fits {
            assert!(matches!(started, Err(Refusal::TooFast { .. })));
            board.run_until(1_000_000);
            assert!(!board.is_busy() && board.recorder().iter().all(|edge| !edge.is_step()));
        }
    }
}

/// An axis counts while it moves, and no longer once it rests.
#[test]
fn a_refusal_says_how_fast_it_may_be_now() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    start(&mut board, &[60_000]).unwrap();
    let refused = start(&mut board, &[0, 30_000]).unwrap_err();
    assert_eq!(refused, Refusal::TooFast { max: Speed::from_millisteps(26_956_521).unwrap() });
    start(&mut board, &[0, 15_117]).unwrap();
    assert_eq!(start(&mut board, &[500]), Err(Refusal::Busy));
    board.motors().stop(Axis::X);
    board.motors().stop(Axis::Y);
    board.run_to_rest();
    start(&mut board, &[0, 114_000]).unwrap();
}

#[test]
fn a_kill_loses_the_position_of_what_moved_and_of_nothing_else() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    start(&mut board, &[9_000, 0, 5_000]).unwrap();
    board.run_until(16_000_000);
    board.motors().kill();
    let steps = [0, 1, 2].map(|axis| steps_of(board.recorder(), axis).len());
    assert!(!board.is_busy());
    board.run_until(64_000_000);
    assert_eq!(steps, [0, 1, 2].map(|axis| steps_of(board.recorder(), axis).len()));
    assert_eq!([0, 1, 2].map(|axis| board.position(axis)), [None, Some(0), None]);
    assert_eq!(board.motors().uncertain(), 0b101);
    board.motors().zero(Axis::X);
    assert_eq!([0, 2].map(|axis| board.position(axis)), [Some(0), None]);
    // A kill before the first step: nothing moved, but the board can't be sure.
    start(&mut board, &[9_000]).unwrap();
    board.motors().kill();
    board.run_until(board.now() + 1_000_000);
    assert_eq!(steps_of(board.recorder(), 0).len(), steps[0]);
    assert!(!board.is_busy());
}

/// Travels of 2³¹ − 1 steps are begun and braked. The end of such a travel is tested on the profile
/// (`exact.rs`).
#[test]
fn the_longest_travel_begins_and_brakes() {
    for travel in [Travel::By(i32::MAX), Travel::By(-i32::MAX), Travel::By(i32::MIN)] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        board.motors().start([(Axis::Y, order(50_000, travel))]).unwrap();
        board.run_until(16_000_000 * 3);
        board.motors().stop(Axis::Y);
        board.run_to_rest();
        let steps = steps_of(board.recorder(), 1);
        let sign = if travel.forward() { 1 } else { -1 };
        assert_eq!(board.position(1), Some(sign * steps.len() as i64));
        assert!(steps.len() > 100_000);
    }
}

#[test]
fn small_travels_are_exact() {
    for steps in [0i32, 1, -1, 2, -2, 3] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let order = order(20_000, Travel::By(steps));
        board.motors().start([(Axis::X, order)]).unwrap();
        assert_eq!(board.is_busy(), steps != 0);
        board.run_to_rest();
        assert_eq!(board.position(0), Some(steps.into()));
        assert_eq!(steps_of(board.recorder(), 0).len(), steps.unsigned_abs() as usize);
    }
}

/// An order back that comes with the last step of the way there: DIR still keeps its hold and set-up times.
#[test]
fn a_reversal_at_once_keeps_the_drivers_times() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    b"$hold-us=45\r$setup-us=60\r".iter().for_each(|&byte| board.receive(byte));
    for steps in [40, -40, 7, -1, 1] {
        let order = order(20_000, Travel::By(steps));
        board.motors().start([(Axis::X, order)]).unwrap();
        board.run_to_rest();
    }
    assert_eq!(board.position(0), Some(7));
    check_timing(board.recorder(), 32, 60 * 16, 45 * 16, 133);
}

/// One axis turns first and the other does not: the first pulses still come together.
#[test]
fn axes_that_start_together_step_together() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    let there = |steps| order(20_000, Travel::By(steps));
    let orders = [(Axis::X, there(100)), (Axis::Y, there(-100)), (Axis::Z, there(1))];
    board.motors().start(orders).unwrap();
    board.run_to_rest();
    let [x, y, z] = [0, 1, 2].map(|axis| steps_of(board.recorder(), axis));
    assert_eq!((x[0].0, x[0].0), (y[0].0, z[0].0));
    assert_eq!(x[99].0, y[99].0);
}

/// The same order on a 16-bit and on a 32-bit timer gives the same edges.
#[test]
fn the_width_of_the_timer_does_not_matter() {
    fn edges<C: stepwright::timer::Count>(rate: Rate) -> Vec<Edge> {
        let mut queues = Queues::default();
        let mut board: VirtualBoard<C, Vec<Edge>> =
            VirtualBoard::new(&mut queues, Description::quick(rate, [133; 3]), Vec::new());
        let slow = Order { top: Speed::from_steps(700).unwrap(), ..order(1, Travel::By(-900)) };
        let orders = [(Axis::X, order(30_000, Travel::By(5_000))), (Axis::Y, slow)];
        board.motors().start(orders).unwrap();
        board.run_to_rest();
        std::mem::take(board.recorder())
    }
    let rate = Rate::from_hz(16_000_000).unwrap();
    let narrow = edges::<u16>(rate);
    check_timing(&narrow, 32, 16, 16, 133);
    assert_eq!(narrow, edges::<u32>(rate));
}

/// An order that the board refuses as a whole has no effect on later orders.
#[test]
fn after_a_refused_order_the_axis_is_free() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    for byte in *b"PO\rt1000000\ra100000000\rd100000000\rG+50000\rE\rF\rt1000\rE\r" {
        board.receive(byte);
    }
    // The refused E has spoiled the order: the next order begins with PO.
    assert_eq!(board.take_answers(), b"Y\rY\rY\rY\rY\rE\rR\rY\rE\r");
    for byte in *b"PO\rG+50000\rE\rF\r" {
        board.receive(byte);
    }
    assert_eq!(board.take_answers(), b"Y\rY\rY\rB\r");
}

/// Edges of the Uno's third axis come at the next multiple of 8 ticks from their deadline; those of the other
/// axes come at their deadlines.
#[test]
fn a_coarse_compare_register_rounds_edges_up() {
    let edges = |grid: [u32; 3]| {
        let mut queues = Queues::default();
        let description = Description { grid, ..Description::uno() };
        let mut board: VirtualBoard<u16, Vec<Edge>> =
            VirtualBoard::new(&mut queues, description, Vec::new());
        board.motors().start([(Axis::Z, order(1_054, Travel::By(400)))]).unwrap();
        board.run_to_rest();
        let steps = board.recorder().iter().filter(|edge| edge.is_step());
        steps.map(|edge| edge.time).collect::<Vec<_>>()
    };
    let (exact, coarse) = (edges([1; 3]), edges(Description::uno().grid));
    assert_eq!(exact.len(), 400);
    assert_eq!(coarse, exact.iter().map(|time| time.next_multiple_of(8)).collect::<Vec<_>>());
    assert_ne!(coarse, exact);
    assert_eq!(Description::uno().grid, [1, 1, 8]);
}
