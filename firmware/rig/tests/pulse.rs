//! Pulses of every width at the highest admitted rates.
//!
//! The time for a step depends on its pulse: the board's description says so, and rates that it
//! admits are kept.

use crate::common::{MINUTE, board, chip, say};
use stepwright_rig::Chip;
use stepwright_rig::edges::{Needs, check, position_of};
use stepwright_sim::Description;

/// The widest and the narrowest pulse that can be set, in µs, and those on both sides of the
/// assembly's own pulse.
const WIDTHS: [u64; 5] = [1, 2, 3, 5, 20];
/// Steps/s² of all ramps.
const ACCEL: u32 = 40_000;
/// Steps at the top speed.
const LEVEL: u32 = 3_000;
/// The highest speed that can be ordered.
const FASTEST: u32 = 200_000;

/// A chip with pulses of this width, and a `max-speed` that is no limit.
fn with_pulse(micros: u64) -> Chip {
    let mut chip = chip();
    say(&mut chip, &format!("$max-speed={FASTEST} $pulse-us={micros}"));
    chip
}

/// Orders ramps to these speeds, the first axis's first. Returns whether they are admitted.
fn order(chip: &mut Chip, speeds: &[u32]) -> bool {
    say(chip, "PO");
    for (n, &top) in speeds.iter().enumerate() {
        let steps = length(top);
        say(chip, &format!("A{} s0 t{top} a{ACCEL} d{ACCEL} G+{steps}", n + 1));
    }
    match chip.ask("E").as_deref() {
        Some("Y") => true,
        Some("E") => {
            let health = chip.ask("?").unwrap();
            assert!(health.contains("too-fast"), "{health}");
            false
        }
        other => panic!("E was answered {other:?}"),
    }
}

fn length(top: u32) -> u32 {
    (u64::from(top) * u64::from(top) / u64::from(ACCEL)) as u32 + LEVEL
}

/// Speeds that differ by 0.3 %, so that the steps meet in every phase.
fn speeds(axes: u32, top: u32) -> Vec<u32> {
    (0..axes).map(|n| top - top * 3 * n / 1000).collect()
}

/// The speeds of the highest rate at which they are admitted: everything above it is refused.
fn highest(micros: u64, speeds: impl Fn(u32) -> Vec<u32>) -> Vec<u32> {
    let (mut low, mut high) = (500, FASTEST);
    while high - low > 1 {
        let middle = (low + high) / 2;
        // A fresh chip, because an admitted order moves.
        let mut chip = with_pulse(micros);
        if order(&mut chip, &speeds(middle)) { low = middle } else { high = middle }
    }
    speeds(low)
}

/// Plays it while the line is queried without a pause. Returns the late steps that the board
/// counts.
fn late(micros: u64, speeds: &[u32]) -> u32 {
    let mut chip = with_pulse(micros);
    assert!(order(&mut chip, speeds), "{speeds:?} are not admitted");
    chip.poll(&["V1", "F"]);
    // All of its time except the end of the last fall.
    let time = |&top: &u32| f64::from(length(top)) / f64::from(top) + f64::from(top) / 40e3;
    let longest = speeds.iter().map(time).fold(0.0, f64::max);
    chip.run_for((longest * 16e6) as u64);
    chip.poll(&[]);
    chip.run_for(1_000_000);
    assert!(chip.run_to_rest(MINUTE));
    check(chip.edges(), Needs { pulse: 16 * micros, ..Needs::DEFAULT }).unwrap();
    for (n, &top) in speeds.iter().enumerate() {
        assert_eq!(position_of(chip.edges(), n as u8), i64::from(length(top)));
    }
    assert_eq!(chip.lost(), 0, "bytes");
    let health = chip.ask("?").unwrap();
    let late = health.split(" late=").nth(1).unwrap().split(' ').next().unwrap();
    late.parse().unwrap()
}

/// The virtual board has the chip's costs: it refuses what the chip refuses.
#[test]
fn what_is_admitted_is_what_the_virtual_board_admits() {
    let cost = Description::uno().board.cost;
    for (micros, costs) in [(2, cost.ticks), (3, cost.longer)] {
        for (axes, cost) in (1..=3).zip(costs) {
            let highest = 16_000_000 / (cost * axes as u32);
            for (top, admitted) in [(highest, true), (highest + 1, false)] {
                let is = order(&mut with_pulse(micros), &vec![top; axes]);
                assert_eq!(is, admitted, "{} x {axes}, {micros} µs, {top} steps/s", board());
            }
        }
    }
}

#[test]
fn no_step_is_late_at_the_highest_rate_admitted() {
    for micros in WIDTHS {
        for axes in 1..=3 {
            let speeds = highest(micros, |top| speeds(axes, top));
            let late = late(micros, &speeds);
            assert_eq!(late, 0, "{} with {micros} µs at {speeds:?} steps/s", board());
        }
    }
}

/// The sum of the rates is what is admitted, and the fastest axis leaves time for a step of the
/// other.
#[test]
fn no_step_is_late_where_two_axes_share_unequally() {
    for shares in [[95, 5], [80, 20], [65, 35]] {
        let speeds = highest(2, |all| shares.map(|share| all / 100 * share).to_vec());
        let late = late(2, &speeds);
        assert_eq!(late, 0, "{} at {speeds:?} steps/s", board());
    }
}
