//! Compares edges of the pins with the virtual board's.
//!
//! Engine, planner and slave are the same code, so the deadlines agree tick for tick, relative to
//! the start of the travel. The differences come from the interrupt's entry, and from other axes'
//! steps.

use stepwright::late_after;
use stepwright_qemu::boards::CONTROLLERS;
use stepwright_qemu::{Machine, Pace, Simulated, machine, virtual_board};

/// Ticks between an edge of one axis and the virtual board's; half of the edges are early, half
/// late. For a counter faster than 16 MHz, the same time.
const ALONE: f64 = 10.0;
/// Instructions between them when two other axes move: a visit steps up to three of them, and takes
/// entries for them.
const BESIDE: f64 = 1_000.0;

/// The ticks of a board in which it executes these instructions.
fn ticks(board: &Simulated, instructions: f64) -> f64 {
    instructions * Pace::Quick.micros() * board.mhz()
}

/// One order on both boards: for each axis the times of its steps, relative to the first of axis 1,
/// on the chip and on the virtual board.
fn both(board: &Simulated, order: &str, pace: Pace) -> Vec<(Vec<f64>, Vec<f64>)> {
    let mut chip = Machine::start(board, "controller", pace).unwrap();
    for line in order.split_whitespace() {
        let answer = chip.ask(line).unwrap();
        assert_eq!(answer, "Y", "{line} of {order}: {}", chip.ask("?").unwrap());
    }
    chip.rest().unwrap();
    let health = chip.ask("?").unwrap();
    assert!(health.contains(" late=0 "), "{order}: {health}");
    let real = chip.end().unwrap();
    let ideal = virtual_board::with(board, |board| {
        for line in order.split_whitespace() {
            assert_eq!(virtual_board::ask(board, line), "Y", "{line}");
        }
        board.run_to_rest();
        board.recorder().clone()
    });
    let real: Vec<_> = (0..3).map(|axis| machine::steps(&real, axis)).collect();
    let ideal: Vec<_> = (0..3).map(|axis| virtual_board::steps(&ideal, axis)).collect();
    let mut off = Vec::new();
    for (real, ideal) in real.iter().zip(&ideal) {
        assert_eq!(real.len(), ideal.len(), "{order}");
        off.extend(real.iter().zip(ideal).map(|(real, ideal)| real - *ideal as f64));
    }
    off.sort_by(f64::total_cmp);
    let (begin, median) = (ideal[0][0] as f64, off[off.len() / 2]);
    let seen = |(real, ideal): (&Vec<f64>, &Vec<u64>)| {
        let real = real.iter().map(|time| time - median - begin).collect();
        (real, ideal.iter().map(|time| *time as f64 - begin).collect())
    };
    real.iter().zip(&ideal).map(seen).collect()
}

/// The largest distance of two edges.
fn worst(axes: &[(Vec<f64>, Vec<f64>)]) -> f64 {
    let pairs = axes.iter().flat_map(|(real, ideal)| real.iter().zip(ideal));
    // The counter is read in whole ticks.
    pairs.map(|(real, ideal)| (real - ideal).abs().round()).fold(0.0, f64::max)
}

#[test]
fn one_axis_is_the_virtual_boards() {
    for board in CONTROLLERS {
        for order in [
            "PO S5 T100 R200 G+1000 E",
            "PO s0 t9000 a30000 d15000 G-3000 E",
            "PO s0 t300 a100 d200 G+90 E",
            "PO s0 t4000 a3000 d3000 j20000 G+6000 E",
        ] {
            let off = worst(&both(board, order, Pace::Quick));
            println!("{}, {order}: {off:.1} ticks", board.name);
            let most = ALONE * (board.mhz() / 16.0).max(1.0);
            assert!(off <= most, "{}, {order}: {off} ticks", board.name);
        }
    }
}

#[test]
fn three_axes_are_the_virtual_boards() {
    for board in CONTROLLERS {
        let order = "PO T90 G+900 A2 T70 G-600 A3 T50 G+300 E";
        let off = worst(&both(board, order, Pace::Quick));
        println!("{}, {order}: {off:.1} ticks", board.name);
        assert!(off <= ticks(board, BESIDE), "{}: {off} ticks", board.name);
    }
}

/// At the pace of the chip, as fast and nearly as steep as its description allows: neither the
/// board nor the rule counts a late step.
#[test]
fn no_step_is_late_at_the_chips_pace() {
    for board in CONTROLLERS {
        for (moving, accel) in [(1, 100_000), (2, 25_000), (3, 9_000)] {
            none_is_late(board, moving, accel);
        }
    }
}

fn none_is_late(board: &Simulated, moving: usize, accel: u32) {
    let rate = board.board.rate;
    let max = rate.hz() / board.board.cost.ticks[moving - 1] / moving as u32;
    let order = |axis: usize| {
        let top = max - axis as u32;
        format!("A{} s0 t{top} a{accel} d{accel} G+7000", axis + 1)
    };
    let axes: Vec<_> = (0..moving).map(order).collect();
    let axes = both(board, &format!("PO {} E", axes.join(" ")), Pace::Chip);
    let off = worst(&axes);
    println!("{}, {moving} axes at {max} steps/s: {off:.1} ticks", board.name);
    for (real, ideal) in &axes[..moving] {
        for n in 1..real.len() {
            let interval = ideal[n] - ideal[n - 1];
            let off = real[n] - ideal[n];
            let most = f64::from(late_after(interval as u32, rate));
            assert!(off <= most, "step {n} of {moving} axes: {off} of {most} ticks");
        }
    }
}
