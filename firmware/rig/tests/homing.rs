//! Homing in a program of a user's own: fast to the switch, slowly off it, and from there to a
//! position.

use stepwright_rig::board::HZ;
use stepwright_rig::edges::{Needs, check, steps_of};
use stepwright_rig::{Chip, firmware};

use crate::common::board;

/// The place of the switch, in steps from the start.
const SWITCH: i64 = -300;

#[test]
fn an_axis_finds_0_by_its_switch() {
    let image = firmware::load(&format!("{}-homing", board().name()))
        .unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(board(), &image);
    let place = |chip: &Chip| steps_of(chip.edges(), 0).last().map_or(0, |step| step.position);
    let (mut deepest, mut now) = (0, 0);
    // A millisecond at a time, a step at most at 1,000 steps/s.
    for _ in 0..4_000 {
        chip.run_for(HZ / 1_000);
        now = place(&chip);
        deepest = deepest.min(now);
        chip.press(0, now <= SWITCH);
    }
    assert_eq!(check(chip.edges(), Needs::DEFAULT), Ok(()));
    // Brakes from 1,000 steps/s at 10,000 steps/s² take 50 steps, after 16 ms that are planned.
    assert!((SWITCH - 70..SWITCH - 45).contains(&deepest), "{deepest}");
    // 0 is where it came to rest behind the edge, some steps off it: 500 from there.
    let zero = now - 500;
    assert!((SWITCH + 1..SWITCH + 5).contains(&zero), "{zero}");
}
