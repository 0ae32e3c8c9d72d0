//! Limit switches: they stop their axis at once, and the position stays known.

use crate::common::{chip, rest, say, steps, talk};

/// A switch is sampled every millisecond, and the queues are cleared: cycles from the contact to
/// the last step.
const AT_ONCE: u64 = 2 * 16_000;

#[test]
fn a_pressed_switch_stops_its_axis_and_travel_towards_it_is_refused() {
    let mut chip = chip();
    say(&mut chip, "$switches=1 $switch-forward=1 PO T200 G+3000 A2 T100 G+700 E");
    chip.run_for(10_000_000);
    talk(&mut chip, "? * closed=0");
    chip.press(0, true);
    let pressed = chip.now();
    chip.run_for(4_000_000);
    let x = steps(&chip, 0);
    let (count, last) = (x.len() as i64, x.last().unwrap().time);
    assert!(last <= pressed + AT_ONCE, "{} cycles late", last - pressed);
    assert!(count < 3000);
    // The other axis continues to its end.
    say(&mut chip, "A0");
    rest(&mut chip);
    assert_eq!(steps(&chip, 1).len(), 700);
    chip.expect("V2", "700");
    chip.expect("V1", &count.to_string());
    talk(&mut chip, "A1 Y\nI1 Y\nPO Y\nG+5 Y\nE E\n? stepwright * uncertain=0* closed=1");
    // Motion away from it is allowed, pressed or not.
    talk(&mut chip, "PO Y\nG-5 Y\nE Y\n*rest\nV1 -5");
    chip.press(0, false);
    talk(&mut chip, "? * closed=0");
    talk(&mut chip, "*wait 50\nPO Y\nG+5 Y\nE Y\n*rest\nV1 0");
}

#[test]
fn an_open_switch_or_one_that_is_not_set_up_does_nothing() {
    let mut chip = chip();
    chip.press(1, true);
    say(&mut chip, "$switches=1 PO T100 G+200 A2 T100 G-200 E A0");
    rest(&mut chip);
    chip.expect("V1", "200");
    chip.expect("V2", "-200");
}

#[test]
fn a_switch_that_bounces_stops_once_and_for_all() {
    let mut chip = chip();
    say(&mut chip, "$switches=1 $switch-forward=1 T100 g+");
    chip.run_for(8_000_000);
    for n in 0..20 {
        chip.press(0, n % 2 == 0);
        chip.run_for(16_000 + 3_000 * n);
    }
    let count = steps(&chip, 0).len();
    chip.run_for(4_000_000);
    assert_eq!(steps(&chip, 0).len(), count, "it goes on");
    chip.expect("F", "R");
}
