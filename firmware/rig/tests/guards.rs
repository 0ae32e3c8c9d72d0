//! The protections of a machine: the lease, soft limits, homing first, safe start, drivers off
//! after a kill, switches that bounce.

use crate::common::{chip, rest, say, steps, talk};
use stepwright_rig::Chip;

/// The cycles of a millisecond.
const MS: u64 = 16_000;

/// A fresh board with these settings.
fn guarded(settings: &str) -> Chip {
    let mut chip = chip();
    say(&mut chip, settings);
    chip
}

/// The cycle of an axis's last step.
fn last(chip: &Chip, axis: u8) -> u64 {
    steps(chip, axis).last().unwrap().time
}

#[test]
fn a_lease_brakes_along_the_ramp_once_the_line_is_silent() {
    let mut chip = guarded("L300 S10 T100 R100 g+");
    for _ in 0..8 {
        chip.run_for(280 * MS);
        chip.expect("F", "B");
    }
    let silent = chip.now();
    let cruise = steps(&chip, 0).len();
    // In silence, because querying the state would be a line.
    chip.run_for(700 * MS);
    rest(&mut chip);
    let made = &steps(&chip, 0)[cruise..];
    let interval = |n: usize| made[n].time - made[n - 1].time;
    // 300 ms at 1000 steps/s, then a ramp of 100 steps down to 100 steps/s, of which the first few
    // are hardly slower.
    let slower = (1..made.len()).position(|n| interval(n) > 16_000 + 300).unwrap();
    let after = made[slower].time - silent;
    assert!((299 * MS..340 * MS).contains(&after), "it brakes after {after} cycles");
    assert!((95..=100).contains(&(made.len() - slower)), "{} steps", made.len() - slower);
    assert!(interval(made.len() - 1) > 130_000, "its last interval");
    let all = steps(&chip, 0).len();
    talk(&mut chip, &format!("V1 {all}\n? * uncertain=0 stop=T-- errors=T *"));
}

#[test]
fn soft_limits_end_a_run_at_the_step_and_refuse_what_lies_beyond() {
    let mut chip = guarded("$soft-limits=1 $ahead-x=400 $behind-x=50");
    talk(
        &mut chip,
        "PO Y
         G+401 Y
         E E
         ? * last=limit *
         PO Y
         G-51 Y
         E E
         S10 Y
         T80 Y
         R60 Y",
    );
    assert!(steps(&chip, 0).is_empty(), "a refused order moves");
    talk(&mut chip, "PO Y\ng+ Y\nE Y\n*rest");
    assert_eq!(steps(&chip, 0).len(), 400);
    talk(&mut chip, "V1 400\n? * uncertain=0 stop=L-- *\ng+ E\nPO Y\nG-450 Y\nE Y");
    rest(&mut chip);
    assert_eq!(steps(&chip, 0).len(), 850);
    talk(&mut chip, "V1 -50\ng- E\n? * last=limit *");
    // A kill makes the position unknown, and then only g is allowed.
    talk(&mut chip, "g+ Y\n*wait 200\nK Y\nPO Y\nG+5 Y\nE E\n? * last=uncertain *");
    // 450 steps back would be the limit.
    talk(&mut chip, "PO Y\ng- Y\nE Y\n*wait 1500\nF B");
    assert!(steps(&chip, 0).len() > 850 + 600);
}

/// One board for all checks before motion, and for the drivers after a kill.
#[test]
fn after_a_kill_the_drivers_are_off_and_nothing_starts_before_it_is_acknowledged() {
    let mut chip = guarded("$safe-start=1 $home-first=1 $kill-off=1 $enable-ms=30 S50 T200 g+");
    chip.run_for(500 * MS);
    let enabled = |chip: &Chip| chip.enable_changes().last().map(|change| !change.1);
    assert_eq!(enabled(&chip), Some(true), "a low level switches the drivers on");
    chip.expect("K", "Y");
    let killed = chip.now();
    chip.run_for(10 * MS);
    assert_eq!(enabled(&chip), Some(false));
    let off = chip.enable_changes().last().unwrap().0;
    assert!(off <= killed && killed - off < 2 * MS, "off {} cycles before its Y", killed - off);
    assert!(last(&chip, 0) <= off, "a step without a driver");
    let made = steps(&chip, 0).len();

    // safe-start: no order before `!`.
    talk(
        &mut chip,
        "g+ E
         ? * last=stopped uncertain=1 stop=K-- errors=K *
         A2 Y
         PO Y
         A2 Y
         G+5 Y
         E E
         I2 Y
         A1 Y
         ! Y",
    );
    // home-first: then no target before the position is known; g is allowed.
    talk(&mut chip, "PO Y\nG+5 Y\nE E\n? * last=uncertain *");
    chip.run_for(100 * MS);
    assert_eq!((steps(&chip, 0).len(), enabled(&chip)), (made, Some(false)), "it moves");
    talk(&mut chip, "PO Y\ng- Y\nE Y\n*wait 200");
    let on = chip.enable_changes().last().unwrap();
    assert!(!on.1, "the next order switches them on");
    let lead = steps(&chip, 0)[made].time - on.0;
    assert!((30 * MS..33 * MS).contains(&lead), "the first step comes after {lead} cycles");
    talk(&mut chip, "Z Y\n*rest\nI1 Y\nPO Y\nG+5 Y\nE Y\n*rest\nV1 5");
}

/// The contact opens and closes for 10 ms each time it moves. The axis stops at the first contact,
/// and no order towards the switch is accepted while it bounces.
#[test]
fn a_bouncing_switch_stops_at_once_and_is_open_when_it_has_been_open_long_enough() {
    let mut chip = guarded("$switches=1 $switch-forward=1 S50 T200 g+");
    chip.run_for(500 * MS);
    chip.press(0, true);
    let pressed = chip.now();
    for n in 1..8 {
        chip.run_for(n * MS / 3);
        chip.press(0, n % 2 == 0);
        if n > 3 {
            talk(&mut chip, "PO Y\nG+5 Y\nE E\n? * last=fault *");
        }
    }
    chip.press(0, true);
    chip.run_for(50 * MS);
    assert!(last(&chip, 0) <= pressed + 2 * MS, "{} cycles late", last(&chip, 0) - pressed);
    let made = steps(&chip, 0).len();
    let count = made.to_string();
    talk(&mut chip, &format!("V1 {count}\nPO Y\nG+5 Y\nE E"));
    // The contact opens: for 25 ms by default it counts as closed, and the direction away from it
    // is free.
    chip.press(0, false);
    let opened = chip.now();
    while chip.now() < opened + 23 * MS {
        talk(&mut chip, "PO Y\nG+5 Y\nE E");
    }
    assert_eq!(steps(&chip, 0).len(), made);
    chip.run_until(opened + 28 * MS);
    talk(&mut chip, "PO Y\nG+5 Y\nE Y\n*rest");
    assert_eq!(steps(&chip, 0).len(), made + 5);
}
