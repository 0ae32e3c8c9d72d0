//! The end of the longest travels, 2³¹ − 1 steps forward and 2³¹ backward.
//!
//! At 1000 steps/s it takes 25 days, so its middle is left out: in the chip's RAM the steps still
//! to be planned, in the planner and in its motor, are reduced by some number, and the axis's count
//! of steps made is increased by it. Before and after that the binary runs unmodified, and each
//! step is checked.

use crate::common::{FIT, LATENCY, chip, follows, image, path_of_accel, rest, say, steps, talk};
use stepwright_rig::Chip;

/// The longest travel in a direction.
fn longest(sign: char) -> u64 {
    if sign == '-' { 1 << 31 } else { (1 << 31) - 1 }
}
/// The steps of the rise from 0 to 1000 steps/s at 2500 steps/s², and of the fall.
const RAMP: u64 = 200;
/// The offset of the first axis's count of steps in the state of the interrupts (`step.rs`), and
/// its bytes.
const LOADED: u16 = 27;
const COUNT: u16 = 5;
/// More than is planned ahead at 1000 steps/s: 16 ms and a run of 8 ms.
const AHEAD: u64 = 30;

/// Begins the travel in the direction `sign`, and leaves out all but `left` of its cruise, from the
/// middle on. Returns the number of steps left out.
#[track_caller]
fn leave_out(chip: &mut Chip, sign: char, left: u64) -> u64 {
    say(chip, &format!("PO s0 t1000 a2500 d2500 G{sign}{} E", longest(sign)));
    // From the first pulse on: one interval fewer than there are pulses.
    let all = longest(sign) - 1 - 2 * RAMP;
    chip.run_for(16_000_000 * 7 / 10);
    // Not while it plans, or makes a step.
    let image = image();
    let plan = image.functions(&["9main_loop4plan"]).next().expect("a main loop").address;
    assert!(chip.run_to(16_000_000, |chip| chip.pc() == plan), "it never plans");
    let made = steps(chip, 0).len() as u64;
    assert!((400..600).contains(&made), "{made} steps");

    let planned = made - RAMP..made + AHEAD - RAMP;
    let device = image.variable("5slave6DEVICE");
    let (place, level) = only(chip, device, 4, all - planned.end..all - planned.start);
    let skipped = level - left;
    poke(chip, place, 4, left);
    // The motor counts the fall too: `Motor::left`.
    let whole = level + RAMP;
    let (place, _) = only(chip, device, 4, whole..whole + 1);
    poke(chip, place, 4, left + RAMP);
    // Includes the groups that are playing and ready: not before the edges.
    let place = image.variable("4step8STEPPERS").0 + LOADED;
    let count = (0..COUNT).rev().fold(0, |n, k| n << 8 | u64::from(chip.byte(place + k)));
    assert!((made..made + AHEAD).contains(&count), "{count} of {made}");
    poke(chip, place, COUNT, count + skipped);
    skipped
}

/// The only number of this many bytes in a static that lies in `range`: its address and its value.
#[track_caller]
fn only(
    chip: &Chip,
    (begin, size): (u16, u16),
    bytes: u16,
    range: std::ops::Range<u64>,
) -> (u16, u64) {
    let number = |place: u16| {
        (0..bytes).rev().fold(0, |number, n| number << 8 | u64::from(chip.byte(place + n)))
    };
    let places = begin..=begin + size - bytes;
    let found: Vec<_> =
        places.map(|place| (place, number(place))).filter(|(_, n)| range.contains(n)).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    found[0]
}

fn poke(chip: &mut Chip, place: u16, bytes: u16, number: u64) {
    for n in 0..bytes {
        chip.set_byte(place + n, (number >> (8 * n)) as u8);
    }
}

#[test]
fn it_ends_exactly_and_counts_beyond() {
    for (sign, one) in [('+', 1), ('-', -1i64)] {
        let mut chip = chip();
        let skipped = leave_out(&mut chip, sign, 1_500);
        assert!(chip.run_to_silence(4_000_000, 16_000_000 * 10));
        let made = longest(sign) - skipped;
        // As a travel of this many steps.
        let path = path_of_accel(0, 1_000, 2_500, made as u32);
        follows(&steps(&chip, 0), &path, FIT + LATENCY);
        assert_eq!(steps(&chip, 0).last().unwrap().position, one * made as i64);
        rest(&mut chip);
        let end = one * longest(sign) as i64;
        chip.expect("V1", &end.to_string());
        assert!(chip.ask("?").unwrap().contains(" late=0 "));
        // Further on, and back.
        say(&mut chip, &format!("PO G{sign}5 E"));
        rest(&mut chip);
        chip.expect("V1", &(end + one * 5).to_string());
        say(&mut chip, &format!("PO G{}12 E", if sign == '+' { '-' } else { '+' }));
        rest(&mut chip);
        chip.expect("V1", &(end - one * 7).to_string());
    }
}

#[test]
fn the_position_on_its_way_to_the_end_is_the_edges() {
    let mut chip = chip();
    let skipped = leave_out(&mut chip, '+', 700);
    let here = |chip: &Chip| skipped + steps(chip, 0).len() as u64;
    for _ in 0..25 {
        chip.run_for(640_000);
        let before = here(&chip);
        let said: u64 = chip.ask("V1").unwrap().parse().unwrap();
        assert!((before..=here(&chip)).contains(&said), "{said} is not from {before} on");
    }
    rest(&mut chip);
    chip.expect("V1", "2147483647");
}

#[test]
fn it_brakes_near_its_end() {
    // So near that braking saves only a few of the steps.
    for left in [400, 100, 10] {
        let mut chip = chip();
        let skipped = leave_out(&mut chip, '+', left);
        say(&mut chip, "Z");
        let before = steps(&chip, 0).len() as u64;
        rest(&mut chip);
        let steps = steps(&chip, 0);
        let after = steps.len() as u64 - before;
        assert!((RAMP..=RAMP + AHEAD).contains(&after), "{after} steps to rest");
        let position = skipped + steps.len() as u64;
        assert!(position < longest('+'), "{left}: it has not braked");
        chip.expect("V1", &position.to_string());
        // The last interval is that of the ramp: √(2/2500) s.
        let last = steps[steps.len() - 1].time - steps[steps.len() - 2].time;
        assert!(last.abs_diff(452_548) < (FIT + LATENCY) as u64, "{last} cycles");
        assert!(chip.ask("?").unwrap().contains(" late=0 "));
    }
}

#[test]
fn where_it_brakes_anyhow_it_goes_to_its_end() {
    let mut chip = chip();
    leave_out(&mut chip, '-', 50);
    chip.run_for(16_000_000 / 4);
    talk(&mut chip, "F B\nZ Y\n*rest\nV1 -2147483648");
    assert!(chip.ask("?").unwrap().contains(" late=0 "));
}
