//! Document 003's basic example on the chip: its 21 lines, and its edges.

mod common;

use common::{board, steps};
use stepwright_rig::edges::{Needs, check};
use stepwright_rig::{Chip, firmware};

/// The positions of a line, in steps.
fn positions(line: &str) -> Vec<i64> {
    let parts = line.split(", ").map(|part| part.split_once(".pos=").unwrap().1);
    parts.map(|at| at.parse::<i64>().unwrap() / 7_500).collect()
}

#[test]
fn the_example_prints_its_lines() {
    let board = board();
    let image =
        firmware::load(&format!("{board}-cycle")).unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(board, &image);
    chip.run_for(21 * 16_000_000);
    let text = String::from_utf8(chip.take_said()).expect("no ASCII");
    let lines: Vec<_> = text.lines().filter(|line| line.starts_with("X.pos=")).collect();
    assert_eq!(lines.len(), 21, "{text}");
    for pair in lines.windows(2) {
        let made = positions(pair[1])[0] - positions(pair[0])[0];
        assert!((999..=1_001).contains(&made), "{pair:?}");
    }
    assert_eq!(lines[20], "X.pos=150000000, Y.pos=75000000, Z.pos=7500000");

    // The same from the edges alone: Y and Z are the other way round.
    check(chip.edges(), Needs::DEFAULT).unwrap();
    for (axis, delay, count, last) in
        [(0, 1_000, 20_000, 20_000), (1, 2_000, 10_000, -10_000), (2, 20_000, 1_000, -1_000)]
    {
        let steps = steps(&chip, axis);
        assert_eq!(steps.len(), count);
        assert_eq!(steps[count - 1].position, last);
        for (n, step) in (0i64..).zip(&steps) {
            let off = (step.time - steps[0].time) as i64 - n * delay * 16;
            assert!(off.abs() <= 1_500, "step {n} of axis {axis} is {off} cycles off");
        }
    }
}
