//! stepper_h's basic example on the chip: its 21 lines, and its edges compared with the virtual
//! board, which plays the same cycle.
//!
//! A late step would cancel the cycle, by the default strategy, which the example uses. So if the
//! last positions are reached, no step was late.

use crate::common::{self, BESIDE, board, steps};
use stepwright_cycle::{Calibration, Clock, Motor, Program};
use stepwright_rig::edges::{Needs, check, steps_of};
use stepwright_rig::{Chip, firmware};
use stepwright_sim::{CycleBoard, Edge, Stand};

/// The cycles of a second.
const SECOND: u64 = 16_000_000;

fn chip() -> Chip {
    let board = board();
    let image =
        firmware::load(&format!("{board}-cycle")).unwrap_or_else(|error| panic!("{error:#}"));
    Chip::new(board, &image)
}

/// The lines with positions in the output.
fn lines(said: &[u8]) -> Vec<String> {
    let text = std::str::from_utf8(said).expect("no ASCII");
    text.lines().filter(|line| line.starts_with("X.pos=")).map(String::from).collect()
}

/// X in a line, in steps.
fn x_of(line: &str) -> i64 {
    let at = line.split(['=', ',']).nth(1).unwrap().parse::<i64>().unwrap();
    assert_eq!(at % 7_500, 0, "{line}");
    at / 7_500
}

/// Every edge of the same cycle on the virtual board.
fn virtual_edges() -> Vec<Edge> {
    let axis = Motor::new(7_500, 1_000);
    let motors = [
        axis.between(0, 300_000_000),
        axis.between(0, 216_000_000).inverted(),
        axis.between(0, 100_000_000).inverted(),
    ];
    let mut board: CycleBoard<Vec<Edge>, 3> = CycleBoard::new(
        motors,
        [Stand::default(); 3],
        Clock::Deadlines,
        common::rate(),
        Vec::new(),
    );
    for (motor, count, delay) in [(0, 20_000, 1_000), (1, 10_000, 2_000), (2, 1_000, 20_000)] {
        let program = Program::Steps { count, delay };
        board.cycle().prepare(motor, program, Calibration::None).unwrap();
    }
    board.cycle().start().unwrap();
    board.run_to_rest();
    board.with_recorder(std::mem::take)
}

#[test]
fn the_example_prints_its_lines() {
    let mut chip = chip();
    chip.run_for(21 * SECOND);
    let said = chip.take_said();
    assert!(said.starts_with(b"Starting stepper_h test...\r\n"));
    let moving = lines(&said);
    assert_eq!(moving.len(), 21, "{moving:#?}");
    for pair in moving.windows(2) {
        let made = x_of(&pair[1]) - x_of(&pair[0]);
        assert!((999..=1_001).contains(&made), "{pair:?}");
    }
    assert_eq!(moving[20], "X.pos=150000000, Y.pos=75000000, Z.pos=7500000");
    // At rest, every ten seconds.
    chip.run_for(10 * SECOND);
    assert_eq!(lines(&chip.take_said()), moving[20..]);
    // On with the first of the steps, off with the last.
    let steps: Vec<_> = chip.edges().iter().filter(|edge| edge.is_step()).collect();
    let changes = chip.enable_changes();
    let &[.., (on, false), (off, true)] = changes else { panic!("{changes:?}") };
    assert!(on < steps[0].time && (0..SECOND / 1_000).contains(&(off - steps[30_999].time)));
}

#[test]
fn its_edges_are_those_of_the_virtual_board() {
    let mut chip = chip();
    chip.run_for(21 * SECOND);
    check(chip.edges(), Needs::DEFAULT).unwrap();
    let ideal = virtual_edges();
    let first = |of: &[Edge]| of.iter().find(|edge| edge.is_step()).expect("no step").time;
    let begun = (first(chip.edges()), first(&ideal));
    for (axis, last) in [(0, 20_000), (1, -10_000), (2, -1_000)] {
        let (real, ideal) = (steps(&chip, axis), steps_of(&ideal, axis));
        assert_eq!(real.len(), ideal.len());
        for (n, (real, ideal)) in real.iter().zip(&ideal).enumerate() {
            assert_eq!(real.position, ideal.position, "step {n} of axis {axis}");
            let off = (real.time - begun.0) as i64 - (ideal.time - begun.1) as i64;
            assert!(off.abs() <= BESIDE, "step {n} of axis {axis} is {off} cycles off");
        }
        assert_eq!(real[real.len() - 1].position, last);
    }
}

/// `CYCLE_COST` of the firmware: the cycles allowed for a step.
const COST: u64 = 1_600;

#[test]
fn no_step_takes_longer_than_the_board_says() {
    let mut chip = chip();
    chip.keep_visits();
    chip.run_for(19 * SECOND);
    let steps: Vec<u64> =
        chip.edges().iter().filter(|edge| edge.is_step()).map(|edge| edge.time).collect();
    let visits = chip.take_visits();
    assert!(visits.len() > steps.len() / 2 && steps.len() > 29_000);
    for visit in visits {
        let made = steps.partition_point(|at| *at < visit.exit)
            - steps.partition_point(|at| *at < visit.entry);
        let took = visit.exit - visit.entry;
        assert!(took <= COST * made.max(1) as u64, "{took} cycles for {made} steps");
    }
}
