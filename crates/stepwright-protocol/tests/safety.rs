//! The protection of a machine on a board that can `safety`: safe start, homing first, soft limits
//! and persistent errors.

use crate::common::{Bench, say, talk};
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
         Z       Y  -> stop 1
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
    for reason in [Stop::Reset, Stop::Driver, Stop::Emergency, Stop::Soft, Stop::Limit] {
        slave.stopped(1, reason);
    }
    assert!(say(&mut slave, &mut bench, b"?").contains(" errors=EDRg "));
}

// ---- Safe start ----

/// The rows that stop axis 1 in motion, and their letters.
const STOPS: [(&str, bool); 4] =
    [("*switch 1", true), ("*silent 1", true), ("K Y -> kill", true), ("Z Y -> stop 1", false)];

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

// ---- Soft limits ----

/// Axis 1 from −100 to 1000, axis 2 from 0 to 50, axis 3 without limits.
const LIMITS: &str = "$soft-limits=3 Y -> soft-limits=3
    $ahead-x=1000 Y -> ahead-x=1000
    $behind-x=100 Y -> behind-x=100
    $ahead-y=50 Y -> ahead-y=50\n";

fn limited(table: &str) {
    talk(&format!("{LIMITS}{table}"));
}

#[test]
fn a_travel_may_end_on_a_soft_limit_and_not_beyond() {
    for (steps, fits) in [("+1000", true), ("+1001", false), ("-100", true), ("-101", false)] {
        let answer = match fits {
            true => format!("Y -> start 1 50-1000 R200 R200 {steps}"),
            false => "E".to_owned(),
        };
        limited(&format!("PO Y\nG{steps} Y\nE {answer}"));
    }
    limited(
        "PO      Y
         G+900   Y
         E       Y  -> start 1 50-1000 R200 R200 +900
         *arrive 1
         PO      Y
         G+101   Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=limit uncertain=0
         PO      Y
         G+0     Y
         E       Y  -> start 1 50-1000 R200 R200 +0
         PO      Y
         G-1000  Y
         E       Y  -> start 1 50-1000 R200 R200 -1000
         PO      E
         A3      Y
         PO      Y
         A3      Y
         G+99999 Y
         E       Y  -> start 3 50-1000 R200 R200 +99999
         PO      E
         A2      Y
         PO      Y
         A2      Y
         G-1     Y
         E       E",
    );
}

/// No limit is so far from 0.
#[test]
fn from_beyond_32_bits_no_travel_is_allowed() {
    let far = |more: &str, answer: &str| {
        talk(&format!(
            "PO            Y
             G+2147483647  Y
             E             Y  -> start 1 50-1000 R200 R200 +2147483647
             *arrive 1
             PO            Y
             G+{more}      Y
             E             Y  -> start 1 50-1000 R200 R200 +{more}
             *arrive 1
             $ahead-x=1000000000 Y -> ahead-x=1000000000
             $soft-limits=1 Y -> soft-limits=1
             PO            Y
             G-2147483646  Y
             E             {answer}"
        ));
    };
    far("0", "Y  -> start 1 50-1000 R200 R200 -2147483646");
    far("1", "E\n?  stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=limit uncertain=0");
}

/// All or none, as with any other refusal.
#[test]
fn one_axis_beyond_its_limit_keeps_all_at_rest() {
    limited(
        "PO      Y
         A0      Y
         G+60    Y
         E       E
         PO      Y
         A0      Y
         G+50    Y
         E       Y  -> start 1 50-1000 R200 R200 +50; start 2 50-1000 R200 R200 +50; start 3 50-1000 R200 R200 +50",
    );
}

#[test]
fn a_g_ends_at_the_limit_and_says_so() {
    limited(
        "I1      Y  -> zero 1
         PO      Y
         G+400   Y
         E       Y  -> start 1 50-1000 R200 R200 +400
         *arrive 1
         g+      Y  -> start 1 50-1000 R200 R200 +600
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=---
         *arrive 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=L-- errors=-
         g+      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=limit uncertain=0 stop=L--
         !       Y  -> clear
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=---
         g-      Y  -> start 1 50-1000 R200 R200 -1100
         !       Y  -> clear
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=---
         Z       Y  -> stop 1
         !       Y  -> clear
         *arrive 1
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=---
         A2      Y
         g-      E
         g+      Y  -> start 2 50-1000 R200 R200 +50
         @+20    Y  -> change 2: @+20
         *arrive 2
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=limit uncertain=0 stop=---
         *refuse too-fast
         g+      E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=2 last=too-fast uncertain=0 stop=---
         A3      Y
         g+      Y  -> start 3 50-1000 R200 R200 forward",
    );
}

#[test]
fn a_target_on_the_way_counts_from_where_the_travel_began() {
    limited(
        "PO      Y
         G+400   Y
         E       Y  -> start 1 50-1000 R200 R200 +400
         *arrive 1
         PO      Y
         G+100   Y
         E       Y  -> start 1 50-1000 R200 R200 +100
         @+601   E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=limit uncertain=0
         @+600   Y  -> change 1: @+600
         @-501   E
         @-500   Y  -> change 1: @-500
         d50     E
         a50     Y  -> change 1: a50
         t60     Y  -> change 1: t60",
    );
}

#[test]
fn without_a_known_position_only_g_is_taken_and_it_has_no_limit() {
    limited(
        "g+      Y  -> start 1 50-1000 R200 R200 +1000
         K       Y  -> kill
         PO      Y
         G+5     Y
         E       E
         ?       stepwright 0.1 axes=3 max=120000 late=0 refused=1 last=uncertain uncertain=1 stop=K--
         PO      Y
         g-      Y
         E       Y  -> start 1 50-1000 R200 R200 backward
         @+5     E
         d90     Y  -> change 1: d90
         *arrive 1
         I1      Y  -> zero 1
         g-      Y  -> start 1 50-1000 R200 90/s2 -100",
    );
}

/// The switch ends the travel, a step or two beyond the limit.
#[test]
fn a_g_towards_a_limit_switch_is_homing_and_has_no_limit() {
    limited(
        "$switches=1 Y -> switches=1
         g-      Y  -> start 1 50-1000 R200 R200 backward
         *arrive 1
         g-      Y  -> start 1 50-1000 R200 R200 backward
         *arrive 1
         g+      Y  -> start 1 50-1000 R200 R200 +3000
         *arrive 1
         $switch-forward=1 Y -> switch-forward=1
         g+      Y  -> start 1 50-1000 R200 R200 forward",
    );
}

#[test]
fn the_words_are_read_by_a_host() {
    assert_eq!(Refusal::named(b"stopped"), Refusal::Stopped);
    assert_eq!(Refusal::named(b"limit"), Refusal::Limit);
}
