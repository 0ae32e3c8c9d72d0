//! What guards a machine on a board that can `safety`: safe start, homing first and
//! errors that stay.

mod common;

use common::{Bench, say, talk};
use stepwright_protocol::{Refusal, Slave, Stop};

// ---- Errors ----

#[test]
fn errors_stay_until_they_are_acknowledged() {
    talk(
        "?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 errors=-
         g+      Y  -> start 1 50-1000 R200 R200 forward
         *silent 1
         *switch 1
         *arrive 1
         g-      Y  -> start 1 50-1000 R200 R200 backward
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=--- errors=ST
         Z       Y  -> brake 1
         *late   2
         ?       stepwright 0.1 axes=3 max=120000 late=2 refused=0 last=none uncertain=0 stop=Z-- errors=STl
         K       Y  -> kill
         ?       stepwright 0.1 axes=3 max=120000 late=2 refused=0 last=none uncertain=1 stop=K-- errors=STKl
         !       Y  -> clear
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=1 stop=--- errors=-
         G+5*00  E*DC
         x       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=2 last=line uncertain=1 errors=c",
    );
}

#[test]
fn a_damaged_byte_and_every_stop_is_an_error() {
    let (mut slave, mut bench) = (Slave::<1>::new(), Bench::new(1));
    slave.garbled();
    say(&mut slave, &mut bench, b"");
    assert!(say(&mut slave, &mut bench, b"?").contains(" errors=g "));
    for reason in [Stop::Reset, Stop::Driver, Stop::Emergency, Stop::Brake, Stop::Limit] {
        slave.stopped(1, reason);
    }
    assert!(say(&mut slave, &mut bench, b"?").contains(" errors=EDRg "));
}

// ---- Safe start ----

/// A row that stops axis 1 in motion, and the letter of it.
const STOPS: [(&str, bool); 4] =
    [("*switch 1", true), ("*silent 1", true), ("K Y -> kill", true), ("Z Y -> brake 1", false)];

#[test]
fn a_safe_start_wants_a_stop_acknowledged() {
    for (stop, locks) in STOPS {
        for setting in [0, 1] {
            let told = if setting == 1 { "-> safe-start=1" } else { "" };
            let refused = locks && setting == 1;
            let (go, change) = if refused {
                ("g- E\nPO Y\nG+5 Y\nE E", "@+7 E\n@-7 E")
            } else {
                ("PO Y\nG+5 Y\nE Y -> start 1 50-1000 R200 R200 +5", "@+7 Y -> change 1: @+7")
            };
            // K has ended the travel, so there is none to change.
            let change = if stop.starts_with('K') { "@+7 E" } else { change };
            talk(&format!(
                "$safe-start={setting} Y {told}
                 g+ Y -> start 1 50-1000 R200 R200 forward
                 {stop}
                 {change}
                 *arrive 1
                 {go}
                 *arrive 1
                 ! Y -> clear
                 PO Y
                 G-5 Y
                 E Y -> start 1 50-1000 R200 R200 -5"
            ));
        }
    }
}

#[test]
fn a_safe_start_names_its_reason_and_leaves_all_but_motion() {
    talk(
        "$safe-start=1 Y -> safe-start=1
         K       Y  -> kill
         g+      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=stopped uncertain=0 stop=--- errors=K
         T50     Y
         A2      Y
         g+      E
         I1      Y  -> zero 1
         V1      0
         F       R
         Z       Y
         $safe-start=0 Y -> safe-start=0
         g+      Y  -> start 2 50-1000 R200 R200 forward",
    );
}

#[test]
fn a_reset_locks_a_board_that_starts_safely() {
    let (mut slave, mut bench) = (Slave::<1>::new(), Bench::new(1));
    slave.stopped(1, Stop::Reset);
    assert_eq!(say(&mut slave, &mut bench, b"$safe-start=1"), "Y");
    assert_eq!(say(&mut slave, &mut bench, b"g+"), "E");
    assert_eq!(say(&mut slave, &mut bench, b"!"), "Y");
    assert_eq!(say(&mut slave, &mut bench, b"g+"), "Y");
}

// ---- Homing first ----

#[test]
fn a_target_wants_a_known_position_where_homing_comes_first() {
    talk(
        "$home-first=1 Y -> home-first=1
         PO      Y
         G+5     Y
         E       Y  -> start 1 50-1000 R200 R200 +5
         K       Y  -> kill
         PO      Y
         G-5     Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=uncertain uncertain=1
         PO      Y
         G+0     Y
         E       E
         A2      Y
         PO      Y
         A2      Y
         G+5     Y
         E       Y  -> start 2 50-1000 R200 R200 +5
         *arrive 2
         PO      Y
         A0      Y
         G+5     Y
         E       E
         A1      Y
         PO      Y
         g-      Y
         E       Y  -> start 1 50-1000 R200 R200 backward
         @-7     E
         t300    Y  -> change 1: t300
         *arrive 1
         I1      Y  -> zero 1
         PO      Y
         G+5     Y
         E       Y  -> start 1 50-300 R200 R200 +5
         @+7     Y  -> change 1: @+7",
    );
}

#[test]
fn without_the_setting_an_unknown_position_is_no_hindrance() {
    talk(
        "g+      Y  -> start 1 50-1000 R200 R200 forward
         K       Y  -> kill
         PO      Y
         G-5     Y
         E       Y  -> start 1 50-1000 R200 R200 -5
         @+7     Y  -> change 1: @+7",
    );
}

#[test]
fn the_words_are_read_by_a_host() {
    assert_eq!(Refusal::named(b"stopped"), Refusal::Stopped);
}
