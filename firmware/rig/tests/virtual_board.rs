//! The same orders on the virtual board: edge against edge.
//!
//! Engine, planner and slave are the same code, so the deadlines agree tick for tick, relative to
//! the start of the travel: a board needs time for a line, the virtual one none. The remaining
//! difference between the edges is the chip's latency: the first step's own shifts all others the
//! other way.

use crate::common::{BESIDE, LATENCY, chip, rest, say, steps};
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

/// The steps of axis `axis` on a virtual Uno that gets `lines`.
fn virtual_steps(lines: &str, axis: u8) -> Vec<u64> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    for line in lines.split_whitespace() {
        line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
    }
    board.run_to_rest();
    let edges = board.recorder().iter();
    edges.filter(|edge| edge.axis == axis && edge.is_step()).map(|edge| edge.time).collect()
}

#[test]
fn every_edge_is_the_virtual_boards() {
    for order in [
        "PO S5 T100 R200 G+1000 E",
        "PO s0 t9000 a30000 d15000 G-7000 E",
        "PO s0 t300 a100 d200 G+90 E",
        "PO s0 t20000 a40000 d40000 G+20000 E",
    ] {
        let mut chip = chip();
        say(&mut chip, order);
        assert!(chip.run_to_silence(8_000_000, 16_000_000 * 30));
        let (real, ideal) = (steps(&chip, 0), virtual_steps(order, 0));
        assert_eq!(real.len(), ideal.len(), "{order}");
        let off = |n: usize| (real[n].time - real[0].time) as i64 - (ideal[n] - ideal[0]) as i64;
        let worst = (0..real.len()).max_by_key(|&n| off(n).abs()).unwrap();
        assert!(off(worst).abs() <= LATENCY, "{order}: step {worst} is {} off", off(worst));
        // No drift: the difference is latency, not time. Slow steps take a longer path than fast
        // ones and the first, so the earliest of either end are compared.
        let quarter = real.len() / 4;
        let begin = (1..quarter).map(off).min().unwrap();
        let end = (real.len() - quarter..real.len()).map(off).min().unwrap();
        assert!((end - begin).abs() <= LATENCY / 4, "{order}: {begin} at first, {end} at last");
        rest(&mut chip);
    }
}

#[test]
fn three_axes_are_the_virtual_boards() {
    let order = "PO T90 G+900 A2 T70 G-600 A3 T50 G+300 E";
    let mut chip = chip();
    say(&mut chip, order);
    assert!(chip.run_to_silence(4_000_000, 16_000_000 * 20));
    // All three are late for their first step, which coincides.
    let begin = steps(&chip, 0)[0].time;
    let ideal_begin = virtual_steps(order, 0)[0];
    for axis in 0..3 {
        let (real, ideal) = (steps(&chip, axis), virtual_steps(order, axis));
        assert_eq!(real.len(), ideal.len());
        for (n, (real, ideal)) in real.iter().zip(&ideal).enumerate() {
            let off = (real.time - begin) as i64 - (ideal - ideal_begin) as i64;
            assert!(off.abs() <= BESIDE, "step {n} of axis {axis} is {off} off at {}", real.time);
        }
    }
}
